"""The pictures of a run file, joined with the readings of the encoders moment by moment.

The rule of the join is in `picture_sections`. Pictures are read when they are looked at, in order,
and never held: a video is decoded once for every call.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.reading.joints import read_joints
from bodyschema.cli.reading.picture_sections import (
    CameraEntry,
    PictureSections,
    offset_spread,
)
from bodyschema.cli.reading.pictures import picture_path
from bodyschema.cli.reading.robot import robot_of
from bodyschema.cli.run_file import RunFile
from bodyschema.documents import is_file
from bodyschema.errors import InputError
from bodyschema.export.result_folder import sha256
from bodyschema.learners.images.markerless import Markerless
from bodyschema.model.camera import Camera
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.images import Images, Picture
from bodyschema.sources.joint_track import LONGEST_GAP, JointTrack
from bodyschema.sources.recording import TIME_COLUMNS, Recording
from bodyschema.sources.tables import open_recording
from bodyschema.sources.video import Video, read_picture
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


UNPLACED = (0.3, 0.3)
"""m and rad, one standard deviation that the search leaves of a camera that nobody has placed."""


@dataclass(frozen=True)
class Album:
    """Moments at which the cameras saw and the encoders were read."""

    run: RunFile
    seen_by: PictureSections
    """Cameras and what is wanted of them."""
    nominal: Body
    """As described."""
    body: Body
    """With the cameras."""
    lenses: tuple[Camera, ...]
    """With distortion, as the pictures are stored."""
    videos: tuple[Video | None, ...]
    """None where a camera has pictures."""
    numbers: Ints
    """(n_moments, n_cameras) of the pictures or frames."""
    q: Array
    """(n_moments, n_joints) rad and m."""
    time: Array
    """(n_moments,) s on the recording's clock."""

    @classmethod
    def open(cls, run: RunFile) -> Album:
        """Read robot and table, and look what pictures there are.

        Raises:
            InputError: anything that cannot be used, in one sentence.
        """
        pictures = run.pictures
        if pictures is None:
            raise InputError("the run file names no camera; add a section [cameras.NAME].")
        nominal = body = robot_of(run)
        for name, entry in pictures.cameras.items():
            T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
            body = body.attach(name, entry.parent, T)
        body.frame_index(pictures.hand)
        table = open_recording(run.recording)
        lenses = tuple(entry.camera(name) for name, entry in pictures.cameras.items())
        entries = pictures.cameras.values()
        videos = tuple(Video.open(entry.video) if entry.video else None for entry in entries)
        for lens, video in zip(lenses, videos, strict=True):
            _check_size(lens, video)
        q, time = read_joints(body, table, run.joints), table.time(run.time)
        if any(entry.start is not None for entry in entries):
            _require_clock(table, run.time)
            starts = [float(entry.start or 0) for entry in entries]
            clocks = [
                start + video.times() for start, video in zip(starts, videos, strict=True) if video
            ]
            numbers, q, time = _by_time(JointTrack(table.source, body.joints, time, q), clocks)
        else:
            numbers = _by_row(table, videos)
        return cls(run, pictures, nominal, body, lenses, videos, numbers, q, time)

    def __len__(self) -> int:
        return len(self.q)

    def round(self, body: Body) -> Album:
        """The same moments with another belief of the robot and its cameras, in its own shape."""
        return replace(self, body=replace(body, visuals=self.nominal.visuals))

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """Without distortion, as the pictures are given."""
        return tuple(
            Camera(c.name, c.frame, c.width, c.height, c.matrix, np.zeros(0)) for c in self.lenses
        )

    @property
    def variables(self) -> Variables:
        """What is wanted, with its prior."""
        free = self.run.free
        offsets = free_joints(self.body, ["offsets"], free.joints)
        wrong = offset_spread(self.run)
        parts = [offsets.with_prior(np.array([wrong[unit] for unit in offsets.units]))]
        for name, entry in self.seen_by.cameras.items():
            if entry.known == "roughly":
                turn = float(np.deg2rad(entry.turn_deg))
                parts.append(free_frame(self.body, name, entry.position_m, turn))
            if entry.known == "no":
                parts.append(free_frame(self.body, name, *UNPLACED))
        return join(*parts)

    @property
    def unplaced(self) -> tuple[str, ...]:
        """Cameras that are looked for from nothing."""
        entries = self.seen_by.cameras.items()
        return tuple(name for name, entry in entries if entry.known == "no")

    @property
    def first_pictures(self) -> list[Path]:
        """One picture and one mask of each camera that has files of them."""
        return [picture_path(pattern, self.numbers[0, c]) for pattern, c in self._patterns]

    @property
    def picture_hashes(self) -> dict[str, str]:
        """One hash for all pictures of a pattern, of theirs in order."""
        found = {}
        for pattern, c in self._patterns:
            whole = hashlib.sha256()
            for number in self.numbers[:, c]:
                path = picture_path(pattern, number)
                whole.update(sha256(path).encode() if is_file(path) else b"-")
            found[pattern] = whole.hexdigest()
        return found

    @property
    def _patterns(self) -> list[tuple[str, int]]:
        """Patterns of pictures and masks, with the number of their camera."""
        entries = enumerate(self.seen_by.cameras.values())
        return [(p, c) for c, entry in entries for p in (entry.images, entry.masks) if p]

    def pictures(self, moments: Sequence[int]) -> Iterator[tuple[Picture, ...]]:
        """What each camera saw: red, green, blue, straightened.

        Args:
            moments: in order, none twice.
        """
        streams = [self._stream(c, moments) for c in range(len(self.lenses))]
        return zip(*streams, strict=True)

    def seen(self, moments: Sequence[int]) -> Iterator[Images]:
        """What is compared: masks if all cameras have them, otherwise the pictures."""
        entries, cameras = list(self.seen_by.cameras.values()), self.cameras
        if not all(entry.masks for entry in entries):
            found = self.pictures(moments)
        else:
            found = (
                tuple(self._mask(c, entry, m) for c, entry in enumerate(entries)) for m in moments
            )
        for moment, pictures in zip(moments, found, strict=True):
            yield Images(float(self.time[moment]), self.q[moment], cameras, pictures)

    def _stream(self, c: int, moments: Sequence[int]) -> Iterator[Picture]:
        """The pictures of one camera."""
        numbers, video = self.numbers[list(moments), c], self.videos[c]
        if video is None:
            pattern = list(self.seen_by.cameras.values())[c].images
            for number in numbers:
                yield self.lenses[c].undistort(read_picture(picture_path(pattern, number)))
            return
        frames, frame = video.frames(frozenset(numbers.tolist())), None
        for number in numbers:
            while frame is None or frame.index < number:
                frame = next(frames, None)
                if frame is None:
                    raise InputError(f"'{video.source}' has no frame {number}; it ends before.")
            yield self.lenses[c].undistort(frame.image)

    def _mask(self, c: int, entry: CameraEntry, moment: int) -> Picture:
        path = picture_path(entry.masks, self.numbers[moment, c])
        return self.lenses[c].undistort(np.asarray(read_picture(path).any(axis=2)))


