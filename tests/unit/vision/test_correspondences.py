"""The outer contour and how it moves, against the triangles themselves in double precision.

The line p + t n meets each projected triangle in an interval of t; the silhouette ends where the
union of the intervals that begins inside ends. No kernel of the library takes part in this.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.errors import InputError
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.correspondences import Rim, RimSlopes, find_rim, rim_slopes
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface
from icub_arm import arm, beside_the_eye, eyes, readings
from referees import ray_silhouette

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
FREE = bs.join(
    bs.free_joints(BODY, ["offsets"], [*icub.NECK, *icub.RIGHT_ARM]),
    bs.free_joints(BODY, ["axes", "links"], ["r_elbow", "r_wrist_yaw"]),
    bs.free_frame(BODY, icub.LEFT_EYE),
)


def triangles(surface: Surface, T: Array, camera: bs.Camera) -> Array:
    """Corners of all triangles in pixels, (m, 3, 2)."""
    piece = np.repeat(np.arange(len(surface.frames)), np.diff(surface.vo))
    points = np.einsum("vij,vj->vi", T[piece, :3, :3], surface.vertices) + T[piece, :3, 3]
    return camera.project(points)[surface.faces]


def intervals(corners: Array, pixel: Array, normal: Array) -> Array:
    """Where the line pixel + t normal is inside triangles, (k, 2), empty ones left out."""
    a, b = corners, np.roll(corners, -1, axis=1)
    side = b - a
    turn = np.sign(np.linalg.det(side[:, :2]))[:, None]
    inward = np.stack([-side[..., 1], side[..., 0]], axis=-1) * turn[..., None]
    rate = inward @ normal
    level = np.sum(inward * (pixel - a), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -level / rate
    enter = np.where(rate > 0, at, np.where((rate == 0) & (level < 0), np.inf, -np.inf)).max(axis=1)
    leave = np.where(rate < 0, at, np.inf).min(axis=1)
    kept = (enter < leave) & (turn[:, 0] != 0)
    return np.stack([enter[kept], leave[kept]], axis=1)


def outline(corners: Array, pixel: Array, normal: Array, depth: float = 1e-3) -> float:
    """t at which the part of the silhouette ends that holds pixel - depth normal."""
    spans, end = intervals(corners, pixel, normal), -depth
    while True:
        further = spans[(spans[:, 0] <= end) & (spans[:, 1] > end), 1]
        if not len(further):
            return end
        end = further.max()


@pytest.fixture(scope="module")
def views() -> list[tuple[Array, Array, Rim]]:
    """Some postures, their poses (2, 3, 4, 4) and contours."""
    found = []
    for q in readings(20)[[0, 4, 9]]:
        T = piece_poses(BODY, q, eyes(), arm().frames)[0]
        found.append((q, T, find_rim(arm(), T, eyes())))
    return found


def test_nothing_is_just_outside_of_any_point_and_the_body_just_inside(
    views: list[tuple[Array, Array, Rim]],
) -> None:
    for _, T, rim in views:
        assert len(rim) > 500
        for c, camera in enumerate(eyes()):
            corners = triangles(arm(), T[c], camera)
            for i in np.flatnonzero(rim.camera == c):
                spans = intervals(corners, rim.pixel[i], rim.normal[i])
                inside, outside = (
                    ((spans[:, 0] < t) & (spans[:, 1] > t)).any() for t in (-2e-3, 2e-3)
                )
                assert inside
                assert not outside


def test_points_lie_on_the_surface_where_they_are_seen(
    views: list[tuple[Array, Array, Rim]],
) -> None:
    for _, T, rim in views:
        poses = T[rim.camera, rim.piece]
        seen = np.einsum("nij,nj->ni", poses[:, :3, :3], rim.point) + poses[:, :3, 3]
        for c, camera in enumerate(eyes()):
            mine = rim.camera == c
            np.testing.assert_allclose(camera.project(seen[mine]), rim.pixel[mine], atol=1e-9)
        on_a_line = np.abs(rim.pixel - np.rint(rim.pixel)).min(axis=1)
        assert on_a_line.max() < 1e-9
        np.testing.assert_allclose(np.linalg.norm(rim.normal, axis=1), 1)


def test_no_part_of_the_contour_is_left_out() -> None:
    """Round a body in full view: area = 1/2 integral of p.n, and no sum of normals is left."""
    hand = Surface.of(BODY, ["r_hand"])
    camera = eyes()[0]
    T = np.eye(4)[None]
    T[0, :3, 3] = [0.06, 0.0, 0.5]
    rim = find_rim(hand, T[None], [camera])
    area = (
        np.sum(rim.length * np.sum((rim.pixel - rim.pixel.mean(axis=0)) * rim.normal, axis=1)) / 2
    )
    assert area == pytest.approx(silhouette(hand, T, camera).sum(), rel=0.01)
    assert np.abs(rim.length @ rim.normal).max() < 0.02 * rim.length.sum()
    half = find_rim(hand, T[None], [camera], step=2)
    assert len(half) == pytest.approx(len(rim) / 2, rel=0.05)
    assert half.length.sum() == pytest.approx(rim.length.sum(), rel=0.03)


def worst_slope_error(
    q: Array, T: Array, rim: Rim, slopes: RimSlopes, points: int, seed: int
) -> float:
    """Largest error of a derivative, relative to the largest of its parameter."""
    rng, h, worst = np.random.default_rng(seed), 1e-7, 0.0
    chosen = rng.choice(len(rim), points, replace=False)
    bases = [triangles(arm(), T[c], camera) for c, camera in enumerate(eyes())]
    for k in range(len(FREE)):
        step = h * (np.arange(len(FREE)) == k)
        moved = [
            piece_poses(BODY.with_variables(FREE, s * step), q, eyes(), arm().frames)[0]
            for s in (1, -1)
        ]
        ends = np.zeros((points, 2))
        for c, camera in enumerate(eyes()):
            sides = [triangles(arm(), side[c], camera) for side in moved]
            for n, i in enumerate(chosen):
                if rim.camera[i] != c:
                    continue
                low, high = bases[c].min(axis=1) - 1, bases[c].max(axis=1) + 1
                near = ((low <= rim.pixel[i]) & (rim.pixel[i] <= high)).all(axis=1)
                ends[n] = [outline(side[near], rim.pixel[i], rim.normal[i]) for side in sides]
        difference = (ends[:, 0] - ends[:, 1]) / (2 * h)
        exact = slopes.by_parameter[chosen, k]
        scale = np.abs(slopes.by_parameter[:, k]).max()
        worst = max(worst, np.abs(difference - exact).max() / scale)
    return worst


def test_slopes_are_those_of_the_silhouette(views: list[tuple[Array, Array, Rim]]) -> None:
    q, T, rim = views[1]
    slopes = rim_slopes(rim, arm(), eyes(), BODY, FREE, np.zeros(len(FREE)), q)
    assert worst_slope_error(q, T, rim, slopes, points=60, seed=0) < 1e-6


def test_an_offset_of_a_joint_and_its_reading_move_the_contour_alike(
    views: list[tuple[Array, Array, Rim]],
) -> None:
    q, _, rim = views[0]
    slopes = rim_slopes(rim, arm(), eyes(), BODY, FREE, np.zeros(len(FREE)), q)
    for k, name in enumerate((*icub.NECK, *icub.RIGHT_ARM)):
        by_reading = slopes.by_joint[:, BODY.joint_index(name)]
        np.testing.assert_allclose(slopes.by_parameter[:, k], by_reading, atol=1e-9)


def test_the_silhouette_grows_as_its_slopes_say() -> None:
    """d area / d x = integral of the outward slope, by super-sampled silhouettes."""
    q, h = readings(20)[4], 5e-3
    large = eyes(1280, 960)
    T = piece_poses(BODY, q, large, arm().frames)[0]
    rim = find_rim(arm(), T, large)
    slopes = rim_slopes(rim, arm(), large, BODY, FREE, np.zeros(len(FREE)), q)
    for k in (3, 5, 6):  # offsets of shoulder pitch, shoulder yaw and elbow
        step = h * (np.arange(len(FREE)) == k)
        areas = [
            silhouette(
                arm(),
                piece_poses(BODY.with_variables(FREE, s * step), q, large, arm().frames)[0, 0],
                large[0],
            ).sum()
            for s in (1.0, -1.0)
        ]
        mine = rim.camera == 0
        expected = rim.length[mine] @ slopes.by_parameter[mine, k]
        scale = rim.length[mine] @ np.abs(slopes.by_parameter[mine, k])
        assert (areas[0] - areas[1]) / (2.0 * h) == pytest.approx(expected, abs=0.02 * scale)


def test_poses_of_another_shape_are_refused() -> None:
    with pytest.raises(InputError, match="2 cameras, 3 pieces"):
        find_rim(arm(), np.eye(4)[None, None], eyes())


def test_an_arm_beside_the_camera_has_a_contour_before_the_near_plane_alone() -> None:
    """Just outside of it nothing is seen, just inside the arm is, by ray casting at four times
    the size; what the near plane cuts makes no points."""
    pytest.importorskip("embreex")
    surface, camera, points = arm(decimated=False), eyes()[0], 0
    for T in beside_the_eye(30):
        mask = np.pad(ray_silhouette(surface, T, eyes(1280, 960)[0]), 8, mode="edge")
        rim = find_rim(surface, T[None], [camera])
        poses = T[rim.piece]
        depth = np.einsum("nj,nj->n", poses[:, 2, :3], rim.point) + poses[:, 2, 3]
        assert (depth >= 0.01).all()
        for away, expected in ((-0.4, True), (0.4, False)):
            at = np.rint((rim.pixel + away * rim.normal + 0.5) * 4 - 0.5).astype(int) + 8
            assert (mask[at[:, 1], at[:, 0]] == expected).all()
        points += len(rim)
    assert points > 200
