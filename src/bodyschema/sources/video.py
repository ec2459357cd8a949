"""Frames of a camera, one after the other: a video file, a folder of pictures, or a pattern.

    left.mp4                a video; its frames carry the time stamps of the file
    left/                   all pictures of a folder; image_2.png comes before image_10.png
    left/image_{row}.png    numbered from 0; {row:03} with leading zeros

Frames are decoded when they are asked for and never held. Nobody can tell from the head of a file
whether the rest is whole: what turns out to be broken on the way is an error there.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Container, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from av.container import InputContainer

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

PICTURES = frozenset((".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"))
"""Endings of the files of a folder that are taken for frames."""


@dataclass(frozen=True)
class Frame:
    """What a camera saw at one moment."""

    index: int
    """From 0."""
    time: float | None
    """s since the beginning of the file's clock; None where there is no clock."""
    image: Pixels
    """(height, width, 3) red, green, blue."""


@dataclass(frozen=True)
class Video:
    """Where frames come from, and what is known of them beforehand."""

    source: str
    """As it was named, for messages."""
    width: int
    """pixels"""
    height: int
    """pixels"""
    count: int | None
    """Frames that the source says it has; None where it does not say."""
    files: tuple[Path, ...] = ()
    """One a frame; empty for a video file."""

    @classmethod
    def open(cls, source: str | Path) -> Video:
        """Look at a source without reading its frames.

        Args:
            source: a video file, a folder of pictures, or a path with {row} in it.

        Raises:
            InputError: there is nothing, no picture in it, or no video that can be decoded.
            MissingExtraError: PyAV for a video, or OpenCV for pictures, is not installed.
        """
        name = str(source)
        files = _numbered(name) if "{" in name else _listed(Path(name))
        if files:
            height, width = read_picture(files[0]).shape[:2]
            return cls(name, width, height, len(files), files)
        with _container(name) as container:
            stream = container.streams.video[0]
            return cls(name, stream.width, stream.height, stream.frames or None)

    def frames(self, wanted: Container[int] | None = None) -> Iterator[Frame]:
        """The frames in order of time.

        Args:
            wanted: numbers of the frames that are looked at; None for all. Others of a video have
                to be decoded on the way and cost little more.

        Raises:
            InputError: a frame is broken, or the source ends before its `count`.
        """
        return self._decoded(wanted) if not self.files else self._pictures(wanted)

    def times(self) -> Array:
        """(n_frames,) s, the time stamps of all frames, strictly increasing, without decoding any.

        Raises:
            InputError: pictures and streams without a clock have none; or stamps repeat.
        """
        if self.files:
            raise InputError(f"the pictures of '{self.source}' carry no times; match them by row.")
        with _container(self.source) as container:
            stream = container.streams.video[0]
            shown = (packet for packet in container.demux(stream) if packet.size)
            stamps = [packet.pts for packet in shown if not packet.is_discard]
            unit = float(stream.time_base or 0)
        times = unit * np.sort(np.array(stamps, dtype=np.float64))  # None becomes nan
        if not len(times) or not np.isfinite(times).all() or not (np.diff(times) > 0).all():
            raise InputError(
                f"the frames of '{self.source}' carry no times, or carry some twice; match them by "
                "row, or write the video anew with a clock."
            )
        return np.asarray(times)

    def _pictures(self, wanted: Container[int] | None) -> Iterator[Frame]:
        for index, path in enumerate(self.files):
            if wanted is None or index in wanted:
                yield Frame(index, None, read_picture(path))

    def _decoded(self, wanted: Container[int] | None) -> Iterator[Frame]:
        import av

        index, packets = -1, -1  # the last packet is empty: it asks the decoder for what is left
        with _container(self.source) as container:
            try:
                for packet in container.demux(container.streams.video[0]):
                    packets += 1
                    for frame in packet.decode():
                        index += 1
                        if frame.is_corrupt:
                            raise _cut_off(self.source, index, self.count)
                        if wanted is None or index in wanted:
                            image = np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)
                            yield Frame(index, frame.time, image)
            except av.FFmpegError:
                raise _cut_off(self.source, index + 1, self.count) from None
        # Not the frames: a file that was trimmed holds some that are not to be shown.
        if index < 0 or packets < (self.count or 1):
            raise _cut_off(self.source, index + 1, self.count)


def read_picture(path: Path) -> Pixels:
    """One picture, (height, width, 3) red, green, blue.

    Raises:
        InputError: there is no picture at that place.
        MissingExtraError: OpenCV is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "reading pictures") from None
    picture: Any = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        state = "is no picture, or is cut off" if path.is_file() else "does not exist"
        raise InputError(f"no picture at '{path}': it {state}.")
    return np.ascontiguousarray(picture[..., ::-1])


def _numbered(pattern: str) -> tuple[Path, ...]:
    """The files of a pattern, from row 0 on until one is missing."""
    try:
        paths = (Path(pattern.format(row=row)) for row in itertools.count())
        first = next(paths)
    except (KeyError, IndexError, ValueError):
        raise InputError(
            f"'{pattern}' is no pattern; write {{row}} where the number goes."
        ) from None
    if str(first) == pattern.format(row=1):
        raise InputError(f"'{pattern}' names one file for all rows; write {{row}} in it.")
    found = [first] if first.is_file() else []
    for path in paths if found else ():
        if not path.is_file():
            break
        found.append(path)
    if not found:
        raise InputError(f"no picture at '{first}'; the pictures of a pattern are counted from 0.")
    return tuple(found)


def _listed(folder: Path) -> tuple[Path, ...]:
    """The pictures of a folder, numbers in their names in order of size; nothing for a file."""
    if not folder.is_dir():
        return ()
    found = [path for path in folder.iterdir() if path.suffix.lower() in PICTURES]
    if not found:
        raise InputError(
            f"the folder '{folder}' holds no pictures; expected names ending in "
            f"{', '.join(sorted(PICTURES))}."
        )
    return tuple(sorted(found, key=lambda path: (_natural(path.name), path.name)))


def _natural(name: str) -> list[tuple[int, str]]:
    """A key that puts image_2 before image_10."""
    return [(int(digits or 0), text) for text, digits in re.findall(r"(\D*)(\d*)", name)]


def _container(source: str) -> InputContainer:
    """The opened file, which has at least one stream of pictures."""
    try:
        import av
    except ImportError:
        raise MissingExtraError("av", "vision", f"reading the video '{source}'") from None
    if not Path(source).is_file():
        raise InputError(f"no video at '{source}'; name a video file or a folder of pictures.")
    try:
        container = av.open(source)
    except (av.FFmpegError, OSError) as error:
        reason = error.strerror or type(error).__name__
        raise InputError(
            f"'{source}' cannot be read as a video ({reason}); it may be cut off, or no video."
        ) from None
    if not container.streams.video:
        container.close()
        raise InputError(f"'{source}' holds no pictures, only other streams.")
    if container.streams.video[0].codec_context is None:
        container.close()
        raise InputError(
            f"'{source}' is in a code that no decoder here knows; convert it to H.264."
        )
    return container


def _cut_off(source: str, index: int, expected: int | None) -> InputError:
    """The error of a video that ends or breaks at a frame."""
    if not index and not expected:
        return InputError(f"'{source}' holds no frame that can be decoded; record it again.")
    of = "" if expected is None else f" of {expected}"
    return InputError(
        f"'{source}' breaks off at frame {index}{of} (the first is 0); the file is damaged or cut "
        "off: copy it again, or cut it there."
    )
