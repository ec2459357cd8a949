"""ROS bags and MCAP files (extra `bags`): one recording a topic, a row a message.

    rec.mcap#/joint_states      a topic of a bag, where a file may be named

Columns are `time`, the stamp of the message's header in s since 1970, or when it was recorded
where it has none, and by the message's kind

    joint states     the joints' names; d_NAME and effort_NAME for speeds and efforts
    poses            x y z qx qy qz qw, of a pose or a transform
    points           x y z
    wrenches         fx fy fz tx ty tz
    transforms       those of poses for every child frame: camera.x, camera.y, ...
    several poses    the same by their numbers: 0.x, 0.y, ...
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.documents import is_file, regular_file
from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.sources.cut_bags import cut_off
from bodyschema.sources.mended_mcap import MendedMcap, is_cut
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]

MARK = "#"
"""Between a bag and its topic."""

ENDINGS = (".mcap", ".bag", ".db3")


def is_bag(path: str | Path) -> bool:
    """Whether a name is that of a bag, or of a topic of one."""
    place = Path(str(path).partition(MARK)[0])
    return place.suffix.lower() in ENDINGS or is_file(place / "metadata.yaml")


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    kind: str
    """Type of its messages."""
    samples: int
    readable: bool
    """Whether its messages hold numbers that are read."""


def bag_topics(path: Path) -> tuple[Topic, ...]:
    """All topics of a bag.

    Raises:
        InputError: no such bag, or none that can be read.
        MissingExtraError: rosbags is not installed.
    """
    with opened_bag(path) as reader:
        names = dict.fromkeys(connection.topic for connection in reader.connections)
        topics = [(name, reader.topics[name]) for name in names]
        return tuple(
            Topic(name, str(topic.msgtype), topic.msgcount, _readable(reader, topic.connections))
            for name, topic in topics
        )


def topics_of(path: str | Path) -> tuple[str, ...]:
    """The topics of a bag that can be read, each as a file may be named.

    Raises:
        InputError: no such bag, or none that can be read.
        MissingExtraError: rosbags is not installed.
    """
    name, _, topic = str(path).partition(MARK)
    if topic:
        return (str(path),)
    return tuple(f"{name}{MARK}{one.name}" for one in bag_topics(Path(name)) if one.readable)


def read_bag(path: str | Path) -> Recording:
    """One topic of a bag, or the only one that can be read.

    Raises:
        InputError: no such bag or topic, or several.
        MissingExtraError: rosbags is not installed.
    """
    known = topics_of(path)
    if len(known) != 1:
        raise InputError(_not_one(path, known))
    name, _, topic = known[0].partition(MARK)
    source = f"'{Path(name).name}{MARK}{topic}'"
    with opened_bag(Path(name)) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        if not wanted:
            there = [c.topic for c in reader.connections]
            raise InputError(f"no topic '{topic}' in '{name}'{did_you_mean(topic, there)}")
        found = _Columns()
        for connection, stamp, raw in reader.messages(connections=wanted):
            found.add(_row(reader.deserialize(raw, connection.msgtype), stamp))
    if len(found.columns) < 2:
        raise InputError(
            f"{source} holds {wanted[0].msgtype}, {found.rows} messages, and of these no numbers "
            "are read; `bodyschema inspect` lists the topics."
        )
    remarks = tuple(mended.sentence for mended in mended_parts(Path(name)))
    return replace(found.recording(source), remarks=remarks)


def mended_parts(path: Path) -> list[Any]:
    """The file itself, where it is MCAP that breaks off; it is read up to there."""
    lone = path.suffix.lower() == ".mcap" and is_file(path)
    return [MendedMcap(path)] if lone and is_cut(path) else []


def stamps(path: Path, topic: str) -> Array:
    """When the messages of a topic were recorded, (n,) s; none of them is decoded."""
    with opened_bag(path) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        return np.array([ns for _, ns, _ in reader.messages(connections=wanted)]) / 1e9


def _readable(reader: Any, connections: Sequence[Any]) -> bool:
    first = next(reader.messages(connections=connections), None)
    if first is None:
        return False
    connection, stamp, raw = first
    try:
        message = reader.deserialize(raw, connection.msgtype)
    except KeyError:  # a type that neither the bag nor ROS describes
        return False
    return len(_row(message, stamp)) > 1


def _not_one(path: str | Path, known: Sequence[str]) -> str:
    place = Path(str(path))
    if not known:
        there = ", ".join(f"{t.name} ({t.kind}, {t.samples})" for t in bag_topics(place))
        return (
            f"'{path}' has no topic of numbers that are read: joint states, poses, transforms, "
            f"points or wrenches; it has {there or 'no topics at all'}."
        )
    shown = ", ".join(f'"{place.name}{MARK}{one.partition(MARK)[2]}"' for one in known)
    return (
        f"'{path}' has {len(known)} topics that can be read; name one: {shown}, or set "
        'join = "time" to join them by their stamps.'
    )


class _Columns:
    """Columns that grow by rows, eight bytes a number."""

    def __init__(self) -> None:
        self.rows = 0
        self.columns: dict[str, array[float]] = {}
        self._empty: dict[str, list[int]] = {}

    def add(self, row: Iterable[tuple[str, float]]) -> None:
        for name, value in row:
            column = self.columns.setdefault(name, array("d"))
            self._fill(name, column)
            if len(column) == self.rows:  # else named twice in one message
                column.append(value)
        self.rows += 1

    def _fill(self, name: str, column: array[float]) -> None:
        """Rows that had nothing of a column."""
        if len(column) < self.rows:
            self._empty.setdefault(name, []).extend(range(len(column), self.rows))
            column.extend([np.nan] * (self.rows - len(column)))

    def recording(self, source: str) -> Recording:
        empty = {}
        for name, column in self.columns.items():
            self._fill(name, column)
        for name, rows in self._empty.items():
            empty[name] = np.zeros(self.rows, dtype=bool)
            empty[name][rows] = True
        return Recording(source, {k: np.array(v) for k, v in self.columns.items()}, empty)


@contextmanager
def opened_bag(path: Path) -> Iterator[Any]:
    """A reader of a bag, whose errors are sentences.

    Raises:
        InputError: no such bag, or none that can be read.
        MissingExtraError: rosbags is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("rosbags", "bags", f"reading '{path.name}'") from None
    missing = f"no recording at '{path}'; give the path of a bag or an MCAP file."
    if not is_file(path / "metadata.yaml"):
        regular_file(path, missing)
    beside = path.parent / "metadata.yaml"
    place = path.parent if path.suffix == ".db3" and is_file(beside) else path
    parts: list[Any] = mended_parts(path)
    if parts and parts[0].seconds is None:
        raise InputError(f"'{path}' is no bag that can be read: {cut_off(path)}.")
    try:
        store = get_typestore(Stores.LATEST)
        with AnyReader(parts or [place], default_typestore=store) as reader:
            yield reader
    except InputError:
        raise
    except Exception as error:  # of a reader, a decompressor, a database, a parser of messages
        reason = str(error).partition("\n")[0].rstrip(".") or type(error).__name__
        said = cut_off(path)
        more = f"; {said}" if said else ""
        raise InputError(f"'{path}' is no bag that can be read: {reason}{more}.") from None


