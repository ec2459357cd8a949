"""Accuracy on recordings of real robots, fitted anew at each run.

    python benchmarks/recordings.py [--json] [--data FOLDER]

fr3     5-fold held-out error of the flange (link8), clean, and with 15 % of the training poses
        shifted by 3 cm or 20 cm; from the nominal robot and unknown frames. "rms_mm" is the
        prediction of the corrected body with its residual field, "body_alone" that of the body
        which goes into the URDF, in the folds that others were measured with. Two rows of these
        are twins, in different folds, and make 38 % of the squared error: who knows one, knows the
        other. "twins_together" is the body alone with both in one fold, "repeats_together" with
        all rows of a posture in one. "recursive" is the recursive learner in one pass, body alone;
        compare it with "batch_body_alone".
talos   held-out error of the point, with joint offsets and with the model that was chosen.
        "nominal_rms_mm" is the robot as modelled, tracker and point placed from all training
        samples. "one_pass" are the online learners, one pass over each training set, begun with
        tracker and point placed from its first 12 samples ("started"): recursive Gauss-Newton and
        the smoother with joint offsets and with the full model, gradient and pool with axes and
        links, which are all they can learn; the pool takes nothing of them from the model.
        "from_nothing" is the skeleton learned without the URDF, from the order of the joints alone.
tiago   what `calibrate` says of a recording with a clock fault.
vislab, med7   joint offsets from pictures alone, see `benchmarks/markerless.py`.
ur5_artag  hand and eye from pairs of poses with outliers: scatter of the target in the hand, all
        pairs counted ("rms_mm" is dominated by the wrong ones; "inlier_rms_mm" by those with
        weight above one half).
eth     hand and eye from two streams with clocks of their own: lag, and scatter of the target in
        the base; and how far two recordings of one rig put the eye apart.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs
import markerless
from bodyschema import lie
from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import folds_of, held_out
from bodyschema.estimation.moments import moments_of
from bodyschema.estimation.problem import Knowledge, Problem
from bodyschema.judging.one_pass import BURN_IN, Fitting, LearnerName, fitting
from bodyschema.learners.hand_eye.full_poses import solve_hand_eye
from bodyschema.learners.hand_eye.pose_streams import join_streams
from bodyschema.learners.learner import run
from bodyschema.model.arrangement import Arrangement, JointEntry
from bodyschema.model.dh import DHRow, body_from_dh
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.sense import Sense
from bodyschema.sources.tables import open_recording

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

TWINS = (112, 113)
"""Rows of FR3 that share their joints within 0.01 mrad: one cannot be held out from the other."""

STARTS = 50
"""Random starts of vislab."""

FULL = ("offsets", "axes", "links")

T_LINK8_CAMERA = np.array([[0, -1, 0, 0.0945], [1, 0, 0, -0.009], [0, 0, 1, 0.04055], [0, 0, 0, 1]])
"""CAD value; it defines the point that is scored, nothing is fitted to it."""


@dataclass(frozen=True)
class Score:
    """Held-out position errors in mm."""

    errors: np.ndarray
    seconds: float

    def json(self) -> dict[str, float]:
        """Summary with the time of one fit."""
        return {
            "rms_mm": float(np.sqrt(np.mean(self.errors**2))),
            "median_mm": float(np.median(self.errors)),
            "max_mm": float(np.max(self.errors)),
            "seconds": self.seconds,
        }


def fr3(data: Path) -> tuple[bs.Body, np.ndarray, np.ndarray]:
    """Nominal robot with unknown board and camera, joint angles, and T_board_camera."""
    folder = data / "fr3_eyeinhand_kincal"
    q = np.loadtxt(folder / "joint_positions.csv", delimiter=",", skiprows=1)
    pose = np.tile(np.eye(4), (len(q), 1, 1))
    seen = np.loadtxt(folder / "camera_in_board.csv", delimiter=",", skiprows=1)
    pose[:, :3] = seen.reshape(-1, 3, 4)
    model = json.loads((folder / "model.json").read_text())
    rows = [
        DHRow(f"joint_{i}", a, alpha, d, theta)
        for i, (a, d, alpha, theta) in enumerate(model["mdh"], start=1)
    ]
    body = body_from_dh(rows, "modified", (0.0, 0.0, model["flange_d"]), "fr3")
    return body.attach("board", "base").attach("camera", "flange"), q, pose


def corrupted(pose: np.ndarray, size: float) -> np.ndarray:
    """17 of the 114 poses shifted by `size` (m) in random directions, as the peers were tested."""
    rng = np.random.default_rng(7)
    shifted = pose.copy()
    for i in rng.choice(len(pose), 17, replace=False) if size else []:
        direction = rng.normal(size=3)
        shifted[i, :3, 3] += size * direction / np.linalg.norm(direction)
    return shifted


def link8_error(predicted: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Distance in mm of the flange as predicted and as seen, through the CAD camera mount."""
    p_camera = lie.inverse(T_LINK8_CAMERA)[:, 3]
    return np.asarray(1e3 * np.linalg.norm((predicted - seen) @ p_camera, axis=1))


