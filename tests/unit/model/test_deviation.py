"""The chart read backwards gives the parameters that were put in."""

from __future__ import annotations

import numpy as np

from bodyschema.model import parts
from bodyschema.model.deviation import deviation
from bodyschema.model.variables import GROUPS, free_part, join
from simulated import drawn, free_all, seen_arm


def test_what_was_put_in_comes_back():
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    variables = free_all(body, GROUPS)
    wide = np.where(np.array(variables.units) == "rad", 3.0, 1.0)
    for scale in (1e-9, 0.1, 1.0):
        x = np.clip(scale * wide * drawn(variables, rng), -1.5, 1.5)
        found = deviation(body, body.with_variables(variables, x), variables)
        assert np.abs(found - x).max() < 1e-12


def test_numbers_of_parts_come_back_too():
    rng = np.random.default_rng(2)
    body = seen_arm(3, rng).with_part("load", parts.load()).with_part("late", parts.clock(0.02))
    some = free_part(body, "load", ["t3", "alpha", "d2"])
    variables = join(free_part(body, "late"), free_all(body, GROUPS), some)
    x = 0.1 * drawn(variables, rng)
    changed = body.with_variables(variables, x)
    assert np.abs(deviation(body, changed, variables) - x).max() < 1e-12
    apart = deviation(body, changed, free_part(body, "load"))
    assert (np.flatnonzero(apart) == [0, 2, 9]).all()


def test_what_is_not_free_plays_no_part():
    rng = np.random.default_rng(1)
    body = seen_arm(4, rng)
    everything = free_all(body, GROUPS)
    changed = body.with_variables(everything, drawn(everything, rng))
    links = everything.where(["links"])
    x = deviation(body, changed, links)
    rows = [everything.names.index(name) for name in links.names]
    assert np.array_equal(x, deviation(body, changed, everything)[rows])
