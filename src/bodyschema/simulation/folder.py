"""A simulation as a folder: robot.urdf, recording.csv and run.toml to calibrate from, truth.json.

robot.urdf      the model that the robot believes, byte by byte as it came
recording.csv   time (s), joints (rad), landmarks in the left eye (m)
run.toml        which column is which sense, and what is known how well
truth.json      for scoring only
"""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.atomic import new_folder
from bodyschema.simulation import icub
from bodyschema.simulation.world import SimulatedRecording, true_frames
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

FILES = ("robot.urdf", "recording.csv", "run.toml", "truth.json")
PURPOSE = "For scoring only: nothing that calibrates may read this file."


def write_simulation(
    simulated: SimulatedRecording, folder: str | Path, overwrite: bool = False
) -> Path:
    """Write the folder, whole or not at all, and return its path.

    Args:
        simulated: from `simulate`.
        folder: where; must be new, empty, or with `overwrite` an older simulation.
        overwrite: replace an older simulation.

    Raises:
        InputError: the folder holds something else, an older simulation without `overwrite`, or
            one that was changed.
    """
    target = Path(folder)
    with new_folder(target, overwrite, is_earlier) as fresh:
        shutil.copyfile(icub.urdf_path(), fresh / "robot.urdf")
        write_table(fresh / "recording.csv", recording_columns(simulated))
        (fresh / "run.toml").write_text(run_text(), encoding="utf-8")
        text = json.dumps(truth_document(simulated)) + "\n"
        (fresh / "truth.json").write_text(text, encoding="utf-8")
    return target


def is_earlier(folder: Path) -> bool:
    """Whether a folder is the simulation of a version that did not list its files, and no more."""
    try:
        with os.scandir(folder) as found:
            ours = {entry.name: entry.is_file(follow_symlinks=False) for entry in found}
        if ours != dict.fromkeys(FILES, True):
            return False
        truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
        return bool(truth["purpose"] == PURPOSE)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def recording_columns(simulated: SimulatedRecording) -> dict[str, Array]:
    """The columns of the recording, in order."""
    columns = {"time": simulated.time}
    columns |= dict(zip(simulated.joints, simulated.q.T, strict=True))
    for mark, points in zip(icub.LANDMARKS, np.moveaxis(simulated.points, 1, 0), strict=True):
        columns |= dict(zip(_columns_of(mark), points.T, strict=True))
    return columns


def run_text() -> str:
    """The run file: what a user would write for this robot and this recording."""
    parts = ['robot = "robot.urdf"\nrecording = "recording.csv"\n\n[joints]\nunit = "rad"\n']
    eye = icub.eye_mounting(icub.LEFT_EYE)
    parts.append(
        f"[frames.{icub.LEFT_EYE}]            # where the camera is believed to be\n"
        f'parent = "{icub.HEAD}"\n'
        f"xyz = {_numbers(eye[:3, 3])}  # m\n"
        f"rpy = {_numbers(lie.rpy_from_rotation(eye[:3, :3]))}  # rad\n"
        'known = "roughly"            # "exactly", "roughly" or "no"\n'
    )
    parts += [
        f'[frames.{mark}]\nparent = "{icub.HAND}"\nxyz = {_numbers(at)}\nknown = "exactly"\n'
        for mark, at in icub.LANDMARKS.items()
    ]
    parts += [
        f'[[senses]]\nkind = "points"\nseen_from = "{icub.LEFT_EYE}"\nseen = "{mark}"\n'
        f'columns = {json.dumps(_columns_of(mark))}\nunit = "m"\n'
        for mark in icub.LANDMARKS
    ]
    return "\n".join(parts)


def truth_document(simulated: SimulatedRecording) -> dict[str, Any]:
    """What was wrong with the robot, and where its hand truly is in the test postures."""
    settings, test = simulated.settings, simulated.test
    _, T_head_eye = true_frames(settings)[icub.LEFT_EYE]
    return {
        "purpose": PURPOSE,
        "settings": asdict(settings) | {"offsets_deg": dict(settings.offsets_deg)},
        "offsets_rad": {name: np.deg2rad(deg) for name, deg in settings.offsets_deg.items()},
        "left_eye": {
            "parent": icub.HEAD,
            "xyz": T_head_eye[:3, 3].tolist(),
            "rpy": lie.rpy_from_rotation(T_head_eye[:3, :3]).tolist(),
            "error_xyz_m": (np.array(settings.eye_error_mm) / 1000).tolist(),
            "error_turn_rad": np.deg2rad(settings.eye_error_deg).tolist(),
        },
        "test": {
            "seen_from": icub.LEFT_EYE,
            "seen": icub.HAND,
            "joints": list(test.joints),
            "q": test.q.tolist(),
            "hand_position": test.T_left_eye_hand[:, :3, 3].tolist(),
            "hand_quaternion_xyzw": lie.quaternion_xyzw(test.T_left_eye_hand[:, :3, :3]).tolist(),
        },
    }


def _columns_of(mark: str) -> list[str]:
    return [f"{mark}_{axis}" for axis in "xyz"]


def _numbers(values: Array | tuple[float, ...]) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"
