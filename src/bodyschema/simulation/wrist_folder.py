"""A simulated arm with a wrist camera as a folder, in the format that a lab would have it in.

arm.urdf        what the maker says: right but for the joint zeros, without camera and board
recording.csv   format csv: a row a posture, joints (rad) and the camera in the board (m)
recording       format bag: a ROS 2 bag of joint states and poses, each with a clock of its own
dataset         format lerobot: a LeRobot data set, version 3, joints in degrees
run.toml        which is which
truth.json      for scoring only
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.atomic import new_folder
from bodyschema.errors import MissingExtraError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.simulation.folder import PURPOSE
from bodyschema.simulation.wrist_camera import (
    BASE,
    BOARD,
    CAMERA,
    FLANGE,
    T_BASE_BOARD,
    T_FLANGE_CAMERA,
    Stream,
    WristRecording,
)
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
JOINTS_TOPIC, POSES_TOPIC = "/joint_states", "/camera_in_board"
START = 1_700_000_000
"""s since 1970: when the bag was recorded."""

FEATURE = "observation.board"
FPS = 10

RUN = """robot = "arm.urdf"
recording = "{recording}"
{more}
[frames.board]                # somewhere beside the base; nobody measured where
parent = "{base}"
known = "no"

[frames.camera]               # on the flange; nobody measured how
parent = "{flange}"
known = "no"

[[senses]]                    # the camera's pose in the board
kind = "poses"
seen_from = "{board}"
seen = "{camera}"
layout = "xyz_xyzw"
unit = "m"
columns = {columns}
"""


def write_wrist_folder(
    recorded: WristRecording, folder: Path, form: str, overwrite: bool = False
) -> None:
    """Write the folder, whole or not at all.

    Args:
        recorded: from `simulate_wrist_camera`.
        folder: where; must be new, empty, or with `overwrite` an older simulation.
        form: a key of FORMS.
        overwrite: replace an older simulation.

    Raises:
        InputError: the folder holds something else, or an older simulation without `overwrite`.
        MissingExtraError: the format's package is not installed.
    """
    with new_folder(folder, overwrite) as fresh:
        (fresh / "arm.urdf").write_bytes(write_urdf(recorded.believed))
        (fresh / "run.toml").write_text(FORMS[form](recorded, fresh), encoding="utf-8")
        text = json.dumps(truth_of(recorded)) + "\n"
        (fresh / "truth.json").write_text(text, encoding="utf-8")


def run_text(recording: str, more: str = "", columns: tuple[str, ...] = POSE) -> str:
    """The run file that goes with a recording."""
    return RUN.format(
        recording=recording, more=more, base=BASE, flange=FLANGE, board=BOARD, camera=CAMERA,
        columns=json.dumps(columns),
    )  # fmt: skip


def truth_of(recorded: WristRecording) -> dict[str, Any]:
    """What was wrong, and where camera and board are."""
    names = recorded.believed.joints
    return {
        "purpose": PURPOSE,
        "settings": asdict(recorded.settings),
        "offsets_rad": dict(zip(names, recorded.offsets.tolist(), strict=True)),
        "frames": {
            name: {
                "parent": parent,
                "xyz": T[:3, 3].tolist(),
                "rpy": lie.rpy_from_rotation(T[:3, :3]).tolist(),
            }
            for name, parent, T in (
                (BOARD, BASE, T_BASE_BOARD),
                (CAMERA, FLANGE, T_FLANGE_CAMERA),
            )
        },
    }


def _poses(stream: Stream) -> Array:
    """(n, 7) position and quaternion, scalar last."""
    T = stream.T_board_camera
    return np.hstack([T[:, :3, 3], lie.quaternion_xyzw(T[:, :3, :3])])


def _csv(recorded: WristRecording, folder: Path) -> str:
    rows = recorded.postures
    columns = dict(zip(recorded.believed.joints, rows.q.T, strict=True))
    write_table(folder / "recording.csv", columns | dict(zip(POSE, _poses(rows).T, strict=True)))
    return run_text("recording.csv")


def _bag(recorded: WristRecording, folder: Path) -> str:
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("rosbags", "bags", "writing a ROS 2 bag") from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    messages = sorted(_messages(recorded, store.types), key=lambda entry: entry[0])
    path = folder / "recording"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics: dict[str, Any] = {}
        for nanoseconds, topic, message in messages:
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], nanoseconds, store.serialize_cdr(message, kind))
    return run_text(
        "recording", 'join = "time"                 # topics have clocks of their own\n'
    )


def _messages(recorded: WristRecording, kinds: Any) -> list[tuple[int, str, Any]]:
    """(ns, topic, message) of both streams, a topic after the other."""
    named, made = list(recorded.believed.joints), []
    for t, q in zip(recorded.joints.time, recorded.joints.q, strict=True):
        ns, header = _header(t, kinds)
        state = kinds["sensor_msgs/msg/JointState"](
            header=header, name=named, position=q, velocity=np.zeros(0), effort=np.zeros(0)
        )
        made.append((ns, JOINTS_TOPIC, state))
    for t, pose in zip(recorded.poses.time, _poses(recorded.poses), strict=True):
        ns, header = _header(t, kinds)
        x, y, z, *turn = map(float, pose)
        place = kinds["geometry_msgs/msg/Point"](x, y, z)
        posed = kinds["geometry_msgs/msg/Pose"](place, kinds["geometry_msgs/msg/Quaternion"](*turn))
        made.append((ns, POSES_TOPIC, kinds["geometry_msgs/msg/PoseStamped"](header, posed)))
    return made


def _header(t: float, kinds: Any) -> tuple[int, Any]:
    ns = START * 10**9 + round(t * 1e9)
    stamp = kinds["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    return ns, kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="")


def _lerobot(recorded: WristRecording, folder: Path) -> str:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingExtraError("pyarrow", "data", "writing a LeRobot data set") from None
    rows, joints = recorded.poses, [f"{name}.pos" for name in recorded.believed.joints]
    n, home = len(rows.q), folder / "dataset"
    features = {
        "observation.state": {"dtype": "float32", "shape": [len(joints)], "names": joints},
        FEATURE: {"dtype": "float32", "shape": [len(POSE)], "names": list(POSE)},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
        "episode_index": {"dtype": "int64", "shape": [1], "names": None},
    }
    info = {
        "codebase_version": "v3.0", "robot_type": "arm", "fps": FPS, "total_episodes": 1,
        "total_frames": n, "features": features, "video_path": None,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    }  # fmt: skip
    table = {
        "observation.state": np.rad2deg(rows.q).astype(np.float32).tolist(),
        FEATURE: _poses(rows).astype(np.float32).tolist(),
        "timestamp": (np.arange(n) / FPS).astype(np.float32),
        "episode_index": np.zeros(n, dtype=np.int64),
    }
    (home / "meta").mkdir(parents=True)
    (home / "data" / "chunk-000").mkdir(parents=True)
    (home / "meta" / "info.json").write_text(json.dumps(info, indent=1), encoding="utf-8")
    pq.write_table(pa.table(table), home / "data" / "chunk-000" / "file-000.parquet")
    named = ", ".join(f'{name} = "{name}.pos"' for name in recorded.believed.joints)
    more = f'\n[joints]\nunit = "deg"\ncolumns = {{ {named} }}\n'
    return run_text("dataset", more, tuple(f"{FEATURE}.{axis}" for axis in POSE))


FORMS: dict[str, Callable[[WristRecording, Path], str]] = {
    "csv": _csv,
    "bag": _bag,
    "lerobot": _lerobot,
}
"""What writes the recording in each format, and returns the run file."""
