"""Expanding a xacro file without ROS (extra `xacro`)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.meshes import Packages

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
    try:
        import xacrodoc
    except ImportError:
        raise MissingExtraError("xacrodoc", "xacro", f"reading '{path.name}'") from None
    xacrodoc.packages.update_package_cache(packages)
    xacrodoc.packages.walk_up_from(path)
    try:
        text = path.read_text(encoding="utf-8")
        for name in _BARE_ARGUMENT.findall(_COMMENT.sub("", text)):
            if name not in arguments:
                raise _lacking(path, name)
        # Packages that only meshes name may be missing; `resolve_mesh` deals with them.
        document = xacrodoc.XacroDoc.from_string(
            _BARE_ARGUMENT.sub("", text),
            subargs=dict(arguments),
            resolve_packages=False,
            rootdir=path.parent,
        )
    except InputError:
        raise
    except Exception as error:  # xacro evaluates Python, so anything may be raised
        reason = str(error).partition("\n")[0].rstrip(". ")
        undefined = _UNDEFINED.search(reason)
        if undefined is not None:
            raise _lacking(path, undefined[1]) from None
        raise InputError(f"'{path}' is no xacro that can be expanded: {reason}.") from None
    return str(document.to_urdf_string()).encode()


def _lacking(path: Path, name: str) -> InputError:
    return InputError(
        f"'{path}' needs the xacro argument '{name}'; give it in the run file, "
        f'robot_arguments = {{ {name} = "..." }}.'
    )
