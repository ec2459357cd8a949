"""Payloads: mass and centre of mass of what a wrist holds, through `bodyschema.learn_payload`.

The error is told as a share of what is stated: the larger one of mass and centre of mass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.prediction import length_quantile
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrist_declaration import MotionReading
from honest.effects import direction
from honest.trial import Row, Trial
from honest.wrists import Wrist, draw_wrist, narrowed

Array = NDArray[np.float64]
Change = Callable[[Wrist, np.random.Generator], Wrist]

G = 9.81


def unchanged(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """Nothing is wrong."""
    return wrist


def trial(make: Callable[[np.random.Generator], Wrist], change: Change, rng: Any) -> Trial:
    """What the public function is given, and what is true of it."""
    wrist = change(make(rng), rng)
    table = wrist.table(rng)
    motion = MotionReading("postures") if wrist.still else None
    about = f"{wrist.load.mass:.2f} kg, " + (
        f"{wrist.still} postures" if wrist.still else f"{wrist.seconds:.0f} s"
    )
    return Trial(
        about,
        lambda: bs.learn_payload(table, wrist.declared, motion),
        lambda answer: (1.0, share(answer, wrist)),
        unit="stated",
        single=True,
    )


def share(answer: bs.Answer, wrist: Wrist) -> float:
    """True error over the 95 % bar, of mass or of centre of mass.

    Where the load changed, or several were told, of the two that are nearest.
    """
    shares = []
    for found in answer.details["loads"]:
        mass_95 = length_quantile([np.array([[found["mass_std"] ** 2]])], np.inf, 0.95)
        com_95 = length_quantile([np.diag(np.square(found["com_std"]))], np.inf, 0.95)
        for load in loads(wrist):
            mass = abs(found["mass"] - load.mass) / mass_95
            com = np.linalg.norm(np.array(found["com"]) - load.com) / com_95
            shares.append(max(mass, com))
    return float(min(shares))


def loads(wrist: Wrist) -> list[Inertia]:
    """What hung there at the beginning, in the middle and at the end."""
    if wrist.later is None:
        return [wrist.load]
    return [wrist.later(at) for at in (0.0, 0.5, 1.0)]


def _tilt(share_of: float) -> Change:
    return lambda wrist, rng: replace(wrist, path=narrowed(wrist.path, share_of))


def _drift(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """An offset that creeps by 0.3 to 1 N, as after switching on."""
    force, torque = rng.uniform(0.3, 1.0) * direction(rng), 0.02 * direction(rng)
    return replace(wrist, drift=np.concatenate([force, torque]))


def gains_off(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    return replace(wrist, mixing=np.diag(1 + rng.uniform(0.03, 0.1) * rng.choice([-1, 1], 6)))


def crosstalk(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """Forces that show in the torques by 2 mm, torques in the forces by a hundredth."""
    mixing = np.eye(6)
    mixing[3:, :3] += 2e-3 * rng.normal(size=(3, 3))
    mixing[:3, :3] += 0.01 * rng.normal(size=(3, 3))
    return replace(wrist, mixing=mixing)


def _slip(sudden: bool) -> Change:
    """The load slides by 5 to 20 mm in the gripper, at once or all the time."""

    def changed(wrist: Wrist, rng: np.random.Generator) -> Wrist:
        by, one = rng.uniform(5e-3, 2e-2) * direction(rng), wrist.load

        def later(at: float) -> Inertia:
            gone = float(at >= 0.5) if sudden else at
            return Inertia(one.mass, one.com + gone * by, one.moments)

        return replace(wrist, later=later)

    return changed


def _leak(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """A tenth to a third of it runs out."""
    lost, one = rng.uniform(0.1, 0.33), wrist.load

    def later(at: float) -> Inertia:
        rest = 1 - lost * at
        return Inertia(rest * one.mass, one.com, rest * one.moments)

    return replace(wrist, later=later)


def tilted_base(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """A base that leans by 3 to 30 degrees."""
    axis = np.cross([0.0, 0.0, 1.0], direction(rng))
    turn = lie.exp_so3(np.radians(rng.choice([3, 10, 30])) * axis / np.linalg.norm(axis))
    return replace(wrist, down=turn @ wrist.down)


def said(**wrench: str) -> Change:
    def changed(wrist: Wrist, rng: np.random.Generator) -> Wrist:
        declared = wrist.declared
        return replace(wrist, declared=replace(declared, wrench=replace(declared.wrench, **wrench)))

    return changed


def said_of_pose(**pose: Any) -> Change:
    def changed(wrist: Wrist, rng: np.random.Generator) -> Wrist:
        declared = wrist.declared
        return replace(wrist, declared=replace(declared, pose=replace(declared.pose, **pose)))

    return changed


def _turned_sensor(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """Mounted a quarter turn from where it is said to be."""
    turn = lie.exp_so3(np.pi / 2 * np.eye(3)[rng.integers(3)])
    sensor = replace(wrist.sensor, R_mount_sensor=turn @ wrist.sensor.R_mount_sensor)
    return replace(wrist, sensor=sensor)


def late(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    return replace(wrist, late=float(rng.choice([0.1, -0.1, 0.3])))


def _touched(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """Somebody leans on it for a fifth of the time."""
    begin, force = rng.uniform(0.2, 0.7), rng.uniform(1.0, 5.0) * direction(rng)
    place = wrist.load.com + 0.05 * direction(rng)

    def push(time: Array, R: Array, p: Array) -> Array:
        on = (time > begin * wrist.seconds) & (time < (begin + 0.2) * wrist.seconds)
        return np.asarray(on[:, None] * np.concatenate([force, np.cross(place, force)]))

    return replace(wrist, pushes=(push,))


def cable(wrist: Wrist, rng: np.random.Generator) -> Wrist:
    """A cable pulls it to a place beside the base, the harder the farther."""
    anchor = np.array([0.3, 0.0, 0.3]) + 0.3 * direction(rng)
    stiff = rng.uniform(2.0, 8.0)

    def push(time: Array, R: Array, p: Array) -> Array:
        f = np.einsum("nji,nj->ni", R, stiff * (anchor - p))
        return np.hstack([f, np.zeros_like(f)])

    return replace(wrist, pushes=(push,))


def _row(name: str, change: Change = unchanged, make: Any = draw_wrist, **more: Any) -> Row:
    return Row("payload", name, partial(trial, make, change), **more)


def _still(*counts: int) -> Callable[[np.random.Generator], Wrist]:
    return lambda rng: draw_wrist(rng, still=int(rng.choice(counts)))


ROWS = (
    _row("none", good=True, weight=3),
    _row("none (postures)", make=_still(15, 30), good=True, weight=2),
    _row("7 postures", make=_still(7)),
    _row("3 s", make=partial(draw_wrist, seconds=(3.0,))),
    _row("hardly tilted", _tilt(0.05)),
    _row("tilted little", _tilt(0.25)),
    _row("offset drifts", _drift),
    _row("gains off", gains_off),
    _row("slips half way", _slip(True)),
    _row("slips slowly", _slip(False)),
    _row("leaks", _leak),
    _row("tilted base", tilted_base),
    _row("tilted base (postures)", tilted_base, make=_still(7, 15, 30)),
    _row("sensor a quarter turn off", _turned_sensor),
    _row("wrong sign", said(sign="on_sensor")),
    _row("torque in Nmm", said(torque_unit="Nmm")),
    _row("force in the base", said(frame="base")),
    _row("inverse pose", said_of_pose(inverse=True)),
    _row("quaternion order", said_of_pose(layout="xyz_wxyz")),
    _row("late 0.1 / 0.3 s", late),
    _row("touched", _touched),
    _row("crosstalk", crosstalk, apart=True),
    _row("cable", cable, apart=True),
)
