"""The track file: one TOML that names the robot, the encoder table and the pictures.

    robot = "arm.urdf"                      # URDF or xacro with meshes
    recording = "joints.csv"                # one row a posture
    time = "t"                              # optional: the column of times
    hand = "tool0"                          # the frame whose pose is told
    links = ["link_2", "link_3"]            # optional: links whose outline is used, of those seen
    faces = 1500                            # optional: of each link

    [joints]
    unit = "rad"                            # see the run file
    columns = { elbow = "q3" }

    [free]
    joints = ["elbow"]                      # joints whose offset is wanted
    offset_deg = 8.0                        # how wrong they may be, one standard deviation

    [cameras.left]
    parent = "base"                         # frame, or the name of a camera named before
    xyz = [0.7, -0.9, 1.1]                  # m, optical centre in the parent
    rpy = [-2.1, 0.0, 0.9]                  # rad, fixed axes; optical: z forward, x right, y down
    known = "exactly"                       # or "roughly": found together with the offsets
    position_m = 0.05                       # if roughly: one standard deviation
    turn_deg = 5.0
    size = [960, 540]                       # pixels
    lens = [534.6, 534.6, 478.1, 261.0]     # f_x, f_y, c_x, c_y
    distortion = []                         # as OpenCV has it
    images = "stereo/left_{row}.png"        # {row} counts from 0; {row:03} with leading zeros
    masks = "stereo/mask_left_{row}.png"    # optional: pictures that are not 0 on the robot

Paths are relative to the file. Leave out of `links` what does not move: an arm's round base says
less of the camera's turn about it than it seems to.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.body.camera import Camera
from bodyschema.body.parameters import Parameters, free_frame, free_joints, join
from bodyschema.body.tree import Body
from bodyschema.cli.loading import read_joints, read_robot
from bodyschema.cli.run_file import JointColumns, entry_of
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.recording.tables import open_recording
from bodyschema.senses.images import Images, Picture

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FreeOffsets:
    """What is wanted."""

    joints: tuple[str, ...]
    offset_deg: float = 8.0


@dataclass(frozen=True)
class CameraEntry:
    """A camera and where its pictures lie."""

    parent: str
    size: tuple[int, ...]
    lens: tuple[float, ...]
    images: str
    masks: str = ""
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    known: str = "exactly"
    position_m: float = 0.05
    turn_deg: float = 5.0
    distortion: tuple[float, ...] = ()

    def camera(self, name: str) -> Camera:
        """Its lens."""
        if len(self.size) != 2 or len(self.lens) != 4 or self.known not in ("exactly", "roughly"):
            raise InputError(
                f"camera '{name}' needs size = [width, height], lens = [f_x, f_y, c_x, c_y] and "
                f'known = "exactly" or "roughly"; got {self.size}, {self.lens}, \'{self.known}\'.'
            )
        f_x, f_y, c_x, c_y = self.lens
        K = np.array([[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]], dtype=np.float64)
        width, height = self.size
        return Camera(name, name, width, height, K, np.array(self.distortion))


@dataclass(frozen=True)
class TrackFile:
    """A whole run, resolved."""

    robot: str
    recording: str
    hand: str
    free: FreeOffsets
    cameras: dict[str, CameraEntry]
    joints: JointColumns = field(default_factory=JointColumns)
    links: tuple[str, ...] = ()
    faces: int = 1500
    time: str | None = None


def read_track_file(path: Path) -> TrackFile:
    """Read a track file; its paths come back absolute.

    Raises:
        InputError: missing, malformed, a key unknown or missing.
    """
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"no track file at '{path}'; give the path of a TOML file.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"'{path}' is not valid TOML: {error}.") from None
    here, where = path.resolve().parent, f"'{path.name}'"
    cameras = {
        name: entry_of(CameraEntry, _absolute(here, entry), f"[cameras.{name}] of {where}")
        for name, entry in table.get("cameras", {}).items()
    }
    if not cameras:
        raise InputError(f"{where} names no camera; add a section [cameras.NAME].")
    named = [key for key in ("robot", "recording") if key in table]
    paths: dict[str, Any] = {key: str(here / table[key]) for key in named}
    entries: dict[str, Any] = {
        **table,
        **paths,
        "joints": entry_of(JointColumns, table.get("joints", {}), f"[joints] of {where}"),
        "free": entry_of(FreeOffsets, table.get("free", {}), f"[free] of {where}"),
        "cameras": cameras,
    }
    return entry_of(TrackFile, entries, where)


def _absolute(here: Path, entry: dict[str, Any]) -> dict[str, Any]:
    paths = {key: str(here / entry[key]) for key in ("images", "masks") if entry.get(key)}
    return {**entry, **paths}


@dataclass(frozen=True)
class Album:
    """The pictures of a run; each is read when it is looked at."""

    run: TrackFile
    body: Body
    """With the cameras."""
    cameras: tuple[Camera, ...]
    """Without distortion."""
    q: Array
    """(n_rows, n_joints)"""
    time: Array
    """(n_rows,) s"""

    @classmethod
    def open(cls, run: TrackFile) -> Album:
        """Read robot and table."""
        body = read_robot(Path(run.robot))
        for name, entry in run.cameras.items():
            T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
            body = body.attach(name, entry.parent, T)
        table = open_recording(run.recording)
        lenses = [entry.camera(name) for name, entry in run.cameras.items()]
        straight = tuple(Camera(c.name, c.frame, c.width, c.height, c.matrix) for c in lenses)
        return cls(run, body, straight, read_joints(body, table, run.joints), table.time(run.time))

    @property
    def parameters(self) -> Parameters:
        """What is wanted, with its prior."""
        free = self.run.free
        offsets = free_joints(self.body, ["offsets"], free.joints)
        parts = [offsets.with_prior(np.full(len(offsets), np.deg2rad(free.offset_deg)))]
        for name, entry in self.run.cameras.items():
            if entry.known == "roughly":
                turn = float(np.deg2rad(entry.turn_deg))
                parts.append(free_frame(self.body, name, entry.position_m, turn))
        return join(*parts)

    def __len__(self) -> int:
        return len(self.q)

    def images(self, row: int) -> tuple[Picture, ...]:
        """Pictures of a row, red, green, blue, straightened."""
        return tuple(
            entry.camera(name).undistort(_read(entry.images, row, True))
            for name, entry in self.run.cameras.items()
        )

    def seen(self, row: int) -> Images:
        """What is compared: masks if all cameras have them, otherwise the images."""
        entries = self.run.cameras
        if not all(entry.masks for entry in entries.values()):
            return Images(float(self.time[row]), self.q[row], self.cameras, self.images(row))
        masks = tuple(
            entry.camera(name).undistort(_read(entry.masks, row, False) > 0)
            for name, entry in entries.items()
        )
        return Images(float(self.time[row]), self.q[row], self.cameras, masks)


def _read(pattern: str, row: int, colour: bool) -> NDArray[Any]:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "reading pictures") from None
    try:
        path = pattern.format(row=row)
    except (KeyError, IndexError, ValueError):
        raise InputError(
            f"'{pattern}' is no pattern; write {{row}} where the number goes."
        ) from None
    picture = cv2.imread(path, cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise InputError(f"no picture at '{path}'; the recording's row {row} needs it.")
    return np.ascontiguousarray(picture[..., ::-1]) if colour else np.asarray(picture)
