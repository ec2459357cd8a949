"""Dots and arrows of what was seen."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bodyschema.model.kinematics import relative_pose
from bodyschema.view.marks import marks_of


def test_an_arrow_leads_from_what_was_predicted_to_what_was_seen(seen: Any) -> None:
    answer, sense = seen.answer, seen.senses[0]
    mark = marks_of(answer, seen.senses)[0]
    np.testing.assert_array_equal(mark.rows, sense.rows)
    assert mark.arrows is not None
    T = relative_pose(answer.body, sense.q, "base", sense.seen_from)
    in_root = np.einsum("nij,nj->ni", T[:, :3, :3], answer.residuals[0])
    np.testing.assert_allclose(mark.arrows[1], in_root)
    # Held out: the fit that predicted a row differs a little from the whole one.
    where = np.einsum("nij,nj->ni", T[:, :3, :3], sense.position) + T[:, :3, 3]
    assert np.abs(mark.places + mark.arrows[1] - where)[~mark.bad].max() < 5e-3
    np.testing.assert_allclose(mark.after, 1e3 * np.linalg.norm(answer.residuals[0], axis=1))
    assert mark.unit == "mm"
    assert mark.bad.nonzero()[0].tolist() == [7]


def test_poses_have_arrows_of_their_position(seen: Any) -> None:
    mark = marks_of(seen.answer, seen.senses)[1]
    assert mark.arrows is not None
    np.testing.assert_allclose(
        np.linalg.norm(mark.arrows[0], axis=1), 1e-3 * mark.before, rtol=1e-9
    )


def test_without_samples_there_are_none(seen: Any) -> None:
    assert marks_of(seen.answer, ()) == ()


def test_residuals_of_other_samples_make_no_marks(seen: Any) -> None:
    """Found by the fuzz bench: those before were fewer than those after."""
    fewer = tuple(one[:-1] for one in seen.answer.nominal_residuals)
    assert marks_of(replace(seen.answer, nominal_residuals=fewer), seen.senses) == ()