def _row(message: Any, stamp: int) -> list[tuple[str, float]]:
    """The time and the numbers of a message; the time alone of kinds that are not read."""
    first = getattr(message, "transforms", ())[:1]
    header = getattr(first[0] if first else message, "header", None)
    if header is not None and (header.stamp.sec or header.stamp.nanosec):
        stamp = header.stamp.sec * 10**9 + header.stamp.nanosec
    return [("time", stamp / 1e9), *_numbers(message)]


def _numbers(message: Any) -> list[tuple[str, float]]:
    if hasattr(message, "name") and hasattr(message, "effort"):
        kinds = {"": message.position, "d_": message.velocity, "effort_": message.effort}
        return [
            (start + name, float(value))
            for start, values in kinds.items()
            for name, value in zip(message.name, values, strict=False)
        ]
    several = {t.child_frame_id: t for t in getattr(message, "transforms", ())}
    several |= {str(i): pose for i, pose in enumerate(getattr(message, "poses", ()))}
    if several:
        return [
            (f"{name}.{axis}", value)
            for name, one in several.items()
            for axis, value in _numbers(one)
        ]
    inner = next(
        (getattr(message, key) for key in ("pose", "transform", "point", "wrench") if
         hasattr(message, key)), message,
    )  # fmt: skip
    inner = getattr(inner, "pose", inner)
    if hasattr(inner, "force"):
        return _axes(inner.force, "f") + _axes(inner.torque, "t")
    place, turn = (
        getattr(inner, keys[0], getattr(inner, keys[1], None))
        for keys in (("position", "translation"), ("orientation", "rotation"))
    )
    if place is not None and turn is not None:
        return _axes(place, "") + _axes(turn, "q", "xyzw")
    return _axes(inner, "") if all(hasattr(inner, axis) for axis in "xyz") else []


def _axes(vector: Any, start: str, axes: str = "xyz") -> list[tuple[str, float]]:
    return [(start + axis, float(getattr(vector, axis))) for axis in axes]
