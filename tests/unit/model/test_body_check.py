"""Bodies and variables that do not fit together are refused before loops follow their indices."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.errors import InputError
from bodyschema.model.body_check import check_body, check_variables
from bodyschema.model.tree import Visual

BODY = bs.Body.random_chain(3, np.random.default_rng(0)).attach("eye", "base")
VARIABLES = bs.free_joints(BODY, ["offsets", "axes", "links"])


def changed(array: np.ndarray, at: Any, value: Any) -> np.ndarray:
    array = array.copy()
    array[at] = value
    return array


WRONG: dict[str, dict[str, Any]] = {
    "a frame far away": {"parent": changed(BODY.parent, 2, 10**9)},
    "a child before its parent": {"parent": changed(BODY.parent, 1, 3)},
    "a root with a parent": {"parent": changed(BODY.parent, 0, 0)},
    "a negative parent": {"parent": changed(BODY.parent, 2, -5)},
    "a joint far away": {"driver": changed(BODY.driver, 1, 10**9)},
    "a joint before the first": {"driver": changed(BODY.driver, 1, -7)},
    "a joint that moves nothing": {"driver": changed(BODY.driver, 1, 1)},
    "a frame that moves by itself": {"driver": changed(BODY.driver, 1, -1)},
    "a kind of its own": {"kind": changed(BODY.kind, 1, 7)},
    "fewer parents": {"parent": BODY.parent[:-1]},
    "fewer drivers": {"driver": BODY.driver[:-1]},
    "fewer axes": {"axis": BODY.axis[:-1]},
    "an axis of two": {"axis": BODY.axis[:, :2]},
    "fewer placements": {"placement": BODY.placement[:-1]},
    "fewer offsets": {"offset": BODY.offset[:-1]},
    "fewer limits": {"lower": BODY.lower[:-1]},
    "fewer carriers": {"carriers": BODY.carriers[:-1]},
    "no frames": {"frames": (), "carriers": ()},
    "a name twice": {"frames": ("base", "base", *BODY.frames[2:])},
    "an axis without length": {"axis": changed(BODY.axis, 1, 0.0)},
    "a bent frame": {"placement": changed(BODY.placement, (1, 0, 0), 3.0)},
    "a place that is none": {"placement": changed(BODY.placement, (1, 0, 3), np.nan)},
    "a place too far": {"placement": changed(BODY.placement, (1, 0, 3), 1e200)},
    "a mimic too fast": {"rate": changed(BODY.rate, 1, 1e300)},
    "a shape on nothing": {"visuals": (Visual("x", np.eye(4), "box", (1, 1, 1)),)},
    "a box of one": {"visuals": (Visual("base", np.eye(4), "box", (1,)),)},
}


def test_bodies_that_are_whole() -> None:
    check_body(BODY, "body")
    check_variables(VARIABLES, BODY, "variables")


@pytest.mark.parametrize("what", WRONG)
def test_bodies_that_do_not_fit(what: str) -> None:
    with pytest.raises(InputError, match="body"):
        check_body(replace(BODY, **WRONG[what]), "body")


@pytest.mark.parametrize(
    "change",
    [
        {"index": changed(VARIABLES.index, 0, 10**9)},
        {"index": changed(VARIABLES.index, -1, -3)},
        {"index": changed(VARIABLES.index, 0, len(BODY.joints))},
        {"component": changed(VARIABLES.component, -1, 5)},
        {"code": changed(VARIABLES.code, 0, 99)},
        {"code": changed(VARIABLES.code, 0, 5)},
        {"index": VARIABLES.index[:-1]},
        {"prior_std": changed(VARIABLES.prior_std, 0, 0.0)},
        {"bound": changed(VARIABLES.bound, 0, np.nan)},
        {"names": (VARIABLES.names[0],) * len(VARIABLES.names)},
        {"units": VARIABLES.units[:-1]},
    ],
)
def test_variables_of_nothing(change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="variables"):
        check_variables(replace(VARIABLES, **change), BODY, "variables")