KEYS = 20
"""Postures that are learned from, far from each other."""


def markerless(album: Album, seeds: int = 512, seed: int = 0) -> Markerless:
    """The learner that the run file asks for.

    Args:
        album: with the robot and what is doubted.
        seeds: first guesses.
        seed: of them.
    """
    seen = album.seen_by
    surface = Surface.of(album.body, seen.links or None, seen.faces)
    return Markerless(surface, seeds=seeds, seed=seed, doubts=seen.doubts.doubts)


def _by_row(table: Recording, videos: Sequence[Video | None]) -> Ints:
    """Picture i of every camera belongs to row i."""
    for video in videos:
        if video is None or video.count == len(table):
            continue
        # Not all frames of a video that was trimmed are shown: its stamps know better.
        count = video.count if video.files else len(video.times())
        if count != len(table):
            raise InputError(
                f"'{video.source}' has {count} frames and {table.source} {len(table)} rows; for "
                "every frame a row is expected. Give the camera a start to match them by time."
            )
    return np.tile(np.arange(len(table))[:, None], (1, len(videos)))


def _by_time(track: JointTrack, clocks: Sequence[Array]) -> tuple[Ints, Array, Array]:
    """Frames, readings and times of the moments at which everything is known.

    Args:
        track: the readings.
        clocks: times of the frames of each camera on the recording's clock, s.
    """
    q = np.array([track.at(time) for time in clocks[0]])
    good = np.isfinite(q).all(axis=1)
    if not good.any():
        raise InputError(
            f"no frame was taken between two rows of {track.source} at most {LONGEST_GAP:g} s "
            f"apart: the frames are from {clocks[0][0]:.3f} s to {clocks[0][-1]:.3f} s, the rows "
            f"from {track.time[0]:.3f} s to {track.time[-1]:.3f} s; check start."
        )
    nearest = [_nearest(clock, clocks[0]) for clock in clocks]
    for clock, at in zip(clocks, nearest, strict=True):
        good &= np.abs(clock[at] - clocks[0]) <= min(_half_frame(clock), _half_frame(clocks[0]))
    if not good.any():
        raise InputError(
            "no frames of all cameras were taken within half a frame of each other; check start."
        )
    return np.column_stack(nearest)[good], q[good], clocks[0][good]


def _half_frame(clock: Array) -> float:
    """s; a little more, as stamps are rounded."""
    return 0.51 * float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0


def _nearest(clock: Array, times: Array) -> Ints:
    """Number of the frame nearest to each time."""
    after = np.clip(np.searchsorted(clock, times), 1, max(len(clock) - 1, 1))
    if len(clock) == 1:
        return np.zeros(len(times), dtype=np.int64)
    return np.asarray(after - (times - clock[after - 1] < clock[after] - times), dtype=np.int64)


def _require_clock(table: Recording, column: str | None) -> None:
    if column == "" or (column is None and not set(TIME_COLUMNS) & {*table.columns, *table.texts}):
        raise InputError(
            f"start matches frames by time, and {table.source} has no column "
            f'{", ".join(TIME_COLUMNS)}; name it: time = "COLUMN".'
        )


def _check_size(lens: Camera, video: Video | None) -> None:
    if video is not None and (video.width, video.height) != (lens.width, lens.height):
        raise InputError(
            f"camera '{lens.name}' has size = [{lens.width}, {lens.height}] and "
            f"'{video.source}' is {video.width} by {video.height} pixels; give the size and lens "
            "of the video."
        )
