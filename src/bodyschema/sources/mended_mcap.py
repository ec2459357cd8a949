"""An MCAP file whose recorder died, read up to the cut as if it had been closed.

What a reader needs and the file lacks is its end: an index of the chunks, and a footer. Both are
made from the whole records that are there and stand behind them as the reader sees it; the file
itself is only read. A chunk that breaks off is lost, since a chunk is packed as a whole.

    chunk index    times, place and length of each chunk             (records of kind 8)
    statistics     empty: the reader then counts for itself          (kind 11)
    footer         where the index begins                            (kind 2)
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

MAGIC = b"\x89MCAP0\r\n"

FOOTER, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS = 0x02, 0x05, 0x06, 0x07, 0x08, 0x0B
"""Kinds of records."""

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
"""First and last time in ns, length when unpacked, checksum, length of the compression's name."""
_STAMP = struct.Struct("<HIQ")


@dataclass(frozen=True)
class Record:
    """One whole record."""

    kind: int
    at: int
    """Where it begins in the file."""
    length: int
    """All of it, its head too."""


def is_cut(path: Path) -> bool:
    """Whether a file begins as MCAP does, and does not end so."""
    with path.open("rb") as file:
        begins = file.read(len(MAGIC)) == MAGIC
        size = file.seek(0, io.SEEK_END)
        file.seek(max(size - len(MAGIC), 0))
        return begins and (size < 2 * len(MAGIC) or file.read() != MAGIC)


def whole_records(file: BinaryIO) -> Iterator[Record]:
    """Every whole record of an open file, up to where it breaks off."""
    size, at = file.seek(0, io.SEEK_END), len(MAGIC)
    while at + _HEAD.size <= size:
        file.seek(at)
        kind, length = _HEAD.unpack(file.read(_HEAD.size))
        if not kind or at + _HEAD.size + length > size:
            return
        if kind == CHUNK and not _has_head(file, length):
            return
        yield Record(kind, at, _HEAD.size + length)
        at += _HEAD.size + length


def _has_head(file: BinaryIO, length: int) -> bool:
    """Whether a chunk, at whose content the file stands, has room for what it begins with."""
    room = length - _CHUNK.size - 8
    return room >= 0 and _CHUNK.unpack(file.read(_CHUNK.size))[-1] <= room


def times_of(file: BinaryIO, record: Record) -> tuple[int, ...]:
    """Times in ns that a record holds: of a chunk the first and the last, of a message its own."""
    file.seek(record.at + _HEAD.size)
    if record.kind == CHUNK:
        return _CHUNK.unpack(file.read(_CHUNK.size))[:2]
    if record.kind == MESSAGE and record.length >= _HEAD.size + _STAMP.size:
        return _STAMP.unpack(file.read(_STAMP.size))[2:]
    return ()


@dataclass(frozen=True)
class MendedMcap:
    """A file that breaks off, in the place of its path where a reader takes one."""

    path: Path

    @property
    def suffix(self) -> str:
        """Of the name."""
        return self.path.suffix

    def exists(self) -> bool:
        """Whether the file is there."""
        return self.path.exists()

    def is_dir(self) -> bool:
        """It is a file."""
        return False

    def __str__(self) -> str:
        """The path."""
        return str(self.path)

    def open(self, mode: str = "rb") -> BinaryIO:
        """The whole records and the end that they lack, for reading."""
        end, tail = self._end
        made: BinaryIO = io.BufferedReader(_Joined(self.path.open(mode, buffering=0), end, tail))
        return made

    @cached_property
    def seconds(self) -> float | None:
        """From the first to the last time of what is whole; None if no message is."""
        end = self._end[0]
        with self.path.open("rb") as file:
            read = (record for record in whole_records(file) if record.at < end)
            times = [t for record in read for t in times_of(file, record) if t]
        return (max(times) - min(times)) / 1e9 if times else None

    @property
    def sentence(self) -> str:
        """What was read of it, in words."""
        size, seconds = self.path.stat().st_size, self.seconds or 0.0
        lost = size - self._end[0]
        return (
            f"'{self.path.name}' breaks off after {size / 1e6:.1f} MB: {seconds:.2f} s of messages "
            f"are whole and were read, the last {lost / 1e3:.3g} kB are lost."
        )

    @cached_property
    def _end(self) -> tuple[int, bytes]:
        """Where the whole records end, and what is to stand there."""
        with self.path.open("rb") as file:
            records = [r for r in whole_records(file) if r.kind not in (FOOTER, CHUNK_INDEX)]
            places = [r.at + r.length for r in records]
            file.seek(places[-1] if places else 0)
            cut_within = file.read(1)[:1] == bytes([MESSAGE_INDEX])
            chunks = _with_indexes(records)
            if chunks and cut_within:  # nobody knows which topics the last chunk holds
                last = chunks.pop()[0]
                places = [place for place in places if place <= last.at]
            end = places[-1] if places else len(MAGIC)
            entries = [_indexed(file, chunk, own) for chunk, own in chunks]
        index = b"".join(entries if all(own for _, own in chunks) else ())
        empty = _record(STATISTICS, struct.pack("<QHIIIIQQI", *[0] * 9))
        footer = _record(FOOTER, struct.pack("<QQI", end, 0, 0))
        return end, index + empty + footer + MAGIC


def _with_indexes(records: list[Record]) -> list[tuple[Record, list[Record]]]:
    """Every chunk with the indexes of its messages, one of each topic, which come after it."""
    found: list[tuple[Record, list[Record]]] = []
    for record in records:
        if record.kind == CHUNK:
            found.append((record, []))
        elif record.kind == MESSAGE_INDEX and found:
            found[-1][1].append(record)
    return found


def _indexed(file: BinaryIO, record: Record, indexes: list[Record]) -> bytes:
    """The entry of a chunk in the index."""
    places = b""
    for one in indexes:
        file.seek(one.at + _HEAD.size)
        places += file.read(2) + struct.pack("<Q", one.at)  # the number of the topic
    file.seek(record.at + _HEAD.size)
    first, last, unpacked, _, letters = _CHUNK.unpack(file.read(_CHUNK.size))
    name = file.read(letters)
    (packed,) = struct.unpack("<Q", file.read(8))
    size = sum(one.length for one in indexes)
    return _record(
        CHUNK_INDEX,
        struct.pack("<QQQQI", first, last, record.at, record.length, len(places))
        + places
        + struct.pack("<QI", size, letters)
        + name
        + struct.pack("<QQ", packed, unpacked),
    )


def _record(kind: int, content: bytes) -> bytes:
    return _HEAD.pack(kind, len(content)) + content


class _Joined(io.RawIOBase):
    """The first bytes of a file and others behind them."""

    def __init__(self, file: Any, end: int, tail: bytes) -> None:
        self._file, self._end, self._tail, self._at = file, end, tail, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        begin = {io.SEEK_SET: 0, io.SEEK_CUR: self._at}
        self._at = begin.get(whence, self._end + len(self._tail)) + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer)
        if self._at < self._end:
            self._file.seek(self._at)
            data = self._file.read(min(len(view), self._end - self._at)) or b""
        else:
            begin = self._at - self._end
            data = self._tail[begin : begin + len(view)]
        view[: len(data)] = data
        self._at += len(data)
        return len(data)

    def close(self) -> None:
        self._file.close()
        super().close()
