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

from bodyschema.documents import file_bytes, is_file, regular_file
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.picture_size import MOST_PIXELS, picture_size

if TYPE_CHECKING:
    from av.container import InputContainer

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

PICTURES = frozenset((".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"))
"""Endings of the files of a folder that are taken for frames."""


PLACE = re.compile(r"\{row(?::(0?\d{0,2}))?\}")
"""Where the number of a row stands in a name, and to how many places it is filled up."""

PROTOCOLS, FORMATS = (
    "file",
    "mov,matroska,avi,mpegts,mpeg,mpegvideo,flv,ogg,asf,ivf,h264,hevc,gif,wav",
)
"""What the decoder may open: playlists, which name other files and addresses, are no videos."""


MOST_BYTES = 1 << 30
"""Of the file of one picture."""


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
    content = file_bytes(path, f"no picture at '{path}': it does not exist.", MOST_BYTES)
    width, height = picture_size(content) or (0, 0)
    if width * height > MOST_PIXELS:
        raise InputError(
            f"the picture '{path}' says that it has {width} x {height} pixels; at most "
            f"{MOST_PIXELS / 1e6:.0f} million are read."
        )
    try:
        picture: Any = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"no picture at '{path}': it is no picture, or is cut off.")
    return np.ascontiguousarray(picture[..., ::-1])


def numbered(pattern: str, row: int) -> str:
    """The name of one picture of a pattern.

    Args:
        pattern: with {row} or {row:03} where the number goes, and nothing else in braces.
        row: the number.

    Raises:
        InputError: no {row} in it, or other things in braces.
    """
    name, found = PLACE.subn(lambda place: format(row, place[1] or ""), pattern)
    if not found or "{" in name or "}" in name:
        raise InputError(f"'{pattern}' is no pattern; write {{row}} where the number goes.")
    return name


def _numbered(pattern: str) -> tuple[Path, ...]:
    """The files of a pattern, from row 0 on until one is missing."""
    paths = (Path(numbered(pattern, row)) for row in itertools.count())
    first = next(paths)
    found = [first] if is_file(first) else []
    for path in paths if found else ():
        if not is_file(path):
            break
        found.append(path)
    if not found:
        raise InputError(f"no picture at '{first}'; the pictures of a pattern are counted from 0.")
    return tuple(found)


def _listed(folder: Path) -> tuple[Path, ...]:
    """The pictures of a folder, numbers in their names in order of size; nothing for a file."""
    try:
        inside = list(folder.iterdir()) if folder.is_dir() else None
    except (OSError, ValueError):
        inside = None
    if inside is None:
        return ()
    found = [path for path in inside if path.suffix.lower() in PICTURES]
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
    missing = f"no video at '{source}'; name a video file or a folder of pictures."
    path = regular_file(Path(source), missing)
    allowed = {"protocol_whitelist": PROTOCOLS, "format_whitelist": FORMATS}
    try:
        container = av.open(f"file:{path}", options=allowed)
    except (av.FFmpegError, OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or type(error).__name__
        raise InputError(
            f"'{source}' cannot be read as a video ({reason}); it may be cut off, or no video."
        ) from None
    if not container.streams.video:
        container.close()
        raise InputError(f"'{source}' holds no pictures, only other streams.")
    shown = container.streams.video[0]
    if shown.codec_context is not None and shown.width * shown.height > MOST_PIXELS:
        container.close()
        raise InputError(
            f"the frames of '{source}' say that they have {shown.width} x {shown.height} pixels; "
            f"at most {MOST_PIXELS / 1e6:.0f} million are read."
        )
    if shown.codec_context is None:
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
