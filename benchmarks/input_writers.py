"""One recording in every form: by rosbags, by the package mcap, by ROS 1's own rosbag, by pyarrow.

Rows are moments at 32 a second, whose stamps all forms hold exactly; numbers are of float32, as
LeRobot keeps them, and float64 elsewhere.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

FPS = 32
POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
JOINTS, EYE = "/joint_states", "/eye/pose"
STATE, BOARD = "observation.state", "observation.board"

ROS1 = """
import sys, json, numpy as np
sys.path[:0] = sys.argv[1].split(":")
import rosbag, genpy
from sensor_msgs.msg import JointState
from geometry_msgs.msg import PoseStamped
names, q, pose = (lambda d: (d["names"], d["q"], d["pose"]))(json.load(open(sys.argv[2])))
with rosbag.Bag(sys.argv[3], "w") as bag:
    for i, (row, place) in enumerate(zip(q, pose)):
        stamp = genpy.Time(0, i * 1000000000 // 32 % 1000000000)
        stamp.secs = i // 32
        joints = JointState(name=names, position=row)
        joints.header.stamp = stamp
        seen = PoseStamped()
        seen.header.stamp = stamp
        p, o = seen.pose.position, seen.pose.orientation
        p.x, p.y, p.z, o.x, o.y, o.z, o.w = place
        at = genpy.Time(stamp.secs, max(stamp.nsecs, 1))
        bag.write("/joint_states", joints, at)
        bag.write("/eye/pose", seen, at)
"""

MCAP = """
import sys, json
sys.path[:0] = sys.argv[1].split(":")
from mcap_ros2.writer import Writer
names, q, pose = (lambda d: (d["names"], d["q"], d["pose"]))(json.load(open(sys.argv[2])))
HEAD = "================================================================================"
TIME = f"{HEAD}\\nMSG: builtin_interfaces/Time\\nint32 sec\\nuint32 nanosec\\n"
HEADER = f"{HEAD}\\nMSG: std_msgs/Header\\nbuiltin_interfaces/Time stamp\\nstring frame_id\\n"
STATES = ("std_msgs/Header header\\nstring[] name\\nfloat64[] position\\nfloat64[] velocity\\n"
          f"float64[] effort\\n{HEADER}{TIME}")
POSED = (f"std_msgs/Header header\\ngeometry_msgs/Pose pose\\n{HEAD}\\nMSG: geometry_msgs/Pose\\n"
         f"geometry_msgs/Point position\\ngeometry_msgs/Quaternion orientation\\n{HEAD}\\n"
         f"MSG: geometry_msgs/Point\\nfloat64 x\\nfloat64 y\\nfloat64 z\\n{HEAD}\\n"
         f"MSG: geometry_msgs/Quaternion\\nfloat64 x\\nfloat64 y\\nfloat64 z\\nfloat64 w\\n"
         f"{HEADER}{TIME}")
with open(sys.argv[3], "wb") as file:
    writer = Writer(file)
    states = writer.register_msgdef("sensor_msgs/msg/JointState", STATES)
    posed = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSED)
    for i, (row, place) in enumerate(zip(q, pose)):
        ns = i * 1000000000 // 32
        header = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": ""}
        writer.write_message("/joint_states", states,
            dict(header=header, name=names, position=row, velocity=[], effort=[]), ns, ns)
        at = dict(zip("xyz", place[:3])), dict(zip("xyzw", place[3:]))
        writer.write_message("/eye/pose", posed,
            {"header": header, "pose": {"position": at[0], "orientation": at[1]}}, ns, ns)
    writer.finish()
