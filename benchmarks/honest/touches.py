"""Touches: where something presses on what a wrist holds, through `bodyschema.find_touches`.

The thing is waved for a while, then pressed twice. The error is told as a share of what is stated:
the larger distance between where a touch is said to be and where it was. A touch where nothing
touched, and one that was not noticed, are errors of `MISSED` times any bar.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.answers.touch import SURFACE
from bodyschema.estimation.prediction import length_quantile
from bodyschema.model.inertia import Inertia
from bodyschema.model.solid import Solid
from bodyschema.simulation.contacts import Contact, draw_contact, pushes
from bodyschema.simulation.held_objects import held_object
from bodyschema.simulation.loads import Path, draw_path, draw_sensor
from honest import payloads
from honest.effects import direction
from honest.trial import Row, Trial
from honest.wrists import Wrist, narrowed

Array = NDArray[np.float64]

WAVED = 15.0
"""s without touches."""

PERIOD = 2.5
"""s from one touch to the next."""

LATE = 0.5
"""s after a touch in which it may be noticed yet."""

EARLY = 0.3
"""s before a touch in which one may be said to begin: means are taken over a quarter."""

MISSED = 10.0


@dataclass(frozen=True)
class Pressed:
    """A wrist whose load is pressed."""

    wrist: Wrist
    solid: Solid
    """As the user describes it, in the mount's frame."""
    contacts: tuple[Contact, ...]
    quiet: tuple[float, float] = (0.0, WAVED)
    """s, in which nothing touches, as the user says."""


Change = Callable[[Pressed, np.random.Generator], Pressed]


def draw(rng: np.random.Generator, count: int = 2) -> Pressed:
    """A box or a rod, pressed by 1 to 5 N."""
    thing = held_object(str(rng.choice(["box", "rod"])))
    contacts = tuple(
        draw_contact(thing.solid, rng.uniform(1.0, 5.0), "point", begins, rng)
        for begins in WAVED + 1.0 + PERIOD * np.arange(count)
    )
    lasts = WAVED + 1.0 + PERIOD * max(count, 2)
    path = draw_path(rng, lasts, float(rng.uniform(0.3, 0.6)))
    sensor = draw_sensor(rng, np.radians(1))
    push = (lambda time, R, p: pushes(contacts, time),) if contacts else ()
    # As far off as `find_touches` takes a surface to be.
    said = Solid(thing.solid.vertices + SURFACE * rng.normal(size=3), thing.solid.faces)
    return Pressed(Wrist(path, lasts, thing.load, sensor, pushes=push), said, contacts)


def trial(make: Callable[[np.random.Generator], Pressed], change: Change, rng: Any) -> Trial:
    """What the public function is given, and what is true of it."""
    one = change(make(rng), rng)
    table = one.wrist.table(rng)
    about = f"{one.wrist.load.mass:.2f} kg, {len(one.contacts)} touches"
    return Trial(
        about,
        lambda: bs.find_touches(table, one.wrist.declared, one.quiet, one.solid),
        lambda answer: (1.0, share(answer.details.get("touches") or (), one.contacts)),
        unit="stated",
        single=True,
    )


def share(touches: Sequence[Mapping[str, Any]], contacts: Sequence[Contact]) -> float:
    """The worst of: distance over the 95 % bar, a touch too many, a touch too few."""
    shares, noticed = [0.05], set()
    for touch in touches:
        ends = np.inf if touch["ends"] is None else touch["ends"]
        there = [
            k for k, c in enumerate(contacts) if touch["begins"] < _over(c) and ends > c.begins
        ]
        noticed |= set(there)
        begun = [k for k in there if touch["begins"] > contacts[k].begins - EARLY]
        if not begun:
            shares.append(MISSED)
        elif touch["verdict"] == "point" and touch["places"]:
            shares.append(min(_off(place, contacts[begun[0]]) for place in touch["places"]))
    shares += [MISSED] * (len(contacts) - len(noticed))
    return float(max(shares))


def _over(contact: Contact) -> float:
    """s, until when it may be noticed."""
    return contact.begins + contact.lasts + LATE


