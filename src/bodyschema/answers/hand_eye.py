"""Hand and eye: where a camera or a tracker sits, from poses alone, without a robot description.

    answer = learn_hand_eye(T_base_hand, T_eye_target, eye_on="base")
    print(answer.summary())
    answer.save("hand_eye")

The hand is a body that moves freely (`model.free_hand`), its poses are the joint readings, and what
the eye saw is a sense of poses: so the answer holds the belief of `solve_hand_eye` in the form of
every other answer, and `check` and `plan` take it.

Poses that do not agree are tried as they would be if they had been recorded otherwise (inverted,
quaternions in the other order, mm for m); if one of these fits, the answer is "not known" and names
it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

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
from bodyschema.learners.hand_eye.full_poses import FEWEST_PAIRS, HandEye, Mount, solve_hand_eye
from bodyschema.learners.hand_eye.pose_pairs import REACH
from bodyschema.learners.hand_eye.pose_streams import JoinedStreams, join_streams
from bodyschema.model import parts
from bodyschema.model.free_hand import free_hand, hand_readings
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import UNKNOWN_TURN, free_frame, join
from bodyschema.senses.poses import Poses

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Whose = Literal["robot", "eye"]
Rival = tuple[str, Whose, Callable[[Array], Array]]
"""How poses may have been recorded: in words, whose poses, and what then has to be done to them."""

QUATERNIONS = {"xyz_xyzw": "xyz_wxyz", "xyz_wxyz": "xyz_xyzw"}
"""Layouts that are taken for each other."""

SCALE, LAG = "eye_scale", "lag"
"""Parts of the body that keep the scale of the eye's lengths, and how late its clock is."""

FOLDS = 5

ANYWHERE = 200
"""Poses that stand for a workspace."""

BAD = 0.5
"""Probability of being good below which a pair is called an outlier."""

PLAUSIBLE = (0.02, 0.05)
"""Noise of good pairs that needs no other explanation: share of the hand's travel, and rad."""

USELESS = (0.2, 0.35)
"""The same beyond which no place of hand and eye explains the poses."""

BETTER = 1 / 3
"""A rival explains the poses when its noise is at most this share of theirs."""

TRUE_SIZES = (0.8, 1.25)
"""A scale of the eye's lengths beyond these is no matter of a board's printer."""


@dataclass(frozen=True)
class Names:
    """What the frames are called."""

    base: str = "base"
    hand: str = "hand"
    eye: str = "eye"
    target: str = "target"


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
        joined = join_streams(times[0], A, times[1], T, eye_on, bool(free_scale))
        found = replace(joined.hand_eye, accepted_std=accepted_std)
        A, T, numbers = joined.T_base_hand, T[joined.rows], numbers[joined.rows]
    q = hand_readings(A)
    described = free_hand(named.base, named.hand, q)
    if joined is not None:
        described = described.with_part(LAG, parts.clock(joined.lag))
    pose = T.copy()
    pose[:, :3, 3] /= found.scale
    sense = Poses.make(q, pose, named.eye, named.target, rows=numbers)
    doubt = None if _within(PLAUSIBLE, found, A) else _doubt(A, T, found, seed, layouts or {})
    calibration = _calibration(found, sense, described, named, joined, doubt, seed)
    timed = replace(calibration, seconds=time.perf_counter() - begin)
    return Answer.of(timed, (sense,), described, run, verb="hand-eye")


def _calibration(
    found: HandEye,
    sense: Poses,
    described: Body,
    names: Names,
    joined: JoinedStreams | None,
    doubt: str | None,
    seed: int,
) -> Calibration:
    estimate = hand_eye_estimate(found, sense, described, names)
    good = found.weights >= BAD
    before, after, residuals = _held_out(found, sense, described, names, good, seed)
    lag = {} if joined is None else {"lag_s": joined.lag, "lag_std_s": joined.lag_std}
    details = {
        "eye_on": found.eye_on,
        "scale": found.scale,
        "determined": found.determined,
        "largest_std_mm": 1e3 * found.largest_std,
        "uncertain_axis": found.uncertain_axis.tolist(),
        **lag,
        "frames": _frames(found, names),
    }
    verdict = "found" if found.determined and not doubt else "not known"
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
        explanation=doubt or said + told,
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


def hand_eye_estimate(found: HandEye, sense: Poses, described: Body, names: Names) -> Estimate:
    """The belief in X and Y as that in two frames of a free hand.

    Args:
        found: the answer.
        sense: what the eye saw, in true lengths.
        described: the free hand.
        names: of the frames.
    """
    moving, standing = _ends(found, names)
    body = described.attach(moving, names.hand, found.X).attach(standing, names.base, found.Y)
    if found.scale != 1:
        body = body.with_part(SCALE, parts.target(found.scale))
    free = (
        free_frame(body, moving, REACH, UNKNOWN_TURN),
        free_frame(body, standing, 10 * REACH, UNKNOWN_TURN),
    )
    variables = join(*free)
    # Twists are taken in the frames' own axes, links in those of their parents.
    own = np.eye(12)
    own[:3, :3], own[6:9, 6:9] = found.X[:3, :3].T, found.Y[:3, :3].T
    information = own.T @ np.linalg.inv(found.covariance) @ own
    values, vectors = np.linalg.eigh(information - np.diag(variables.prior_std**-2.0))
    told = (vectors * values.clip(0.0)) @ vectors.T
    residual = sense.residual(body)
    good = found.weights / max(float(found.weights.sum()), 1e-12)
    sizes = [float(np.sqrt(good @ np.mean(residual[:, k] ** 2, axis=1))) for k in _PARTS]
    believed = np.sqrt(np.diag(sense.covariance))[[0, 3]]
    noise = {
        f"{sense.label}: {name} ({unit})": size
        for (name, unit, _), size in zip(sense.components, sizes, strict=True)
    }
    levels = (tuple(float(size / std) for size, std in zip(sizes, believed, strict=True)),)
    weights = (np.maximum(found.weights, 1e-9),)
    return Estimate(body, variables, np.zeros(12), (told + told.T) / 2, noise, levels, weights)


