"""A wrist camera looks at a board: where is the camera, where is the board, is the arm right?

Nobody measured either. The board gives a full pose in every image, so the sense is `Poses`: the
board is the frame that looks, the camera is what is looked at.

python examples/02_wrist_camera.py
"""

from __future__ import annotations

import numpy as np

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.kinematics import relative_pose

NOISE = (1e-3, 2e-3)  # m and rad: of a small board, half a metre away
rng = np.random.default_rng(2)


def placed(turn: list[float], at: list[float]) -> np.ndarray:
    """A transform from a rotation vector (rad) and a position (m)."""
    return lie.transform(lie.exp_so3(turn), at)


def distance(T: np.ndarray, other: np.ndarray) -> str:
    """How far apart two transforms are, in words."""
    turn = np.rad2deg(np.linalg.norm(lie.log_so3(T[:3, :3] @ other[:3, :3].T)))
    return f"{1e3 * np.linalg.norm(T[:3, 3] - other[:3, 3]):.2f} mm and {turn:.2f} deg off"


def look(body: bs.Body, q: np.ndarray) -> bs.Poses:
    """Poses of the camera in the board, as a detector would report them."""
    pose = relative_pose(body, q, "board", "camera")
    pose[:, :3, 3] += NOISE[0] * rng.normal(size=(len(q), 3))
    pose[:, :3, :3] = lie.exp_so3(NOISE[1] * rng.normal(size=(len(q), 3))) @ pose[:, :3, :3]
    return bs.Poses.make(q, pose, seen_from="board", seen="camera", std=NOISE)


arm = bs.Body.random_chain(6, rng)
truth = arm.attach("board", "base", placed([0.1, 0.2, -0.4], [0.5, 0.1, 0.0]))
truth = truth.attach("camera", "tip", placed([0.0, 1.4, 0.3], [0.03, 0.0, 0.06]))
nominal = arm.attach("board", "base").attach("camera", "tip")
unknown = {"board": "no", "camera": "no"}
q = rng.uniform(-1.2, 1.2, (30, 6))

print("An arm that is as modelled")
answer = bs.calibrate(nominal, [look(truth, q)], unknown)
print(f"  {answer.verdict}: {answer.explanation}")
for frame in unknown:
    k = answer.body.frame_index(frame)
    print(f"  {frame}: {distance(answer.body.placement[k], truth.placement[k])}")

print("The same arm with three wrong joint zeros")
zeros = bs.free_joints(arm, ["offsets"], ["joint_2", "joint_3", "joint_5"])
wrong = truth.with_variables(zeros, np.deg2rad([2.0, -1.5, 3.0]))
answer = bs.calibrate(nominal, [look(wrong, q)], unknown)
print(f"  {answer.verdict}: {answer.explanation}")
for name in zeros.names:
    i = answer.estimate.variables.names.index(name)
    x, std = np.rad2deg(answer.estimate.x[i]), np.rad2deg(answer.estimate.std[i])
    print(f"  {name}: {x:+.2f} +- {std:.2f} deg")
print("What the images cannot tell")
for sentence in answer.identifiability.sentences:
    print("  -", sentence)
