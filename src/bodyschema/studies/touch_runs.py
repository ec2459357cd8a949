"""Touches of things in a simulated hand: the course of an experiment, and what to compare it with.

An arm in MuJoCo with a sensor in its wrist (noise, steps, and an offset and a turned mount as the
premises say; unless told otherwise 0.5 N and 20 mNm, 1 degree) waves a thing for 20 s and learns
its load; then, moving on, the thing is touched every 2.5 s for 0.5 to 1 s. What is known of load
and sensor:

    identified   what was learned from the 20 s
    known        the truth
    gain         learned, with gains of the six readings that are off by 1 % (standard deviation)
    faithful     mass and centre of mass by Eq. 37 from 6.6 s, no offset, no acceleration; of a
                 touch one reading ("one"), or the mean of its middle half ("mean"): the text does
                 not say which
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.published.linear_relation import Moments
from bodyschema.learners.published.paper_payload import PaperPayload, load_of, paper_rows
from bodyschema.learners.touch.evidence import Evidence, principal
from bodyschema.learners.touch.finder import Touch
from bodyschema.learners.touch.known_load import KnownLoad
from bodyschema.learners.touch.place import locate
from bodyschema.learners.touch.search import TouchSearch
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.contacts import Contact, Kind, draw_contact, pushes
from bodyschema.simulation.held_objects import HeldObject, held_object
from bodyschema.simulation.loads import DOWN, RATE, Sensor, draw_path
from bodyschema.simulation.wrist_sensor import WristSensor, record
from bodyschema.studies.wrist_premises import Premises, WristPremises

Array = NDArray[np.float64]

WAVED = 20.0
"""s of free motion from which the load is learned."""

PAPER_WAVED = 6.6
"""s, after which the paper's identification ended."""

PERIOD = 2.5
"""s from one touch to the next."""

USUAL = WristPremises().outside
"""A sensor as it comes, and a usual speed."""

GAIN = 0.01

Reading = Literal["one", "mean"]
READINGS: tuple[Reading, ...] = ("one", "mean")
"""Of a touch, in the published way."""

LATE = 0.3
"""s after its end up to which a touch may be noticed."""

CHI2_95 = 5.991
"""Two degrees of freedom: a place on a surface."""


@dataclass(frozen=True)
class Wrist:
    """A sensor with its own errors, the thing on it, and the arm that moves it."""

    held: HeldObject
    sensor: Sensor
    gain: Array
    """(6,) relative errors of the readings."""
    speed: float
    """Peak joint speed as a share of the limits."""

    def move(
        self, seconds: float, rng: np.random.Generator, contacts: Sequence[Contact] = ()
    ) -> WristSamples:
        """A random motion, as the robot gets to know it."""
        time = np.arange(round(seconds * RATE)) / RATE
        path = draw_path(rng, seconds, self.speed)
        push = pushes(contacts, time) if contacts else None
        felt = WristSensor(self.held.load).feel(path, time, push)
        return record(felt, self.sensor, rng, self.gain)

    def truth(self) -> KnownLoad:
        """What there is to know."""
        R, c = self.sensor.R_mount_sensor, 1 / (1 + self.gain) - 1
        offset = (1 + c) * self.sensor.bias
        bias = np.concatenate([R @ offset[:3], R @ offset[3:]])
        return KnownLoad(self.held.load.phi, bias, R, c)


def draw_wrist(
    surface: str,
    condition: str,
    speed: float,
    rng: np.random.Generator,
    premises: Premises = USUAL,
) -> Wrist:
    """A sensor and a thing; the sensor is the same for all conditions of a seed.

    Args:
        surface: name of the thing.
        condition: of the module's text; decides the gains.
        speed: peak joint speed as a share of the limits.
        rng: of the sensor.
        premises: what is wrong with the sensor; their own speed is not looked at.
    """
    sensor, gain = premises.draw_sensor(rng), GAIN * rng.normal(size=6)
    return Wrist(held_object(surface), sensor, gain if condition == "gain" else np.zeros(6), speed)


def learn(wrist: Wrist, condition: str, rng: np.random.Generator) -> TouchSearch:
    """Wave the thing, and know what the condition says."""
    quiet = wrist.move(WAVED, rng)
    if condition == "known":
        return TouchSearch.taught(quiet, wrist.truth(), wrist.held.solid, gain_std=0.0)
    learner = LoadLearner()
    belief, _ = learner.step(learner.start(), (Averaging().means(quiet),))
    if belief.solution is None:
        raise RuntimeError("a belief that took a step has a solution.")
    gain_std = GAIN if condition == "gain" else 0.0
    return TouchSearch.taught(quiet, KnownLoad.of(belief.solution), wrist.held.solid, gain_std)


def draw_contacts(
    wrist: Wrist, force: float, kind: Kind, count: int, rng: np.random.Generator
) -> list[Contact]:
    """Touches one after the other."""
    begins = 1.0 + PERIOD * np.arange(count)
    return [draw_contact(wrist.held.solid, force, kind, float(t), rng) for t in begins]


def matched(found: Sequence[Touch], contacts: Sequence[Contact]) -> list[Touch | None]:
    """The touch that was felt during each contact."""
    answer: list[Touch | None] = []
    for contact in contacts:
        over = contact.begins + contact.lasts + LATE
        felt = [t for t in found if contact.begins - LATE < t.begins < over]
        answer.append(felt[0] if felt else None)
    return answer


def miss(touch: Touch, contact: Contact) -> tuple[float, bool]:
    """Distance of the place from the true one, m, and whether its 95 % ellipse holds the truth.

    The ellipse lies in the surface that was believed and is looked at along its normal.
    """
    e = touch.point - contact.point
    values, axes = np.linalg.eigh(touch.covariance)
    inside = float(np.sum((axes[:, 1:].T @ e) ** 2 / values[1:])) < CHI2_95
    return float(np.linalg.norm(e)), inside


def paper_load(wrist: Wrist, rng: np.random.Generator) -> tuple[float, Array]:
    """Mass and centre of mass by the paper's form, from as long a motion as the paper's."""
    samples = wrist.move(PAPER_WAVED, rng)
    y, R = samples.wrench, samples.rotation
    if R is None:
        raise RuntimeError("the simulated arm knows its orientation.")
    moments = Moments.empty(5)
    for A in paper_rows(R, y[:, :3], y[:, 3:], DOWN):
        moments = moments.add(A)
    return load_of(PaperPayload().solve(moments).x)


def paper_place(
    wrist: Wrist,
    load: tuple[float, Array],
    samples: WristSamples,
    contact: Contact,
    reading: Reading = "one",
) -> Array:
    """Where the paper's line of action meets the surface, or comes nearest to it, (3,) m."""
    middle, quarter = contact.begins + contact.lasts / 2, contact.lasts / 4
    row, spread = round(middle * RATE), round(quarter * RATE) if reading == "mean" else 0
    rows = slice(row - spread, row + spread + 1)
    mass, com = load
    weight, y = mass * samples.downward()[rows], samples.wrench[rows]
    f = (-y[:, :3] - weight).mean(axis=0)
    tau = (-y[:, 3:] - np.cross(com, weight)).mean(axis=0)
    noise = np.diag(wrist.sensor.noise**2)
    one = Evidence.none(0).add(np.concatenate([f, tau]), np.zeros((6, 0)), 2.0)
    return locate(principal(one, noise), f, wrist.held.solid).places[0].point
