"""What a wrist's load is said to be, where its recording is not what it is taken for.

Each test dies when the rule that it names is taken out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bodyschema import Answer, WristDeclaration, WristTable, learn_payload, lie
from bodyschema.errors import InputError
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrist_declaration import MotionReading, PoseColumns, WrenchColumns
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.loads import (
    Held,
    Sensor,
    draw_motion,
    draw_sensor,
    joined,
    record,
    wire_box,
)
from bodyschema.sources.recording import Recording

WRENCH = WrenchColumns(("fx", "fy", "fz", "tx", "ty", "tz"), "sensor", "on_object")
POSE = PoseColumns(("x", "y", "z", "qx", "qy", "qz", "qw"))
DECLARED = WristDeclaration(WRENCH, POSE)
BOX = wire_box()
Fault = Callable[[WristSamples, np.random.Generator], WristSamples]


def recorded(
    seed: int,
    seconds: float = 15.0,
    held: list[Held] | None = None,
    sensor: Sensor | None = None,
) -> WristSamples:
    """A motion of the box."""
    rng = np.random.default_rng([17, seed])
    motion, drawn = draw_motion(rng, seconds, 0.4, 100.0), draw_sensor(rng, 0.02)
    return record(motion, held or [Held(0.0, BOX)], sensor or drawn, rng)


def table(samples: WristSamples, clock: bool = True) -> WristTable:
    """As a recording."""
    assert samples.rotation is not None
    xyzw = lie.quaternion_xyzw(samples.rotation)
    values = np.column_stack([samples.time, samples.wrench, samples.position, xyzw])
    columns = dict(zip(("t", *WRENCH.columns, *POSE.columns), values.T, strict=True))
    if not clock:
        del columns["t"]
    return WristTable(Recording("log", columns, {}))


def drifts(samples: WristSamples, rng: np.random.Generator) -> WristSamples:
    """By 0.6 N and 20 mNm, slower and slower."""
    by = np.repeat([0.6, 0.02], 3) * rng.normal(size=6) / np.sqrt(3)
    share = samples.time / samples.time[-1]
    return replace(samples, wrench=samples.wrench + np.outer(1 - np.exp(-3 * share), by))


def leans(samples: WristSamples, rng: np.random.Generator, degrees: float = 4.0) -> WristSamples:
    """The base."""
    turn = lie.exp_so3(np.radians([degrees, 0.0, 0.0]))
    assert samples.rotation is not None
    assert samples.position is not None
    R, p = turn @ samples.rotation, samples.position @ turn.T
    return replace(samples, rotation=R, position=p)


def leans_far(samples: WristSamples, rng: np.random.Generator) -> WristSamples:
    """The base, by 30 degrees: no small effect."""
    return leans(samples, rng, 30.0)


def mixes(samples: WristSamples, rng: np.random.Generator) -> WristSamples:
    """Readings, by 2 % of each other."""
    size = np.array([1.0, 1, 1, 0.08, 0.08, 0.08])
    mixed = np.eye(6) + 0.02 * rng.normal(size=(6, 6)) * np.outer(size, 1 / size)
    return replace(samples, wrench=samples.wrench @ mixed.T)


def pulls(samples: WristSamples, rng: np.random.Generator) -> WristSamples:
    """A cable, towards a place beside the base; nothing is made to find it."""
    assert samples.rotation is not None
    assert samples.position is not None
    away = np.array([0.3, 0.1, 0.5]) - samples.position
    force = 3.0 * np.einsum("nji,nj->ni", samples.rotation, away)
    wrench = samples.wrench.copy()
    wrench[:, :3] -= force
    return replace(samples, wrench=wrench)


def shares(answer: Answer, load: Inertia = BOX) -> tuple[float, float]:
    """Errors of mass and centre of mass over their 95 % bars."""
    (found,) = answer.details["loads"]
    mass = abs(found["mass"] - load.mass) / (1.96 * found["mass_std"])
    return mass, float(np.linalg.norm(np.array(found["com"]) - load.com)) / found["com_95"]


@pytest.mark.parametrize("seed", range(2))
def test_a_good_recording_is_trusted(seed: int) -> None:
    answer = learn_payload(table(recorded(seed)), DECLARED)
    assert answer.trust.level == "good", answer.trust.reasons
    assert max(shares(answer)) < 1.5
    assert answer.predicted_95 is not None
    assert answer.predicted_95 < 3e-4


@pytest.mark.parametrize(
    ("fault", "word", "seed"),
    [
        (drifts, "offset drifts", 0),
        (leans, "base is tilted by 4", 0),
        (leans, "base is tilted by 4", 1),
        (leans_far, "base is tilted by 30 degrees", 0),
        (leans_far, "write down = [0.00, 4.9", 1),
    ],
)
def test_what_is_found_is_put_right_and_said(fault: Fault, word: str, seed: int) -> None:
    """`judging.mended_wrist`: the error falls to that of a good recording, the bars hold it."""
    answer = learn_payload(table(fault(recorded(seed), np.random.default_rng(seed))), DECLARED)
    assert answer.trust.level == "limited"
    assert word in " ".join(answer.trust.reasons)
    assert max(shares(answer)) < 2
    (found,) = answer.details["loads"]
    assert found["mass"] == pytest.approx(BOX.mass, rel=4e-3)


@pytest.mark.parametrize("degrees", [3.0, 30.0])
def test_a_base_that_leans_carries_two_recordings(degrees: float) -> None:
    """`answers.held_recording`: of the gripper alone, and with its object; gravity is one."""
    gripper = Inertia(0.4, np.array([0.01, 0.0, 0.05]), 5e-4 * np.eye(3))
    rng = np.random.default_rng(0)
    sensor = draw_sensor(rng, 0.02)
    alone = recorded(5, held=[Held(0.0, gripper)], sensor=sensor)
    both = recorded(6, held=[Held(0.0, joined(gripper, BOX))], sensor=sensor)
    alone, both = leans(alone, rng, degrees), leans(both, rng, degrees)
    answer = learn_payload(table(both), DECLARED, empty=table(alone))
    assert f"base is tilted by {degrees:.0f} degrees" in " ".join(answer.trust.reasons)
    assert answer.trust.level == "limited"
    (found,) = (load for load in answer.details["loads"] if load["name"] == "object")
    assert found["mass"] == pytest.approx(BOX.mass, abs=3 * 1.96 * found["mass_std"])
    assert found["mass_std"] < 0.01 * BOX.mass


@pytest.mark.parametrize("fault", [mixes, pulls])
@pytest.mark.parametrize("seed", range(2))
def test_what_cannot_be_put_right_widens_the_bars(fault: Fault, seed: int) -> None:
    """`trust.wrench_doubt`: rivals that stay, and what stretches of time have in common."""
    answer = learn_payload(table(fault(recorded(seed), np.random.default_rng(seed))), DECLARED)
    assert answer.trust.level != "good" or max(shares(answer)) < 2
    assert max(shares(answer)) < 4


def test_a_weight_that_hardly_turns_tells_no_mass() -> None:
    """`untold.LEAST_SPAN`, with the motion that is missing."""
    samples = recorded(0, 10.0)
    assert samples.rotation is not None
    assert samples.position is not None
    turns = lie.log_so3(samples.rotation[0].T @ samples.rotation)
    small = samples.rotation[0] @ lie.exp_so3(0.03 * turns)
    down = np.einsum("nji,j->ni", small, [0.0, 0.0, 9.81])
    force = BOX.mass * down
    wrench = np.hstack([force, np.cross(BOX.com, force)])
    wrench += (
        0.02 * np.random.default_rng(0).normal(size=wrench.shape) * [1, 1, 1, 0.02, 0.02, 0.02]
    )
    still = np.tile(samples.position[0], (len(samples), 1))
    answer = learn_payload(
        table(replace(samples, rotation=small, position=still, wrench=wrench)), DECLARED
    )
    assert answer.verdict == "not known"
    assert "tilt the sensor" in " ".join(answer.identifiability.sentences)
    assert answer.details["loads"][0]["controllers"] == {}


def test_seven_postures_are_as_sure_as_they_say() -> None:
    """`noise_levels.ALIKE`: six levels of their own would collapse."""
    z, motion = [], MotionReading("postures")
    for seed in range(20):
        rng = np.random.default_rng([18, seed])
        R = lie.exp_so3(rng.uniform(-1.5, 1.5, size=(7, 3)))
        force = BOX.mass * np.einsum("nji,j->ni", R, [0.0, 0.0, 9.81])
        wrench = np.hstack([force, np.cross(BOX.com, force)])
        wrench += np.repeat([0.1, 0.005], 3) * rng.normal(size=wrench.shape)
        samples = WristSamples(np.arange(7.0), wrench, rotation=R, position=np.zeros((7, 3)))
        answer = learn_payload(table(samples, clock=False), DECLARED, motion)
        z.append(max(shares(answer)))
    assert np.mean(np.array(z) > 2) < 0.06
    assert 0.3 < np.median(z) < 0.8


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"torque_unit": "Nmm"}, "torque_unit"),
        ({"force_unit": "kgf"}, "force_unit"),
        ({"frame": "base"}, 'frame = "sensor"'),
    ],
)
def test_another_declaration_is_named_and_nothing_is_written(
    said: dict[str, str], reason: str
) -> None:
    declared = replace(DECLARED, wrench=replace(WRENCH, **said))
    answer = learn_payload(table(recorded(1)), declared)
    assert answer.trust.level == "contradicted"
    assert answer.withheld
    assert reason in " ".join(answer.trust.reasons)


@pytest.mark.parametrize("down", [(0.0, 0.0, -1.0), (0.0, 0.0, -9.4), (9.81, 0.0, 0.0)])
def test_gravity_that_is_none_is_no_answer(down: tuple[float, ...]) -> None:
    answer = learn_payload(table(recorded(2)), replace(DECLARED, down=down))
    assert answer.withheld


def test_the_other_sign_is_refused() -> None:
    declared = replace(DECLARED, wrench=replace(WRENCH, sign="on_sensor"))
    with pytest.raises(InputError, match="other sign"):
        learn_payload(table(recorded(3)), declared)


@pytest.mark.parametrize("part", [0.5, 1.0])
def test_a_load_that_changes_is_not_one_number(part: float) -> None:
    """Half way, or all the time: each is said, or the bar holds both."""
    cuts = np.linspace(0.0, 15.0, 61)[:-1] if part == 1.0 else np.array([0.0, 7.5])
    course = np.linspace(0.0, 1.0, len(cuts))
    held = [Held(t, Inertia((1 - 0.1 * c) * BOX.mass, BOX.com, BOX.moments))
            for t, c in zip(cuts, course, strict=True)]  # fmt: skip
    answer = learn_payload(table(recorded(4, held=held)), DECLARED)
    if answer.trust.level == "good":
        masses = [load["mass"] for load in answer.details["loads"]]
        assert masses == pytest.approx([BOX.mass, 0.9 * BOX.mass], rel=5e-3)
