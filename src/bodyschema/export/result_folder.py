"""The answer of any verb as one folder, which appears whole or not at all.

answer.json         the whole answer at full precision, for check, plan, report and Python
run.json            what was asked, with versions and hashes of the inputs
report.html         all of it for people, where the extra `report` is installed
robot.urdf          the user's own file with the changed numbers, byte by byte otherwise
robot.xml           the same where that is an MJCF; robot.urdf is then newly written
calibration.yaml    where joints or frames were corrected: everything that was found
kinematics.yaml     and the joint frames, for xacro
ur_kinematics.yaml  those of a UR arm in the keys that ur_description loads
NAME_camera_info.yaml, NAME_opencv.yml    lenses that were estimated, for ROS and for OpenCV
transforms.yaml     cameras, trackers and tools that were estimated, if any
payload.yaml        loads in the forms of controllers, where a wrist's were found
.bodyschema.json    what of this bodyschema wrote, with hashes: only that is ever replaced

When the verdict is "only frames", the joints of robot.urdf are as they were given, and without a
frame of its own that was estimated it is the same bytes. Whether to write a result that was
"refused" is for the caller to decide; its calibration.yaml says so.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from bodyschema.atomic import check_new_folder, new_folder
from bodyschema.atomic.manifest import file_hash
from bodyschema.atomic.places import resolved
from bodyschema.documents import is_file, is_folder, is_there
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.export.calibration_yaml import calibration_text
from bodyschema.export.documents import plain, versions
from bodyschema.export.kinematics_yaml import kinematics_text
from bodyschema.export.lens_files import lens_files
from bodyschema.export.mjcf_edits import edited_mjcf
from bodyschema.export.payload import carried_loads, payload_text, urdf_with_load
from bodyschema.export.record import encoded
from bodyschema.export.static_transforms import (
    added_frames,
    attached_frames,
    estimated_frames,
    transforms_text,
)
from bodyschema.export.ur_kinematics import ur_kinematics_text
from bodyschema.export.urdf_edits import described, unwritable, urdf_edits
from bodyschema.export.urdf_frames import with_frames
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.settled import settled
from bodyschema.model.description import is_mjcf, is_urdf
from bodyschema.model.meshes import Packages
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf, urdf_text

INPUT_KEYS = ("robot", "skeleton", "recording", "inputs")
"""Entries of a run that name files or folders that were read."""

ANSWER, FORM = "answer.json", 2
"""The whole answer, and the version of its form."""

EARLIER = re.compile(
    r"(answer|run|estimate|track|found)\.json|(calibration|kinematics|transforms|payload)\.yaml|"
    r"robot\.urdf|report\.html|evidence\.(csv|npz)|mask\.png|overlay(\.mp4|_\d+\.png)"
)
"""Names of files in the results of versions that did not list them."""

UNPLACED = ("not known", "not found")
"""Verdicts after which no frame is published."""

UNSTORED = frozenset({"senses", "run", "visuals", "seconds", "sections", "files"})
"""Fields that answer.json leaves out: the recording has them, run.json, and the
description; and the time that it took."""


def write_result(
    calibration: Calibration,
    nominal: Body,
    source: Path | None,
    folder: Path,
    run: Mapping[str, Any],
    overwrite: bool = False,
    more: Mapping[str, bytes] | None = None,
) -> list[Path]:
    """Write the folder.

    Args:
        calibration: the answer.
        nominal: as described, without the frames that were attached.
        source: the robot description of any form; None if there is no file.
        folder: where; new, empty, or with `overwrite` an earlier result, which is replaced.
        run: what was asked. Paths under INPUT_KEYS are hashed.
        overwrite: replace what is in the folder.
        more: further files by name, such as a report.

    Returns:
        The paths of the files.

    Raises:
        InputError: the folder holds one of the inputs or lies in it, cannot be written, or holds
            something already.
    """
    inputs = list(inputs_of(source, run))
    refuse_inputs(folder, inputs)
    with new_folder(folder, overwrite, is_earlier) as fresh:
        names = write_files(calibration, nominal, source, fresh, run, more or {})
    return [folder / name for name in names]


def write_files(
    calibration: Calibration,
    nominal: Body,
    source: Path | None,
    folder: Path,
    run: Mapping[str, Any],
    more: Mapping[str, bytes],
) -> list[str]:
    """Write into a folder that is there; see `write_result`. Returns the files' names."""
    packages, added = run.get("packages", {}), bool(run.get("add_frames"))
    files = result_files(calibration, nominal, source, packages, added)
    files |= {name: text.encode() for name, text in lens_files(calibration, run).items()}
    record = json.dumps(run_record(source, run), indent=2, ensure_ascii=False, allow_nan=False)
    files["run.json"] = (record + "\n").encode()
    files |= more
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return list(files)


