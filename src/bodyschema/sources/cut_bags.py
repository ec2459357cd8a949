"""What is left of a bag whose recorder died or whose copy broke off, in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from bodyschema.documents import is_folder
from bodyschema.sources.mended_mcap import MAGIC, MendedMcap, is_cut

ROS1 = b"#ROSBAG V2"


def cut_off(place: Path) -> str:
    """What is there of a bag that breaks off, and how to mend it; "" of one that does not.

    Args:
        place: a file, or the folder of a ROS 2 bag.
    """
    inside = sorted(place.glob("*.mcap")) + sorted(place.glob("*.db3")) if is_folder(place) else ()
    for path in inside or (place,):
        try:
            with path.open("rb") as file:
                said = _said(path, file, bool(inside))
        except (OSError, ValueError):
            continue
        if said:
            return said
    return ""


def _said(path: Path, file: BinaryIO, within: bool) -> str:
    start = file.read(16)
    if start.startswith(ROS1):
        return f"its index is missing or damaged; `rosbag reindex {path.name}` makes it anew"
    if start.startswith(b"SQLite"):
        return f"what is whole of it: `sqlite3 {path.name} .recover | sqlite3 whole.db3`"
    if not start.startswith(MAGIC) or not is_cut(path):
        return ""
    size, seconds = f"after {path.stat().st_size / 1e6:.1f} MB", MendedMcap(path).seconds
    if seconds is None:
        return f"it breaks off {size}, before any message is whole; record it again"
    way = (
        f"name {path.name} itself to read these"
        if within
        else f"`mcap recover {path.name} -o whole.mcap` keeps them"
    )
    return f"it breaks off {size}, and {seconds:.2f} s of messages are whole; {way}"
