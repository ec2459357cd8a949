"""Result folders from elsewhere: indices, shapes and details that do not fit are refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.answers.answer import Answer, load
from bodyschema.answers.details import LOAD, check_details, fits
from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.judging.accuracy import Accuracy


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """answer.json of an arm with two offsets."""
    body = bs.Body.random_chain(3, np.random.default_rng(0))
    variables = bs.free_joints(body, ["offsets"], ["joint_2", "joint_3"])
    fit = Estimate(body, variables, np.array([0.01, -0.02]), 1e6 * np.eye(2))
    known = Identifiability(2, (), np.zeros(2))
    none = Accuracy({}, {})
    answer = Answer("calibrated", "It fits.", fit, none, none, known, (), 5, described=body)
    place = tmp_path_factory.mktemp("saved") / "out"
    answer.save(place)
    document: dict[str, Any] = json.loads((place / "answer.json").read_text())
    return document


def stored(document: Any, folder: Path) -> Path:
    (folder / "answer.json").write_text(json.dumps(document))
    (folder / "run.json").write_text("{}")
    return folder


def test_a_whole_one_comes_back(whole: dict[str, Any], tmp_path: Path) -> None:
    assert load(stored(whole, tmp_path)).body.joints == ("joint_1", "joint_2", "joint_3")


def put(value: Any, *keys: Any) -> Callable[[Any], None]:
    """A change of one entry."""

    def change(document: Any) -> None:
        for key in keys[:-1]:
            document = document[key]
        document[keys[-1]] = value

    return change


CHANGES = {
    "a parent far away": put(10**9, "fit", "reference", "parent", 1),
    "a driver far away": put(10**9, "fit", "reference", "driver", 1),
    "a variable of another joint": put(10**9, "fit", "variables", "index", 0),
    "a short parent": put([-1, 0], "fit", "reference", "parent"),
    "a short axis": put([[0, 0, 1]], "described", "axis"),
    "a short x": put([0.0], "fit", "x"),
    "a short information": put([[1.0]], "fit", "data_information"),
    "an information that is none": put([[1.0, 5.0], [0.0, 1.0]], "fit", "data_information"),
    "an x that is none": put(["nan", 0.0], "fit", "x"),
    "an x out of bounds": put([1e6, 0.0], "fit", "x"),
    "a share too many": put([0.0, 0.0, 0.0], "identifiability", "open_share"),
    "a negative row": put([-1], "outliers"),
    "true for a number": put(True, "n_rows"),
    "a word for a reference": put("x", "fit", "reference"),
    "a huge empty array": put({"empty": [0, 2**40]}, "fit", "x"),
    "a load without a mass": put({"loads": [{"name": "a"}]}, "details"),
    "a posture of words": put({"next_posture": "x"}, "details"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_what_does_not_fit_is_refused(whole: dict[str, Any], tmp_path: Path, what: str) -> None:
    document = json.loads(json.dumps(whole))
    CHANGES[what](document)
    with pytest.raises(InputError, match=r"is damaged: .*Make it again\.$"):
        load(stored(document, tmp_path))


@pytest.mark.parametrize("verb", ["payload", "touch", "track"])
def test_a_verb_leaves_what_others_read(verb: str) -> None:
    with pytest.raises(InputError, match=f"which {verb} writes"):
        check_details(verb, {})


def test_a_document_for_a_terminal(whole: dict[str, Any], tmp_path: Path) -> None:
    document = json.loads(json.dumps(whole))
    document["explanation"] = "It \x1b[31mfits."
    answer = load(stored(document, tmp_path))
    assert answer.document["explanation"] == "It \\x1b[31mfits."


@pytest.mark.parametrize("name", ["", "I_xw", "I_xx_"])
def test_spreads_of_moments_have_their_names(name: str) -> None:
    """Found by the fuzz bench: a name of no moment was taken apart."""
    spreads = dict.fromkeys(("I_xx", "I_yy", "I_zz", "I_xy", "I_xz", "I_yz"), 0.1)
    assert fits(spreads, LOAD["inertia_std"])
    assert not fits(spreads | {name: 0.1}, LOAD["inertia_std"])
