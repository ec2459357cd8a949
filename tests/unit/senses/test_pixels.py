"""Pixels: OpenCV's lens, points out of the view, refusals, and pictures of several corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import UNSEEN, pixel_derivatives, pixels, straight_rays
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame
from bodyschema.senses.pixels import Pixels

K = np.array([[600.0, 0.0, 330.0], [0.0, 590.0, 245.0], [0.0, 0.0, 1.0]])
BENT = np.array([-0.25, 0.08, 1e-3, -2e-3, 0.01])
CAMERA = Camera("eye", "eye", 660, 490, K, BENT)
LENS = parts.lens(CAMERA).values


@pytest.fixture(scope="module")
def body() -> Body:
    """An eye one metre behind the tip, looking along z of the base, whatever the arm does."""
    arm = Body.random_chain(3, np.random.default_rng(0))
    tip = relative_pose(arm, np.zeros(3), "base", "tip")[:3, 3]
    T = np.eye(4)
    T[:3, 3] = tip - [0.0, 0.0, 1.0]
    return arm.attach("eye", "base", T).with_part("lens", parts.lens(CAMERA))


def test_pixels_are_those_of_the_camera_and_rays_undo_them() -> None:
    p = np.random.default_rng(0).uniform([-0.5, -0.4, 0.8], [0.5, 0.4, 2.0], size=(50, 3))
    image = pixels(LENS, p)
    assert image == pytest.approx(CAMERA.project(p), abs=1e-10)
    assert pixel_derivatives(LENS, p)[0] == pytest.approx(image, abs=1e-12)
    assert straight_rays(LENS, image) == pytest.approx(p[:, :2] / p[:, 2:], abs=1e-12)


@pytest.mark.parametrize("point", [[0.1, 0, -1], [0, 0, 0], [0, 0, 5e-4], [2.1, 0, 1]])
def test_what_no_picture_shows_is_far_off_and_tells_nothing(point: list[float]) -> None:
    image, by_point, by_lens = pixel_derivatives(LENS, [point])
    assert (image == UNSEEN).all()
    assert (pixels(LENS, [point]) == UNSEEN).all()
    assert not by_point.any()
    assert not by_lens.any()


def test_a_target_may_have_been_printed_too_large(body: Body) -> None:
    corner = np.array([0.1, -0.05, 0.02])
    body = body.with_part("board", parts.target(1.1))
    blank = Pixels.make(np.zeros((1, 3)), np.zeros((1, 2)), "eye", "tip", "lens", corner)
    scaled = replace(blank, scale="board")
    true = replace(blank, target=1.1 * blank.target)
    assert scaled.predict(body) == pytest.approx(true.predict(body), abs=1e-9)


def test_corners_of_one_picture_share_a_moment(body: Body) -> None:
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
    q = np.repeat(np.random.default_rng(1).uniform(-0.2, 0.2, (2, 3)), 3, axis=0)
    rows, target = np.repeat([0, 1], 3), np.tile(corners, (2, 1))
    seen = Pixels.make(q, np.zeros((6, 2)), "eye", "tip", "lens", target, time=rows, rows=rows)
    assert seen.rows.tolist() == [0, 0, 0, 1, 1, 1]
    more = seen.imagined(body, q[:4])
    assert (more.target == target[:4]).all()
    assert np.abs(more.residual(body)).max() < 1e-9


def test_a_single_point_at_the_origin_hides_the_orientation(body: Body) -> None:
    one = Pixels.make(np.zeros((1, 3)), np.zeros((1, 2)), "eye", "tip", "lens")
    assert one.shows[1] == ("link_x", "link_y", "link_z")
    two = Pixels.make(np.zeros((1, 3)), np.zeros((1, 2)), "eye", "tip", "lens", [0, 0, 0.1])
    assert len(two.shows[1]) == 6
    turns = free_frame(body, "tip", only=("turn_x", "turn_y", "turn_z"))
    assert not one.linearize(body, turns, np.zeros(3)).by_parameter.any()


def test_refusals(body: Body) -> None:
    q, image = np.zeros((2, 3)), np.zeros((2, 2))
    with pytest.raises(InputError, match="name the camera's lens"):
        Pixels.make(q, image, "eye", "tip", "")
    with pytest.raises(InputError, match=r"seen should have shape \(2, 3\), it has \(5, 3\)"):
        Pixels.make(q, image, "eye", "tip", "lens", np.zeros((5, 3)))
    with pytest.raises(InputError, match="not a finite number in row 1"):
        Pixels.make(q, [[0, 0], [np.nan, 0]], "eye", "tip", "lens")
    with pytest.raises(InputError, match=r"no part 'lenz'.*did you mean 'lens'"):
        Pixels.make(q, image, "eye", "tip", "lenz").predict(body)
    with pytest.raises(InputError, match="part 'c' is a clock, not a lens"):
        Pixels.make(q, image, "eye", "tip", "c").predict(body.with_part("c", parts.clock()))
