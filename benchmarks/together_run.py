"""The arm of `together` as people would bring it: three tables, four pictures and one run file."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli import run
from bodyschema.model.camera import Camera
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense
from bodyschema.sources.tables import write_table
from seen_and_felt import ARM, EYE, JOINTS, MARKER, SENSOR, TRACKER

Array = NDArray[np.float64]

RUN = """
robot = "arm4.urdf"
time = ""
folds = 4
{frames}
[parts.lens]
kind = "lens"
fx = {fx}
size = [{width}, {height}]
known = "exactly"
[parts.edge]
kind = "edge"
[parts.load]
kind = "load"
known = "no"
[parts.ft]
kind = "sensor"
free = ["offset"]

[[senses]]
kind = "points"
recording = "tracker.csv"
seen_from = "tracker"
seen = "marker"
columns = ["x", "y", "z"]
unit = "mm"
[[senses]]
kind = "outlines"
recording = "pictures.csv"
seen_from = "camera"
lens = "lens"
edge = "edge"
reach = 60.0
masks = "mask_{{row}}.png"
[[senses]]
kind = "wrenches"
recording = "wrist.csv"
seen_from = "sensor"
seen = "base"
columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
sign = "on_object"
loads = ["load"]
sensor = "ft"

[free]
groups = ["offsets"]
joints = ["j2", "j3", "j4"]
"""

FRAMES = (
    ("camera", "base", EYE, "roughly"),
    ("tracker", "base", TRACKER, "roughly"),
    ("marker", "hand", MARKER, "roughly"),
    ("sensor", "hand", SENSOR, "exactly"),
)


def write_run(
    folder: Path, points: Points, wrenches: Sense, q: Array, masks: Any, lens: Camera
) -> Path:
    """Write everything that was seen and felt of an arm; returns the run file.

    Args:
        folder: where.
        points: of the tracker.
        wrenches: of the sensor.
        q: (n, 4) readings at the pictures.
        masks: of the arm, one for each.
        lens: of the camera.
    """
    import cv2

    (folder / "arm4.urdf").write_text(ARM)
    _record(folder / "tracker.csv", points.q, ("x", "y", "z"), 1e3 * points.position)
    wrench = ("fx", "fy", "fz", "tx", "ty", "tz")
    _record(folder / "wrist.csv", wrenches.q, wrench, wrenches.observed)
    _record(folder / "pictures.csv", q, (), np.zeros((len(q), 0)))
    for i, mask in enumerate(masks):
        cv2.imwrite(str(folder / f"mask_{i}.png"), mask.astype(np.uint8) * 255)
    sizes = {"fx": lens.matrix[0, 0], "width": lens.width, "height": lens.height}
    frames = "".join(_frame(*frame) for frame in FRAMES)
    (folder / "run.toml").write_text(RUN.format(frames=frames, **sizes))
    return folder / "run.toml"


def calibrated(run_file: Path) -> dict[str, Any]:
    """What `bodyschema calibrate RUN.toml --json` prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        run(["calibrate", str(run_file), "--out", str(run_file.parent / "out"), "--json"])
    found: dict[str, Any] = json.loads(printed.getvalue())
    return found


def _record(path: Path, q: Array, names: tuple[str, ...], values: Array) -> None:
    joints = {joint: q[:, j] for j, joint in enumerate(JOINTS)}
    write_table(path, {**joints, **dict(zip(names, values.T, strict=True))})


def _frame(name: str, parent: str, T: Array, known: str) -> str:
    xyz, rpy = (np.round(v, 12).tolist() for v in (T[:3, 3], lie.rpy_from_rotation(T[:3, :3])))
    return f'[frames.{name}]\nparent = "{parent}"\nxyz = {xyz}\nrpy = {rpy}\nknown = "{known}"\n'
