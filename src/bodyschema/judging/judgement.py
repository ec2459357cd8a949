"""Judgement: which model the held-out samples speak for, and the answer that it gives.

1. Each model is judged by k-fold held-out predictive density over the rows that are no outliers;
   the simplest that the best does not beat by two standard errors is taken, unless the user has
   chosen.
2. The chosen model is fitted to all samples, with noise levels and robust weights.
3. The answer carries held-out errors before and after, what the data cannot tell, outlier rows,
   a test of the clocks, and whether it is good enough to be written to a robot.
4. What its samples hold against it widens the error that it states, or contradicts it
   (`trust.weighing`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.agreement import within_prediction
from bodyschema.estimation.clock import check_clock
from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import (
    HeldOut,
    folds_of,
    held_out,
    outlier_free,
    with_field,
)
from bodyschema.estimation.identifiability import (
    identifiability,
    random_postures,
)
from bodyschema.estimation.prediction import PredictedError, degrees_of_freedom, predict_error
from bodyschema.estimation.problem import Problem
from bodyschema.judging.accuracy import Accuracy, change_in_words, in_words, main_in_words
from bodyschema.judging.calibration import (
    Calibration,
    Candidate,
    Verdict,
    describe_groups,
)
from bodyschema.judging.one_pass import Fitting
from bodyschema.judging.telling import Telling, unhelped, untold, wanted_pairs
from bodyschema.senses.sense import Sense
from bodyschema.trust.weighing import weighed_up

Array = NDArray[np.float64]

ANYWHERE = 200
"""Postures that stand for a workspace."""

WHOLE = ("offsets", "axes", "links")
"""What may be wrong with joints, whether or not a recording is long enough to tell: what a shorter
model takes for exact is held against it within its prior."""

CONVINCING = 2.0
"""Standard errors by which a larger model must be better to be preferred to a smaller one."""


def judged(
    problem: Problem,
    fitted: Fitting,
    models: Sequence[tuple[str, ...]],
    choose: bool,
    folds: int,
    seed: int,
    progress: Callable[[str], None],
    again: Callable[[Estimate, Sequence[Sense]], Estimate] | None = None,
) -> Calibration:
    """Test the models on held-out samples and answer with the chosen one, or with the last.

    Args:
        problem: what is to be found, and from what.
        fitted: fits a model to samples, frames included.
        models: groups of joint parameters, simple ones first.
        choose: by held-out accuracy; otherwise the last model is taken.
        folds: of the held-out test.
        seed: of the folds.
        progress: told what is being done.
        again: fits a part of the samples, given the fit to all; anew with `fitted` when None.
    """
    begin = time.perf_counter()
    body, senses, loss = problem.body, problem.senses, problem.learner.loss
    cut = folds_of(senses, folds, seed, body)

    def judge(whole: Estimate, fit: Fitting) -> HeldOut:
        def part(some: Sequence[Sense]) -> Estimate:
            return again(whole, some) if again else fit(whole.variables, some)

        return held_out(part, senses, cut, loss, body)

    fits, tests = {}, {}
    for model in dict.fromkeys(models):
        progress(f"{folds}-fold test of {describe_groups(model)}")
        fits[model] = fitted(problem.variables(model), senses)
        tests[model] = judge(fits[model], fitted)
    # The largest model leaves the least geometry in the residuals: it tells outliers and lateness.
    good = outlier_free(senses, fits[models[-1]], loss)
    rows = np.unique(np.concatenate([sense.rows for sense in senses]))
    kept = ~np.isin(rows, list(_outliers(senses, good)))
    scored = {model: test.scored_by(kept) for model, test in tests.items()}
    candidates = _candidates(problem, scored, senses, good)
    chosen = _choose(scored, candidates) if choose else models[-1]
    still = problem.variables((), False)
    if again and () in fits and still.names == fits[()].variables.names:
        modelled = tests[()]
    else:
        progress(f"{folds}-fold test of the robot as modelled")
        modelled = judge(problem.fit(still, senses), problem.fit)
    sure = scored[models[0]].behind(scored[chosen]) >= CONVINCING
    whole = fits[models[-1]]
    if choose and again and models[-1] != WHOLE:
        whole = problem.fit(problem.variables(WHOLE), senses)
    trial = _Trial(senses, good, fits[chosen], fits[models[-1]], whole, modelled, tests[chosen])
    progress("residual fields, and what disagrees")
    found = _answered(trial, problem, chosen, sure, candidates, seed)
    return replace(found, seconds=time.perf_counter() - begin)


@dataclass(frozen=True)
class _Trial:
    """All fits and tests that an answer is made from."""

    senses: tuple[Sense, ...]
    good: Sequence[NDArray[np.bool_]]
    """(n,) for each sense: no outliers."""
    fit: Estimate
    fullest: Estimate
    """Of the largest model that the recording can afford."""
    whole: Estimate
    """Of the largest that there is."""
    modelled: HeldOut
    final: HeldOut


def _answered(
    trial: _Trial,
    problem: Problem,
    chosen: tuple[str, ...],
    sure: bool,
    candidates: tuple[Candidate, ...],
    seed: int,
) -> Calibration:
    """The chosen model with its errors, its verdict, and how far it may be trusted."""
    senses, good, fit, final = trial.senses, trial.good, trial.fit, trial.final
    nominal = Accuracy.of(senses, trial.modelled.residuals, good)
    corrected = Accuracy.of(senses, final.residuals, good)
    anywhere = random_postures(problem.body, ANYWHERE, np.random.default_rng(seed))
    verdict, explanation = _verdict(chosen, sure, nominal, candidates[0].accuracy, corrected)
    wanted = problem.wanted
    unsure = verdict == "calibrated" and not wanted
    unknown = untold(fit, trial.fullest, senses, anywhere) if unsure else None
    if unknown is not None:
        verdict, explanation = "refused", f"{explanation} {_untold(unknown)}"
    fields = {
        sense.label: learn_discrepancy(fit.body, sense, mask)
        for sense, mask in zip(senses, good, strict=True)
    }
    larger = trial.whole if trial.whole.converged else trial.fullest
    pairs = wanted or wanted_pairs(fit, senses)
    weighing = weighed_up(fit, larger, senses, fields, pairs, seed)
    if wanted and verdict == "calibrated" and (why := unhelped(fit, weighing, senses, wanted)):
        verdict, explanation = "refused", f"{explanation} {why}"
    where_seen = [_predicted(fit, senses, s, _some(s.q)) for s in senses]
    elsewhere = [_predicted(fit, senses, s, anywhere) for s in senses]
    found = Calibration(
        verdict=verdict,
        explanation=explanation,
        fit=fit,
        groups=chosen,
        candidates=candidates,
        nominal=nominal,
        held_out=corrected,
        with_field=Accuracy.of(senses, with_field(final, senses, problem.learner.loss), good),
        nominal_residuals=trial.modelled.residuals,
        residuals=final.residuals,
        fields=fields,
        predicted=tuple(e.widened(weighing.widening) for e in where_seen),
        predicted_anywhere=tuple(e.widened(weighing.widening) for e in elsewhere),
        agreement=_agreement(fit, senses, final.residuals, good),
        identifiability=identifiability(fit, senses, seed),
        outliers=tuple(sorted(_outliers(senses, good))),
        clock=replace(
            check_clock(trial.fullest, senses, seed), instead=weighing.rather_than("lag")
        ),
        n_rows=len(np.unique(np.concatenate([sense.rows for sense in senses]))),
        predicted_95=weighing.total if pairs else None,
        wanted=wanted,
        weighing=weighing,
    )
    return found.believed(weighing.trust)


def _outliers(senses: Sequence[Sense], good: Sequence[NDArray[np.bool_]]) -> set[int]:
    """Rows with a sample that was held off."""
    return {int(row) for s, mask in zip(senses, good, strict=True) for row in s.rows[~mask]}


def _predicted(fit: Estimate, senses: Sequence[Sense], sense: Sense, q: Array) -> PredictedError:
    freedom = degrees_of_freedom(fit, senses)
    return predict_error(fit, q, sense.seen_from, sense.seen, freedom)


def _some(q: Array) -> Array:
    """At most ANYWHERE postures, evenly spaced."""
    return np.asarray(q[np.linspace(0, len(q) - 1, min(len(q), ANYWHERE)).astype(int)])


def _agreement(
    fit: Estimate,
    senses: Sequence[Sense],
    residuals: Sequence[Array],
    good: Sequence[NDArray[np.bool_]],
) -> float:
    inside = [
        share[mask]
        for sense, level, nu, residual, mask in zip(
            senses, fit.levels, fit.freedom, residuals, good, strict=True
        )
        for share in within_prediction(fit, sense, level, residual, nu).values()
    ]
    return float(np.mean(np.concatenate(inside)))


def _choose(
    tests: Mapping[tuple[str, ...], HeldOut], candidates: Sequence[Candidate]
) -> tuple[str, ...]:
    """The simplest model that the best one does not beat convincingly.

    Models with larger held-out errors than the frames alone do not compete.
    """
    frames = candidates[0].accuracy
    eligible = [c.groups for c in candidates if not c.accuracy.worse_than(frames)]
    best = min((tests[model] for model in eligible), key=lambda test: float(np.mean(test.scores)))
    return next(model for model in eligible if tests[model].behind(best) < CONVINCING)


def _candidates(
    problem: Problem,
    tests: Mapping[tuple[str, ...], HeldOut],
    senses: Sequence[Sense],
    good: Sequence[NDArray[np.bool_]],
) -> tuple[Candidate, ...]:
    best = min(tests.values(), key=lambda test: float(np.mean(test.scores)))
    return tuple(
        Candidate(
            groups=model,
            n_parameters=len(problem.variables(model)),
            score=float(np.mean(test.scores)),
            behind=test.behind(best),
            accuracy=Accuracy.of(senses, test.residuals, good),
        )
        for model, test in tests.items()
    )


def _untold(unknown: Telling) -> str:
    """What the senses leave open although the fit suits them better, in words."""
    return (
        f"But what was seen does not tell where '{unknown.seen}' is: the correction moves it by "
        f"{in_words(unknown.moved, 'm')} rms seen from '{unknown.seen_from}', and is known to "
        f"{in_words(unknown.stated, 'm')} there. Add a sense that sees it, or wider postures."
    )


def _verdict(
    chosen: tuple[str, ...], sure: bool, nominal: Accuracy, frames: Accuracy, corrected: Accuracy
) -> tuple[Verdict, str]:
    """Whether the held-out error speaks for the corrected body.

    Args:
        chosen: the model that was fitted.
        sure: whether it predicts convincingly better than the frames alone.
        nominal: accuracy of the robot as modelled.
        frames: with the frames alone fitted.
        corrected: of the corrected body.
    """
    if corrected.worse_than(nominal) or (chosen and corrected.worse_than(frames)):
        return "refused", (
            f"Fitting {describe_groups(chosen)} makes the held-out error worse: "
            f"{main_in_words(corrected)} rms, against {main_in_words(nominal)} as modelled and "
            f"{main_in_words(frames)} with the frames alone."
        )
    if chosen and not sure:
        return "refused", (
            f"Fitting {describe_groups(chosen)} does not make the held-out error convincingly "
            f"better: {main_in_words(corrected)} rms, against {main_in_words(frames)} with the "
            "frames alone."
        )
    if chosen:
        return "calibrated", (
            f"The held-out error falls {change_in_words(nominal, corrected)} when "
            f"{describe_groups(chosen)} are corrected."
        )
    return "only frames", (
        f"Correcting the joints does not help: the held-out error is {main_in_words(corrected)} "
        "rms with the frames placed and the joints left as modelled."
    )
