"""How far off a body imagines its hand, against the truth that the simulation kept aside."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.simulation.icub import HAND, LEFT_EYE
from bodyschema.simulation.world import HandPoseTruth, Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """What a simulation knows and its recording does not tell."""

    settings: Simulation
    """With them the real robot can be built again."""
    hand: HandPoseTruth
    """Test postures and where the hand truly is in them."""


@dataclass(frozen=True)
class HandErrors:
    """Imagined against true pose of the hand in the left eye, one a test posture."""

    position: Array
    """(n,) m."""
    rotation: Array
    """(n,) rad."""


def hand_error(body: Body, truth: Truth) -> HandErrors:
    """Errors of the hand poses that a body predicts for the test postures.

    Args:
        body: any body with the frames `left_eye` and `r_hand` and the joints of the truth.
        truth: from `load_truth`.

    Raises:
        InputError: the body lacks a frame or a joint.
    """
    pose = predicted_hand(body, truth.hand)
    off = lie.inverse(truth.hand.T_left_eye_hand) @ pose
    return HandErrors(
        position=np.linalg.norm(off[:, :3, 3], axis=-1),
        rotation=np.linalg.norm(lie.log_so3(off[:, :3, :3]), axis=-1),
    )


def predicted_hand(body: Body, hand: HandPoseTruth) -> Array:
    """T_left_eye_hand as the body imagines it in the test postures, (n, 4, 4)."""
    return relative_pose(body, readings_for(body, hand), LEFT_EYE, HAND)


def readings_for(body: Body, hand: HandPoseTruth) -> Array:
    """The readings of the test postures in the order of the body's joints; others are 0."""
    q = np.zeros((len(hand.q), len(body.joints)))
    for column, joint in enumerate(hand.joints):
        q[:, body.joint_index(joint)] = hand.q[:, column]
    return q


def describe_errors(before: HandErrors, after: HandErrors) -> str:
    """Both results in words, for the command line."""
    rows = [("before", before), ("after", after)]
    return "\n".join(
        f"hand error {name:>6}: {1000 * errors.position.mean():7.2f} mm mean, "
        f"{1000 * errors.position.max():7.2f} mm at most, "
        f"{np.rad2deg(errors.rotation).mean():6.2f} deg mean"
        for name, errors in rows
    )


def load_truth(path: str | Path) -> Truth:
    """Read the `truth.json` of a simulation, by its own path or by that of its folder.

    Raises:
        InputError: there is none, or it is something else.
    """
    file = Path(path)
    if file.is_dir():
        file = file / "truth.json"
    if not file.is_file():
        raise InputError(f"no truth at '{file}'; name the folder of a simulation.")
    try:
        return _truth(json.loads(file.read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"'{file}' is not the truth of a simulation ({type(error).__name__}: {error}); "
            "simulate again."
        ) from None


def _truth(document: Mapping[str, Any]) -> Truth:
    stored = document["settings"]
    values = {field.name: stored[field.name] for field in fields(Simulation)}
    for name in ("eye_error_mm", "eye_error_deg"):
        values[name] = tuple(values[name])
    test = document["test"]
    rotation = lie.rotation_from_xyzw(test["hand_quaternion_xyzw"])
    pose = lie.transform(rotation, test["hand_position"])
    hand = HandPoseTruth(tuple(test["joints"]), np.array(test["q"], dtype=np.float64), pose)
    return Truth(Simulation(**values), hand)
