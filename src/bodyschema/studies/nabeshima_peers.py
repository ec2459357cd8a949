"""Other ways to hand and eye, on the same postures: full poses of a known marker, or all the data.

Full-pose methods need a marker of known size: four corners of a 60 mm square in the hand, at the
tracked point, seen by the same stereo camera with the same noise; the marker's pose is the one with
the smallest pixel residuals in both images. Then, for every posture i,
T_world_hand(i) T_hand_marker = T_world_cam T_cam_marker(i). OpenCV 4's and kinhec's solvers join
where they are installed.

Batch maximum likelihood keeps every sample and minimises the true pixel residuals from the same
tracked point: the bound for every method that sees no more.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.relation_fit import Normal, descend
from bodyschema.learners.hand_eye.chart import CameraAndPoints, predict
from bodyschema.learners.hand_eye.stereo_points import Stereo
from bodyschema.seeds.closed_forms import align_points, mean_transform, solve_ky_xt
from bodyschema.simulation.katana import Scene, perceive

Array = NDArray[np.float64]

Answer = tuple[Array, Array]
"""T_world_cam (4, 4), and the marker's centre in the hand (3,)."""

SIDE = 0.06
"""m: edge of the marker."""

CORNERS = SIDE / 2 * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])


class _Reprojection:
    """Squared pixel residuals of the marker's corners at one posture; a `relation_fit.Problem`.

    A hand at rest in the origin that holds the known corners makes T_cam_marker = (M, -u).
    """

    def __init__(self, pixels: Array, eyes: Stereo) -> None:
        self.pixels, self.eyes = pixels, eyes

    def normal(self, theta: CameraAndPoints) -> Normal:
        e, J, _ = predict(theta, np.eye(4)[None], self.pixels[None], self.eyes.numbers)
        rows, seen = J[0, :, :, :6].reshape(-1, 6), e.ravel()
        return Normal(float(seen @ seen), -rows.T @ seen, rows.T @ rows)

    def move(self, theta: CameraAndPoints, delta: Array) -> CameraAndPoints:
        return theta.move(np.append(delta, np.zeros(theta.points.size)))


def marker_poses(
    scene: Scene, T_world_hand: Array, eyes: Stereo, rng: np.random.Generator
) -> Array:
    """T_cam_marker (n, 4, 4) that explain the corners' pixels best, at the hand's poses."""
    corners = Scene(scene.T_world_cam, scene.points[0] + CORNERS)
    pixels = perceive(corners, T_world_hand, eyes, rng)
    poses = []
    for seen, four in zip(pixels, eyes.triangulate(pixels), strict=True):
        T = align_points(CORNERS, four, np.ones(4))
        theta, _, _ = descend(
            _Reprojection(seen, eyes), CameraAndPoints(T[:3, :3], -T[:3, 3], CORNERS)
        )
        poses.append(lie.transform(theta.M, -theta.u))
    return np.array(poses)


def batch_likelihood(
    start: CameraAndPoints, T_world_hand: Array, pixels: Array, eyes: Stereo
) -> CameraAndPoints:
    """Gauss-Newton on all stored pixels of one point, from a good start."""
    theta = start
    for _ in range(8):
        e, J, _ = predict(theta, T_world_hand, pixels, eyes.numbers)
        rows, seen = J.reshape(-1, 9), e.reshape(-1)
        theta = theta.move(np.asarray(np.linalg.solve(rows.T @ rows, rows.T @ seen)))
    return theta


def peers() -> dict[str, Callable[[Array, Array], Answer]]:
    """Name -> solver of (T_world_hand, T_cam_marker), for all that are installed."""
    found: dict[str, Callable[[Array, Array], Answer]] = {"shah_ours": _shah}
    found |= _of_opencv()
    try:
        import kinhec.solvers as kinhec
    except ImportError:
        return found

    def refined(K: Array, T: Array) -> Answer:
        # kinhec's A X = Y B: A the hand, B the marker seen, Y the camera, X the marker in the hand.
        X, Y = kinhec.shah(K, T)
        X, Y = kinhec.refine_lm_axyb(K, T, X, Y)
        return np.asarray(Y), np.asarray(X)[:3, 3]

    return found | {"kinhec_shah_lm": refined}


def _shah(K: Array, T: Array) -> Answer:
    X, Y = solve_ky_xt(K, T, np.ones(len(K)))
    return X, Y[:3, 3]


def _of_opencv() -> dict[str, Callable[[Array, Array], Answer]]:
    """OpenCV 4's solvers; OpenCV 5 has none."""
    try:
        import cv2
    except ImportError:
        return {}
    opencv: Any = cv2
    if not hasattr(opencv, "calibrateHandEye"):
        return {}
    methods = {"tsai": 0, "park": 1, "horaud": 2, "daniilidis": 4}

    def solver(method: int) -> Callable[[Array, Array], Answer]:
        def solve(K: Array, T: Array) -> Answer:
            # The camera stands still: OpenCV's "gripper to base" is the base seen from the hand.
            back = lie.inverse(K)
            R, t = opencv.calibrateHandEye(
                list(back[:, :3, :3]), list(back[:, :3, 3]), list(T[:, :3, :3]), list(T[:, :3, 3]),
                method=method,
            )  # fmt: skip
            camera = lie.transform(R, np.ravel(t))
            marker = mean_transform(back @ camera @ T, np.ones(len(K)))
            return camera, marker[:3, 3]

        return solve

    return {f"opencv_{name}": solver(number) for name, number in methods.items()}
