"""Poses from pictures, against OpenCV, and cameras and points that only single points show."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import pixels, straight_rays
from bodyschema.model.tree import Body
from bodyschema.seeds.pixel_poses import pose_of_points, seen_poses
from bodyschema.seeds.pixel_rays import place_by_rays
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.distances import Distances
from bodyschema.senses.pixels import Pixels
from simulated import angle, forgotten

Array = NDArray[np.float64]

K = np.array([[600.0, 0.0, 330.0], [0.0, 590.0, 245.0], [0.0, 0.0, 1.0]])
BENT = np.array([-0.25, 0.08, 1e-3, -2e-3, 0.01])
LENS = np.concatenate([[600.0, 590.0, 330.0, 245.0], BENT])

GRID = 0.03 * np.stack([*np.mgrid[-3:4, -2:3], np.zeros((7, 5))], axis=-1).reshape(-1, 3)
SOLID = np.random.default_rng(8).uniform(-0.1, 0.1, (12, 3))
CORNERS = GRID[[0, 4, 30, 34]]


def shown(points: Array, rng: np.random.Generator) -> Array:
    """A pose 0.4 to 0.9 m before the camera, tilted by up to a radian."""
    turn = lie.exp_so3(rng.uniform(-0.6, 0.6, 3)) @ lie.exp_so3([np.pi, 0, 0])
    return lie.transform(turn, rng.uniform([-0.1, -0.1, 0.4], [0.1, 0.1, 0.9]))


@pytest.mark.parametrize("points", [GRID, SOLID, CORNERS], ids=["board", "solid", "corners"])
def test_the_pose_of_exact_points_is_exact(points: Array) -> None:
    for seed in range(10):
        T = shown(points, np.random.default_rng(seed))
        image = pixels(LENS, points @ T[:3, :3].T + T[:3, 3])
        found = pose_of_points(points, straight_rays(LENS, image))
        assert found == pytest.approx(T, abs=1e-8)


def test_noisy_boards_are_placed_as_well_as_by_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    ours, theirs = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        T = shown(GRID, rng)
        image = pixels(LENS, GRID @ T[:3, :3].T + T[:3, 3]) + rng.normal(size=(35, 2))
        found = pose_of_points(GRID, straight_rays(LENS, image))
        assert found is not None
        _, _, place = cv2.solvePnP(GRID, image, K, BENT)
        ours.append(np.linalg.norm(found[:3, 3] - T[:3, 3]))
        theirs.append(np.linalg.norm(place.ravel() - T[:3, 3]))
    assert np.median(ours) < 1.1 * np.median(theirs)


@pytest.mark.parametrize("points", [GRID[:3], GRID[:5], GRID[:1]], ids=["few", "line", "one"])
def test_too_few_points_have_no_pose(points: Array) -> None:
    T = shown(points, np.random.default_rng(0))
    rays = straight_rays(LENS, pixels(LENS, points @ T[:3, :3].T + T[:3, 3]))
    assert pose_of_points(points, rays) is None


def watching(n: int, rng: np.random.Generator) -> tuple[Body, Array]:
    """An arm, an eye beside it that sees its tip, a board on the tip, and postures (n, 4)."""
    arm = Body.random_chain(4, rng)
    q = rng.uniform(-1.5, 1.5, (40 * n, 4))
    tip = relative_pose(arm, q, "base", "tip")[:, :3, 3].mean(axis=0)
    R = lie.exp_so3(rng.normal(size=3))
    arm = arm.attach("eye", "base", lie.transform(R, tip - 1.5 * R[:, 2]))
    arm = arm.attach("board", "tip", lie.transform(lie.exp_so3(rng.normal(size=3)), [0.03] * 3))
    camera = Camera("eye", "eye", 660, 490, K, BENT)
    return arm.with_part("lens", parts.lens(camera)), q[:n]


def seen(body: Body, q: Array, points: Array, rng: np.random.Generator) -> Pixels:
    """Pictures of all points at every posture, with noise of half a pixel."""
    m = len(points)
    samples = np.repeat(q, m, axis=0)
    rows = np.repeat(np.arange(len(q)), m)
    blank = Pixels.make(
        samples, np.zeros((len(samples), 2)), "eye", "board", "lens",
        np.tile(points, (len(q), 1)), time=0.1 * rows, rows=rows,
    )  # fmt: skip
    image = blank.predict(body) + 0.5 * rng.normal(size=(len(samples), 2))
    made = Pixels.make(
        samples, image, "eye", "board", "lens", blank.target, time=blank.time, rows=rows
    )
    return made.take((np.abs(blank.predict(body)) < 5e3).all(axis=1))


def test_each_picture_becomes_one_pose_with_its_row() -> None:
    body, q = watching(6, np.random.default_rng(0))
    sense = seen(body, q, GRID, np.random.default_rng(1))
    poses = seen_poses(body, sense)
    assert poses is not None
    assert poses.rows.tolist() == sorted(set(sense.rows.tolist()))
    assert (poses.q == q[poses.rows]).all()
    assert poses.residual(body)[:, :3] == pytest.approx(np.zeros((len(poses), 3)), abs=0.02)
    assert seen_poses(body, seen(body, q, GRID[:3], np.random.default_rng(1))) is None


@pytest.mark.parametrize("points", [GRID, GRID[:1]], ids=["boards", "one point"])
def test_frames_start_from_pictures_of_either_kind(points: Array) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        body, q = watching(60, rng)
        sense = seen(body, q, points, rng)
        found = start_frames(forgotten(body, ("eye", "board")), ("eye", "board"), [sense])
        assert np.median(np.abs(sense.residual(found))) < 2.0


def test_the_sense_that_shows_more_places_a_frame() -> None:
    """A wire to the eye tells where it is, and not how it is turned."""
    rng = np.random.default_rng(0)
    body, q = watching(60, rng)
    sense = seen(body, q, GRID, rng)
    length = np.linalg.norm(relative_pose(body, q, "eye", "board")[:, :3, 3], axis=1)
    wire = Distances.make(q, length, "eye", "board")
    found = start_frames(forgotten(body, ("eye", "board")), ("eye", "board"), [wire, sense])
    assert np.median(np.abs(sense.residual(found))) < 2.0


def test_too_few_pictures_start_nothing() -> None:
    rng = np.random.default_rng(0)
    body, q = watching(60, rng)
    few = seen(body, q, GRID[:1], rng).take([0, 1, 2])
    with pytest.raises(InputError, match="can place it from nothing"):
        start_frames(forgotten(body, ("eye", "board")), ("eye", "board"), [few])


@pytest.mark.parametrize("unknown", [("eye",), ("board",), ("eye", "board")], ids="+".join)
@pytest.mark.parametrize("bad", [0.0, 0.1])
def test_a_single_point_places_camera_and_point(unknown: tuple[str, ...], bad: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        body, q = watching(60, rng)
        sense = seen(body, q, np.zeros((1, 3)), rng)
        wrong = rng.choice(len(sense), int(bad * len(sense)), replace=False)
        sense.observed[wrong] += rng.uniform(-100, 100, (len(wrong), 2))
        found = place_by_rays(forgotten(body, unknown), sense, unknown)
        eye = [b.placement[b.frame_index("eye")] for b in (found, body)]
        point = [b.placement[b.frame_index("board")][:3, 3] for b in (found, body)]
        assert angle(*eye) < 0.02
        assert np.linalg.norm(eye[0][:3, 3] - eye[1][:3, 3]) < 0.03
        assert np.linalg.norm(point[0] - point[1]) < 0.01
