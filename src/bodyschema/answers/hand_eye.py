"""Hand and eye: where a camera or a tracker sits, from poses alone, without a robot description.

    answer = bs.learn_hand_eye(T_base_hand, T_eye_target, eye_on="base")
    print(answer.summary())
    answer.save("hand_eye")

The hand is a body that moves freely (`model.free_hand`), its poses are the joint readings, and what
the eye saw is a sense of poses: so the answer holds the belief of `solve_hand_eye` in the form of
every other answer, and `check` and `plan` take it.

Poses that fit far better as they would be if they had been recorded otherwise (inverted,
quaternions in the other order, mm for m) make the answer "not known", and it names the way. What
else the pairs hold against the answer is its `trust`, and widens `predicted_95` of the eye's place.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.answers.answer import Answer
from bodyschema.errors import InputError
from bodyschema.estimation.agreement import within_prediction
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import folds_of, held_out
from bodyschema.estimation.identifiability import identifiability, random_postures
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.prediction import degrees_of_freedom, predict_error
from bodyschema.judging.accuracy import Accuracy, in_words
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.pose_declarations import Whose, declared_rightly
from bodyschema.judging.pose_trust import weighed_pairs
from bodyschema.learners.hand_eye.free_estimate import LAG, Names, ends, hand_eye_estimate
from bodyschema.learners.hand_eye.full_poses import FEWEST_PAIRS, HandEye, Mount, solve_hand_eye
from bodyschema.learners.hand_eye.pose_streams import JoinedStreams, join_streams
from bodyschema.model import parts
from bodyschema.model.free_hand import free_hand, hand_readings
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.poses import Poses
from bodyschema.threads import one_thread
from bodyschema.trust.trust import Trust

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FOLDS = 5

ANYWHERE = 200
"""Poses that stand for a workspace."""

BAD = 0.5
"""Probability of being good below which a pair is called an outlier."""


@one_thread
def learn_hand_eye(
    T_base_hand: ArrayLike,
    T_eye_target: ArrayLike,
    eye_on: Mount = "hand",
    times: tuple[ArrayLike, ArrayLike] | None = None,
    rows: ArrayLike | None = None,
    names: Names | None = None,
    layouts: Mapping[Whose, str] | None = None,
    free_scale: bool | None = None,
    accepted_std: float = 0.05,
    seed: int = 0,
    run: Mapping[str, Any] | None = None,
) -> Answer:
    """Find where an eye sits, from poses of the hand and of what the eye saw.

    Args:
        T_base_hand: (n, 4, 4) from the robot.
        T_eye_target: (m, 4, 4) from the eye; one for each hand pose unless there are times.
        eye_on: whether the hand or the base carries the eye.
        times: (n,) and (m,) s, of streams with clocks of their own; they are joined by a lag.
        rows: (m,) row numbers of what the eye saw, for messages.
        names: of the frames.
        layouts: in which poses were recorded ("xyz_xyzw" and the like), to try others where they
            do not agree.
        free_scale: the eye's lengths have one unknown scale; decided by the data when None.
        accepted_std: m; above it the eye's place counts as not known.
        seed: of the random starts and folds.
        run: what was asked, to be kept with the answer.

    Raises:
        InputError: too few pairs, arrays that do not match, or poses that do not turn.
    """
    begin = time.perf_counter()
    named = names or Names()
    A, T = (np.asarray(poses, dtype=np.float64) for poses in (T_base_hand, T_eye_target))
    numbers = np.arange(len(T)) if rows is None else np.asarray(rows, dtype=np.int64)
    joined = None
    if times is None:
        found = solve_hand_eye(A, T, eye_on, free_scale, accepted_std, seed)
    else:
        joined = join_streams(
            times[0], A, times[1], T, eye_on, free_scale, accepted_std=accepted_std, seed=seed
        )
        found = joined.hand_eye
        A, T, numbers = joined.T_base_hand, T[joined.rows], numbers[joined.rows]
    q = hand_readings(A)
    described = free_hand(named.base, named.hand, q)
    if joined is not None:
        described = described.with_part(LAG, parts.clock(joined.lag))
    pose = T.copy()
    pose[:, :3, 3] /= found.scale
    sense = Poses.make(q, pose, named.eye, named.target, rows=numbers)
    estimate = hand_eye_estimate(found, sense, described, named)
    given = Poses.make(q, T, named.eye, named.target, rows=numbers)
    wrong = declared_rightly(found, A, estimate.body, given, layouts or {})
    trust, total = _weighed(found, estimate, sense, joined, seed)
    calibration = _calibration(found, estimate, sense, described, named, joined, wrong, seed)
    known = replace(calibration, predicted_95=total).believed(wrong.also(trust))
    timed = replace(known, seconds=time.perf_counter() - begin)
    return Answer.of(timed, (sense,), described, run, verb="hand-eye")


def _weighed(
    found: HandEye, estimate: Estimate, sense: Poses, joined: JoinedStreams | None, seed: int
) -> tuple[Trust, float]:
    """How far the answer may be believed beside its declaration, and 95 % of the eye's error, m."""
    trust, total = Trust(), found.predicted_95
    if not found.determined:
        trust = Trust("limited", (f"{found.verdict[0].upper()}{found.verdict[1:]}",))
    if found.problem is not None:
        weighing = weighed_pairs(found, found.problem, estimate, sense, joined is not None, seed)
        trust, total = trust.also(weighing.trust), weighing.total
    return (trust if joined is None else trust.also(_of_lag(joined))), total