"""
"""Run with the paths of packages that are not installed here: BODYSCHEMA_MCAP, _ROS1."""


def table(columns: Mapping[str, Array], folder: Path) -> list[str]:
    """CSV, the numbers as they are."""
    time = np.arange(len(columns["x"])) / FPS
    write_table(folder / "data.csv", {"time": time, **columns})
    return [str(folder / "data.csv")]


def lerobot(columns: Mapping[str, Array], folder: Path) -> list[str]:
    """A data set of version 3, by its specification."""
    place = folder / "set"
    joints = [name for name in columns if name not in POSE]
    features = {
        STATE: {"dtype": "float32", "shape": [len(joints)], "names": [f"{j}.pos" for j in joints]},
        BOARD: {"dtype": "float32", "shape": [7], "names": list(POSE)},
    }
    path = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    info = {"codebase_version": "v3.0", "total_episodes": 1, "fps": FPS, "data_path": path,
            "features": features}  # fmt: skip
    (place / "meta").mkdir(parents=True)
    (place / "meta" / "info.json").write_text(json.dumps(info))
    file = place / path.format(chunk_index=0, file_index=0)
    file.parent.mkdir(parents=True)
    n = len(columns["x"])

    def together(names: Any) -> pa.Array:
        values = np.stack([columns[name] for name in names], axis=1).astype(np.float32)
        return pa.FixedSizeListArray.from_arrays(values.ravel(), values.shape[1])

    rows = {
        STATE: together(joints),
        BOARD: together(POSE),
        "timestamp": (np.arange(n) / FPS).astype(np.float32),
        "episode_index": np.zeros(n, dtype=np.int64),
    }
    pq.write_table(pa.table(rows), file)
    return [str(place)]


def rosbags(form: str) -> Callable[[Mapping[str, Array], Path], list[str]]:
    """A writer of "ros1", "sqlite3" or "mcap" by the package rosbags."""

    def write(columns: Mapping[str, Array], folder: Path) -> list[str]:
        from rosbags.rosbag1 import Writer as Writer1
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        first = form == "ros1"
        store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
        place = folder / (f"{form}.bag" if first else form)
        plugin = StoragePlugin.MCAP if form == "mcap" else StoragePlugin.SQLITE3
        opened = Writer1(place) if first else Writer(place, version=9, storage_plugin=plugin)
        pack = store.serialize_ros1 if first else store.serialize_cdr
        with opened as writer:
            kinds = ("sensor_msgs/msg/JointState", "geometry_msgs/msg/PoseStamped")
            topics = [
                writer.add_connection(topic, kind, typestore=store)
                for topic, kind in zip((JOINTS, EYE), kinds, strict=True)
            ]
            for ns, messages in _messages(store.types, columns, first):
                for topic, kind, message in zip(topics, kinds, messages, strict=True):
                    writer.write(topic, ns, pack(message, kind))
        return [f"{place}#{JOINTS}", f"{place}#{EYE}"]

    return write


def _messages(types: Any, columns: Mapping[str, Array], first: bool) -> Any:
    """Time in ns, and joint state and pose, row by row."""
    joints, none = [name for name in columns if name not in POSE], np.zeros(0)
    for i in range(len(columns["x"])):
        ns = i * 10**9 // FPS
        stamp = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
        more = {"seq": i} if first else {}
        header = types["std_msgs/msg/Header"](**more, stamp=stamp, frame_id="")
        q = np.array([columns[name][i] for name in joints])
        state = types["sensor_msgs/msg/JointState"](header, joints, q, none, none)
        place = [float(columns[name][i]) for name in POSE]
        point = types["geometry_msgs/msg/Point"](*place[:3])
        turn = types["geometry_msgs/msg/Quaternion"](*place[3:])
        pose = types["geometry_msgs/msg/Pose"](point, turn)
        yield ns, (state, types["geometry_msgs/msg/PoseStamped"](header, pose))


def elsewhere(program: str, variable: str, name: str) -> Any:
    """A writer of packages that lie in the folders of an environment variable; None where unset."""
    folders = os.environ.get(variable, "")
    if not folders:
        return None

    def write(columns: Mapping[str, Array], folder: Path) -> list[str]:
        joints = [name for name in columns if name not in POSE]
        told = {"names": joints, "q": np.stack([columns[j] for j in joints], 1).tolist(),
                "pose": np.stack([columns[c] for c in POSE], 1).tolist()}  # fmt: skip
        (folder / "told.json").write_text(json.dumps(told))
        done = [os.environ.get("PYTHON3", "python3"), "-c", program, folders,
                str(folder / "told.json"), str(folder / name)]  # fmt: skip
        subprocess.run(done, check=True)
        return [f"{folder / name}#{JOINTS}", f"{folder / name}#{EYE}"]

    return write


FORMS: dict[str, Any] = {
    "csv": table,
    "lerobot v3": lerobot,
    "ROS 1 by rosbags": rosbags("ros1"),
    "sqlite3 by rosbags": rosbags("sqlite3"),
    "MCAP by rosbags": rosbags("mcap"),
    "MCAP by mcap": elsewhere(MCAP, "BODYSCHEMA_MCAP", "other.mcap"),
    "ROS 1 by rosbag": elsewhere(ROS1, "BODYSCHEMA_ROS1", "other.bag"),
}
