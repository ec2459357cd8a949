"""How far the load of a wrist may be believed, in sentences.

    contradicted   another declaration explains the wrench; a load that no body can be; gravity
                   that is none; a load that became another one by more than a tenth
    limited        error bars that are wider for what errs in common, or for a cause that was found;
                   what was mended, by more than the noise

A cause is stated when it beats its runner-up (`CLEARLY`), with what it explains; else "perhaps".
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.answers.held_recording import HeldRecording
from bodyschema.estimation.loads import com_covariance, moments_covariance
from bodyschema.estimation.prediction import length_quantile
from bodyschema.judging.wrist_declarations import POOR
from bodyschema.model.inertia import Inertia
from bodyschema.trust.trust import Trust
from bodyschema.trust.wrench_doubt import CLEARLY
from bodyschema.trust.wrench_rivals import MASS, USUAL, WeighedRival, upright
from bodyschema.trust.wrench_rows import slopes

Array = NDArray[np.float64]

DENSEST, SOLID, LOOSE = 22600.0, 8000.0, 100.0
"""kg/m^3: osmium, steel, and a load that is mostly air."""

NEAR, FAR = 0.3, 6.0
"""Radii of a ball of steel within which, and of the third root of the volume of a loose load beyond
which, no centre of mass is: grippers stand on the sensor, and tools are not ten times longer."""

ASKEW = 15.0
"""deg that a sensor may seem turned against what was declared roughly, before that is said."""

MANY = 0.05
"""Share of samples left out from which something else must have touched the load."""

EARTH = (9.76, 9.84)
"""m/s^2 of gravity, anywhere on the ground."""

WIDER = 1.41
"""Times the error bar must grow for a cause to be worth a word."""

COMMON = 2.0
"""Times the error bar must grow for errors in common to be worth a word."""

SLIGHT, CLOSE = 0.005, 1e-3
"""Share of the mass, and m of the centre of mass, within 95 % of which nothing matters."""

UNUSUAL = 5.0
"""Times its usual size at which a cause is not stated, whatever it explains."""

ANOTHER, ELSEWHERE = 0.1, 0.01
"""Share of the mass, and m of the centre of mass, by which a load has become another one."""

WORDS = {
    "tilt": "gravity points elsewhere: the base is tilted by {size} against what was declared",
    "lag": "the wrench is {size} {side} against the motion",
    "drift": "the sensor's offset drifts, by {size}",
    "jump": "the sensor's offset jumped at {when:.1f} s, by {size}",
    "gains": "the readings err by shares of each other (gains, cross-talk), of {size}",
    "loss": "the load changes evenly with time (a leak, a slip), by {size}",
    "change": "the load changed at {when:.1f} s, by {size}",
}
REMEDY = {
    "tilt": "measure down under [motion], or mount the base level",
    "lag": "put both on one clock",
    "drift": "let the sensor warm up, and repeat",
    "jump": "do not tare while recording, and look for what pulls at a cable",
    "gains": "have the sensor calibrated, or take its errors for granted",
    "loss": "fasten the load",
    "change": "name the times under [segments]",
}


def load_trust(held: HeldRecording) -> Trust:
    """All reasons together."""
    found = [_declared(held), _gravity(held), *(_odd(held, name) for name in held.fit.names)]
    found += [_mended(held), _left(held), _common(held), _askew(held), _wild(held)]
    trust = Trust()
    for one in found:
        trust = trust if one is None else trust.also(one)
    return trust


def centre_95(load: Inertia, P: Array, freedom: float = np.inf) -> float:
    """m that the error of a centre of mass stays below with 95 %; P (10, 10) of phi."""
    return length_quantile([com_covariance(load, P)], freedom, 0.95)


def _declared(held: HeldRecording) -> Trust | None:
    share = float(held.fit.unexplained.max())
    left = f"the load leaves {100 * share:.2g} % of the wrench unexplained"
    if held.hint:
        return Trust("contradicted", (f"{left}; with {held.hint} it would be far less: check it.",))
    if share < POOR:
        return None
    return Trust(
        "contradicted",
        (
            f"{left}: check the frame of the wrench, the layout and inverse of the pose, the "
            'units, [sensor] rpy or known = "no", and which stretch is free of contact.',
        ),
    )


def _gravity(held: HeldRecording) -> Trust | None:
    felt = np.linalg.norm(held.samples.downward(), axis=1)
    size = float(np.median(felt))
    measured = held.samples.gravity is not None
    slack = 0.02 * size if measured else 0.0
    if EARTH[0] - slack <= size <= EARTH[1] + slack:
        return None
    what = "[gravity]" if measured else "down under [motion]"
    return Trust(
        "contradicted",
        (
            f"{what} is {size:.4g} m/s^2 long, on Earth it is {EARTH[0]} to {EARTH[1]}: the mass "
            f"would be wrong by {100 * abs(size / 9.81 - 1):.2g} %; check its unit.",
        ),
    )


def _odd(held: HeldRecording, name: str) -> Trust | None:
    """A load that no body can be, or that stands where none does."""
    load, P = held.fit.loads[name], held.fit.covariance(name)
    if too_dense(load, P):
        return Trust(
            "contradicted",
            ("the load would be denser than any metal: check torque_unit and unit.",),
        )
    if any(one.what in ("mass", "com") for one in held.fit.untold(name)):
        return None
    here, off = float(np.linalg.norm(load.com)), centre_95(load, P)
    low = NEAR * (3 * load.mass / (4 * np.pi * SOLID)) ** (1 / 3)
    high = FAR * (load.mass / LOOSE) ** (1 / 3)
    if low - off <= here <= high + off or "gripper" in held.fit.names:
        return None
    return Trust(
        "contradicted",
        (
            f"{load.mass:.3g} kg would have their centre {1e3 * here:.3g} mm off the sensor, where "
            f"{1e3 * low:.2g} to {1e3 * high:.3g} mm are usual: check force_unit, torque_unit and "
            "about.",
        ),
    )


def too_dense(load: Inertia, P: Array) -> bool:
    """Whether its spread, two deviations more, is below that of a ball of the densest metal."""
    radius = (3 * max(load.mass, 0.0) / (4 * np.pi * DENSEST)) ** (1 / 3)
    spread = np.trace(load.moments) + 2 * np.sqrt(moments_covariance(load, P).trace())
    return bool(spread < 3 * 0.4 * load.mass * radius**2)


def _mended(held: HeldRecording) -> Trust | None:
    if not held.mended:
        return None
    best = {one.family: one for one in held.mended}
    whole = {
        family: np.sum([o.gamma for o in held.mended if o.family == family], axis=0)
        for family in best
    }
    remedy = REMEDY | {"tilt": _downward(held)}
    if "tilt" in whole:
        whole["tilt"] = _slopes(held)
    said = [_cause(one, whole[family]) for family, one in best.items()]
    shares = [
        f"{100 * min(max(o.share for o in held.mended if o.family == family), 1.0):.0f} %"
        for family in best
    ]
    lines = tuple(
        f"{text}; that explained {share} of what the load left over, also of stretches it was not "
        f"fitted to, and was put right: {remedy[one.family]}."
        for text, share, one in zip(said, shares, best.values(), strict=True)
    )
    return Trust("limited", lines)


def _slopes(held: HeldRecording) -> Array:
    """(2,) of the base against what was declared, after all steps towards where gravity points."""
    x, y, z = upright(np.asarray(held.read.samples.down)) @ np.asarray(held.samples.down)
    return np.asarray([x / -z, y / -z])


def _downward(held: HeldRecording) -> str:
    """The entry that says where gravity points."""
    down = ", ".join(f"{round(value, 2) + 0.0:.2f}" for value in held.samples.down)
    return f"write down = [{down}] under [motion], or mount the base level"


def _left(held: HeldRecording) -> Trust | None:
    """The cause that still explains most, if it widens an error bar that matters."""
    left = held.doubt.left
    grown = _growth(held, held.doubt.core, held.doubt.whole)
    if not left or grown < WIDER or _slight(held):
        return None
    one, second = left[0], left[1] if len(left) > 1 else None
    clear = second is None or one.gain > second.gain + CLEARLY
    clear = clear and one.size < UNUSUAL * USUAL[one.family]
    text = _cause(one, one.gamma) if clear else f"perhaps {_cause(one, one.gamma)}"
    text += f"; that would explain {100 * min(one.share, 1.0):.0f} % of what the load leaves over"
    if second is not None:
        text += f" (runner-up: {second.family}, {100 * min(second.share, 1.0):.0f} %)"
    text += f". Error bars are {grown:.1f} times wider for it: {REMEDY[one.family]}."
    gone = one.family in ("loss", "change") and clear and _another(held, one)
    return Trust("contradicted" if gone else "limited", (text,))


def _another(held: HeldRecording, one: WeighedRival) -> bool:
    heaviest = max(held.fit.loads.values(), key=lambda load: load.mass)
    change = MASS * one.gamma
    shift = float(np.linalg.norm(change[1:] - heaviest.com * change[0])) / heaviest.mass
    return abs(change[0]) > ANOTHER * heaviest.mass or shift > ELSEWHERE


def _common(held: HeldRecording) -> Trust | None:
    worst = max(max(k["mass"], k["centre"]) for k in held.doubt.inflation)
    if np.sqrt(worst) < COMMON or _slight(held):
        return None
    return Trust(
        "limited",
        (
            "means of one stretch of time, or of one posture, err in common: error bars are "
            f"{np.sqrt(worst):.1f} times those of noise.",
        ),
    )


def _growth(held: HeldRecording, before: Array, after: Array) -> float:
    """Times that the error bar of a mass or of a centre of mass is wider, the largest."""
    found = [1.0]
    for k in range(len(held.fit.names)):
        for name, J in slopes(held.fit, k).items():
            if name != "moments":
                old, new = (float(np.trace(J @ P @ J.T)) for P in (before, after))
                found.append(float(np.sqrt(new / max(old, 1e-300))))
    return max(found)


def _slight(held: HeldRecording) -> bool:
    """Whether all error bars are so small that nobody needs to know why."""
    for name, load in held.fit.loads.items():
        P = held.fit.covariance(name)
        if 1.96 * float(np.sqrt(P[0, 0])) > SLIGHT * load.mass or centre_95(load, P) > CLOSE:
            return False
    return True


def _askew(held: HeldRecording) -> Trust | None:
    turn = float(np.degrees(np.linalg.norm(lie.log_so3(held.fit.R))))
    if held.declared.sensor.known != "roughly" or turn <= ASKEW:
        return None
    return Trust(
        "limited",
        (
            f"the sensor seems turned by {turn:.0f} degrees against what was declared: check "
            '[sensor] rpy and the frames, or set known = "no".',
        ),
    )


def _wild(held: HeldRecording) -> Trust | None:
    wild, total = int((~held.kept).sum()), len(held.kept)
    if wild <= MANY * total:
        return None
    text = f"{wild} of {total} samples were left out as wild; something touched the load."
    return Trust("limited", (text,))


def _cause(one: WeighedRival, gamma: Array) -> str:
    """A family in words, with its size."""
    side = "late" if gamma[0] < 0 else "early"
    return WORDS[one.family].format(size=_size(one, gamma), side=side, when=one.rival.when)


def _size(one: WeighedRival, gamma: Sequence[float] | Array) -> str:
    g = np.asarray(gamma)
    if one.family == "tilt":
        return f"{np.degrees(np.arctan(np.linalg.norm(g))):.2g} degrees"
    if one.family == "lag":
        return f"{1e3 * abs(g[0]):.0f} ms"
    if one.family == "gains":
        return f"{100 * one.size:.2g} %"
    if one.family in ("loss", "change"):
        ends = 2.0 if one.family == "loss" else 1.0
        return f"{ends * MASS[0] * g[0]:+.3g} kg"
    force = g.reshape(-1, 6)[:, :3]
    return f"{float(np.linalg.norm(force)):.2g} N"
