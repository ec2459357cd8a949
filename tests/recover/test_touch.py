"""Touches of things in MuJoCo: noticed, placed within what is stated, and nothing else noticed."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from bodyschema.studies.touch_runs import (
    PERIOD,
    draw_contacts,
    draw_wrist,
    learn,
    matched,
    miss,
)


@pytest.mark.parametrize("surface", ["box", "rod", "mesh"])
def test_points_are_found_where_they_are(surface):
    rng = np.random.default_rng([5, len(surface)])
    errors, held = [], []
    for _ in range(2):
        wrist = draw_wrist(surface, "identified", 0.5, rng)
        search = learn(wrist, "identified", rng)
        contacts = draw_contacts(wrist, 1.0, "point", 15, rng)
        found = search.touches(wrist.move(PERIOD * 15 + 1, rng, contacts))
        assert len(found) == 15
        for touch, contact in zip(matched(found, contacts), contacts, strict=True):
            assert touch is not None
            error, inside = miss(touch, contact)
            errors.append(error)
            held.append(inside)
    assert np.median(errors) < 0.8e-3
    assert np.quantile(errors, 0.95) < 3e-3
    assert np.mean(held) > 0.75


@pytest.mark.parametrize("kind", ["soft", "moving"])
def test_what_is_no_point_contact_is_refused(kind):
    rng = np.random.default_rng(6)
    wrist = draw_wrist("box", "identified", 0.5, rng)
    search = learn(wrist, "identified", rng)
    contacts = draw_contacts(wrist, 2.0, kind, 15, rng)
    found = matched(search.touches(wrist.move(PERIOD * 15 + 1, rng, contacts)), contacts)
    verdicts = [touch.verdict for touch in found if touch is not None]
    assert len(verdicts) == 15
    assert verdicts.count("point") <= 1


def test_gains_that_are_off_are_learned_from_free_motion():
    rng = np.random.default_rng(7)
    wrist = draw_wrist("box", "gain", 0.5, rng)
    contacts = draw_contacts(wrist, 1.0, "point", 15, rng)
    searches = {
        name: learn(wrist, name, np.random.default_rng(8)) for name in ("gain", "identified")
    }
    samples = wrist.move(PERIOD * 15 + 1, rng, contacts)
    errors = {}
    for name, search in searches.items():
        pairs = zip(matched(search.touches(samples), contacts), contacts, strict=True)
        errors[name] = np.median([miss(t, c)[0] if t is not None else 0.1 for t, c in pairs])
    assert errors["gain"] < 2e-3
    assert errors["gain"] < 0.6 * errors["identified"]
