"""ROS bags and MCAP files (extra `bags`): one recording a topic, a row a message.

    rec.mcap#/joint_states      a topic of a bag, where a file may be named

Columns are `time`, the stamp of the message's header in s since 1970, or when it was recorded
where it has none, and by the message's kind

    joint states     the joints' names; d_NAME and effort_NAME for speeds and efforts
    poses            x y z qx qy qz qw, of a pose or a transform
    points           x y z
    wrenches         fx fy fz tx ty tz
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from bodyschema.documents import is_file, regular_file
from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.sources.recording import Recording

MARK = "#"
"""Between a bag and its topic."""

ENDINGS = (".mcap", ".bag", ".db3")


def is_bag(path: str | Path) -> bool:
    """Whether a name is that of a bag, or of a topic of one."""
    place = Path(str(path).partition(MARK)[0])
    return place.suffix in ENDINGS or is_file(place / "metadata.yaml")


def topics_of(path: str | Path) -> tuple[str, ...]:
    """The topics of a bag that can be read, each as a file may be named.

    Raises:
        InputError: no such bag, or none that can be read.
        MissingExtraError: rosbags is not installed.
    """
    name, _, topic = str(path).partition(MARK)
    if topic:
        return (str(path),)
    with _opened(Path(name)) as reader:
        found = {}
        for connection, stamp, raw in reader.messages():
            if connection.topic not in found:
                message = reader.deserialize(raw, connection.msgtype)
                found[connection.topic] = bool(_row(message, stamp)[1:])
    return tuple(f"{name}{MARK}{topic}" for topic, readable in found.items() if readable)


def read_bag(path: str | Path) -> Recording:
    """One topic of a bag, or the only one that can be read.

    Raises:
        InputError: no such bag or topic, or several.
        MissingExtraError: rosbags is not installed.
    """
    known = topics_of(path)
    if len(known) != 1:
        place = Path(str(path)).name
        shown = ", ".join(f'"{place}{MARK}{one.partition(MARK)[2]}"' for one in known)
        raise InputError(
            f"'{path}' has {len(known)} topics that can be read; name one: {shown}, or set "
            'join = "time" to join them by their stamps.'
        )
    name, _, topic = known[0].partition(MARK)
    rows = []
    with _opened(Path(name)) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        if not wanted:
            there = [c.topic for c in reader.connections]
            raise InputError(f"no topic '{topic}' in '{name}'{did_you_mean(topic, there)}")
        for connection, stamp, raw in reader.messages(connections=wanted):
            rows.append(dict(_row(reader.deserialize(raw, connection.msgtype), stamp)))
    names = list(dict.fromkeys(key for row in rows for key in row))
    columns = {key: np.array([row.get(key, np.nan) for row in rows]) for key in names}
    empty = {key: np.array([key not in row for row in rows]) for key in names}
    return Recording(
        f"'{Path(name).name}{MARK}{topic}'", columns, {k: v for k, v in empty.items() if v.any()}
    )


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("rosbags", "bags", f"reading '{path.name}'") from None
    missing = f"no recording at '{path}'; give the path of a bag or an MCAP file."
    if not is_file(path / "metadata.yaml"):
        regular_file(path, missing)
    place = path.parent if path.suffix == ".db3" else path
    try:
        with AnyReader([place], default_typestore=get_typestore(Stores.LATEST)) as reader:
            yield reader
    except InputError:
        raise
    except Exception as error:  # of a reader, a decompressor, a database, a parser of messages
        reason = str(error).partition("\n")[0].rstrip(".") or type(error).__name__
        raise InputError(f"'{path}' is no bag that can be read: {reason}.") from None


def _row(message: Any, stamp: int) -> list[tuple[str, float]]:
    """The time and the numbers of a message; the time alone of kinds that are not read."""
    header = getattr(message, "header", None)
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
