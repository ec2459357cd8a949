"""Accuracy: errors of every component, which of two is worse, and how people read them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.held_out import Errors
from bodyschema.judging.accuracy import (
    Accuracy,
    Key,
    change_in_words,
    in_words,
    main_in_words,
)
from simulated import points, poses, postures, seen_arm

Array = NDArray[np.float64]
POSITION, ROTATION, FORCE = ("position", "m"), ("rotation", "rad"), ("force", "N")


def of(**rms: float) -> Accuracy:
    """Accuracy with these rms errors, ten times as many positions as other numbers."""
    keys: dict[str, Key] = {"position": POSITION, "rotation": ROTATION, "force": FORCE}
    errors = {keys[name]: Errors(value, value / 2, 2 * value) for name, value in rms.items()}
    return Accuracy(errors, {key: 100 if key == POSITION else 10 for key in errors})


def test_lengths_are_pooled_over_senses_and_good_rows() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    q = postures(3, body, rng)
    senses = [poses(body, q, rng), points(body, q[:2], rng)]
    posed = np.array([[3.0, 4, 0, 0, 0, 1], [0, 0, 7, 0, 2, 0], [9, 9, 9, 9, 9, 9]])
    pointed = np.array([[0.0, 0, 1], [50, 50, 50]])
    good = [np.array([True, True, False]), np.array([True, False])]
    found = Accuracy.of(senses, [posed, pointed], good)
    assert found.numbers == {POSITION: 9, ROTATION: 6}
    assert found.position == Errors.of(np.array([5.0, 7.0, 1.0]))
    assert found.rotation == Errors.of(np.array([1.0, 2.0]))
    alone = Accuracy.of(senses[1:], [pointed], good[1:])
    assert alone.rotation is None
    assert Accuracy({}, {}).position is None


def test_it_speaks_of_positions_first() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)

    class Force:
        components = (("force", "N", slice(0, 3)),)

    senses = [Force(), points(body, postures(1, body, rng), rng)]
    row, all_good = np.ones((1, 3)), np.array([True])
    found = Accuracy.of(senses, [row, 2 * row], [all_good, all_good])
    assert list(found.errors) == [POSITION, FORCE]
    name, unit, errors = found.main
    assert (name, unit, errors.rms) == ("position", "m", pytest.approx(2 * np.sqrt(3)))


def test_the_worse_of_two_has_the_larger_error() -> None:
    assert of(position=0.002).worse_than(of(position=0.001))
    assert not of(position=0.001).worse_than(of(position=0.002))
    assert not of(position=0.001).worse_than(of(position=0.001))


def test_each_component_counts_by_the_numbers_seen_of_it() -> None:
    """A hundred positions 10 % better outweigh ten rotations 50 % worse, not 3 times worse ones."""
    nominal = of(position=0.010, rotation=0.010)
    assert not of(position=0.009, rotation=0.015).worse_than(nominal)
    assert of(position=0.009, rotation=0.030).worse_than(nominal)


def test_whatever_the_unit() -> None:
    """Newtons are not summed with metres: what counts is the ratio."""
    nominal = of(position=0.001, force=100.0)
    assert not of(position=0.0005, force=150.0).worse_than(nominal)
    assert of(position=0.00101, force=100.0).worse_than(nominal)


@pytest.mark.parametrize("none", [0.0, float("nan")])
def test_what_was_not_seen_does_not_count(none: float) -> None:
    assert not of(position=0.001, rotation=none).worse_than(of(position=0.002, rotation=0.1))
    assert of(position=0.002, rotation=0.1).worse_than(of(position=0.001, rotation=none))
    empty = Accuracy(of(position=1.0, force=9.0).errors, {POSITION: 3, FORCE: 0})
    assert not empty.worse_than(of(position=1.0, force=1.0))


def test_the_document_has_the_units_of_people_in_its_keys() -> None:
    document = of(position=0.00123, rotation=np.deg2rad(0.4), force=2.0).document()
    assert list(document) == ["position_mm", "rotation_deg", "force_N"]
    assert document["position_mm"] == pytest.approx({"rms": 1.23, "median": 0.615, "max": 2.46})
    assert document["rotation_deg"]["rms"] == pytest.approx(0.4)
    assert document["force_N"]["max"] == 4.0


@pytest.mark.parametrize(
    ("key", "word"),
    [
        (("wire length", "m"), "wire_length_mm"),
        (("gravity", "m/s^2"), "gravity_m_per_s2"),
        (("torque", "Nm"), "torque_Nm"),
        (("pixel", "px"), "pixel_px"),
        (("lag", "s"), "lag_ms"),
    ],
)
def test_keys_are_words(key: Key, word: str) -> None:
    assert list(Accuracy({key: Errors(1.0, 1.0, 1.0)}, {key: 1}).document()) == [word]


def test_a_change_in_words_names_what_else_was_seen() -> None:
    before = of(position=0.00521, rotation=0.1, force=3.0)
    after = of(position=0.00084, rotation=0.01, force=0.25)
    assert change_in_words(before, after) == (
        "from 5.21 to 0.84 mm rms (force from 3.00 to 0.250 N rms)"
    )
    assert change_in_words(of(position=0.005), of(position=0.001)) == "from 5.00 to 1.00 mm rms"
    assert change_in_words(of(force=12.3), of(force=1.0)) == "from 12.3 to 1.00 N rms"


def test_the_main_error_in_words() -> None:
    assert main_in_words(of(position=0.00084, force=3.0)) == "0.84 mm"
    assert main_in_words(of(force=3.0)) == "3.00 N"
    assert in_words(0.013, "1") == "1.30 %"