def _of_lag(joined: JoinedStreams) -> Trust:
    said = []
    if joined.other_lags:
        others = ", ".join(f"{1e3 * lag:+.0f} ms" for lag in joined.other_lags)
        said.append(
            f"The motion repeats itself: lags of {others} explain the streams as well as "
            f"{1e3 * joined.lag:+.0f} ms; record motion that does not, or start both together."
        )
    if joined.at_edge:
        said.append(
            f"The lag of {joined.lag:+.2f} s lies where the search ended: the right one may lie "
            "beyond; start both recordings together."
        )
    return Trust("limited", tuple(said)) if said else Trust()


def _calibration(
    found: HandEye,
    estimate: Estimate,
    sense: Poses,
    described: Body,
    names: Names,
    joined: JoinedStreams | None,
    wrong: Trust,
    seed: int,
) -> Calibration:
    good = found.weights >= BAD
    before, after, residuals = _held_out(found, sense, described, names, good, seed)
    lag = {} if joined is None else {"lag_s": joined.lag, "lag_std_s": joined.lag_std}
    details = {
        "eye_on": found.eye_on,
        "scale": found.scale,
        "determined": found.determined,
        "largest_std_mm": 1e3 * found.largest_std,
        "uncertain_axis": found.uncertain_axis.tolist(),
        "postures": found.postures,
        **lag,
        "frames": _frames(found, names),
    }
    verdict = "found" if found.determined and not wrong.reasons else "not known"
    said = f"{found.verdict[0].upper()}{found.verdict[1:]}"
    residuals = residuals or (sense.residual(estimate.body),)
    told = f" The held-out error is {_sizes(after)}." if after.errors else ""
    freedom = degrees_of_freedom(estimate, [sense])
    postures = sense.q, random_postures(described, ANYWHERE, np.random.default_rng(seed))
    seen, anywhere = (
        predict_error(estimate, q, names.eye, names.target, freedom) for q in postures
    )
    return Calibration(
        verdict=verdict,
        explanation=wrong.reasons[0] if wrong.reasons else said + told,
        fit=estimate,
        nominal=before,
        held_out=after,
        identifiability=identifiability(estimate, [sense], seed),
        outliers=tuple(int(row) for row in sense.rows[~good]),
        n_rows=len(sense),
        nominal_residuals=(_from_mean(sense),),
        residuals=residuals,
        predicted=(seen,),
        predicted_anywhere=(anywhere,),
        agreement=_agreement(estimate, sense, residuals, good),
        compared=("taking the mean of what was seen", "with hand and eye placed"),
        findings=tuple(_findings(found, names, joined)),
        corrects=False,
        details=details,
    )