def _off(place: Mapping[str, Any], contact: Contact) -> float:
    bar = length_quantile([np.array(place["covariance"])], np.inf, 0.95)
    return float(np.linalg.norm(np.array(place["point"]) - contact.point) / bar)


def _of_wrist(change: payloads.Change) -> Change:
    """A fault that a payload's recording may have too."""
    return lambda one, rng: replace(one, wrist=change(one.wrist, rng))


def _drifts(one: Pressed, rng: np.random.Generator) -> Pressed:
    """An offset that creeps by 0.5 to 2 N, most of it while the load is learned."""
    drift = np.concatenate([rng.uniform(0.5, 2.0) * direction(rng), 0.05 * direction(rng)])
    return replace(one, wrist=replace(one.wrist, drift=drift))


def _after(change: Callable[[Inertia, np.random.Generator], Inertia]) -> Change:
    """Another load from the end of the quiet time on."""

    def changed(one: Pressed, rng: np.random.Generator) -> Pressed:
        before = one.wrist.load
        after, begins = change(before, rng), WAVED / one.wrist.seconds
        wrist = replace(one.wrist, later=lambda at: after if at > begins else before)
        return replace(one, wrist=wrist)

    return changed


def _slid(load: Inertia, rng: np.random.Generator) -> Inertia:
    return Inertia(load.mass, load.com + rng.uniform(0.01, 0.03) * direction(rng), load.moments)


def _filled(load: Inertia, rng: np.random.Generator) -> Inertia:
    return Inertia(1.15 * load.mass, load.com, load.moments)


def _touched_while_quiet(one: Pressed, rng: np.random.Generator) -> Pressed:
    """Two of the quiet seconds are not."""
    early = draw_contact(one.solid, 3.0, "point", rng.uniform(3, 10), rng)
    early = replace(early, lasts=3.0)
    return replace(one, wrist=replace(one.wrist, pushes=(
        lambda time, R, p: pushes((early, *one.contacts), time),)))  # fmt: skip


def _taught_elsewhere(one: Pressed, rng: np.random.Generator) -> Pressed:
    """Hardly tilted while the load is learned, all over the place afterwards."""
    path = one.wrist.path
    k = int(np.searchsorted(path.start, WAVED))
    narrow = narrowed(Path(path.start, path.length, path.ways.copy()), 0.2).ways
    ways = np.concatenate([narrow[: k + 1], path.ways[k + 1 :]])
    return replace(one, wrist=replace(one.wrist, path=replace(path, ways=ways)))


def _displaced(one: Pressed, rng: np.random.Generator) -> Pressed:
    """The thing sits 5 to 15 mm beside where its surface is said to be, and a little turned."""
    by = lie.transform(
        lie.exp_so3(0.1 * rng.normal(size=3)), rng.uniform(5e-3, 1.5e-2) * direction(rng)
    )
    vertices = one.solid.vertices @ by[:3, :3].T + by[:3, 3]
    return replace(one, solid=Solid(vertices, one.solid.faces))


def _row(name: str, change: Change = lambda one, rng: one, make: Any = draw, **more: Any) -> Row:
    return Row("touch", name, partial(trial, make, change), **more)


ROWS = (
    _row("none", good=True, weight=3),
    _row("none (nothing touches)", make=partial(draw, count=0), good=True, weight=2),
    _row("offset drifts", _drifts),
    _row("gains off", _of_wrist(payloads.gains_off)),
    _row("load slides after", _after(_slid)),
    _row("load grows after", _after(_filled)),
    _row("touched while quiet", _touched_while_quiet),
    _row("taught elsewhere", _taught_elsewhere),
    _row("surface displaced", _displaced, apart=True),
    _row("tilted base", _of_wrist(payloads.tilted_base)),
    _row("wrong sign", _of_wrist(payloads.said(sign="on_sensor"))),
    _row("torque in Nmm", _of_wrist(payloads.said(torque_unit="Nmm"))),
    _row("quaternion order", _of_wrist(payloads.said_of_pose(layout="xyz_wxyz"))),
    _row("late 0.1 / 0.3 s", _of_wrist(payloads.late)),
    _row("crosstalk", _of_wrist(payloads.crosstalk), apart=True),
    _row("cable", _of_wrist(payloads.cable), apart=True),
)