def fr3_nominal(data: Path) -> float:
    """rms in mm of the robot as modelled, with CAD frames."""
    body, q, pose = fr3(data)
    T_base_board = lie.transform(np.eye(3), [0.66025, -0.5905, -0.0097])
    body = body.with_placement("board", T_base_board).with_placement("camera", T_LINK8_CAMERA)
    error = link8_error(relative_pose(body, q, "board", "camera"), pose)
    return float(np.sqrt(np.mean(error**2)))


def peers_folds() -> list[np.ndarray]:
    """The five folds of FR3's 114 rows that other methods were measured with."""
    return np.array_split(np.random.default_rng(0).permutation(114), 5)


def twins_together(folds: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The same folds, the second of `TWINS` moved to the fold of the first."""
    first, second = TWINS
    apart = [fold[fold != second] for fold in folds]
    return [np.append(fold, second) if first in fold else fold for fold in apart]


def repeats_together(data: Path, folds: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The same folds, every row moved to the fold of the first row of its posture.

    The arm came back to four postures, with two or three rows each: 65-67, 101-102, 103-105 and
    the twins. Their images agree to a tenth of a millimetre, however far they are off.
    """
    body, q, pose = fr3(data)
    rows, moment = moments_of([bs.Poses.make(q, pose, "board", "camera")], body=body)
    place = np.empty(len(rows), dtype=int)
    for i, fold in enumerate(folds):
        place[fold] = i
    first = np.unique(moment, return_index=True)[1]
    return [np.flatnonzero(place[first][moment] == i) for i in range(len(folds))]


def fr3_batch(
    data: Path, size: float, folds: Sequence[np.ndarray] | None = None
) -> tuple[Score, Score]:
    """Held-out errors with the residual field and of the body alone; peers' folds when None."""
    body, q, pose = fr3(data)
    training = corrupted(pose, size)
    alone, corrected = np.zeros(len(q)), np.zeros(len(q))
    seconds = []
    for fold in peers_folds() if folds is None else folds:
        rows = np.setdiff1d(np.arange(len(q)), fold)
        sense = bs.Poses.make(q[rows], training[rows], "board", "camera")
        begin = time.perf_counter()
        problem = Problem(body, (sense,), {"board": "no", "camera": "no"}, body.joints)
        fit = problem.fit(problem.variables(FULL), [sense])
        good = ~fit.outliers[0]
        field = learn_discrepancy(fit.body, sense, good)
        seconds.append(time.perf_counter() - begin)
        predicted = relative_pose(fit.body, q[fold], "board", "camera")
        alone[fold] = link8_error(predicted, pose[fold])
        residual = field.predict(q[fold])
        predicted[:, :3, 3] += residual[:, :3]
        predicted[:, :3, :3] = lie.exp_so3(residual[:, 3:]) @ predicted[:, :3, :3]
        corrected[fold] = link8_error(predicted, pose[fold])
    return Score(corrected, float(np.mean(seconds))), Score(alone, float(np.mean(seconds)))


def fr3_recursive(data: Path) -> Score:
    """Held-out errors of the recursive learner, one pass over each training set, body alone."""
    body, q, pose = fr3(data)
    errors, seconds = np.zeros(len(q)), []
    for fold in np.array_split(np.random.default_rng(0).permutation(len(q)), 5):
        rows = np.setdiff1d(np.arange(len(q)), fold)
        sense = bs.Poses.make(q[rows], pose[rows], "board", "camera")
        problem = Problem(body, (sense,), {"board": "no", "camera": "no"}, body.joints)
        learner = bs.Filter(unknown=problem.unknown)
        begin = time.perf_counter()
        start = learner.start(body, problem.variables(FULL))
        *_, (state, _) = run(learner, start, [sense])
        seconds.append(time.perf_counter() - begin)
        predicted = relative_pose(state.estimate.body, q[fold], "board", "camera")
        errors[fold] = link8_error(predicted, pose[fold])
    return Score(errors, float(np.mean(seconds)))


def talos_recording(data: Path) -> tuple[bs.Body, bs.Points]:
    """TALOS with a frame for the tracker and for the point on its left hand, and what was seen."""
    folder = data / "figaroh_talos_contact"
    body = bs.Body.from_urdf(folder / "talos_left_arm_chain.urdf")
    recording = open_recording(folder / "data.csv")
    q = recording.matrix(body.joints, "rad")[0]
    points = recording.matrix(["x1", "y1", "z1"], "m")[0]
    body = body.attach("tracker", "base_link").attach("point", "gripper_left_base_link")
    return body, bs.Points.make(q, points, "tracker", "point")


def talos(data: Path, groups: Sequence[str] | None) -> dict[str, Any]:
    """Held-out error of TALOS's left arm with tracker frame and point unknown."""
    body, sense = talos_recording(data)
    frames: dict[str, Knowledge] = {"tracker": "no", "point": "no"}
    answer = bs.calibrate(body, [sense], frames, groups)
    position = answer.held_out.position
    return {
        "groups": list(answer.groups),
        "nominal_rms_mm": 1e3 * answer.nominal.position.rms,
        "rms_mm": 1e3 * position.rms,
        "median_mm": 1e3 * position.median,
        "max_mm": 1e3 * position.max,
        "seconds": answer.seconds,
    }


ONLINE: dict[str, tuple[LearnerName, Sequence[str]]] = {
    "gauss_newton_offsets": ("gauss-newton", ("offsets",)),
    "gauss_newton_full": ("gauss-newton", FULL),
    "smoother_offsets": ("smoother", ("offsets",)),
    "smoother_full": ("smoother", FULL),
    "gradient_axes_links": ("online-gradient", ("axes", "links")),
    "pool_axes_links": ("pool", ("axes", "links")),
}


def talos_online(data: Path) -> dict[str, dict[str, float]]:
    """Held-out errors of the online learners on TALOS, and of where they begin."""
    body, sense = talos_recording(data)
    frames: dict[str, Knowledge] = {"tracker": "no", "point": "no"}
    problem = Problem(body, (sense,), frames, body.joints)

    def begun(variables: bs.Variables, senses: Sequence[Sense]) -> Estimate:
        return problem.fit(variables, [senses[0].take(range(BURN_IN))])

    fits = {name: (fitting(problem, learner), free) for name, (learner, free) in ONLINE.items()}
    return {
        name: held_out_score(problem, fit, problem.variables(free)).json()
        for name, (fit, free) in {"started": (begun, ()), **fits}.items()
    }


def talos_skeleton(data: Path) -> dict[str, Any]:
    """Held-out error of TALOS's skeleton learned without its URDF."""
    body, sense = talos_recording(data)
    joints = {
        joint: JointEntry(above) for joint, above in pairwise(reversed(("base", *body.joints)))
    }
    ordered = {joint: joints[joint] for joint in body.joints}
    unknown = Arrangement("talos", "base", ordered, {"point": body.joints[-1]}, None).body()
    answer = bs.learn_skeleton(unknown, [replace(sense, seen_from="base")])
    return {
        "verdict": answer.verdict,
        "standing_still_rms_mm": 1e3 * answer.nominal.position.rms,
        "rms_mm": 1e3 * answer.held_out.position.rms,
        "median_mm": 1e3 * answer.held_out.position.median,
        "max_mm": 1e3 * answer.held_out.position.max,
        "seconds": answer.seconds,
    }


def held_out_score(problem: Problem, fit: Fitting, variables: bs.Variables) -> Score:
    """Held-out errors of one sense, with the mean time of a fit."""
    folds = folds_of(problem.senses, 5, 0)
    begin = time.perf_counter()
    test = held_out(lambda s: fit(variables, s), problem.senses, folds, problem.learner.loss)
    seconds = (time.perf_counter() - begin) / len(folds)
    return Score(1e3 * np.linalg.norm(test.residuals[0], axis=1), seconds)


def tiago(data: Path) -> dict[str, Any]:
    """What is said of the recording whose tracker clock runs behind."""
    folder = data / "figaroh_tiago_mocap"
    body = bs.Body.from_urdf(folder / "tiago_arm_chain.urdf")
    recording = open_recording(folder / "data.csv")
    q = recording.matrix(body.joints, "rad")[0]
    body = body.attach("mocap", "base_footprint")
    senses = []
    # The fourth point repeats the third.
    for k in (1, 2, 3):
        body = body.attach(f"marker_{k}", "wrist_ft_tool_link")
        points = recording.matrix([f"{axis}{k}" for axis in "xyz"], "m")[0]
        senses.append(bs.Points.make(q, points, "mocap", f"marker_{k}"))
    frames = dict.fromkeys(("mocap", "marker_1", "marker_2", "marker_3"), "no")
    answer = bs.calibrate(body, senses, frames)
    offsets = bs.calibrate(body, senses, frames, groups=["offsets"])
    return {
        "verdict": answer.verdict,
        "explanation": answer.explanation,
        "frames_only_rms_mm": 1e3 * answer.held_out.position.rms,
        "offsets_rms_mm": 1e3 * offsets.held_out.position.rms,
        "offsets_verdict": offsets.verdict,
        "clock_fault_p": answer.clock.p_value,
        "bad_rows": sorted({*answer.outliers, *answer.clock.late_rows}),
    }


def scatter(place: np.ndarray, mean: np.ndarray, weights: np.ndarray) -> dict[str, float]:
    """How far a frame that stands still was seen from where it is: in mm and degrees."""
    apart = 1e3 * np.linalg.norm(place[:, :3, 3] - mean[:3, 3], axis=1)
    turned = np.linalg.norm(lie.log_so3(mean[:3, :3].T @ place[:, :3, :3]), axis=1)
    good = weights > 0.5
    return {
        "median_mm": float(np.median(apart)),
        "rms_mm": float(np.sqrt(np.mean(apart**2))),
        "inlier_rms_mm": float(np.sqrt(np.mean(apart[good] ** 2))),
        "median_deg": float(np.rad2deg(np.median(turned))),
        "outliers": int(np.sum(~good)),
        "pairs": len(apart),
    }


def ur5_artag(data: Path) -> dict[str, Any]:
    """Eye on the base, target on the hand."""
    path = data / "ur5_artag_handeye" / "pairs.csv"
    pairs = np.loadtxt(path, delimiter=",", skiprows=1)
    T_base_hand, T_eye_target = pairs[:, :16].reshape(-1, 4, 4), pairs[:, 16:].reshape(-1, 4, 4)
    begin = time.perf_counter()
    answer = solve_hand_eye(T_base_hand, T_eye_target, eye_on="base")
    seconds = time.perf_counter() - begin
    seen = lie.inverse(T_base_hand) @ answer.Y @ T_eye_target
    return {**scatter(seen, answer.X, answer.weights), "seconds": seconds}


def pose_stream(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times that increase, and poses (time, x, y, z, quaternion with w last)."""
    lines = path.read_text(encoding="utf-8").replace(",", " ").splitlines()
    table = np.array([line.split() for line in lines if line.strip()], dtype=np.float64)
    latest = np.maximum.accumulate(np.concatenate([[-np.inf], table[:-1, 0]]))
    table = table[table[:, 0] > latest]
    quaternion = table[:, 4:] / np.linalg.norm(table[:, 4:], axis=1, keepdims=True)
    return table[:, 0], lie.transform(lie.rotation_from_xyzw(quaternion), table[:, 1:4])


def eth(data: Path) -> dict[str, Any]:
    """Eye on the hand; every recording of the set."""
    figures: dict[str, Any] = {}
    place = {}
    for name in ("robot_arm_real", "robot_arm_sim", "primesense_vicon_1", "primesense_vicon_2"):
        time_hand, hand = pose_stream(data / "eth_handeye" / f"{name}_hand.csv")
        time_eye, T_target_eye = pose_stream(data / "eth_handeye" / f"{name}_eye.csv")
        begin = time.perf_counter()
        found = join_streams(time_hand, hand, time_eye, lie.inverse(T_target_eye))
        seconds = time.perf_counter() - begin
        answer = found.hand_eye
        seen = found.T_base_hand @ answer.X @ lie.inverse(T_target_eye[found.rows])
        place[name] = answer.X[:3, 3]
        figures[name] = {
            **scatter(seen, answer.Y, answer.weights),
            "lag_s": found.lag,
            "lag_std_s": found.lag_std,
            "determined": answer.determined,
            "seconds": seconds,
        }
    apart = place["primesense_vicon_1"] - place["primesense_vicon_2"]
    figures["two_recordings_apart_mm"] = float(1e3 * np.linalg.norm(apart))
    return figures


def measure(data: Path) -> dict[str, Any]:
    """All figures."""
    arm: dict[str, Any] = {"nominal_rms_mm": fr3_nominal(data)}
    for name, size in (("clean", 0.0), ("outliers_3cm", 0.03), ("outliers_20cm", 0.2)):
        corrected, alone = fr3_batch(data, size)
        arm[name] = {**corrected.json(), "body_alone": alone.json()}
        together = fr3_batch(data, size, twins_together(peers_folds()))
        arm[name]["twins_together"] = together[1].json()
        together = fr3_batch(data, size, repeats_together(data, peers_folds()))
        arm[name]["repeats_together"] = together[1].json()
    arm["recursive"] = fr3_recursive(data).json()
    arm["batch_body_alone"] = arm["clean"]["body_alone"]
    return {
        "fr3": arm,
        "talos": {
            "offsets": talos(data, ["offsets"]),
            "chosen": talos(data, None),
            "one_pass": talos_online(data),
            "from_nothing": talos_skeleton(data),
        },
        "tiago": tiago(data),
        **markerless.measure(data, STARTS),
        "ur5_artag": ur5_artag(data),
        "eth": eth(data),
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Accuracy on recordings of real robots.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    options = parser.parse_args()
    figures = measure(options.data)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