def check_place(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that could not be written, before any work is spent.

    Only an earlier result may be replaced, and it alone.

    Args:
        folder: for the result.
        overwrite: whether an earlier one may be replaced.

    Raises:
        InputError: it holds something else, or its place cannot be written.
    """
    check_new_folder(folder, overwrite, is_earlier)


def is_earlier(folder: Path) -> bool:
    """Whether a folder is the result of a version that did not list its files, and no more."""
    try:
        with os.scandir(folder) as found:
            ours = all(
                entry.is_file(follow_symlinks=False) and EARLIER.fullmatch(entry.name)
                for entry in found
            )
        run = json.loads((folder / "run.json").read_text(encoding="utf-8")) if ours else {}
        return "bodyschema" in run["versions"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def result_files(
    calibration: Calibration,
    nominal: Body,
    source: Path | None,
    packages: Packages,
    add_frames: bool = False,
) -> dict[str, bytes]:
    """Contents of the files that the answer decides, by name; see `write_result`.

    With `add_frames` robot.urdf has the frames that were estimated, too.
    """
    text = None
    if source is not None and is_urdf(source):
        text = urdf_text(source, packages, nominal.arguments)
    if text is not None and source is not None:
        # What the file says is what is patched, whatever was done to the body since.
        nominal = parse_urdf(text, source, packages)
    body = body_to_write(calibration, nominal) if calibration.corrects else nominal
    texts: dict[str, str] = {}
    if calibration.corrects:
        notes = writing_notes(calibration, nominal)
        if source is not None and is_mjcf(source):
            mjcf, note = _corrected_mjcf(calibration, nominal, source, body, add_frames)
            texts |= {"robot.xml": mjcf} if mjcf else {}
            notes += [note] if note else []
        texts["calibration.yaml"] = calibration_text(calibration, notes)
        texts["kinematics.yaml"] = kinematics_text(body)
        of_ur = ur_kinematics_text(body)
        texts |= {"ur_kinematics.yaml": of_ur} if of_ur else {}
    texts[ANSWER] = answer_text(calibration)
    if "loads" in calibration.details:
        texts["payload.yaml"] = payload_text(calibration.details)
    if calibration.verdict not in UNPLACED and attached_frames(calibration, nominal):
        texts["transforms.yaml"] = transforms_text(calibration, nominal)
    files = {name: content.encode() for name, content in texts.items()}
    loaded = carried_loads(calibration)
    if calibration.corrects or (loaded and text is not None):
        robot = write_urdf(body) if text is None else patch_urdf(text, urdf_edits(nominal, body))
        for link, loads in loaded.items():
            robot = urdf_with_load(robot, link, loads)
        if add_frames:
            robot = with_frames(robot, added_frames(calibration, nominal))
        files = {"robot.urdf": robot, **files}
    return files


def _corrected_mjcf(
    calibration: Calibration, nominal: Body, source: Path, body: Body, add_frames: bool
) -> tuple[str, str]:
    """The MJCF that was read with corrected numbers; "" with a sentence why there is none."""
    added = added_frames(calibration, nominal) if add_frames else []
    try:
        return edited_mjcf(source, nominal, body, added, elsewhere=True)[0].decode(), ""
    except (InputError, MissingExtraError, UnicodeDecodeError) as error:
        return "", f"No robot.xml was written: {error}"


def answer_text(calibration: Calibration) -> str:
    """answer.json: every number of the answer, so that a later run can go on from it."""
    document = {"form": FORM, **encoded(calibration, UNSTORED)}
    return json.dumps(document, allow_nan=False, ensure_ascii=False) + "\n"


def body_to_write(calibration: Calibration, nominal: Body) -> Body:
    """The nominal tree with the corrected numbers; those of its frames alone if so decided."""
    corrected = described(nominal, settled(calibration).body)
    if calibration.verdict != "only frames":
        return corrected
    body = nominal
    for frame in estimated_frames(calibration.estimate.variables):
        if frame in nominal.frames:
            body = body.with_placement(frame, corrected.placement[corrected.frame_index(frame)])
    return body


def writing_notes(calibration: Calibration, nominal: Body) -> list[str]:
    """Sentences on what of the robot is written and what is not."""
    if not calibration.corrects:
        return []
    body, notes = body_to_write(calibration, nominal), []
    if calibration.withheld:
        said = f"This calibration was {calibration.verdict}"
        notes.append(f"{said}: do not trust a robot to these files.")
    count = len(urdf_edits(nominal, body))
    if count:
        notes.append(f"robot.urdf is corrected at {count} joint{'s' * (count > 1)}.")
    else:
        notes.append("robot.urdf is the robot as described: nothing in it was changed.")
    return notes + unwritable(nominal, body)


def inputs_of(source: Path | None, run: Mapping[str, Any]) -> Iterator[Path]:
    """Files and folders that were read, each once."""
    values = [source, *(run.get(key) for key in INPUT_KEYS)]
    seen = set()
    while values:
        value = values.pop(0)
        if isinstance(value, Mapping):
            values += value.values()
        elif isinstance(value, list | tuple):
            values += value
        elif isinstance(value, str | Path) and str(value) and is_there(Path(value)):
            if Path(value).resolve() not in seen:
                yield Path(value)
            seen.add(Path(value).resolve())


def refuse_inputs(place: Path, inputs: Sequence[Path]) -> None:
    """Refuse a folder or file that is an input, holds one, or lies in one.

    Raises:
        InputError: it would touch what was read.
    """
    target = resolved(place)
    for path in inputs:
        if _touches(target, resolved(path)):
            raise InputError(
                f"the results cannot go to '{place}': the input '{path}' lies there, and inputs "
                "are never touched; name another folder."
            )


def _touches(target: Path, read: Path) -> bool:
    if target == read or target in read.parents or (is_folder(read) and read in target.parents):
        return True
    return is_file(target) and is_file(read) and target.samefile(read)  # two names of one file


def run_record(source: Path | None, run: Mapping[str, Any]) -> dict[str, Any]:
    """What run.json holds: the run as given, versions, and the SHA-256 of each input.

    Args:
        source: the robot description; None if there is no file.
        run: what was asked; see `write_result`. Hashes that it has already are kept.
    """
    hashes = {str(path): sha256(path) for path in inputs_of(source, run)}
    hashes |= run.get("sha256", {})
    return {**plain(run), "versions": versions(), "sha256": hashes}


def sha256(path: Path) -> str:
    """Hash of a file, or of the names and hashes of all files of a folder, in hexadecimal."""
    if is_file(path):
        return file_hash(path)
    whole = hashlib.sha256()
    for inner in sorted(p for p in path.rglob("*") if p.is_file()):
        whole.update(f"{inner.relative_to(path).as_posix()}\0{sha256(inner)}\n".encode())
    return whole.hexdigest()
