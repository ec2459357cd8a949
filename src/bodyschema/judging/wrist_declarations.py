"""What a declaration of a wrist's columns makes of them, and which other one would explain more.

A load that leaves much of the wrench unexplained often means that one entry was written wrongly:
the axes of the wrench, its unit, the layout of the pose. Each of these entries is tried as it is
often meant; the one under which a load explains the wrench is named.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bodyschema.errors import InputError
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, fit_payload
from bodyschema.senses.wrench_means import Averaging, WrenchMeans, postures
from bodyschema.senses.wrist_columns import WristRecording, WristTable
from bodyschema.senses.wrist_declaration import (
    SIGNS,
    MotionReading,
    SensorPlace,
    WristDeclaration,
)
from bodyschema.senses.wrist_samples import WristSamples

TURN_STD = {"exactly": 1e-6, "roughly": float(np.radians(5)), "no": float(np.inf)}
"""rad, by what is known of the sensor's mounting."""

TARED = (0.05, 0.002)
"""N and Nm, what the offset of a tared sensor may still be."""

SLOWEST = 0.08
"""s between samples, beyond which a motion cannot be followed."""

POOR = 0.1
"""Share of the wrench that may be left over before the answer says that something is wrong."""

DOUBTFUL, MUCH = 0.01, 0.3
"""Share from which other entries are tried, and what one must bring it down to, to be named."""

LONG = 0.6
"""m from the sensor, beyond which a load's centre is no usual one. A unit of torque scales centre
and moments and explains nothing better: only where the centre is odd may another unit be named, or
a load that slips would be blamed on the unit that makes its torques next to nothing."""

AS_WELL = 1.3
"""Entries that explain nearly as much as the best are named with it."""

ALTERNATIVES: dict[str, dict[str, tuple[str, ...]]] = {
    "wrench": {
        "frame": ("sensor", "base"), "about": ("base",), "sign": SIGNS,
        "torque_unit": ("Nm", "Nmm", "kgfm"), "force_unit": ("N", "kgf", "lbf"),
    },
    "pose": {"unit": ("m", "mm"), "angle_unit": ("rad", "deg")},
}  # fmt: skip
"""Entries that are often written wrongly, and what else they may be."""

SWAPPED = {
    "xyz_xyzw": "xyz_wxyz", "xyz_wxyz": "xyz_xyzw", "xyzw": "wxyz", "wxyz": "xyzw",
    "xyz_rpy": "xyz_rotvec", "xyz_rotvec": "xyz_rpy", "rpy": "rotvec", "rotvec": "rpy",
}  # fmt: skip
"""Layouts that are taken for each other."""


def is_moving(motion: MotionReading, read: WristRecording) -> bool:
    """Whether rows are moments of a motion that can be followed."""
    if motion.kind != "auto":
        return motion.kind == "moving"
    step = float(np.median(np.diff(read.samples.time)))
    return read.moving and step <= SLOWEST


def load_means(
    motion: MotionReading, samples: WristSamples, moving: bool, sensor: SensorPlace
) -> WrenchMeans:
    """Wrenches and regressors: of windows of a motion, or of postures at rest.

    Args:
        motion: how the recording is read.
        samples: of it.
        moving: whether they are of a motion.
        sensor: with its noise at rest, if it is known.
    """
    if moving:
        return Averaging(motion.window).means(samples)
    made = postures(samples)
    noise = made.std.copy()
    if sensor.noise_N is not None:
        noise[:3] = sensor.noise_N
    if sensor.noise_Nm is not None:
        noise[3:] = sensor.noise_Nm
    return replace(made, std=noise)


def load_learner(declared: WristDeclaration) -> LoadLearner:
    """The learner that believes what is said of the sensor."""
    learner = LoadLearner(turn_std=TURN_STD[declared.sensor.known])
    if declared.wrench.bias == "none":
        learner = replace(learner, force_bias_std=TARED[0], torque_bias_std=TARED[1])
    return learner


def other_declarations(declared: WristDeclaration) -> Mapping[str, WristDeclaration]:
    """Words for one changed entry -> the declaration with it, most likely first."""
    trials = dict[str, WristDeclaration]()
    for key, words in ALTERNATIVES["wrench"].items():
        for word in (word for word in words if word != getattr(declared.wrench, key)):
            change: dict[str, Any] = {key: word}
            wrench = replace(declared.wrench, **change)
            trials[f'{key} = "{word}"'] = replace(declared, wrench=wrench)
    if declared.pose is not None:
        layout = declared.pose.layout
        changes: list[tuple[str, Any]] = [("inverse", not declared.pose.inverse)]
        changes += [("layout", SWAPPED[layout])] if layout in SWAPPED else []
        for key, words in ALTERNATIVES["pose"].items():
            changes += [(key, word) for word in words if word != getattr(declared.pose, key)]
        for key, value in changes:
            pose = replace(declared.pose, **{key: value})
            trials[f"{key} = {json.dumps(value)} under [pose]"] = replace(declared, pose=pose)
    strength = float(np.linalg.norm(declared.down))
    for axis in (*np.eye(3), *-np.eye(3)):
        x, y, z = (strength * axis).tolist()
        if not np.allclose((x, y, z), declared.down, atol=0.1 * strength):
            entry = f"down = [{x:.4g}, {y:.4g}, {z:.4g}] under [motion]"
            trials[entry] = replace(declared, down=(x, y, z))
    turned = replace(declared.sensor, known="no")
    trials['known = "no" under [sensor]'] = replace(declared, sensor=turned)
    return trials


def better_declaration(
    table: WristTable,
    declared: WristDeclaration,
    motion: MotionReading,
    moving: bool,
    share: float,
    lever: float,
) -> str:
    """The entry that, written otherwise, would explain the wrench; "" if there is none.

    Args:
        table: the recording.
        declared: what is said of it.
        motion: how it is read.
        moving: whether its rows are moments of a motion.
        share: of the wrench that the load leaves unexplained as declared.
        lever: m, of its centre of mass as declared.
    """
    if share <= DOUBTFUL:
        return ""
    found = dict[str, float]()
    for words, trial in other_declarations(declared).items():
        if lever <= LONG and words.startswith(("torque_unit", "force_unit")):
            continue
        try:
            means = load_means(motion, table.read(trial).samples, moving, trial.sensor)
            fit = fit_payload([Part(means, ("load",))], load_learner(trial))
        except InputError:
            continue
        left = float(fit.unexplained.max())
        if left < min(0.5 * POOR, MUCH * share):
            found[words] = left
    best = min(found.values(), default=0.0)
    return " or ".join(words for words, left in found.items() if left <= AS_WELL * best)
