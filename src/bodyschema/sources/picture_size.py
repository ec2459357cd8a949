"""Width and height of a picture from its first bytes, before anything is decoded.

A PNG of a hundred bytes may say that it is 60000 pixels wide and high, which is 11 GB decoded.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable

Size = tuple[int, int]

MOST_PIXELS = 2**27
"""134 million, 400 MB decoded: more than any camera on a robot."""


def picture_size(content: bytes) -> Size | None:
    """Width and height in pixels; None where the bytes are of no kind that is known here.

    Args:
        content: of a file, its beginning at least.
    """
    reader = next((reader for mark, reader in _KINDS.items() if content.startswith(mark)), None)
    try:
        return None if reader is None else reader(content)
    except (struct.error, IndexError, ValueError):
        return None


def _png(content: bytes) -> Size:
    width, height = struct.unpack(">II", content[16:24])
    return width, height


def _bmp(content: bytes) -> Size:
    width, height = struct.unpack("<ii", content[18:26])
    return abs(width), abs(height)


def _jpeg(content: bytes) -> Size | None:
    """The frame header stands behind segments that say how long they are."""
    at = 2
    while at + 9 <= len(content):
        if content[at] != 0xFF:
            return None
        kind = content[at + 1]
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return width, height
        padding = kind == 0xFF
        at += 1 if padding else 2 + max(2, struct.unpack(">H", content[at + 2 : at + 4])[0])
    return None


def _webp(content: bytes) -> Size | None:
    kind = content[12:16]
    if kind == b"VP8X":
        return (
            1 + int.from_bytes(content[24:27], "little"),
            1 + int.from_bytes(content[27:30], "little"),
        )
    if kind == b"VP8L":
        bits = int.from_bytes(content[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    width, height = struct.unpack("<HH", content[26:30])
    return width & 0x3FFF, height & 0x3FFF


def _plain(content: bytes) -> Size | None:
    """Portable maps: P6, then comments, width and height in words."""
    found = re.match(rb"P\d(?:\s+|#[^\n]*\n)*(\d{1,9})(?:\s+|#[^\n]*\n)+(\d{1,9})\s", content)
    return None if found is None else (int(found[1]), int(found[2]))


def _tiff(content: bytes) -> Size | None:
    order = "<" if content.startswith(b"II") else ">"
    (at,) = struct.unpack(f"{order}I", content[4:8])
    (count,) = struct.unpack(f"{order}H", content[at : at + 2])
    found: dict[int, int] = {}
    for k in range(count):
        entry = content[at + 2 + 12 * k : at + 14 + 12 * k]
        tag, kind = struct.unpack(f"{order}HH", entry[:4])
        form = "H" if kind == 3 else "I"
        if tag in (256, 257):
            (found[tag],) = struct.unpack(f"{order}{form}", entry[8 : 8 + struct.calcsize(form)])
    return (found[256], found[257]) if len(found) == 2 else None


_KINDS: dict[bytes, Callable[[bytes], Size | None]] = {
    b"\x89PNG": _png,
    b"\xff\xd8": _jpeg,
    b"BM": _bmp,
    b"RIFF": _webp,
    b"II*\0": _tiff,
    b"MM\0*": _tiff,
    **{b"P%d" % kind: _plain for kind in range(1, 7)},
}
