"""Which other declaration of a wrist's columns would explain the wrench."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.judging.wrist_declarations import (
    better_declaration,
    load_learner,
    other_declarations,
)
from bodyschema.senses.wrist_columns import WristTable
from bodyschema.senses.wrist_declaration import (
    MotionReading,
    PoseColumns,
    SensorPlace,
    WrenchColumns,
    WristDeclaration,
)
from bodyschema.simulation.loads import Held, draw_motion, draw_sensor, record, wire_box
from bodyschema.sources.recording import Recording

WRENCH = WrenchColumns(("fx", "fy", "fz", "tx", "ty", "tz"), "sensor", "on_object")
RIGHT = WristDeclaration(WRENCH, PoseColumns(("x", "y", "z", "qx", "qy", "qz", "qw")))


def recorded(*held: Held) -> WristTable:
    """Eight seconds of what is held."""
    rng = np.random.default_rng(5)
    motion, sensor = draw_motion(rng, 8.0, 0.5, 100.0), draw_sensor(rng, 0.01)
    samples = record(motion, held, sensor, rng)
    assert samples.rotation is not None
    turn = lie.quaternion_xyzw(samples.rotation)
    values = np.column_stack([samples.time, samples.wrench, samples.position, turn])
    names = ("t", *WRENCH.columns, *("x", "y", "z", "qx", "qy", "qz", "qw"))
    return WristTable(Recording("log", dict(zip(names, values.T, strict=True)), {}))


@pytest.fixture(scope="module")
def table() -> WristTable:
    """Of a box."""
    return recorded(Held(0.0, wire_box()))


def test_a_right_declaration_is_left_alone(table: WristTable) -> None:
    assert better_declaration(table, RIGHT, MotionReading(), True, 0.002, 0.1) == ""


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (replace(RIGHT, wrench=replace(WRENCH, frame="base")), 'frame = "sensor"'),
        (
            replace(RIGHT, wrench=replace(WRENCH, torque_unit="kgfm")),
            'torque_unit = "Nm" or force_unit = "kgf"',
        ),
        (
            replace(RIGHT, pose=replace(RIGHT.pose, layout="xyz_wxyz")),
            'layout = "xyz_xyzw" under [pose]',
        ),
    ],
)
def test_the_entry_that_is_wrong_is_named(
    table: WristTable, wrong: WristDeclaration, words: str
) -> None:
    assert better_declaration(table, wrong, MotionReading(), True, 0.5, 0.93) == words


def test_a_load_that_slips_is_no_unit_of_torque() -> None:
    # Torques of a thousandth leave next to nothing to explain; no reason to name their unit.
    box = wire_box()
    slips = [replace(box, com=box.com + np.array([0.0, 0.01 * k, 0.0])) for k in range(6)]
    table = recorded(*(Held(1.3 * k, one) for k, one in enumerate(slips)))
    odd, usual = (
        better_declaration(table, RIGHT, MotionReading(), True, 0.2, c) for c in (0.9, 0.1)
    )
    assert 'torque_unit = "Nmm"' in odd
    assert "unit" not in usual


def test_each_trial_changes_one_entry() -> None:
    for words, trial in other_declarations(RIGHT).items():
        changed = [
            (section, key)
            for section in ("wrench", "pose", "sensor")
            for key, value in vars(getattr(trial, section)).items()
            if value != getattr(getattr(RIGHT, section), key)
        ]
        changed += [("", "down")] * (trial.down != RIGHT.down)
        assert len(changed) == 1, words
        assert words.startswith(changed[0][1])


def test_what_is_declared_is_believed() -> None:
    tared = replace(RIGHT, wrench=replace(WRENCH, bias="none"), sensor=SensorPlace(known="exactly"))
    assert load_learner(tared).force_bias_std < 0.1 < load_learner(RIGHT).force_bias_std
    assert load_learner(tared).turn_std < 1e-4 < load_learner(RIGHT).turn_std


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"wrench": replace(WRENCH, sign="up")}, "sign = 'up'"),
        ({"wrench": replace(WRENCH, columns=("a", "b"))}, "needs 6 entries"),
        ({"sensor": SensorPlace(known="well")}, "known = 'well'"),
        ({"down": (0.0, 9.81)}, "needs 3 entries"),
    ],
)
def test_words_that_mean_nothing_are_refused(change: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        replace(RIGHT, **change)  # type: ignore[arg-type]
