"""Whether the keys of an entry are those that its kind uses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bodyschema.errors import InputError, did_you_mean


def check_keys(
    kind: object,
    given: Mapping[str, Any],
    used: Mapping[str, tuple[str, ...]],
    what: str,
    where: str,
) -> None:
    """Refuse a kind that there is not, and keys that it does not use.

    Args:
        kind: as given.
        given: the keys and what they say.
        used: the keys of every kind.
        what: that there are kinds of, in the plural.
        where: for messages.

    Raises:
        InputError: an unknown kind, or a key of others; the message names them.
    """
    if not isinstance(kind, str) or kind not in used:
        raise InputError(f"kind = '{kind!s:.80}' in {where}{did_you_mean(str(kind), used)}")
    for key in given:
        users = [name for name, keys in used.items() if key in keys]
        if users and kind not in users:
            raise InputError(
                f"'{key}' in {where} is for {what} of {_listed(users)}, not of {kind}; remove it, "
                "or change the kind."
            )


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
