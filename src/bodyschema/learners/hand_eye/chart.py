"""The nine unknowns of hand, eye and one point: chart, monomials, prediction, with derivatives.

    theta = (w, u, r_1 .. r_K),  M <- exp(w) M,   y_k = M (p + R_h r_k) - u,   M = R^T, u = M r_o

(M, -u) is T_cam_world; r_k is a tracked point in the hand. Symbols as in `stereo_points`. People
want the camera's position r_o instead of u: d r_o = M^T (d u + [u]x w), see `world_slope`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.stereo_points import MONOMIALS
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

LONGEST_TURN = 0.7
"""rad: longest rotation of one step; farther away the slope says nothing."""


@dataclass(frozen=True)
class CameraAndPoints:
    """Where the camera stands in the world and where the tracked points sit in the hand."""

    M: Array
    """(3, 3) rotation from the world to the camera."""
    u: Array
    """(3,) M r_o, in m."""
    points: Array
    """(K, 3) r_k, in m."""

    @property
    def T_world_cam(self) -> Array:
        """(4, 4)."""
        return lie.transform(self.M.T, self.M.T @ self.u)

    def move(self, delta: Array) -> CameraAndPoints:
        """After a step (6 + 3 K,) of theta; long rotations are cut, with all that goes along."""
        angle = float(np.linalg.norm(delta[:3]))
        if angle > LONGEST_TURN:
            delta = delta * (LONGEST_TURN / angle)
        M = lie.exp_so3(delta[:3]) @ self.M
        return CameraAndPoints(M, self.u + delta[3:6], self.points + delta[6:].reshape(-1, 3))

    def away_from(self, other: CameraAndPoints) -> Array:
        """(6 + 3 K,) the step that leads from the other to this one."""
        w = lie.log_so3(self.M @ other.M.T)
        return np.concatenate([w, self.u - other.u, (self.points - other.points).ravel()])

    def world_slope(self) -> Array:
        """(6 + 3 K, same) of (w in the camera, r_o in the world, points in the hand) with theta."""
        G = np.eye(6 + self.points.size)
        G[3:6, :3] = self.M.T @ lie.skew(self.u)
        G[3:6, 3:6] = self.M.T
        return G


def from_transform(T_world_cam: Array, points: Array) -> CameraAndPoints:
    """The unknowns of a camera at (4, 4) and points (K, 3) in the hand."""
    M = T_world_cam[:3, :3].T
    return CameraAndPoints(M, M @ T_world_cam[:3, 3], np.asarray(points, dtype=np.float64))


@kernel
def lift(M: Array, u: Array, r: Array, x: Array, J: Array) -> None:
    """x (40,) and J = dx/d(w, u, r), (40, 9), of one point."""
    x[:] = 0.0
    J[:] = 0.0
    for i in range(3):
        up, down = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            at = 3 * i + j
            x[at] = M[i, j]
            # Rows of [e_k]x M: d m_i / d w_k.
            J[at, up] = M[down, j]
            J[at, down] = -M[up, j]
            for k in range(3):
                x[9 + 9 * k + at] = r[k] * M[i, j]
                J[9 + 9 * k + at, up] = r[k] * M[down, j]
                J[9 + 9 * k + at, down] = -r[k] * M[up, j]
                J[9 + 9 * k + at, 6 + k] = M[i, j]
        x[36 + i] = u[i]
        J[36 + i, 3 + i] = 1.0
    x[39] = 1.0


@kernel
def normal_equations(
    M: Array, u: Array, points: Array, C: Array, N: Array, g: Array, H: Array
) -> float:
    """Sum over points of x^T (C - N) x, its half gradient g (6 + 3K,) and H = J^T C J.

    C and N are (K, 40, 40). g and H must come in as zeros.
    """
    x, J = np.empty(MONOMIALS), np.empty((MONOMIALS, 9))
    place = np.empty(9, dtype=np.int64)
    cost = 0.0
    for k in range(points.shape[0]):
        lift(M, u, points[k], x, J)
        CJ = C[k] @ J
        part = J.T @ CJ
        Qx = C[k] @ x - N[k] @ x
        cost += x @ Qx
        slope = J.T @ Qx
        for i in range(9):
            place[i] = i if i < 6 else 3 * k + i
        for i in range(9):
            g[place[i]] += slope[i]
            for j in range(9):
                H[place[i], place[j]] += part[i, j]
    return cost


@kernel
def misfit(M: Array, u: Array, points: Array, C: Array) -> float:
    """Sum over points of x^T C x."""
    x, J = np.empty(MONOMIALS), np.empty((MONOMIALS, 9))
    total = 0.0
    for k in range(points.shape[0]):
        lift(M, u, points[k], x, J)
        total += x @ (C[k] @ x)
    return total


@kernel
def innovations(
    M: Array, u: Array, points: Array, T: Array, pixels: Array, stereo: Array,
    e: Array, J: Array, depth: Array,
) -> None:  # fmt: skip
    """White innovations of moments: pixels seen less pixels predicted, over their noise.

    T (n, 4, 4) hand poses and pixels (n, K, 3) come in; e (n, K, 3), J = d prediction / d theta
    (n, K, 3, 9: w, u and the point's own r) and depth (n, K), in m, go out.
    """
    f, B = stereo[0], stereo[3]
    q, y, by = np.empty(3), np.empty(3), np.empty((3, 9))
    for n in range(T.shape[0]):
        for k in range(points.shape[0]):
            for i in range(3):
                q[i] = T[n, i, 3]
                for j in range(3):
                    q[i] += T[n, i, j] * points[k, j]
            for i in range(3):
                y[i] = M[i, 0] * q[0] + M[i, 1] * q[1] + M[i, 2] * q[2]
            by[:] = 0.0
            for i in range(3):
                up, down = (i + 1) % 3, (i + 2) % 3
                # w x (M q)
                by[i, up] = y[down]
                by[i, down] = -y[up]
                by[i, 3 + i] = -1.0
                for j in range(3):
                    by[i, 6 + j] = (
                        M[i, 0] * T[n, 0, j] + M[i, 1] * T[n, 1, j] + M[i, 2] * T[n, 2, j]
                    )
            for i in range(3):
                y[i] -= u[i]
            # Behind the camera nothing is predicted well; a tiny depth makes the misfit huge.
            z = max(y[2], 1e-3)
            depth[n, k] = y[2]
            scale = f / (stereo[4] * z)
            for row in range(3):
                s = 1 if row == 1 else 0
                a = (y[s] - (B if row == 2 else 0.0)) / z
                e[n, k, row] = (pixels[n, k, row] - stereo[1 + s] - f * a) / stereo[4]
                for j in range(9):
                    J[n, k, row, j] = scale * (by[s, j] - a * by[2, j])


def predict(
    theta: CameraAndPoints, T: Array, pixels: Array, numbers: Array
) -> tuple[Array, Array, Array]:
    """`innovations` of moments T (n, 4, 4) with pixels (n, K, 3): e, J and depth."""
    n, K = pixels.shape[:2]
    e, J, depth = np.empty((n, K, 3)), np.empty((n, K, 3, 9)), np.empty((n, K))
    innovations(
        theta.M, theta.u, theta.points, np.ascontiguousarray(T), pixels, numbers, e, J, depth
    )
    return e, J, depth