def _agreement(
    estimate: Estimate, sense: Poses, residuals: Sequence[Array], good: NDArray[np.bool_]
) -> float:
    inside = within_prediction(estimate, sense, estimate.levels[0], residuals[0], np.inf)
    return float(np.mean([share[good] for share in inside.values()]))


def _held_out(
    found: HandEye,
    sense: Poses,
    described: Body,
    names: Names,
    good: NDArray[np.bool_],
    seed: int,
) -> tuple[Accuracy, Accuracy, tuple[Array, ...]]:
    """Errors without and with X and Y, of pairs that took no part in finding them."""
    folds = min(FOLDS, len(sense))
    if len(sense) - -(-len(sense) // folds) < FEWEST_PAIRS:
        return Accuracy({}, {}), Accuracy({}, {}), ()

    def fit(senses: Sequence[Any]) -> Estimate:
        (seen,) = senses
        A = _hand_poses(described, seen, names)
        try:
            part = solve_hand_eye(A, seen.pose, found.eye_on, False, found.accepted_std, seed)
        except InputError:
            # What is left turns too little: the whole recording has to do.
            return hand_eye_estimate(found, sense, described, names)
        return hand_eye_estimate(part, seen, described, names)

    cut = folds_of([sense], folds, seed)
    tested = held_out(fit, [sense], cut, Loss())
    mean = Accuracy.of([sense], [_from_mean(sense)], [good])
    return mean, Accuracy.of([sense], tested.residuals, [good]), tested.residuals


def _hand_poses(described: Body, sense: Poses, names: Names) -> Array:
    """T_base_hand of the samples, (n, 4, 4)."""
    return relative_pose(described, sense.q, names.base, names.hand)


def _from_mean(sense: Poses) -> Array:
    """What is left of each pose over the middle of all, (n, 6) m and rad."""
    T = sense.pose
    U, _, Vt = np.linalg.svd(T[:, :3, :3].sum(axis=0))
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    turned = lie.log_so3(T[:, :3, :3] @ R.T)
    return np.hstack([T[:, :3, 3] - np.median(T[:, :3, 3], axis=0), turned])


def _frames(found: HandEye, names: Names) -> list[dict[str, Any]]:
    """X and Y with their errors in their own axes, mm and deg."""
    moving, standing = ends(found, names)
    std = np.sqrt(np.diag(found.covariance))
    listed = (("X", names.hand, moving, found.X, 0), ("Y", names.base, standing, found.Y, 6))
    return [
        {
            "name": name,
            "parent": parent,
            "child": child,
            "T_parent_child": T.tolist(),
            "std_mm": (1e3 * std[k : k + 3]).tolist(),
            "std_deg": np.rad2deg(std[k + 3 : k + 6]).tolist(),
        }
        for name, parent, child, T, k in listed
    ]


def _findings(found: HandEye, names: Names, joined: JoinedStreams | None) -> list[str]:
    """X and Y as people read them, the lag, and the scale."""
    said = []
    for frame in _frames(found, names):
        T = np.array(frame["T_parent_child"])
        place = ", ".join(f"{1e3 * v:.1f}" for v in T[:3, 3])
        turn = ", ".join(f"{v:.2f}" for v in np.rad2deg(lie.rpy_from_rotation(T[:3, :3])))
        errors = f"{max(frame['std_mm']):.2g} mm, {max(frame['std_deg']):.2g} deg"
        said.append(
            f"{frame['name']} = {frame['child']} in {frame['parent']}: {place} mm, roll pitch yaw "
            f"{turn} deg (+- {errors})"
        )
    if joined is not None:
        said.append(
            f"Lag: the hand's clock shows {1e3 * joined.lag:+.1f} +- {1e3 * joined.lag_std:.1f} ms "
            "more than the eye's."
        )
    return said


def _sizes(accuracy: Accuracy) -> str:
    said = [in_words(errors.rms, unit) for (_, unit), errors in accuracy.errors.items()]
    return f"{' and '.join(said)} rms"
