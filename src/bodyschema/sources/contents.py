"""What is in a recording, before anybody says what it means: its streams, their rates and gaps."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.documents import is_file, is_folder, is_there, json_file
from bodyschema.errors import BodyschemaError, InputError
from bodyschema.sources.arrays import ENDINGS as ARRAYS
from bodyschema.sources.bags import MARK, bag_topics, is_bag, mended_parts, read_bag, stamps
from bodyschema.sources.lerobot import is_lerobot, read_info
from bodyschema.sources.recording import Recording, seconds
from bodyschema.sources.tables import open_recording
from bodyschema.sources.text_table import ENDINGS as TEXTS
from bodyschema.sources.text_table import PIPED
from bodyschema.sources.video import PICTURES

Array = NDArray[np.float64]

TABLES = (*TEXTS, *ARRAYS, ".parquet")
VIDEOS = (".mp4", ".mkv", ".avi", ".mov", ".webm")

GAPS = 4.0
"""Of the usual spacing: a longer pause is a gap, as it is where streams are joined."""

DEEPEST = 2
"""Folders in one another that are looked into."""

CLOCK = re.compile(r"(.*[._])?(time|t|timestamp|stamp)(_?(s|sec|ms|us|ns|start))?", re.IGNORECASE)
"""Names of columns that hold times."""

UNNAMED = "column_0"
"""The first column of a table without names: its times, if it never goes back."""


@dataclass(frozen=True, eq=False)
class Stream:
    """Samples that came together."""

    name: str
    """As a run file may name it."""
    kind: str
    """Type of its messages or file."""
    samples: int
    time: Array | None = None
    """(n,) s; None without a clock."""
    clock: str = ""
    """Its column of times."""
    recording: Recording | None = None
    """Its numbers; None where none are read."""
    note: str = ""
    """What else is to be said of it."""
    fps: float | None = None
    """Stated rate, of what has no clock of its own."""

    @property
    def rate_hz(self) -> float | None:
        """Samples a second, by the usual spacing; None without a clock."""
        if self.time is None or len(self.time) < 2:
            return self.fps
        step = float(np.median(np.diff(self.time)))
        return 1 / step if step > 0 else None

    @property
    def gaps(self) -> tuple[int, float]:
        """How many pauses there are, and the longest of them, s."""
        if self.time is None or len(self.time) < 3:
            return 0, 0.0
        steps = np.diff(self.time)
        long = steps[steps > GAPS * float(np.median(steps))]
        return len(long), float(long.max(initial=0.0))


@dataclass(frozen=True)
class Contents:
    """All streams of a recording."""

    kind: str
    streams: tuple[Stream, ...]
    notes: tuple[str, ...] = ()
    more: dict[str, Any] = field(default_factory=dict)
    """Of a LeRobot data set: episodes, features, robot, calibration."""


def contents(path: Path) -> Contents:
    """What a file or folder holds.

    Raises:
        InputError: nothing is there, or nothing that is known.
        MissingExtraError: its kind needs an extra.
    """
    if is_lerobot(path):
        return _lerobot(path)
    if is_bag(path):
        place = Path(str(path).partition(MARK)[0])
        notes = tuple(mended.sentence for mended in mended_parts(place))
        return Contents("bag", tuple(_topics(path)), notes)
    if is_folder(path):
        return _folder(path, 0)
    kind = path.suffix.lower()
    if kind in VIDEOS and is_there(path):
        return Contents("video", (_video(path),))
    if kind in PICTURES and is_there(path):
        return Contents("pictures", (Stream(str(path), "picture", 1),))
    table = _table(str(path), "table", open_recording(path))
    return Contents("text" if path.name == PIPED else kind.strip("."), (table,))


def _table(name: str, kind: str, recording: Recording, note: str = "") -> Stream:
    clock = next((c for c in recording.columns if CLOCK.fullmatch(c)), "")
    first = recording.columns.get(UNNAMED)
    if first is not None and (np.diff(first) >= 0).all():
        clock = UNNAMED
    time = seconds(recording.columns[clock]) if clock else None
    if time is not None and not (np.isfinite(time).all() and len(time) > 1):
        time, clock = None, ""
    return Stream(name, kind, len(recording), time, clock, recording, note)


def _topics(path: Path) -> Iterator[Stream]:
    place, _, only = str(path).partition(MARK)
    for topic in bag_topics(Path(place)):
        if only and topic.name != only:
            continue
        name = f"{place}{MARK}{topic.name}"
        if topic.readable:
            yield _table(name, topic.kind, read_bag(name))
        else:
            time = stamps(Path(place), topic.name) if topic.samples else None
            yield Stream(name, topic.kind, topic.samples, time, note="not read as numbers")


def _lerobot(folder: Path) -> Contents:
    info = read_info(folder, ("features",))
    features, fps = info["features"], float(info.get("fps") or 0) or None
    note, made = "", list[Stream]()
    try:
        table = _table(str(folder), "LeRobot states", open_recording(folder))
    except BodyschemaError as error:
        note = str(error)
        table = Stream(str(folder), "LeRobot states", 0, fps=fps, note=note)
    made.append(table)
    made += [
        Stream(f"{folder}: {key}", f"LeRobot {entry['dtype']}", table.samples, fps=fps)
        for key, entry in features.items()
        if entry.get("dtype") in ("video", "image")
    ]
    more = {
        "version": str(info.get("codebase_version")),
        "robot": info.get("robot_type"),
        "episodes": info.get("total_episodes"),
        "features": {k: [e.get("dtype"), e.get("shape")] for k, e in features.items()},
        "calibration": [str(found) for found in calibrations(folder)],
    }
    return Contents("lerobot", tuple(made), (note,) if note else (), more)


def calibrations(folder: Path) -> list[Path]:
    """LeRobot's calibration files in a data set or beside it: range_min and range_max by motor."""
    near = [
        *folder.glob("*.json"),
        *folder.glob("calibration/**/*.json"),
        *folder.parent.glob("*.json"),
    ]
    return [path for path in dict.fromkeys(near) if is_file(path) and _is_calibration(path)]


