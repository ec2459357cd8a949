"""Pictures of the cells that are me."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.overlay import LINE, draw_found, joint_colours
from bodyschema.errors import InputError

pytest.importorskip("cv2")

IMAGE = np.full((64, 96, 3), 100, dtype=np.uint8)


@pytest.fixture
def found() -> BodyInView:
    """Two cells of the second joint."""
    finder = BodyFinder(("shoulder", "elbow"))
    nothing = finder.found(finder.start((96, 64)))
    mask, joint = nothing.mask.copy(), nothing.joint.copy()
    mask[1, 2:4], joint[1, 2:4] = True, 1
    return replace(nothing, mask=mask, joint=joint)


def test_only_cells_that_are_me_are_coloured(found):
    picture = draw_found(IMAGE, found)[:64]
    changed = (picture != IMAGE).any(axis=2)
    inside = np.zeros_like(changed)
    inside[16:32, 32:64] = True
    np.testing.assert_array_equal(changed, inside)
    colour = joint_colours(2)[1]
    np.testing.assert_array_equal(picture[16, 32], colour)
    edge = (picture == colour).all(axis=2)
    assert edge[16:32, 32].all()
    assert not edge[17:31, 46:50].any(), "no line between two cells that are me"


def test_cells_that_move_now_carry_a_frame(found):
    now = found.now.copy()
    now[2, 0] = True
    picture = draw_found(IMAGE, replace(found, now=now))[:64]
    changed = (picture != draw_found(IMAGE, found)[:64]).any(axis=2)
    assert changed[34:46, 2:14].sum() == changed.sum() == 4 * 11


def test_the_image_is_not_changed_and_the_strip_is_always_as_high(found):
    none = replace(found, mask=np.zeros_like(found.mask))
    assert draw_found(IMAGE, found, "now").shape == draw_found(IMAGE, none).shape
    assert (IMAGE == 100).all()
    assert (draw_found(IMAGE, none)[:64] == 100).all()


def test_many_joints_take_more_lines(found):
    names = tuple(f"a_rather_long_name_{k}" for k in range(5))
    finder = BodyFinder(names)
    picture = draw_found(IMAGE, finder.found(finder.start((96, 64))))
    assert len(picture) == 64 + 6 * LINE


def test_colours_differ():
    colours = joint_colours(12).astype(int)
    apart = np.abs(colours[:, None] - colours).sum(axis=2)[~np.eye(12, dtype=bool)]
    assert apart.min() > 40
    assert joint_colours(0).shape == (0, 3)


def test_another_size_is_refused(found):
    with pytest.raises(InputError, match="expected an 8-bit image of shape"):
        draw_found(IMAGE[:-1], found)
