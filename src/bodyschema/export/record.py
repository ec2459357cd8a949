"""Frozen records as JSON and back: names, numbers and arrays at full precision, nothing executed.

What is read is built by the types that the records declare, so a file can hold no other thing than
such a record: a field that is missing takes its default, one that has another type is refused.
An array without a number stands as {"empty": shape}, as [] would not say how many columns it has.
"""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from bodyschema.errors import InputError

Record = TypeVar("Record")

EMPTY = "empty"
"""Key of the shape of an array without a number."""

JOINT = "|"
"""Between the words of a key that is a tuple of names."""

DIMENSIONS, LONGEST = 8, 2**31
"""Of an array without a number: more axes, or longer ones, nothing here has."""

PLAIN: dict[str, type] = {"f": float, "i": int, "b": bool}
"""The type in JSON of the numbers of an array, by numpy's letter."""


def encoded(value: Any, skip: frozenset[str] = frozenset()) -> Any:
    """A record, or anything in one, in the types of JSON.

    Args:
        value: the record.
        skip: names of fields that are left out, in all records.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {
            entry.name: encoded(getattr(value, entry.name), skip)
            for entry in fields(value)
            if entry.name not in skip
        }
    if isinstance(value, Mapping):
        return {
            JOINT.join(key) if isinstance(key, tuple) else key: encoded(inner, skip)
            for key, inner in value.items()
        }
    if isinstance(value, np.ndarray):
        bare = value.ndim > 1 and not value.size
        return {EMPTY: list(value.shape)} if bare else encoded(value.tolist())
    if isinstance(value, list | tuple):
        return [encoded(inner, skip) for inner in value]
    if isinstance(value, np.generic):
        return encoded(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a {type(value).__name__} cannot be written: {value!r}")


def decoded(kind: type[Record], value: Any) -> Record:
    """The record of a kind that `encoded` wrote.

    Raises:
        InputError: the value is no such record; the message names the field.
    """
    made: Record = _decoded(kind, value, kind.__name__)
    return made


def _decoded(kind: Any, value: Any, where: str) -> Any:
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any or kind is object:
        return value
    if origin is Literal:
        return _expect(value in inner, value, where, value)
    if origin in (Union, types.UnionType):
        return _union(inner, value, where)
    if is_dataclass(kind):
        return _record(kind, value, where)
    if origin is np.ndarray or kind is np.ndarray:
        return _array(inner, value, where)
    if origin is tuple:
        return _tuple(inner, value, where)
    if origin is not None and issubclass(origin, Mapping):
        return _mapping(inner, value, where)
    if kind is float:
        return _number(value, where)
    if kind is int and isinstance(value, bool):
        return _refuse(value, where)
    return _expect(isinstance(value, kind), value, where, value)


def _number(value: Any, where: str) -> float:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number and not (isinstance(value, str) and value in ("inf", "-inf", "nan")):
        _refuse(value, where)
    try:
        return float(value)
    except OverflowError:
        _refuse(value, where)
        raise


def _record(kind: Any, value: Any, where: str) -> Any:
    _expect(isinstance(value, Mapping), value, where, None)
    hints = get_type_hints(kind)
    made = {}
    for entry in fields(kind):
        if entry.name in value:
            made[entry.name] = _decoded(
                hints[entry.name], value[entry.name], f"{where}.{entry.name}"
            )
        elif entry.default is MISSING and entry.default_factory is MISSING:
            raise InputError(f"{where} lacks '{entry.name}'; it was not written by bodyschema.")
    try:
        return kind(**made)
    except (TypeError, ValueError, IndexError, AttributeError):  # a record that looks at itself
        return _refuse(value, where)


def _union(kinds: tuple[Any, ...], value: Any, where: str) -> Any:
    if value is None and type(None) in kinds:
        return None
    for kind in kinds:
        if kind is type(None):
            continue
        try:
            return _decoded(kind, value, where)
        except InputError:
            continue
    return _refuse(value, where)


def _array(inner: tuple[Any, ...], value: Any, where: str) -> Any:
    scalar = get_args(inner[1])[0] if len(inner) > 1 and get_args(inner[1]) else np.float64
    if isinstance(value, Mapping):
        return _empty(scalar, value, where)
    _expect(isinstance(value, list), value, where, None)
    try:
        return np.array(_numbers(PLAIN[np.dtype(scalar).kind], value, where), dtype=scalar)
    except (TypeError, ValueError, OverflowError):
        return _refuse(value, where)


def _empty(scalar: Any, value: Mapping[Any, Any], where: str) -> Any:
    """An array of a shape in which a length is 0."""
    shape = value.get(EMPTY)
    if not isinstance(shape, list):
        return _refuse(value, where)
    lengths = all(
        isinstance(n, int) and not isinstance(n, bool) and 0 <= n < LONGEST for n in shape
    )
    if not lengths or len(value) != 1 or len(shape) > DIMENSIONS or 0 not in shape:
        return _refuse(value, where)
    try:
        return np.zeros(shape, dtype=scalar)
    except ValueError:  # the other lengths together are more than any memory
        return _refuse(value, where)


def _numbers(kind: type, value: Any, where: str) -> Any:
    """Lists in lists of one kind of number; numpy would take None, words and True for numbers."""
    if isinstance(value, list):
        return [_numbers(kind, inner, where) for inner in value]
    if isinstance(value, bool) and kind is not bool:
        return _refuse(value, where)
    return _decoded(kind, value, where)


def _tuple(inner: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    _expect(isinstance(value, list), value, where, None)
    if len(inner) == 2 and inner[1] is Ellipsis:
        return tuple(_decoded(inner[0], v, f"{where}[{i}]") for i, v in enumerate(value))
    _expect(len(value) == len(inner), value, where, None)
    pairs = zip(inner, value, strict=True)
    return tuple(_decoded(kind, v, f"{where}[{i}]") for i, (kind, v) in enumerate(pairs))


def _mapping(inner: tuple[Any, ...], value: Any, where: str) -> dict[Any, Any]:
    _expect(isinstance(value, Mapping), value, where, None)
    paired = get_origin(inner[0]) is tuple
    for key in value if paired else ():
        _expect(key.count(JOINT) == len(get_args(inner[0])) - 1, key, where, None)
    return {
        tuple(key.split(JOINT)) if paired else key: _decoded(inner[1], v, f"{where}[{key}]")
        for key, v in value.items()
    }


def _expect(holds: bool, value: Any, where: str, made: Any) -> Any:
    return made if holds else _refuse(value, where)


def _refuse(value: Any, where: str) -> Any:
    shown = repr(value)
    raise InputError(f"{where} cannot be {shown[:60]}{'...' if len(shown) > 60 else ''}.")
