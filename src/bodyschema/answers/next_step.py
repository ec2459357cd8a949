"""What to do next to know more, in sentences, where it is no list of postures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bodyschema.answers.answer import Answer
from bodyschema.answers.filtered import METHOD

NOT_SAID = (
    "The published filter does not say which posture would tell more; a result of `track` without "
    "--method does."
)
ENOUGH = "Everything that was asked for is known; nothing more is needed."


def next_sentences(stored: Answer) -> tuple[str, ...]:
    """Which motion, posture or view would tell most, as the answer itself says.

    Args:
        stored: the answer of a verb without senses.
    """
    details = stored.details
    if "next_motion" in details:
        return stored.notes[-1:]
    if stored.learner == METHOD:
        return (NOT_SAID,)
    if "next_posture" in details:
        return _posture(details) or (ENOUGH,)
    if "loads" in details:
        said = {one["sentence"]: None for load in details["loads"] for one in load["not_told"]}
        return tuple(f"{sentence[0].upper()}{sentence[1:]}" for sentence in said) or (ENOUGH,)
    return stored.identifiability.sentences or (ENOUGH,)


def _posture(details: Mapping[str, Any]) -> tuple[str, ...]:
    """The posture whose pictures would tell most, if any tells much more."""
    if not details["gains"]:
        return ()
    where = ", ".join(f"{joint} at {at}" for joint, at in details["next_posture"].items())
    return (
        f"One more moment with {where} would bring {'; '.join(details['gains'])}. Whether the way "
        "there is free was not asked.",
    )
