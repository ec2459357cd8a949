"""Reasons: what a weighing says of an answer in words, and how grave it is.

A cause limits an answer, or contradicts it where nobody should take an answer that errs so far;
whatever else widens the stated error limits it.
"""

from __future__ import annotations

from collections.abc import Sequence

from bodyschema.trust.outlook import Outlook
from bodyschema.trust.rival import Weighed
from bodyschema.trust.trust import Trust
from bodyschema.units import shown

WIDENED = 1.41
"""Total over core above which an answer is limited: as much again as was stated."""

FAR = 3.0
"""Error by a rival over core above which the answer is contradicted."""

MOST_OF_IT = 0.5
"""Share of what the fit leaves over, above which a rival is named whatever it does, and contradicts
the answer if it widens the error."""

LITTLE = 0.25
"""Share of what is left over, below which a cause is a perhaps."""

AS_GOOD = 10.0
"""Log likelihood by which the best cause must beat the next of another kind to be no perhaps."""

EVENTS = ("frame moved", "joint slipped", "lag", "gear", "frame misplaced", "scale")
"""Causes that can be mended, or told apart by cutting the recording: nobody should take an answer
that they contradict. With the others (a joint that gives way, a lens) a robot has to live."""

REMEDIES = {
    "frame moved": "Cut the recording there and calibrate each part alone.",
    "joint slipped": "Cut the recording there and calibrate each part alone.",
    "drift": "Fix the mounting, and record anew.",
    "warming": "Record with a warm robot.",
    "lag": "Bring both to one clock, or free the lag: a clock in [parts].",
    "gear": "Free gears too.",
    "wave": "No number in a URDF describes it.",
    "sag": "No number in a URDF describes it.",
    "hysteresis": "Approach each posture from one side, and let it settle.",
    "frame misplaced": "Say that its place is known roughly, or not at all.",
    "scale": "Measure the board or target, or free its scale.",
    "field": "Calibrate the lens or tracker by itself first.",
}
"""What to do about a cause."""


def of_rivals(rivals: Sequence[Weighed], core: float) -> Trust:
    """What the best rival says, beside its runner-up of another kind."""
    best = rivals[0]
    if best.bias < core and best.share < MOST_OF_IT:
        return Trust()
    others = [r for r in rivals if r.family != best.family]
    rivalled = bool(others) and others[0].criterion > best.criterion - AS_GOOD
    perhaps = rivalled or best.share < LITTLE
    beside = f"; next best, that {others[0].says}, {100 * others[0].share:.0f} %" if others else ""
    said = (
        f"{'Perhaps' if perhaps else 'What was seen says that'} {best.says}: that explains "
        f"{100 * best.share:.0f} % of what the fit leaves over{beside}. If so, the result errs by "
        f"{shown(best.bias, 'm')} where noise alone would leave {shown(core, 'm')}. "
        f"{REMEDIES[best.family]}"
    )
    far = best.bias > (WIDENED if best.share > MOST_OF_IT else FAR) * core
    against = far and not perhaps and best.family in EVENTS
    return Trust("contradicted" if against else "limited", (said,))


def of_size(
    core: float, total: float, split: str, field: float, excess: float, seen: Outlook
) -> Trust:
    """Why the number is wider than noise alone would make it."""
    parts = []
    if split:
        parts.append(f"{split} disagree")
    if field > core:
        parts.append(f"{shown(field, 'm')} follow the posture smoothly")
    if excess > core:
        parts.append(f"{shown(excess, 'm')} exceed the noise that was stated")
    if seen.total > WIDENED * core:
        parts.append(
            f"with a chance of {100 * seen.share:.0f} % {seen.says}, which the robot's own numbers "
            "can imitate"
        )
    why = f" ({'; '.join(parts)})" if parts else ""
    return Trust(
        "limited",
        (
            f"Count on {shown(total, 'm')} (95 %), not on the {shown(core, 'm')} that noise "
            f"alone would leave: the data do not agree with the model to that degree{why}.",
        ),
    )
