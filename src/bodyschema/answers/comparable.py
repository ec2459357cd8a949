"""Whether two results are of one robot and speak of the same things."""

from __future__ import annotations

from typing import Any

from bodyschema.errors import InputError
from bodyschema.judging.calibration import Calibration
from bodyschema.units import listed

LOADS = ("payload", "touch")
"""Verbs whose answers are of what a wrist carries."""

NAMED = 4
"""Names that a sentence spells out."""


def refuse_unlike(first: Calibration, second: Calibration) -> None:
    """Refuse two results that cannot be compared.

    Raises:
        InputError: two robots, loads beside bodies, or nothing that both speak of.
    """
    verbs = [str(getattr(one, "verb", "calibrate")) for one in (first, second)]
    for verb in verbs:
        if verb == "find-body":
            raise InputError(
                "an answer of find-body holds no numbers of a robot that could be compared; name "
                "two results of calibrate, track, hand-eye, payload or touch."
            )
    if (verbs[0] in LOADS) != (verbs[1] in LOADS):
        raise InputError(
            f"the first result is of {verbs[0]} and the second of {verbs[1]}: the one says what a "
            "wrist carries, the other how a robot is built; compare two of the same verb."
        )
    if verbs[0] in LOADS:
        return
    if first.from_nothing or second.from_nothing:
        raise InputError(
            "a skeleton that was learned from nothing has no zeros and no frames that another one "
            "shares; test it on new data, `bodyschema check`."
        )
    _refuse_other_robot(first, second)
    common = {*first.estimate.variables.names} & {*second.estimate.variables.names}
    if not common:
        own, other = (listed(_spoken(one), NAMED) for one in (first, second))
        raise InputError(
            f"the results speak of other things, {own} and {other}; give the frames of the same "
            "cameras, boards and tools the same names in both run files."
        )


def _refuse_other_robot(first: Calibration, second: Calibration) -> None:
    one, other = first.estimate.reference, second.estimate.reference
    if {*one.joints} == {*other.joints}:
        return
    alone = [joint for joint in one.joints if joint not in other.joints]
    added = [joint for joint in other.joints if joint not in one.joints]
    raise InputError(
        f"these are two robots: '{one.name}' has the joints {listed(one.joints, NAMED)} and "
        f"'{other.name}' {listed(other.joints, NAMED)}; of these only one has "
        f"{listed(alone + added, NAMED)}. Compare results of one robot."
    )


def _spoken(one: Any) -> list[str]:
    """Parts of which an answer speaks."""
    names = one.estimate.variables.names
    return list(dict.fromkeys(name.rpartition(".")[0] for name in names)) or ["nothing"]
