"""From a result folder back to what was recorded, as far as its files are still there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bodyschema.cli.loading import blank_senses, read_senses
from bodyschema.cli.reading.robot import robot_of
from bodyschema.cli.run_file import run_from_record
from bodyschema.documents import is_file
from bodyschema.errors import BodyschemaError, InputError
from bodyschema.model.tree import Body, Visual
from bodyschema.senses.sense import Sense


@dataclass(frozen=True)
class Recalled:
    """What a run was made of."""

    senses: tuple[Sense, ...]
    """As recorded; without samples where the recording is gone."""
    visuals: tuple[Visual, ...]
    """Shapes of the robot description; none where that is gone."""
    notes: tuple[str, ...]
    """Sentences on what is gone."""


def recall(document: Mapping[str, Any], body: Body, robot: Path | None = None) -> Recalled:
    """Read the robot description and the recording of a stored run again.

    Args:
        document: run.json.
        body: the stored body, whose frames and joints the recording must fit.
        robot: description with the shapes; that of the run when None.

    Raises:
        InputError: the run does not say what was seen.
    """
    run = run_from_record(document)
    visuals: tuple[Visual, ...] = ()
    notes: list[str] = []
    if robot is not None and not is_file(robot):
        raise InputError(f"no robot description at '{robot}'; give the path of a URDF file.")
    try:
        if robot or run.robot:
            visuals = robot_of(run, robot).visuals
    except BodyschemaError as error:
        notes.append(f"The robot description was not read again: {error}")
    seen = replace(body, visuals=visuals)
    try:
        senses = read_senses(run, seen)
    except BodyschemaError as error:
        notes.append(f"The recording was not read again, so its view bounds nothing: {error}")
        senses = blank_senses(run, seen)
    return Recalled(senses, visuals, tuple(notes))
