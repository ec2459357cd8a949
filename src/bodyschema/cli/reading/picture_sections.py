"""Sections of a run file for pictures of a robot without markers: what `bodyschema track` reads.

    robot = "arm.urdf"                      # URDF or xacro with meshes
    recording = "joints.csv"                # one row a posture
    time = "t"                              # optional: the column of times
    hand = "tool0"                          # the frame whose pose is told
    links = ["link_2", "link_3"]            # optional: links whose outline is used, of those seen
    faces = 1500                            # optional: of each link; 0 for all

    [free]
    joints = ["elbow"]                      # joints whose offset is wanted
    offset_deg = 8.0                        # how wrong they may be, one standard deviation
    offset_mm = 5.0                         # the same of joints that slide

    [doubts]                                # optional: what cameras and meshes may have wrong
    focal_percent = 0.5                     # one standard deviation each; 0 for none
    centre_px = 1.0
    turn_deg = 0.1                          # of a camera that is known exactly
    shape_mm = 0.3
    edge_px = 1.0                           # how far out masks or edges lie all round the body

    [cameras.left]
    parent = "base"                         # frame, or the name of a camera named before
    xyz = [0.7, -0.9, 1.1]                  # m, optical centre in the parent
    rpy = [-2.1, 0.0, 0.9]                  # rad, fixed axes; optical: z forward, x right, y down
    known = "exactly"                       # or "roughly": found together with the offsets; or
                                            # "no": looked for from nothing by its masks
    position_m = 0.05                       # if roughly: one standard deviation
    turn_deg = 5.0
    size = [960, 540]                       # pixels
    lens = [534.6, 534.6, 478.1, 261.0]     # f_x, f_y, c_x, c_y; or "camera_info.yaml", the file of
                                            # ROS, OpenCV or Kalibr, with size and distortion
    distortion = []                         # as OpenCV has it
    model = ""                              # "fisheye" of a lens that is one; the file says it
    images = "stereo/left_{row}.png"        # {row} counts from 0; {row:03} with leading zeros
    video = "left.mp4"                      # instead of images
    start = 12.5                            # optional, of a video; see below
    masks = "stereo/mask_left_{row}.png"    # optional: pictures that are not 0 on the robot

Without `start`, row i of the recording belongs to picture or frame i, and a video must have as many
frames as the recording has rows. With `start` a video is matched by time: a frame was taken at
`start` plus its time stamp on the clock of the recording's column of times, and the joints are
interpolated there, between two rows at most half a second apart. The moments are then the frames of
the first camera; frames of the others must lie within half a frame of them. {row} of masks is the
number of the frame.

Paths are relative to the file. Leave out of `links` what does not move: an arm's round base says
less of the camera's turn about it than it seems to.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema.cli.reading.lens_entries import camera_with_lens
from bodyschema.cli.reading.run_entries import KNOWLEDGE
from bodyschema.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile
    from bodyschema.learners.images.doubts import Doubts
    from bodyschema.model.camera import Camera

OFFSET_DEG, OFFSET_MM = 8.0, 5.0
"""One standard deviation of an offset, where nobody says another."""


@dataclass(frozen=True)
class CameraEntry:
    """A camera and where its pictures lie."""

    parent: str
    size: tuple[int, ...]
    lens: tuple[float, ...]
    images: str = ""
    video: str = ""
    start: float | None = None
    masks: str = ""
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    known: str = "exactly"
    position_m: float = 0.05
    turn_deg: float = 5.0
    distortion: tuple[float, ...] = ()
    model: str = ""
    """Of the distortion: "fisheye", or "" for one whose count says it."""
    file: str = ""
    """Of the lens, where it was read from one."""

    def camera(self, name: str) -> Camera:
        """Its lens."""
        import numpy as np

        from bodyschema.model.camera import Camera
        from bodyschema.model.distortion import FISHEYE, MODELS

        if self.model and self.model not in MODELS:
            raise InputError(
                f"model = '{self.model}' of camera '{name}'{did_you_mean(self.model, MODELS)}"
            )
        if len(self.size) != 2 or len(self.lens) != 4 or self.known not in KNOWLEDGE:
            raise InputError(
                f"camera '{name}' needs size = [width, height], lens = [f_x, f_y, c_x, c_y] and "
                f'known = "exactly", "roughly" or "no"; got {self.size}, {self.lens}, '
                f"'{self.known}'."
            )
        f_x, f_y, c_x, c_y = self.lens
        K = np.array([[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]], dtype=np.float64)
        width, height = self.size
        fisheye = self.model == FISHEYE
        return Camera(name, name, width, height, K, np.array(self.distortion), fisheye)


@dataclass(frozen=True)
class DoubtEntry:
    """How far cameras and meshes may be off, one standard deviation."""

    edge_px: float = 1.0
    focal_percent: float = 0.5
    centre_px: float = 1.0
    turn_deg: float = 0.1
    shape_mm: float = 0.3

    @property
    def doubts(self) -> Doubts:
        """In SI units."""
        from bodyschema.learners.images.doubts import Doubts

        return Doubts(
            edge=self.edge_px,
            focal=self.focal_percent / 100,
            centre=self.centre_px,
            turn=math.radians(self.turn_deg),
            shape=self.shape_mm / 1e3,
        )


@dataclass(frozen=True)
class PictureSections:
    """What a run file says of pictures."""

    cameras: dict[str, CameraEntry]
    hand: str = ""
    """The frame whose pose is told."""
    links: tuple[str, ...] = ()
    """Whose outline is used; all that show when empty."""
    faces: int = 1500
    """Of each link; 0 for all."""
    doubts: DoubtEntry = field(default_factory=DoubtEntry)

    @property
    def files(self) -> list[str]:
        """Videos and files of lenses."""
        cameras = self.cameras.values()
        return [name for entry in cameras for name in (entry.video, entry.file) if name]


KEYS = ("hand", "links", "faces")
"""Outside of any section."""


def read_sections(table: Mapping[str, Any], here: Path, where: str) -> PictureSections:
    """The sections of a run file.

    Args:
        table: cameras, doubts, and those of `KEYS` that it has.
        here: anchors its paths.
        where: names it in messages.

    Raises:
        InputError: a key is unknown or missing.
    """
    from bodyschema.cli.entry_types import entry_of

    given = table.get("cameras")
    if not isinstance(given, Mapping) or not given:
        raise InputError(f"{where} names no camera; add a section [cameras.NAME].")
    cameras = {
        name: _camera(here, entry, f"[cameras.{name}] of {where}") for name, entry in given.items()
    }
    doubts = entry_of(DoubtEntry, table.get("doubts", {}), f"[doubts] of {where}")
    return entry_of(PictureSections, {**table, "cameras": cameras, "doubts": doubts}, where)


def _camera(here: Path, table: Any, where: str) -> CameraEntry:
    """One camera, with the numbers of its lens, and the paths of its files from `here`."""
    from bodyschema.cli.entry_types import entry_of

    entry = entry_of(CameraEntry, camera_with_lens(table, here, where), where)
    images, video, masks = (
        str(here / name) if name else "" for name in (entry.images, entry.video, entry.masks)
    )
    return replace(entry, images=images, video=video, masks=masks)


def check_pictures(run: RunFile, where: str) -> None:
    """Refuse runs that lack a camera or what is wanted, and settings that mean nothing.

    Raises:
        InputError: in one sentence.
    """
    pictures = run.pictures
    if pictures is None or not pictures.cameras:
        raise InputError(f"{where} names no camera; add a section [cameras.NAME].")
    if not pictures.hand:
        raise InputError(f"{where} lacks the key 'hand': the frame whose pose is told.")
    if not run.robot:
        raise InputError(f'{where} names no robot; add: robot = "path".')
    if not run.free.joints:
        raise InputError(f"[free] of {where} names no joints; list those whose offset is wanted.")
    if pictures.faces < 0:
        raise InputError(f"faces = {pictures.faces} in {where}; give 1 or more, or 0 for all.")
    _check_sources(pictures.cameras, where)
    _check_spreads(run, pictures, where)


def offset_spread(run: RunFile) -> dict[str, float]:
    """One standard deviation of an offset by its unit, rad or m."""
    deg, mm = run.free.offset_deg, run.free.offset_mm
    return {
        "rad": math.radians(OFFSET_DEG if deg is None else deg),
        "m": (OFFSET_MM if mm is None else mm) / 1e3,
    }


def _check_spreads(run: RunFile, pictures: PictureSections, where: str) -> None:
    """What is wanted may be wrong by more than nothing."""
    units = {"rad": "offset_deg of [free]", "m": "offset_mm of [free]"}
    spreads = {units[unit]: spread for unit, spread in offset_spread(run).items()}
    for name, entry in pictures.cameras.items():
        if len(entry.xyz) != 3 or len(entry.rpy) != 3:
            raise InputError(f"xyz and rpy of camera '{name}' of {where} must be three numbers.")
        spreads |= {f"position_m of camera '{name}'": entry.position_m}
        spreads |= {f"turn_deg of camera '{name}'": entry.turn_deg}
    for name, spread in spreads.items():
        if spread <= 0:
            raise InputError(
                f"{name} of {where} is {spread:g}; give a standard deviation above zero."
            )


def _check_sources(cameras: dict[str, CameraEntry], where: str) -> None:
    """Each camera has one source, and all are matched to the recording in one way."""
    for name, entry in cameras.items():
        if bool(entry.images) == bool(entry.video):
            raise InputError(
                f"camera '{name}' of {where} needs either images = \"left_{{row}}.png\" or "
                'video = "left.mp4".'
            )
        if entry.start is not None and not entry.video:
            raise InputError(
                f"camera '{name}' of {where} has a start, and pictures have no clock; give it a "
                "video, or leave start out to match all by row."
            )
    timed = {name: entry.start is not None for name, entry in cameras.items()}
    if any(timed.values()) and not all(timed.values()):
        without = next(name for name, has in timed.items() if not has)
        raise InputError(
            f"camera '{without}' of {where} has no start while others have; give every camera one, "
            "or none."
        )
