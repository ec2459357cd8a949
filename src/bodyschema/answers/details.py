"""What `details` of a result folder must look like, as far as anything is computed from them.

Details are plain values that each verb chooses. Those that others read (loads, touches, the next
posture) have a form here; what else is there is shown as it stands.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bodyschema.errors import InputError
from bodyschema.model.inertia import PHI


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _size(value: Any) -> bool:
    return bool(_number(value) and value >= 0)


def _text(value: Any) -> bool:
    return isinstance(value, str)


def _flag(value: Any) -> bool:
    return isinstance(value, bool)


def _table(value: Any) -> bool:
    return isinstance(value, Mapping)


def _spreads(value: Any) -> bool:
    """Of each moment of inertia, and of nothing else: each is found by its name."""
    return (
        isinstance(value, Mapping) and {*value} == MOMENT_NAMES and all(map(_size, value.values()))
    )


MOMENT_NAMES = {f"I_{pair}" for pair in ("xx", "yy", "zz", "xy", "xz", "yz")}
THREE = (_number,) * 3
MOMENTS = (THREE,) * 3
TOLD = {"mass": _number, "com": THREE, "inertia": MOMENTS}
LOAD = {
    **TOLD,
    "name": _text,
    "mass_std": _size,
    "com_std": (_size,) * 3,
    "inertia_std": _spreads,
    "phi": dict.fromkeys(PHI, _number),
    "phi_covariance": ((_number,) * len(PHI),) * len(PHI),
    "not_told": [{"what": _text, "sentence": _text}],
}
TOUCH = {
    "begins": _number,
    "force": THREE,
    "verdict": _text,
    "on_surface": _flag,
    "places": [{"point": THREE, "covariance": MOMENTS, "chance": _number}],
}

FORMS: dict[str, Any] = {
    "loads": [LOAD],
    "last": [_text],
    "touches": [TOUCH],
    "gains": [_text],
    "next_posture": _table,
    "lost": _flag,
    "sensor": {"link": _text},
    "notes": [_text],
}
"""Keys of any verb that something is computed from; each may be absent, or null where nothing was
found."""

BY_VERB: dict[str, tuple[str, ...]] = {
    "payload": ("loads", "last", "sensor"),
    "touch": ("loads", "last", "sensor"),
    "track": ("lost", "gains", "next_posture"),
}
"""Keys that answers of a verb must have."""

WRIST = {"flange": TOLD, "controllers": _table}
"""What loads on a wrist have besides."""


def check_details(verb: str, details: Mapping[str, Any]) -> None:
    """Refuse details that the verb did not write.

    Raises:
        InputError: the first entry that does not fit.
    """
    for key in BY_VERB.get(verb, ()):
        if key not in details:
            raise InputError(f"details lack '{key}', which {verb} writes.")
    for key, form in FORMS.items():
        found = details.get(key)
        if found is not None and not fits(found, form):
            raise InputError(f"details.{key} cannot be {found!r:.60}.")
    loads = details.get("loads") or []
    if "sensor" in details and not all(fits(load, WRIST) for load in loads):
        raise InputError("details.loads lack what they are in the flange's frame.")
    names = {load["name"] for load in loads}
    if len(names) != len(loads) or not names >= {*(details.get("last") or ())}:
        raise InputError("details.last names loads that are not among details.loads.")
    if verb in ("payload", "touch") and not (loads and details["last"] and details["sensor"]):
        raise InputError(f"details hold no load, which {verb} always finds.")


def fits(value: Any, form: Any) -> bool:
    """Whether a plain value has a form.

    Args:
        value: of JSON.
        form: a mapping of keys that there must be, a list of one form for all entries, a tuple of
            a form for each entry, or a test.
    """
    if isinstance(form, Mapping):
        return isinstance(value, Mapping) and all(
            key in value and fits(value[key], inner) for key, inner in form.items()
        )
    if isinstance(form, list):
        return isinstance(value, list) and all(fits(one, form[0]) for one in value)
    if isinstance(form, tuple):
        return (
            isinstance(value, list)
            and len(value) == len(form)
            and all(fits(one, inner) for one, inner in zip(value, form, strict=True))
        )
    return bool(form(value))
