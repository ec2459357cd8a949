"""Faults of a calibration: the rows of the campaign."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from honest import changes, sights
from honest.changes import Change, unchanged
from honest.drawing import Plan
from honest.scene import SenseKind


@dataclass(frozen=True)
class Fault:
    """One row of the table."""

    name: str
    plan: Plan = field(default_factory=Plan)
    change: Change = unchanged
    good: bool = False
    apart: bool = False
    """No rival is made for it."""
    weight: int = 1
    """Share of the runs."""


THREE_D: tuple[SenseKind, ...] = ("points", "poses")
MOVING = Plan(n=(120,), smooth=(True,))
EITHER = Plan(n=(48, 48, 96), smooth=(False, False, True))

FAULTS: tuple[Fault, ...] = (
    Fault("none", Plan(n=(24, 48, 120)), good=True, weight=5),
    Fault("none (smooth path)", Plan(n=(48, 120), smooth=(True,)), good=True, weight=2),
    Fault("none (stated noise)", Plan(n=(24, 48, 120), stated=True), good=True, weight=2),
    Fault("random outliers 5-35 %", change=lambda s, r: changes.sight(
        sights.outliers(r.uniform(0.05, 0.35), 0.2))(s, r)),
    Fault("random outliers 50 %", Plan(n=(48, 96)), changes.sight(sights.outliers(0.5, 0.2))),
    Fault("20-40 % shifted alike", change=lambda s, r: changes.sight(
        sights.shifted_alike(r.uniform(0.2, 0.4), 10 ** r.uniform(-2.7, -1.5), False))(s, r)),
    Fault("one corner shifted", change=lambda s, r: changes.sight(
        sights.shifted_alike(r.uniform(0.2, 0.4), 10 ** r.uniform(-2.7, -1.5), True))(s, r)),
    Fault("AR noise (shuffled)", change=changes.remembering),
    Fault("AR noise (smooth path)", Plan(n=(48, 120), smooth=(True,)), changes.remembering),
    Fault("late 50 ms", MOVING, changes.late(0.05)),
    Fault("late 200 ms", MOVING, changes.late(0.2)),
    Fault("early", MOVING, changes.late(-0.05, -0.2)),
    Fault("tracker bumped 2 mm", EITHER, changes.bumped("tracker", 0.002)),
    Fault("tracker bumped 10 / 50 mm", EITHER, changes.bumped("tracker", 0.01, 0.05)),
    Fault("encoder slips 0.5 deg", EITHER, changes.slip(0.5, -0.5)),
    Fault("encoder slips 2 / 10 deg", EITHER, changes.slip(2, -2, 10, -10)),
    Fault("marker slips 3 / 15 mm", EITHER, changes.bumped("tool", 0.003, 0.015)),
    Fault("locked or planar", Plan(moving=(2, 3)), weight=1),
    Fault("tiny or small region", Plan(reach=(0.1, 0.4))),
    Fault("8-20 rows", Plan(n=tuple(range(8, 21))), weight=2),
    Fault("mm", change=changes.in_mm),
    Fault("mirror", change=changes.declared(sights.mirrored)),
    Fault("swapped axes", change=changes.declared(sights.axes_swapped)),
    Fault("inverse pose", Plan(("poses",)), changes.declared(sights.inverted)),
    Fault("quaternion order", Plan(("poses",)), changes.reordered),
    Fault("swapped columns", change=changes.columns(True)),
    Fault("flipped column", change=changes.columns(False)),
    Fault("gear 2 %", change=changes.gear(0.02, -0.02)),
    Fault("gear 30 %", change=changes.gear(0.3, -0.3)),
    Fault("sag 0.6 deg", EITHER, changes.effect(changes.sag)),
    Fault("gear waves", EITHER, changes.effect(changes.waves)),
    Fault("12 postures x 7 frames", Plan(THREE_D, n=(84,), repeats=7),
          changes.noise(sights.white, sights.by_posture(7)), weight=2),
    Fault("backlash", change=changes.backlash),
    Fault("encoder steps", change=changes.steps),
    Fault("uneven noise", change=changes.noise(sights.uneven)),
    Fault("10 mm noise", change=changes.many_mm),
    Fault("3 % scale of the robot", change=changes.scaled_robot(1.03, 0.97)),
    Fault("sensor distortion", EITHER, changes.distorted, apart=True),
    Fault("bending links", EITHER, changes.bending, apart=True),
    Fault("hysteresis", MOVING, changes.effect(changes.hysteresis), apart=True),
    Fault("drifting tracker", EITHER, changes.walk, apart=True),
    Fault("warming", EITHER, changes.warming, apart=True),
    Fault("heavy noise", EITHER, changes.noise(sights.heavy(2.0), sights.heavy(3.0)), apart=True),
    Fault("distortion (stated noise)", replace(EITHER, stated=True), changes.distorted),
    Fault("bending (stated noise)", replace(EITHER, stated=True), changes.bending),
    Fault("waves (stated noise)", replace(EITHER, stated=True), changes.effect(changes.waves)),
    Fault("warming (stated noise)", replace(EITHER, stated=True), changes.warming),
)  # fmt: skip
"""All that a recording for `calibrate` may have."""
