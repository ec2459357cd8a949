"""Whether what a TOML file gives fits the types of the record that it is read into."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from bodyschema.errors import InputError

WORDS = {str: "text", int: "a whole number", float: "a finite number", bool: "true or false"}


def check_types(kind: type[Any], table: Mapping[str, Any], where: str) -> None:
    """Refuse a value of another type than the field of its name.

    Args:
        kind: a dataclass.
        table: values by names of its fields; lists as tuples.
        where: what is read, for the message.

    Raises:
        InputError: a value does not fit.
    """
    hints = get_type_hints(kind)
    for name, value in table.items():
        if not fits(value, hints[name]):
            shown = list(value) if isinstance(value, tuple) else value
            raise InputError(f"{name} = {shown!r} in {where}; expected {_said(hints[name])}.")


def fits(value: object, hint: Any) -> bool:
    """Whether a value is of a type: a class, T | None, tuple[T, ...] or dict[str, T]."""
    origin, inside = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(fits(value, one) for one in inside)
    if origin is tuple:
        return isinstance(value, tuple) and all(fits(one, inside[0]) for one in value)
    if origin is dict:
        return isinstance(value, Mapping) and all(fits(one, inside[1]) for one in value.values())
    if hint is Any:
        return True
    if hint in (int, float) and isinstance(value, bool):
        return False
    if hint is float:
        return isinstance(value, int | float) and math.isfinite(value)
    return isinstance(value, hint)


def _said(hint: Any) -> str:
    """A type in words."""
    origin, inside = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return " or ".join(_said(one) for one in inside if one is not NoneType)
    if origin is tuple:
        return f"a list, each {_said(inside[0])}"
    return WORDS.get(hint, "a section of keys")