def _is_calibration(path: Path) -> bool:
    try:
        table = json_file(path, "", "no JSON")
    except InputError:
        return False
    motors = list(table.values()) if isinstance(table, dict) else []
    return bool(motors) and all(isinstance(m, dict) and "range_min" in m for m in motors)


def _video(path: Path) -> Stream:
    from bodyschema.sources.video import Video

    seen = Video.open(path)
    return Stream(
        str(path), "video", seen.count or 0, seen.times(), note=f"{seen.width} x {seen.height} px"
    )


def _folder(folder: Path, depth: int) -> Contents:
    """Everything in a folder that can be read, and in the folders in it."""
    streams, notes, pictures = list[Stream](), list[str](), 0
    more: dict[str, Any] = {}
    for path in sorted(folder.iterdir()):
        kind = path.suffix.lower()
        inner = is_folder(path) and not path.name.startswith(".") and depth < DEEPEST
        pictures += kind in PICTURES and not inner
        try:
            if is_lerobot(path) or kind in (*TABLES, *VIDEOS) or is_bag(path):
                found = contents(path)
            elif inner:
                found = _folder(path, depth + 1)
            else:
                continue
        except BodyschemaError as error:
            notes.append(str(error))
            continue
        streams += found.streams
        notes += found.notes
        more |= found.more
    if pictures:
        streams.append(Stream(str(folder), "pictures", pictures))
    if not streams and not depth:
        there = ", ".join(sorted(path.name for path in folder.iterdir())[:6]) or "nothing"
        raise InputError(
            f"'{folder}' holds no recording, video or pictures; it has {there}."
            + "".join(f" {note}" for note in notes[:1])
        )
    return Contents("folder", tuple(streams), tuple(notes), more)
