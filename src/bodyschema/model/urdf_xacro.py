"""Expanding a xacro file without ROS (extra `xacro`)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from bodyschema.documents import file_text
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.meshes import Packages
from bodyschema.model.xacro_process import in_process

_BARE_ARGUMENT = re.compile(
    r"<xacro:arg\s+name\s*=\s*[\"']([^\"']+)[\"']\s*(?:/>|>\s*</xacro:arg>)"
)
"""One without a default, which launch files always give; the expander wants a default."""

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_UNDEFINED = re.compile(r"[Uu]ndefined substitution argument (\S+)")


def expanded(path: Path, packages: Packages, arguments: Mapping[str, str]) -> bytes:
    """The URDF that a xacro file stands for.

    Args:
        path: the file.
        packages: folder of each ROS package that it finds.
        arguments: values by name.

    Raises:
        InputError: it cannot be expanded, or lacks an argument.
        MissingExtraError: xacrodoc is not installed.
    """
    if not _installed():
        raise MissingExtraError("xacrodoc", "xacro", f"reading '{path.name}'")
    text = file_text(path, f"no robot description at '{path}'; give the path of a URDF file.")
    for name in _BARE_ARGUMENT.findall(_COMMENT.sub("", text)):
        if name not in arguments:
            raise _lacking(path, name)
    said = in_process(
        {
            "path": str(path),
            "text": _BARE_ARGUMENT.sub("", text),
            "packages": {name: str(folder) for name, folder in packages.items()},
            "arguments": dict(arguments),
        }
    )
    if "urdf" in said:
        return said["urdf"].encode()
    reason = said["error"].rstrip(". ")[:200]
    undefined = _UNDEFINED.search(reason)
    if undefined is not None:
        raise _lacking(path, undefined[1])
    raise InputError(f"'{path}' is no xacro that can be expanded: {reason}.")


def _installed() -> bool:
    """Whether the expander is there; it is imported by its own process alone."""
    try:
        return find_spec("xacrodoc") is not None
    except ValueError:  # it was marked as absent
        return False


def _lacking(path: Path, name: str) -> InputError:
    return InputError(
        f"'{path}' needs the xacro argument '{name}'; give it in the run file, "
        f'robot_arguments = {{ {name} = "..." }}.'
    )
