"""Frozen records of the sections of a TOML file, whose keys and types they must fit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from types import NoneType, UnionType
from typing import (
    Any,
    Protocol,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

from bodyschema.errors import InputError, did_you_mean

Table = TypeVar("Table")

WORDS = {str: "text", int: "a whole number", float: "a finite number", bool: "true or false"}

LARGEST, SMALLEST = 1e18, 1e-18
"""Of a number that is not 0: squares of others are none, and ticks of encoders have 53 bits."""


@runtime_checkable
class Checked(Protocol):
    """A record that looks at its own values."""

    def check(self, where: str) -> None:
        """Raise InputError for values that mean nothing; `where` names the section."""


def entry_of(kind: type[Table], table: Mapping[str, Any], where: str) -> Table:
    """A frozen record of a TOML table; lists become tuples.

    Args:
        kind: a dataclass.
        table: the section.
        where: names it in messages.

    Raises:
        InputError: a key is unknown or missing, or a value does not fit.
    """
    table = section(table, where)
    refuse_unknown(kind, table, where)
    for entry in fields(kind):  # type: ignore[arg-type]
        required = entry.default is MISSING and entry.default_factory is MISSING
        if required and entry.name not in table:
            raise InputError(f"{where} lacks the key '{entry.name}'.")
    values = {key: frozen(value) for key, value in table.items()}
    check_types(kind, values, where)
    made = kind(**values)
    if isinstance(made, Checked):
        made.check(where)
    return made


def section(value: Any, where: str) -> Mapping[str, Any]:
    """A section of a file; anything else that stands in its place is refused.

    Raises:
        InputError: it is no table.
    """
    if not isinstance(value, Mapping):
        raise InputError(f"{where} is {value!r:.80}; it must be a section with keys.")
    return value


def listed(value: Any, key: str, where: str, of: str) -> list[Any]:
    """A list of a file; nothing for None.

    Args:
        value: as it stands.
        key: its name.
        where: for the message.
        of: what it should be a list of.

    Raises:
        InputError: it is no list.
    """
    if value is None:
        return []
    if not isinstance(value, list | tuple):
        raise InputError(f"{key} = {value!r:.80} in {where}; expected a list of {of}.")
    return list(value)


def files(value: Any, key: str, where: str, here: Path) -> tuple[str, ...]:
    """Paths of one file or of several, from the folder `here`.

    Raises:
        InputError: it is no name and no list of names.
    """
    names = [value] if isinstance(value, str) else listed(value, key, where, "names of files")
    for name in names:
        if not isinstance(name, str):
            raise InputError(f"{key} = {name!r:.80} in {where}; expected the name of a file.")
    return tuple(str(here / name) for name in names)


def refuse_unknown(kind: type[Any], table: Mapping[str, Any], where: str) -> None:
    """Refuse keys that a record does not have.

    Raises:
        InputError: with those that are near.
    """
    known = [f.name for f in fields(kind)]
    for key in table:
        if key not in known:
            raise InputError(f"unknown key '{key}' in {where}{did_you_mean(key, known)}")


def one_of(key: str, word: str, known: Iterable[str], where: str) -> None:
    """Refuse a word that is none of those known.

    Raises:
        InputError: with those that are near.
    """
    words = tuple(known)
    if word not in words:
        raise InputError(f"{key} = '{word}' in {where}{did_you_mean(word, words)}")


def frozen(value: Any) -> Any:
    """A value of TOML with tuples for its lists."""
    return tuple(frozen(one) for one in value) if isinstance(value, list) else value


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
            raise InputError(f"{name} = {shown!r:.200} in {where}; expected {_said(hints[name])}.")


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
        return isinstance(value, int | float) and (value == 0 or SMALLEST < abs(value) < LARGEST)
    if hint is int:
        return isinstance(value, int) and abs(value) < LARGEST
    return isinstance(value, hint)


def _said(hint: Any) -> str:
    """A type in words."""
    origin, inside = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return " or ".join(_said(one) for one in inside if one is not NoneType)
    if origin is tuple:
        return f"a list, each {_said(inside[0])}"
    return WORDS.get(hint, "a section of keys")
