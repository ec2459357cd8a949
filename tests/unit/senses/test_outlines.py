"""Outlines: promises of a sense, arcs of contour, and what is found in pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.outlines import Outlines
from bodyschema.testing import check_sense
from bodyschema.vision.arcs import ARC
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

pytest.importorskip("cv2")

Array = NDArray[np.float64]

CAMERA = bs.Camera.from_fov("eye", "eye", 320, 240, 1.0)
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)], dtype=float)
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
PARTS = {"lens": "lens", "edge": "edge", "skin": "skin"}


def arm() -> Body:
    """A post that stands still and two boxes that turn before a camera."""
    body = Body.build(
        "arm",
        ["base", "upper", "lower"],
        ["", "shoulder", "elbow"],
        [-1, 0, 1],
        [0, 1, 1],
        [[0, 0, 1], [0, 1, 0], [0.1, 1, 0.2] / np.linalg.norm([0.1, 1, 0.2])],
        lie.transform(np.tile(np.eye(3), (3, 1, 1)), [[0, 0, 0], [0, 0, 0.2], [0, 0, 0.25]]),
    )
    R = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) @ lie.exp_so3([0.0, 0.0, 0.05])
    body = body.attach("eye", "base", lie.transform(R, [0.1, -1.2, 0.35]))
    body = body.with_part("lens", parts.lens(CAMERA)).with_part("edge", parts.edge())
    body = body.with_part("skin", parts.skin(4 * 3))
    return body.with_part("clock", parts.clock(0.01))


def surface() -> Surface:
    sizes = {"base": [0.05, 0.04, 0.2], "upper": [0.03, 0.03, 0.25], "lower": [0.03, 0.02, 0.2]}
    return Surface.build({name: (CORNERS * size, FACES) for name, size in sizes.items()})


def variables(body: Body) -> Variables:
    held = [free_part(body, part) for part in ("edge", "skin", "clock")]
    lens = free_part(body, "lens", ("fx", "fy", "cx", "cy"))
    frame = free_frame(body, "eye", 0.1, 0.1)
    return join(free_joints(body, ("offsets", "axes", "links")), frame, lens, *held)


def masks(body: Body, q: Array) -> list[NDArray[np.bool_]]:
    poses = piece_poses(body, q, [CAMERA], surface().frames)[:, 0]
    return [silhouette(surface(), pose, CAMERA) for pose in poses]


Q = np.array([[0.2, 0.5], [-0.3, 0.8], [0.6, -0.7]])


def look(body: Body, seen: Body, **more: object) -> Outlines:
    """Masks of one body, looked at as another."""
    return Outlines.make(body, Q, masks(seen, Q), CAMERA, surface(), patches=4, **PARTS, **more)  # type: ignore[arg-type]


def test_it_keeps_the_promises_of_a_sense() -> None:
    body = arm()
    some = look(body, body, clock="clock", rate=np.ones((3, 2))).take(slice(0, 40, 7))
    check_sense(some, body, variables(body))


def test_at_the_truth_the_outline_lies_where_it_is_imagined() -> None:
    body = arm()
    sense = look(body, body)
    assert np.median(np.abs(sense.residual(body))) < 0.2
    assert sense.matched(body) > 0.97
    assert sense.share.sum(axis=1) == pytest.approx(1.0)
    off = body.with_variables(free_joints(body, ["offsets"]), [0.1, 0.1])
    assert sense.matched(off) < 0.6


def test_what_stands_still_counts_once() -> None:
    body = arm()
    sense = look(body, body)
    views = [np.unique(sense.view[sense.piece == piece]).tolist() for piece in range(3)]
    assert views == [[0], [0, 1, 2], [0, 1, 2]]


def test_rounds_of_association_bring_the_joints_home() -> None:
    body = arm()
    free = free_joints(body, ["offsets"])
    truth = np.array([0.12, -0.15])
    sense, x = look(body, body.with_variables(free, truth)), np.zeros(2)
    for _ in range(6):
        L = sense.linearize(body, free, x)
        J, r = L.by_parameter[:, 0], L.residual[:, 0]
        w = 1 / (1 + (r / max(1.0, float(np.median(np.abs(r))))) ** 2)
        x = x - np.linalg.solve(J.T @ (w[:, None] * J), J.T @ (w * r))
        sense = sense.associate(body.with_variables(free, x))
    assert x == pytest.approx(truth, abs=2e-3)
    assert sense.reach == 4.0


def test_an_imagined_outline_is_the_bodys_own() -> None:
    body = arm()
    thick = replace(body.part("skin"), values=np.full(12, 1e-3))
    body = body.with_part("skin", thick).with_part("edge", parts.edge().moved(np.array([0]), 0.5))
    blank = Outlines.blank(CAMERA, surface(), 2, patches=4, **PARTS)
    there = blank.imagined(body, Q)
    assert np.unique(there.rows).tolist() == [0, 1, 2]
    assert np.abs(there.residual(body)).max() < 1e-9
    assert len(there) > 3 * 10
    assert there.associate(body).residual(body) == pytest.approx(there.residual(body), abs=1e-9)


def test_images_are_searched_by_their_slopes() -> None:
    body = arm()
    images = [np.where(mask, 40, 200).astype(np.uint8) for mask in masks(body, Q)]
    sense = Outlines.make(body, Q, images, CAMERA, surface(), polarity=1.0)
    assert np.median(np.abs(sense.residual(body))) < 0.3
    assert sense.label == "outline seen from eye"


def test_pictures_and_postures_come_in_pairs() -> None:
    body = arm()
    with pytest.raises(InputError, match="2 pictures and 3 postures"):
        Outlines.make(body, Q, masks(body, Q)[:2], CAMERA, surface())
    with pytest.raises(InputError, match="a mask"):
        Outlines.make(body, Q, [np.zeros((240, 320))] * 3, CAMERA, surface())


def test_pictures_that_were_left_out_stay_out() -> None:
    body = arm()
    sense = look(body, body)
    some = sense.take(sense.rows < 2)
    assert np.unique(some.associate(body).rows).tolist() == [0, 1]
    far = look(body.with_variables(free_joints(body, ["offsets"]), [1.5, 0.5]), body, reach=3.0)
    home = far.associate(body)
    assert set(far.rows.tolist()) | set(far.unseen) == {0, 1, 2}
    assert np.unique(home.rows).tolist() == [0, 1, 2]


def test_arcs_are_as_long_as_is_asked_for() -> None:
    body = arm()
    fine, coarse = (look(body, body, arc=arc) for arc in (ARC / 2, ARC))
    assert len(fine) > 1.4 * len(coarse)
