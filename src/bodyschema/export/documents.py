"""Documents of a result: plain values with rounded numbers, their YAML, and the versions used."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import yaml

DIGITS = 9
"""Significant digits of a number that people read: a nanometre in a metre."""

PACKAGES = ("bodyschema", "numpy", "scipy", "numba")


def plain(value: Any) -> Any:
    """The same in mappings, lists, text, numbers and None, as JSON and YAML have them.

    Numbers that are not finite become None: neither format has them everywhere.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"cannot write a {type(value).__name__} into a document: {value!r}")


def rounded(value: float | None, digits: int = DIGITS) -> float | None:
    """A number to so many significant digits; None when there is none, or it is not finite."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{digits}g}") + 0.0


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that results depend on."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "unknown"
    return found


def yaml_text(document: Mapping[str, Any], heading: str) -> str:
    """YAML with the keys in the given order, short lists on one line.

    Args:
        document: what `plain` takes.
        heading: lines of comment to put above.
    """
    comment = "".join(f"# {line}".rstrip() + "\n" for line in heading.splitlines())
    # Lines are not folded: a command must be copied as it stands.
    body = yaml.dump(
        plain(document), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=10_000
    )
    return comment + "\n" + body


class _Dumper(yaml.SafeDumper):
    """Block style, but lists of numbers and names on one line; no anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _represent_list(dumper: yaml.SafeDumper, values: list[Any]) -> yaml.Node:
    short = all(not isinstance(v, dict | list) and " " not in str(v) for v in values)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", values, flow_style=short)


_Dumper.add_representer(list, _represent_list)
