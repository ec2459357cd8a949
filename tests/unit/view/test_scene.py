"""What of an answer is drawn."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bodyschema.judging.places import places

pytest.importorskip("trimesh")


def test_everything_that_was_found(seen: Any) -> None:
    scene = seen.scene()
    assert scene.ghost
    assert scene.verdict == "calibrated"
    assert [shape.frame for shape in scene.shapes] == [seen.visuals[0].frame]
    place = places(seen.answer)[0]
    placed = scene.placed[0]
    assert (placed.name, placed.parent) == (place.frame, "base")
    assert placed.place == ", ".join(f"{1e3 * v:.2f}" for v in place.T[:3, 3])
    # The zero of the first joint turns the whole arm before the camera, so the base is not told.
    assert float(placed.error) == pytest.approx(1e3 * place.position_95, rel=0.05)
    assert scene.notes == (f"{place.frame} in base is not determined: {place.untold}.",)
    assert any(place.frame in sentence for sentence in scene.unsure)


def test_small_things_are_drawn_larger_by_a_round_number(seen: Any) -> None:
    scene = seen.scene()
    factors = scene.factors
    assert set(factors) == {"correction", "arrows", "ellipsoids"}
    told = [e.widest for e in scene.ellipsoids if not scene.is_wide(e)]
    assert len(told) == 1
    assert factors["ellipsoids"] > 1
    assert factors["ellipsoids"] * told[0] <= 0.1 * scene.size
    assert factors["correction"] * scene.moving.shift[0] <= 0.1 * scene.size


def test_a_recording_that_is_gone_is_said(seen: Any) -> None:
    scene = seen.scene(senses=())
    assert scene.marks == ()
    assert len(scene.recorded.q) == 1
    assert any("not at hand" in note for note in scene.notes)
    assert scene.placed, "the answer knows its frames without it"


def test_what_is_not_corrected_has_no_ghost(seen: Any) -> None:
    fit = replace(seen.answer.fit, x=np.where(
        np.char.startswith(seen.answer.fit.variables.groups, "frame:"), seen.answer.fit.x, 0.0
    ))  # fmt: skip
    same = replace(seen, answer=replace(seen.answer, fit=fit))
    assert not same.scene().ghost
    learned = replace(seen, answer=replace(seen.answer, from_nothing=True))
    assert not learned.scene().ghost
