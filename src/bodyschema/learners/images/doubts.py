"""What cameras and meshes may have wrong, and what that does to the outline of the body.

For a rim point p with outward normal n, seen by camera c and lying on patch m of the mesh, the seen
outline lies outward of the imagined one by

    b_c + n.(p - c_c) s_c + n.u_c + |n^T P| h_m

b_c   pixels, of a mask or an edge that lies outward all round the body
s_c   relative error of the focal length
u_c   (2,) pixels, error of the principal point c_c
h_m   m, that the body is thicker there than its mesh; P = d pi / dX

Cameras may also be turned a little against what carries them: those turns are parameters of the
body (`free_frame`). None of these is of interest, but whoever takes them for zero is too sure: they
do not average out over pictures. They are estimated along, each with its own prior, and what they
leave open of the body shows in its covariance. Lens and turns are drawn; b and h only counted, as
they are small and act along the normal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import FIXED, TURN
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, join
from bodyschema.vision.correspondences import Rim
from bodyschema.vision.patches import Patches

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

PER_CAMERA = 4
"""b, s, u_x, u_y."""


@dataclass(frozen=True)
class Doubts:
    """Standard deviations; 0 takes cameras and meshes at their word."""

    edge: float = 1.0
    """pixels, b."""
    focal: float = 0.005
    """s, a share of the focal length."""
    centre: float = 1.0
    """pixels, each component of u."""
    turn: float = float(np.deg2rad(0.1))
    """rad, each component of a camera's turn, where its mounting is not looked for anyway."""
    shape: float = 3e-4
    """m, h: of a patch, outward or inward."""
    patches: int = 24
    """Of each piece of the surface; h differs from one to the next."""

    def __post_init__(self) -> None:
        for name in ("edge", "focal", "centre", "turn", "shape"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(
                    f"the doubt '{name}' is {value}; give a standard deviation, 0 or more."
                )

    def turns(self, body: Body, wanted: Variables, cameras: Sequence[Camera]) -> Variables:
        """The turns of those cameras that are fixed to something and not looked for anyway."""
        found = wanted.take([])
        for frame in dict.fromkeys(camera.frame for camera in cameras):
            node = body.frame_index(frame)
            fixed = node > 0 and body.kind[node] == FIXED
            if self.turn and fixed and f"frame:{frame}" not in wanted.groups:
                mounting = free_frame(body, frame, 1.0, self.turn)
                found = join(found, mounting.take(np.flatnonzero(mounting.code == TURN).tolist()))
        return found

    def std(self, n_cameras: int, n_patches: int) -> Array:
        """Of (b, s, u) of every camera and of h, (PER_CAMERA n_cameras + n_patches,)."""
        one = [self.edge, self.focal, self.centre, self.centre]
        return np.array(one * n_cameras + [self.shape] * n_patches)

    def outward(self, rim: Rim, gain: Array, cameras: Sequence[Camera], patches: Patches) -> Array:
        """How far the outline moves, (n, PER_CAMERA n_cameras + n_patches) pixels per unit.

        Args:
            rim: of the body as imagined.
            gain: (n,) |n^T P|, see `outward_gain`.
            cameras: as drawn.
            patches: of the surface.
        """
        K = np.array([camera.intrinsics for camera in cameras])[rim.camera]
        own = np.zeros((len(rim), len(cameras), PER_CAMERA))
        i = np.arange(len(rim))
        own[i, rim.camera, 0] = 1.0
        own[i, rim.camera, 1] = np.sum(rim.normal * (rim.pixel - K[:, 2:]), axis=1)
        own[i, rim.camera, 2:] = rim.normal
        thick = np.zeros((len(rim), len(patches)))
        if len(patches):
            thick[i, patches.of_rim(rim)] = gain
        return np.hstack([own.reshape(len(rim), PER_CAMERA * len(cameras)), thick])


def drawn(n_cameras: int, n_patches: int) -> Flags:
    """Which of the doubts change what is drawn: those of the lens."""
    return np.array([False, True, True, True] * n_cameras + [False] * n_patches)


def corrected(cameras: Sequence[Camera], y: Array) -> tuple[Camera, ...]:
    """The cameras by what is believed of their lenses.

    Args:
        cameras: as they were given.
        y: (PER_CAMERA n_cameras + n_patches,) doubts.
    """
    lenses = y[: PER_CAMERA * len(cameras)].reshape(-1, PER_CAMERA)
    return tuple(
        _moved(camera, lens[1], lens[2:]) for camera, lens in zip(cameras, lenses, strict=True)
    )


def _moved(camera: Camera, s: float, u: Array) -> Camera:
    K = camera.matrix.copy()
    K[[0, 1], [0, 1]] *= np.exp(s)
    K[:2, 2] += u
    return replace(camera, matrix=K)
