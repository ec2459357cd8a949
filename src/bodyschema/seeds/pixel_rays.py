"""A camera and one point from pictures that show too little for a pose, such as a ball on a hand.

With P_i = R_i y + t_i where the robot says that the point is, were it y on its link:

    camera open     the pose of the point set P for the camera: resection, as for a solid target
    point open      ray_i x (R_i y + t_i) = 0 is linear in y
    both            resection for several y, the best of which are polished together

Wrong samples are held off by drawing small sets: the resection that is best in the middle wins.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.lens import straight_rays
from bodyschema.model.tree import Body
from bodyschema.seeds.pixel_poses import image_error, pose_guesses
from bodyschema.senses.ends import Ends
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.placing import polished

Array = NDArray[np.float64]

GUESSES = 0.15 * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
"""m; places of an unknown point on its link from which a resection is tried."""

DRAWS, OF = 30, 8
"""Sets of samples for a resection: with a tenth of them wrong, 13 of 30 sets of 8 are right."""


def place_by_rays(body: Body, sense: Pixels, unknown: Collection[str]) -> Body | None:
    """The body with the open ends of a sense of single points placed; None of too few samples.

    The orientation of the link's frame stays as attached.

    Args:
        body: has the lens and the scale.
        sense: one point or a few in each picture.
        unknown: frames that nobody measured.
    """
    ends = Ends.of(body, sense, unknown)
    rays = straight_rays(sense.lens_of(body), sense.observed)
    R = ends.K[:, :3, :3]
    reached = ends.K[:, :3, 3] + np.einsum("nij,nj->ni", R, sense.points(body) @ ends.Y[:3, :3].T)
    if not ends.find_x:
        return ends.placed(ends.X, ends.at(ends.Y, _point(R, reached, rays)))
    places = GUESSES if ends.find_y else GUESSES[:1]

    def parts(z: Array) -> tuple[Array, Array]:
        T_camera_world = lie.transform(lie.exp_so3(z[:3]), z[3:6])
        return T_camera_world, reached + (R @ z[6:] if ends.find_y else 0.0)

    def wrong(z: Array) -> Array:
        return image_error(*parts(z), rays).ravel()

    guesses = [
        np.concatenate([lie.log_so3(T[:3, :3]), T[:3, 3], y if ends.find_y else []])
        for y in places
        for T in _resections(reached + R @ y, rays)
    ]
    if not guesses:
        return None
    guesses.sort(key=lambda z: float(np.median(np.abs(wrong(z)))))
    z = polished(wrong, guesses[: len(places)])
    point = z[6:] if ends.find_y else np.zeros(3)
    return ends.placed(lie.inverse(parts(z)[0]), ends.at(ends.Y, point))


def _resections(P: Array, rays: Array) -> list[Array]:
    """Poses of a point set before a camera from all samples and from small draws, (4, 4) each."""
    rng = np.random.default_rng(0)
    n = len(P)
    draws = [np.arange(n)] + [rng.choice(n, min(OF, n), replace=False) for _ in range(DRAWS)]
    return [T for rows in draws for T in pose_guesses(P[rows], rays[rows])]


def _point(R: Array, reached: Array, rays: Array) -> Array:
    """The point y with R_i y + t_i on ray i, (3,) m."""
    across = lie.skew(np.hstack([rays, np.ones((len(rays), 1))]))[:, :2]
    left, right = across @ R, -np.einsum("nij,nj->ni", across, reached)

    def wrong(y: Array) -> Array:
        p = R @ y + reached
        return image_error(np.eye(4), p, rays).ravel()

    first = np.linalg.lstsq(left.reshape(-1, 3), right.ravel(), rcond=None)[0]
    return polished(wrong, [np.asarray(first)])
