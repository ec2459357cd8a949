"""Calibration: the answer of `calibrate`, in all its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.clock import ClockCheck
from bodyschema.estimation.discrepancy import Discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.estimation.prediction import PredictedError
from bodyschema.judging.accuracy import Accuracy
from bodyschema.model.tree import Body
from bodyschema.trust.trust import Trust
from bodyschema.trust.weighing import Weighing

Array = NDArray[np.float64]
Verdict = Literal["calibrated", "learned", "only frames", "refused"]
VERDICTS: tuple[Verdict, ...] = ("calibrated", "learned", "only frames", "refused")

CONTRADICTED = "contradicted"
"""The verdict, of any verb, when the data speak against what the answer presumes; see `Trust`."""

TONES = {
    "only frames": "doubtful",
    "refused": "bad",
    CONTRADICTED: "bad",
    "not known": "bad",
    "load not known": "bad",
    "not found": "bad",
}
"""How good the news of a verdict are, of any verb; "good" for all others."""

WITHHELD = (CONTRADICTED, "refused", "not known", "load not known", "not found")
"""Verdicts after which nothing may be put on a robot."""


@dataclass(frozen=True)
class Candidate:
    """One model that was tried."""

    groups: tuple[str, ...]
    n_parameters: int
    score: float
    """Mean negative log predictive density of a held-out row; lower is better."""
    behind: float
    """Mean loss against the best model, in standard errors of the paired difference."""
    accuracy: Accuracy


@dataclass(frozen=True)
class Calibration:
    """The answer of `calibrate`."""

    verdict: str
    """Of `calibrate`: one of `VERDICTS`; other verbs have words of their own."""
    explanation: str
    """The verdict in a sentence or two."""
    fit: Estimate
    nominal: Accuracy
    """The robot as modelled, with only the frames placed that nobody knew; see `before`."""
    held_out: Accuracy
    """The corrected body alone, on samples that its fit had not seen."""
    identifiability: Identifiability
    outliers: tuple[int, ...]
    """Row numbers."""
    n_rows: int
    groups: tuple[str, ...] = ()
    """Joint parameter groups that were freed."""
    candidates: tuple[Candidate, ...] = ()
    with_field: Accuracy = Accuracy({}, {})  # noqa: RUF009  (a frozen record)
    """The corrected body and its residual field (`discrepancy`), likewise held out; empty where no
    field was looked for."""
    nominal_residuals: tuple[Array, ...] = ()
    """(n, dimension) a sense: seen minus predicted by the nominal robot, every sample; SI units."""
    residuals: tuple[Array, ...] = ()
    """The same for the corrected body alone, held out."""
    fields: Mapping[str, Discrepancy] = field(default_factory=dict)
    """The residual field of each sense, by its label."""
    predicted: tuple[PredictedError, ...] = ()
    """Predicted 95 % error of what each sense looks at, over the postures that were seen; as wide
    as `weighing` makes it."""
    predicted_anywhere: tuple[PredictedError, ...] = ()
    """The same over postures anywhere within the joint limits."""
    agreement: float = float("nan")
    """Share of held-out errors within their predicted 95 % bounds; noise in, outliers out."""
    clock: ClockCheck = ClockCheck(1.0, ())  # noqa: RUF009  (a frozen record)
    seconds: float = 0.0
    """That it took; not stored, so that the same run gives the same bytes."""
    learner: str = "batch"
    """Who found it."""
    from_nothing: bool = False
    """The body is a skeleton that was learned from an arrangement; nothing was modelled."""
    compared: tuple[str, ...] = ()
    """What `nominal` and `held_out` are, in words; by what was corrected when empty."""
    findings: tuple[str, ...] = ()
    """What was found besides the parameters, a sentence each."""
    notes: tuple[str, ...] = ()
    """What looks wrong or has to be known beforehand, a sentence each."""
    corrects: bool = True
    """Whether it is about joints or frames of the robot, which are then written."""
    details: Mapping[str, Any] = field(default_factory=dict)
    """What a verb found besides, in the plain types of JSON; SI."""
    trust: Trust = field(default_factory=Trust)
    """Whether to believe it, and why not."""
    predicted_95: float | None = None
    """m: the error that what was asked for (a tool, a camera) stays below with 95 %, all that is
    known to be wrong included; see `stated_95`."""
    wanted: tuple[tuple[str, str], ...] = ()
    """Frames (seen from, seen) in which the robot was wanted right; what was seen when empty."""
    weighing: Weighing | None = None
    """What widened that error, and which causes would explain what is left; None where nobody
    asked."""

    @property
    def before(self) -> str:
        """What `nominal` is, in words."""
        if self.compared:
            return self.compared[0]
        return "with markers that stand still" if self.from_nothing else "as modelled"

    @property
    def after(self) -> str:
        """What `held_out` is, in words."""
        if self.compared:
            return self.compared[1]
        corrected = f"{describe_groups(self.groups)} corrected"
        return "the learned skeleton" if self.from_nothing else corrected

    @property
    def stated_95(self) -> float | None:
        """m: `predicted_95`, or where a verb gives none the worst of `predicted`."""
        if self.predicted_95 is not None or not self.predicted:
            return self.predicted_95
        return max(error.position_overall for error in self.predicted)

    @property
    def withheld(self) -> bool:
        """Whether nothing of it may be put on a robot."""
        return self.verdict in WITHHELD

    @property
    def tone(self) -> str:
        """How good the news are: "good", "doubtful" or "bad"."""
        tone = TONES.get(self.verdict, "good")
        return "doubtful" if tone == "good" and self.trust.level == "limited" else tone

    def believed(self, trust: Trust) -> Self:
        """The same with what else is known of how far it may be trusted.

        An answer that the data contradict has no other verdict; one that is withheld keeps its own.
        """
        both = self.trust.also(trust)
        against = both.level == "contradicted" and not self.withheld
        return replace(self, trust=both, verdict=CONTRADICTED if against else self.verdict)

    @property
    def estimate(self) -> Estimate:
        """The belief over the parameters."""
        return self.fit

    @property
    def widened(self) -> Estimate:
        """The belief, as wide as its own samples make it and no narrower; see `weighing`."""
        if self.weighing is None:
            return self.fit
        return self.fit.widened(max(self.weighing.widening, 1.0))

    @property
    def least_change(self) -> float:
        """m: half of what noise alone leaves open; a smaller change of the robot matters less."""
        return 0.0 if self.weighing is None else self.weighing.stated / 2

    @property
    def body(self) -> Body:
        """The corrected body."""
        return self.fit.body


def describe_groups(groups: Sequence[str]) -> str:
    """Words for a model."""
    return "joint " + ", ".join(groups) if groups else "frames only"
