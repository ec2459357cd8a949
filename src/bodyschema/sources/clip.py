"""Clip: a video, and where the joints were at each of its frames.

Frames have times of their own (the stamps of the file, or k / fps), to which `start` is added: the
time of the encoders' clock at which the first frame was taken. A constant lag of a few frames
between the two clocks does no harm, whoever uses the clip may learn it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.joint_track import JointTrack
from bodyschema.sources.lerobot import Episode
from bodyschema.sources.video import Pixels, Video

Array = NDArray[np.float64]

FEWEST = 10
"""Frames with readings that a clip must have."""


@dataclass(frozen=True)
class Moment:
    """What was seen and felt at one time."""

    index: int
    """Of the frame in the video, from 0."""
    time: float
    """s on the encoders' clock."""
    image: Pixels
    """(height, width, 3) red, green, blue."""
    positions: Array
    """(n_joints,) in the unit of the track."""

    @property
    def grey(self) -> Pixels:
        """(height, width) brightness."""
        try:
            import cv2
        except ImportError:
            raise MissingExtraError("opencv-python-headless", "vision", "grey images") from None
        return np.asarray(cv2.cvtColor(self.image, cv2.COLOR_RGB2GRAY), dtype=np.uint8)


@dataclass(frozen=True)
class Clip:
    """Frames with readings, in order of time."""

    video: Video
    """Where the frames come from."""
    joints: tuple[str, ...]
    """Their names."""
    index: NDArray[np.int64]
    """(n,) numbers of the frames that have readings."""
    time: Array
    """(n,) s on the encoders' clock."""
    positions: Array
    """(n, n_joints) in the unit of the track."""
    left_out: int = 0
    """Frames without readings."""

    def __len__(self) -> int:
        return len(self.index)

    def moments(self) -> Iterator[Moment]:
        """Decode the frames one after the other.

        Raises:
            InputError: a frame is broken.
        """
        row = {int(index): k for k, index in enumerate(self.index)}
        last = int(self.index[-1])
        for frame in self.video.frames(row):
            k = row[frame.index]
            yield Moment(frame.index, float(self.time[k]), frame.image, self.positions[k])
            if frame.index == last:
                return


def join_clip(
    video: Video, track: JointTrack, start: float = 0.0, fps: float | None = None
) -> Clip:
    """Join a video to the readings of encoders.

    Args:
        video: a file or a folder of pictures.
        track: where the joints were.
        start: s of the encoders' clock at which the first frame was taken.
        fps: frames a second, for pictures and where the stamps of a video are wrong; pictures
            without it are taken to be one for each reading.

    Raises:
        InputError: no times, or too few frames while there are readings.
    """
    if fps is not None and not 0 < fps < np.inf:
        raise InputError(f"frames a second must be above zero; got {fps}.")
    if video.files and fps is None:
        if start:
            raise InputError(
                f"pictures that go with the rows of {track.source} have no clock; to match them by "
                "time from --start on, say how many frames a second (--fps)."
            )
        if len(video.files) != len(track.time):
            raise InputError(
                f"there are {len(video.files)} pictures and {len(track.time)} rows of "
                f"{track.source}; say how many frames a second (--fps), and when the first was "
                "taken (--start)."
            )
        return _clip(video, track, track.time)
    if fps is None:
        return _clip(video, track, video.times() + start)
    count = video.count or len(video.times())
    return _clip(video, track, start + np.arange(count) / fps)


def episode_clip(video: Video, track: JointTrack, episode: Episode) -> Clip:
    """Join the frames of a LeRobot episode, which may share its video with others.

    Raises:
        InputError: the video has no frames of the episode.
    """
    time = video.times() - episode.begin
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    # Stamps and rows are both rounded, in different ways, to about a microsecond.
    own = (time > -step / 2) & (time < track.time[-1] + step / 2)
    return _clip(video, track, np.clip(time, track.time[0], track.time[-1]), own)


def _clip(
    video: Video, track: JointTrack, time: Array, own: NDArray[np.bool_] | None = None
) -> Clip:
    """The frames at times that have readings."""
    own = np.ones(len(time), dtype=bool) if own is None else own
    index = np.flatnonzero(own)
    positions = np.array([track.at(float(t)) for t in time[index]])
    felt = np.isfinite(positions).all(axis=1) if len(index) else own[index]
    if felt.sum() < FEWEST:
        seen = f"from {time[index][0]:.3f} to {time[index][-1]:.3f} s" if len(index) else "never"
        raise InputError(
            f"only {felt.sum()} frames of '{video.source}' have readings: it lasts {seen}, "
            f"{track.source} from {track.time[0]:.3f} to {track.time[-1]:.3f} s; say when on the "
            "encoders' clock the first frame was taken (--start)."
        )
    index, lost = index[felt], int(np.sum(~felt))
    return Clip(video, track.joints, index, time[index], positions[felt], lost)
