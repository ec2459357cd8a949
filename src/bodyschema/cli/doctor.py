"""`bodyschema doctor`: what this installation has and lacks; for people and for fault reports."""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import re
import subprocess
import sys
from dataclasses import dataclass
from importlib import metadata
from typing import Any

CORE = ""
"""Stands for what every installation needs, among the extras."""

PRIVATE = ("dev", "docs")
"""Extras for those who work on bodyschema itself."""

DRAWN = """
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco/>")
renderer = mujoco.Renderer(model, 8, 8)
renderer.update_scene(mujoco.MjData(model))
renderer.render()
renderer.close()
"""
"""Draws one small picture; in a process of its own, as a broken OpenGL may end it."""

PATIENCE = 30
"""s, for that picture."""


@dataclass(frozen=True)
class Doctor:
    """Say what this installation has and lacks: versions, extras, cache, cores, BLAS, OpenGL."""

    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Print; returns 0."""
        found = findings()
        print(json.dumps(found) if self.json else "\n".join(told(found)))
        return 0


def findings() -> dict[str, Any]:
    """All that is looked at, in JSON types."""
    extras = {name: state(name, needs) for name, needs in requirements().items()}
    return {
        "bodyschema": metadata.version("bodyschema"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": extras.pop(CORE)["packages"],
        "extras": extras,
        "cache": cache(),
        "cores": {"machine": os.cpu_count(), "usable": usable_cores()},
        "blas": blas(),
        "opengl": opengl(),
    }


def requirements() -> dict[str, dict[str, str]]:
    """For the core and each extra, the packages that it needs and their least versions."""
    found: dict[str, dict[str, str]] = {CORE: {}}
    for line in metadata.requires("bodyschema") or ():
        need, _, marker = line.partition(";")
        extra = re.search(r"extra == ['\"](\S+)['\"]", marker)
        name = extra.group(1) if extra else CORE
        package = re.match(r"[\w.-]+", need)
        if name in PRIVATE or package is None or package.group() == "bodyschema":
            continue
        least = re.search(r">=\s*([\d.a-z]+)", need)
        found.setdefault(name, {})[package.group()] = least.group(1) if least else ""
    return found


def state(extra: str, needs: dict[str, str]) -> dict[str, Any]:
    """Versions of the packages, None where missing, and how to install what is missing or old."""
    packages: dict[str, str | None] = {}
    for package in needs:
        try:
            packages[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            packages[package] = None
    wanting = [p for p, version in packages.items() if _below(version, needs[p])]
    missing = [f"{p}>={needs[p]}" if needs[p] else p for p in wanting]
    line = f"pip install {' '.join(repr(m) for m in missing)}" if missing else None
    return {"complete": not missing, "packages": packages, "install": line}


def _below(version: str | None, least: str) -> bool:
    if version is None:
        return True
    return _numbers(version) < _numbers(least)


def _numbers(version: str) -> list[int]:
    """The leading numbers: 3.11.0rc1 gives 3, 11, 0."""
    return [int(n) for n in re.findall(r"\d+", re.split(r"[a-z+]", version)[0])]


def cache() -> dict[str, Any]:
    """Where compiled loops are kept, and whether those of the kinematics are there."""
    from bodyschema.model import compiled, kernels

    kept = kernels.relative_pose_derivatives._cache  # type: ignore[attr-defined]
    if not isinstance(kept, compiled.Kept):
        return {"folder": None, "warm": False}
    folder = str(kept.cache_path)
    names = os.listdir(folder) if os.path.isdir(folder) else []
    warm = any(name.startswith("kernels.relative_pose_derivatives-") for name in names)
    return {"folder": folder, "warm": warm}


def usable_cores() -> int:
    """That this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def blas() -> list[dict[str, Any]]:
    """The libraries that numpy and scipy calculate with, and their threads in this process."""
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_info

    return [
        {
            "library": pool["internal_api"],
            "version": pool["version"],
            "threads": pool["num_threads"],
        }
        for pool in threadpool_info()
        if pool["user_api"] == "blas"
    ]


def opengl() -> str:
    """Whether MuJoCo can draw without a window, and why not."""
    if importlib.util.find_spec("mujoco") is None:
        return "not tried: MuJoCo is missing"
    environment = {"MUJOCO_GL": "egl", **os.environ} if sys.platform == "linux" else {**os.environ}
    command = [sys.executable, "-c", DRAWN]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no picture within {PATIENCE} s"
    if done.returncode == 0:
        return f"works ({environment.get('MUJOCO_GL', 'default')})"
    lines = [line for line in done.stderr.splitlines() if line and not line.startswith(" ")]
    return f"cannot draw: {lines[-1] if lines else f'exit code {done.returncode}'}"


def told(found: dict[str, Any]) -> list[str]:
    """The same in lines."""
    packages = ", ".join(f"{name} {version}" for name, version in found["packages"].items())
    kept = found["cache"]
    place = f"{kept['folder']} ({'warm' if kept['warm'] else 'cold: the first call compiles'})"
    none = "no folder can be written: every call compiles; set NUMBA_CACHE_DIR to one that can"
    libraries = "; ".join(
        f"{b['library']} {b['version']}, threads {b['threads']}" for b in found["blas"]
    )
    cores = found["cores"]
    lines = [
        f"bodyschema {found['bodyschema']}, Python {found['python']}, {found['platform']}",
        f"packages    {packages}",
        f"cache       {place if kept['folder'] else none}",
        f"cores       {cores['usable']} of {cores['machine']}",
        f"BLAS        {libraries or 'unknown'}",
        f"OpenGL      {found['opengl']}",
    ]
    for name, extra in found["extras"].items():
        here = ", ".join(f"{p} {v}" for p, v in extra["packages"].items() if v)
        lines.append(
            f"[{name}]".ljust(12) + ("complete" if extra["complete"] else extra["install"])
        )
        if here:
            lines.append(f"{'':12}{here}")
    return lines
