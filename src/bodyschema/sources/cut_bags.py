"""What is left of a bag whose recorder died or whose copy broke off, in one sentence."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from bodyschema.documents import is_folder

MCAP, ROS1 = b"\x89MCAP0\r\n", b"#ROSBAG V2"

FOOTER, MESSAGE, CHUNK = 0x02, 0x05, 0x06
"""Kinds of records of an MCAP file: the last one, a message, messages packed together."""

_HEAD = struct.Struct("<BQ")
_TIMES = struct.Struct("<QQ")
_STAMP = struct.Struct("<HIQ")


def cut_off(place: Path) -> str:
    """What is there of a bag that breaks off, and how to mend it; "" of one that does not.

    Args:
        place: a file, or the folder of a ROS 2 bag.
    """
    inside = sorted(place.glob("*.mcap")) + sorted(place.glob("*.db3")) if is_folder(place) else ()
    for path in inside or (place,):
        try:
            with path.open("rb") as file:
                said = _said(path, file)
        except (OSError, ValueError):
            continue
        if said:
            return said
    return ""


def _said(path: Path, file: BinaryIO) -> str:
    start = file.read(16)
    if start.startswith(ROS1):
        return f"its index is missing or damaged; `rosbag reindex {path.name}` makes it anew"
    if start.startswith(b"SQLite"):
        return f"what is whole of it: `sqlite3 {path.name} .recover | sqlite3 whole.db3`"
    if not start.startswith(MCAP):
        return ""
    file.seek(len(MCAP))
    ended, times = False, list[int]()
    for kind, stamps in _records(file):
        ended |= kind == FOOTER
        times += stamps
    if ended:
        return ""
    size = f"after {path.stat().st_size / 1e6:.1f} MB"
    if not times:
        return f"it breaks off {size}, before any message is whole; record it again"
    seconds = (max(times) - min(times)) / 1e9
    return (
        f"it breaks off {size}, and {seconds:.2f} s of messages are whole; "
        f"`mcap recover {path.name} -o whole.mcap` keeps them"
    )


def _records(file: BinaryIO) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Kind and times in ns of every whole record of an MCAP file."""
    size = file.seek(0, 2)
    at = file.seek(len(MCAP))
    while at + _HEAD.size <= size:
        kind, length = _HEAD.unpack(file.read(_HEAD.size))
        at += _HEAD.size + length
        if at > size:
            return
        stamps: tuple[int, ...] = ()
        if kind == CHUNK and length >= _TIMES.size:
            stamps = _TIMES.unpack(file.read(_TIMES.size))
        elif kind == MESSAGE and length >= _STAMP.size:
            stamps = _STAMP.unpack(file.read(_STAMP.size))[2:]
        yield kind, stamps
        file.seek(at)