_PARTS = (slice(0, 3), slice(3, 6))


def _ends(found: HandEye, names: Names) -> tuple[str, str]:
    """The frame that the hand carries, and the one that stands."""
    ends = (names.eye, names.target)
    return ends if found.eye_on == "hand" else (ends[1], ends[0])


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


def _within(limits: tuple[float, float], found: HandEye, A: Array) -> bool:
    """Whether good pairs agree so far, in lengths that are about true."""
    position, turn = _noise(found)
    low, high = TRUE_SIZES
    return position <= limits[0] * _travel(A) and turn <= limits[1] and low < found.scale < high


def _travel(A: Array) -> float:
    return max(float(np.linalg.norm(np.ptp(A[:, :3, 3], axis=0))), 1e-12)


def _noise(found: HandEye) -> tuple[float, float]:
    """Size of a good pair's residual in true lengths, m and rad."""
    position = float(np.sqrt(np.trace(found.noise[:3, :3]))) / found.scale
    return position, float(np.sqrt(np.trace(found.noise[3:, 3:])))


def _doubt(
    A: Array, T: Array, found: HandEye, seed: int, layouts: Mapping[Whose, str]
) -> str | None:
    """Why poses that hardly agree are not to be trusted, in a sentence; None where they are.

    Raises nothing: what cannot be solved is no explanation.
    """
    position, turn = _noise(found)
    said = f"As declared, the poses agree to {1e3 * position:.3g} mm and {np.rad2deg(turn):.2g} deg"
    for words, whose, undone in rivals(layouts):
        hand, eye = (undone(A), T) if whose == "robot" else (A, undone(T))
        try:
            other = solve_hand_eye(hand, eye, found.eye_on, False, found.accepted_std, seed)
        except (InputError, np.linalg.LinAlgError):
            continue
        there, turned = _noise(other)
        share = there / _travel(hand) / max(position / _travel(A), 1e-12)
        places = share < BETTER and turned < max(BETTER * turn, PLAUSIBLE[1])
        turns = share < 1 / TRUE_SIZES[0] and turn > PLAUSIBLE[1] and turned < BETTER * turn
        if (places or turns) and other.determined:
            return (
                f"{said} only; {words} they agree to {1e3 * there:.3g} mm and "
                f"{np.rad2deg(turned):.2g} deg."
            )
    if _within(USELESS, found, A):
        return None
    return (
        f"{said}: no place of hand and eye explains them; perhaps rows of the two lists do not "
        "belong together, or one of them is not what it is declared to be."
    )


def rivals(layouts: Mapping[Whose, str]) -> list[Rival]:
    """Ways in which poses are recorded other than they are said to be.

    Args:
        layouts: as they are said to be, where that is known.
    """
    # Inverting both lists swaps X and Y, so nobody can tell from poses which one is inverse.
    inverse = (
        "with inverse = true for the seen poses (or for the robot's, or the eye on the other end)"
    )
    found: list[Rival] = [(inverse, "eye", lie.inverse)]
    owners: tuple[tuple[Whose, str], ...] = (("eye", "seen"), ("robot", "robot"))
    for whose, said in owners:
        layout = layouts.get(whose, "")
        if layout in QUATERNIONS:
            shift = 1 if layout == "xyz_xyzw" else -1
            words = f'with layout = "{QUATERNIONS[layout]}" for the {said} poses'
            found.append((words, whose, partial(_reordered, shift=shift)))
        for unit, size in (("mm", 1e-3), ("m", 1e3)):
            words = f"with lengths a thousand times {'smaller' if size < 1 else 'larger'}"
            words += f' (unit = "{unit}") for the {said} poses'
            found.append((words, whose, partial(_sized, size=size)))
    return found


def _reordered(T: Array, shift: int) -> Array:
    """Poses whose quaternion was read in the wrong order; 1 if its first number is w."""
    q = lie.quaternion_xyzw(T[:, :3, :3])
    return lie.transform(lie.rotation_from_xyzw(np.roll(q, -shift, axis=1)), T[:, :3, 3])


def _sized(T: Array, size: float) -> Array:
    return lie.transform(T[:, :3, :3], size * T[:, :3, 3])


def _frames(found: HandEye, names: Names) -> list[dict[str, Any]]:
    """X and Y with their errors in their own axes, mm and deg."""
    moving, standing = _ends(found, names)
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
