"""Xacro in a process of its own: files in it are programs, which may never end or fill the memory.

${9**9**9} is computed by no handler of signals, and macros may call themselves. The process has a
time and a size; what it prints is an object of JSON with "urdf" or "error".
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

SECONDS = 6.0
"""For one file: the largest that are known take one."""

MEMORY = 2 << 30
"""Bytes of addresses, and MOST_TEXT of the URDF."""

MOST_TEXT = 64 << 20


def in_process(asked: Mapping[str, Any]) -> dict[str, str]:
    """What a new process says of a file: "urdf", or "error" with the reason.

    Args:
        asked: `path`, `text`, `packages` and `arguments`, see `_urdf`.
    """
    # -P: nothing of the folder that somebody stands in is imported.
    command = [sys.executable, "-P", "-c", f"import {__name__} as own; own.main()"]
    paths = os.pathsep.join(path for path in sys.path if path)
    try:
        done = subprocess.run(
            command, input=json.dumps(asked).encode(), capture_output=True, timeout=SECONDS,
            env={**os.environ, "PYTHONPATH": paths}, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"error": f"it takes more than {SECONDS:.0f} s"}
    try:
        said: dict[str, str] = json.loads(done.stdout)
    except ValueError:
        return {"error": "it ends the process that expands it"}
    return said


def main() -> None:
    """Expand what stands on the standard input; see the module's text."""
    with suppress(ImportError, ValueError, OSError):  # where there are no such limits
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    asked, speaking = json.load(sys.stdin), os.dup(1)
    os.dup2(2, 1)  # xacro prints warnings
    try:
        said = {"urdf": _urdf(**asked)}
        if len(said["urdf"]) > MOST_TEXT:
            said = {"error": f"it becomes {len(said['urdf']) / 1e6:.0f} MB"}
    except BaseException as error:  # xacro evaluates Python, so anything may be raised
        lines = [line for line in str(error).splitlines() if line.strip()]
        said = {"error": (lines or [type(error).__name__])[0]}
    with os.fdopen(speaking, "w", encoding="utf-8") as out:
        json.dump(said, out)


def _urdf(path: str, text: str, packages: Mapping[str, str], arguments: Mapping[str, str]) -> str:
    """The URDF of a text that stands at a path."""
    import xacrodoc

    xacrodoc.packages.update_package_cache(packages)
    xacrodoc.packages.walk_up_from(path)
    # Packages that only meshes name may be missing; `resolve_mesh` deals with them.
    document = xacrodoc.XacroDoc.from_string(
        text, subargs=dict(arguments), resolve_packages=False, rootdir=str(Path(path).parent)
    )
    return str(document.to_urdf_string())
