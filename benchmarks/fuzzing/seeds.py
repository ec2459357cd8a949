"""Small whole inputs of every kind, made here: what mutations start from."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs
from bodyschema import lie
from bodyschema.cli import run
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.sources.tables import write_table

HEAD = """
robot = "robot.urdf"
recording = "data.csv"
robot_arguments = { dof = "3" }
packages = { arm = "." }
folds = 3
seed = 1
[joints]
unit = "rad"
columns = { joint_1 = "joint_1" }
joint_2 = { column = "joint_2", sign = 1, scale = 1.0, zero = 0.0 }
[frames.eye]
parent = "base"
xyz = [0.1, 0.2, -1.5]
rpy = [0.0, 0.1, 0.0]
known = "roughly"
[frames.tool]
parent = "tip"
xyz = [0.02, 0.04, 0.05]
known = "exactly"
[parts.lens]
kind = "lens"
fx = 600.0
size = [640, 480]
known = "exactly"
[parts.held]
kind = "load"
mass_kg = 1.5
com_m = [0.02, 0.01, 0.05]
known = "exactly"
[free]
groups = ["offsets"]
joints = ["joint_2"]
[[senses]]
kind = "points"
seen_from = "eye"
seen = "tool"
columns = ["a0", "a1", "a2"]
std = 0.5
unit = "m"
"""
SENSE = '[[senses]]\nkind = "{}"\nseen_from = "eye"\nseen = "tool"\n{}\n'
MORE = (
    ("poses", 'columns = ["a0", "a1", "a2", "a3", "a4", "a5"]\nlayout = "xyz_rotvec"'),
    ("touches", 'columns = ["a0", "a1", "a2"]\ntouching = [0.0, 0.0, 0.03]'),
    ("pixels", 'columns = ["a0", "a1"]\nlens = "lens"\ntarget = [[0.0, 0.0, 0.0]]'),
    ("distances", 'columns = ["d"]\nanchor = [0.0, 0.0, 0.1]'),
    ("planes", 'columns = ["d"]\npoint = [0.0, 0.0, 0.1]'),
    ("gravity", 'columns = ["g0", "g1", "g2"]\nunit = "g"'),
    ("wrenches",
     'columns = ["a0", "a1", "a2", "a3", "a4", "a5"]\nsign = "on_object"\nloads = ["held"]'),
    ("torques", 'columns = ["a0", "a1", "a2"]\nloads = { link_3 = "held" }\nmoving = true'),
)  # fmt: skip
WRIST = """
recording = "log.csv"
time_unit = "s"
[wrench]
columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
frame = "sensor"
sign = "on_sensor"
force_unit = "N"
[pose]
columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
layout = "xyz_xyzw"
[sensor]
rpy = [0.0, 0.0, 0.1]
known = "roughly"
[motion]
window = 0.5
down = [0.0, 0.0, -9.81]
[segments]
loaded = [0.5, 3.0]
"""
TOUCH = """
[surface]
box = [0.1, 0.1, 0.2]
xyz = [0.0, 0.0, 0.1]
[touch]
quiet = [0.0, 3.0]
gains = 0.01
"""
PAIRS = """
recording = "pairs.csv"
time = ""
[hand_eye]
eye_on = "base"
join = "rows"
"""
LIST = '[[senses]]\nkind = "poses"\nseen_from = "{}"\nseen = "{}"\ncolumns = ["{}*"]\n'
TRACK = """
robot = "boxes.urdf"
recording = "joints.csv"
hand = "fore"
links = ["upper"]
faces = 50
[free]
joints = ["lift", "bend"]
offset_deg = 8.0
[doubts]
edge_px = 1.0
[cameras.eye]
parent = "base"
xyz = [0.0, 1.2, 0.2]
rpy = [1.5707963267948966, 0.0, 0.0]
size = [32, 24]
lens = [30.0, 30.0, 15.5, 11.5]
images = "image_{row:03}.png"
masks = "image_{row:03}.png"
"""
BOXES = """<robot name="boxes"><link name="base"/>
<link name="upper"><visual><origin xyz="0 0 0.15"/><geometry><box size="0.06 0.09 0.3"/></geometry>
</visual></link>
<link name="fore"><visual><geometry><mesh filename="part.stl" scale="1 1 1"/></geometry></visual>
</link><joint name="lift" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
<joint name="bend" type="prismatic"><parent link="upper"/><child link="fore"/>
<origin xyz="0 0 0.3" rpy="0 0.1 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/>
<mimic joint="lift" multiplier="2" offset="0.1"/></joint></robot>"""
XACRO = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="dof" default="2"/><xacro:property name="len" value="0.3"/>
<xacro:macro name="piece" params="n up"><link name="l${n}"/><joint name="j${n}" type="revolute">
<parent link="${up}"/><child link="l${n}"/><origin xyz="0 0 ${len * 2}"/></joint></xacro:macro>
<link name="base"/><xacro:piece n="1" up="base"/><xacro:if value="$(arg dof)">
<xacro:piece n="2" up="l1"/></xacro:if></robot>"""
DH = """name = "a"
convention = "modified"
tool = [0.0, 0.0, 0.1]
[[joint]]
name = "j1"
a = 0.0
alpha = 0.1
d = 0.3
theta = 0.0
limits = [-2.7, 2.7]
[[joint]]
type = "prismatic"
"""
ARRANGED = """name = "arm"
root = "base"
[joints]
shoulder = "base"
wrist = { parent = "shoulder", kind = "revolute", limits = [-1.5, 1.5] }
[markers]
hand = "wrist"
[camera]
name = "eye"
parent = "base"
"""


def quietly(*arguments: str) -> int:
    """The exit code of a verb, its words thrown away."""
    words = io.StringIO()
    with contextlib.redirect_stdout(words), contextlib.redirect_stderr(words):
        try:
            return run(list(arguments))
        except SystemExit as stop:  # of the parser of flags
            return int(stop.code or 0)


def arm(folder: Path, more: bool = True) -> None:
    """robot.urdf, data.csv and new.csv of a chain of three joints, and run.toml."""
    rng = np.random.default_rng(3)
    body = bs.Body.random_chain(3, rng)
    (folder / "robot.urdf").write_bytes(write_urdf(body))
    eye = lie.transform(lie.rotation_from_rpy([0.0, 0.1, 0.0]), [0.1, 0.2, -1.5])
    tool = lie.transform(np.eye(3), [0.02, 0.04, 0.05])
    placed = body.attach("eye", "base", eye).attach("tool", "tip", tool)
    for name, n in (("data.csv", 24), ("new.csv", 12)):
        q = rng.uniform(-1, 1, (n, 3))
        T = bs.relative_pose(placed, q, "eye", "tool") @ lie.transform(np.eye(3), [0, 0, 1e-3])
        seen = T[:, :3, 3] + 1e-3 * rng.normal(size=(n, 3))
        turn = lie.log_so3(T[:, :3, :3])
        table = {"d": np.linalg.norm(seen, axis=1)}
        table |= {f"g{i}": v for i, v in enumerate(np.swapaxes(T[:, :3, :3], 1, 2)[:, :, 2].T)}
        table |= {f"joint_{j + 1}": q[:, j] for j in range(3)}
        table |= {f"a{i}": v for i, v in enumerate(np.hstack([seen, turn]).T)}
        write_table(folder / name, {"t": 0.5 * np.arange(n), **table})
    senses = "".join(SENSE.format(*one) for one in MORE) if more else ""
    (folder / "run.toml").write_text(HEAD + senses)


def wrist(folder: Path, touch: bool = False) -> None:
    """A wrist with half a kilogram, 4 s at 25 Hz."""
    rng = np.random.default_rng(5)
    t = np.arange(0, 6, 0.04)
    rotvec = np.stack([np.sin(t), np.cos(0.7 * t), 0.5 * np.sin(0.4 * t)], axis=1)
    R = lie.exp_so3(rotvec)
    force = 0.5 * np.swapaxes(R, 1, 2) @ [0.0, 0.0, -9.81]
    wrench = np.hstack([force, np.cross([0.01, 0.02, 0.1], force)])
    wrench += 0.01 * rng.normal(size=wrench.shape)
    place = 0.1 * np.stack([np.sin(t), np.cos(t), np.sin(0.5 * t)], axis=1)
    named = [*(f"f{a}" for a in "xyz"), *(f"t{a}" for a in "xyz"), *"xyz", "qx", "qy", "qz", "qw"]
    values = np.hstack([wrench, place, lie.quaternion_xyzw(R)])
    write_table(folder / "log.csv", {"t": t, **dict(zip(named, values.T, strict=True))})
    (folder / "run.toml").write_text(WRIST + (TOUCH if touch else ""))


def pairs(folder: Path) -> None:
    """Poses of a hand and of what an eye saw."""
    rng = np.random.default_rng(7)
    A = lie.transform(lie.exp_so3(rng.normal(size=(14, 3))), rng.normal(size=(14, 3)))
    X = lie.transform(lie.exp_so3([0.1, 0.2, 0.3]), [0.1, 0.0, 0.2])
    noise = lie.transform(lie.exp_so3(1e-3 * rng.normal(size=(14, 3))), np.zeros(3))
    columns = {}
    for name, T in (("A", A), ("T", A @ X @ noise)):
        columns |= {f"{name}{i:02}": v for i, v in enumerate(T[:, :3].reshape(14, 12).T)}
    write_table(folder / "pairs.csv", columns)
    text = PAIRS + LIST.format("base", "hand", "A") + LIST.format("eye", "board", "T")
    (folder / "run.toml").write_text(text)


def pictured(folder: Path) -> None:
    """An arm of a box and a mesh before a camera of 32 x 24 pixels."""
    described(folder)
    (folder / "joints.csv").write_text("lift\n0.1\n0.4\n")
    for i in range(2):
        (folder / f"image_{i:03}.png").write_bytes(picture(".png"))
    (folder / "run.toml").write_text(TRACK)


def described(folder: Path) -> None:
    """boxes.urdf and its mesh in several forms, a xacro, a DH table, an arrangement."""
    import trimesh

    (folder / "boxes.urdf").write_text(BOXES)
    box = trimesh.creation.box((0.1, 0.1, 0.2))
    for kind in ("stl", "obj", "dae", "ply"):
        data = box.export(file_type=kind)
        (folder / f"part.{kind}").write_bytes(data.encode() if isinstance(data, str) else data)
        (folder / f"{kind}.urdf").write_text(BOXES.replace("part.stl", f"part.{kind}"))
    (folder / "arm.xacro").write_text(XACRO)
    (folder / "dh.toml").write_text(DH)
    rows = [{"name": "a", "d": 0.3, "limits": [-1, 1]}, {"a": 0.5, "type": "prismatic"}]
    (folder / "dh.json").write_text(json.dumps({"convention": "standard", "joint": rows}))
    (folder / "arm.toml").write_text(ARRANGED)


def picture(ending: str) -> bytes:
    """A few grey squares."""
    import cv2

    image = np.zeros((24, 32, 3), np.uint8)
    image[4:12, 5:20], image[12:20, 14:18] = 200, (20, 90, 255)
    return bytes(cv2.imencode(ending, image)[1].tobytes())


def seen(folder: Path) -> None:
    """Pictures of all endings in folders of their own, and a video."""
    from bodyschema.sources.video_writer import video_writer

    for ending in ("png", "jpg", "bmp", "ppm", "webp", "tiff"):
        (folder / ending).mkdir()
        (folder / ending / f"a_0.{ending}").write_bytes(picture(f".{ending}"))
    with video_writer(folder / "clip.mp4", (32, 24), 10) as write:
        for i in range(12):
            write(np.full((24, 32, 3), 20 * i, np.uint8))
    steps = "\n".join(f"{0.1 * i},{0.2 * i}" for i in range(14))
    (folder / "joints.csv").write_text(f"t,lift\n{steps}\n")


def tables(folder: Path) -> None:
    """One table as CSV, TSV and Parquet, and bags of one topic."""
    arm(folder, more=False)
    recorded = bs.open_recording(folder / "data.csv")
    write_table(folder / "data.parquet", dict(recorded.columns))
    text = (folder / "data.csv").read_text()
    (folder / "semicolons.csv").write_text(text.replace(",", ";"))
    (folder / "tabs.csv").write_text(text.replace(",", "\t"))


def bags(folder: Path) -> None:
    """Joint states as MCAP, ROS 1 and ROS 2 bag."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    for plugin, name in ((StoragePlugin.MCAP, "mcap"), (StoragePlugin.SQLITE3, "sqlite")):
        store = get_typestore(Stores.ROS2_HUMBLE)
        with Writer2(folder / name, version=9, storage_plugin=plugin) as writer:
            _states(writer, store, store.serialize_cdr)
    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(folder / "one.bag") as writer:
        _states(writer, store, store.serialize_ros1)


def _states(writer: Any, store: Any, serialize: Any) -> None:
    kinds = store.types
    kind = kinds["sensor_msgs/msg/JointState"]
    topic = writer.add_connection("/joint_states", kind.__msgtype__, typestore=store)
    extra = {"seq": 0} if "seq" in kinds["std_msgs/msg/Header"].__dataclass_fields__ else {}
    for i in range(6):
        stamp = kinds["builtin_interfaces/msg/Time"](sec=100 + i, nanosec=5)
        header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base", **extra)
        message = kind(
            header=header, name=["a", "b"], position=np.array([0.1 * i, 0.2]),
            velocity=np.array([1.0, 2.0]), effort=np.array([]),
        )  # fmt: skip
        writer.write(topic, 10**9 * (7 + i), serialize(message, kind.__msgtype__))


def lerobot(folder: Path) -> None:
    """A data set of version 3 with one camera, one of version 2."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from bodyschema.sources.video_writer import video_writer

    key = "observation.images.head"
    features = {
        "observation.state": {"dtype": "float32", "shape": [2], "names": [["a", "b"]]},
        "timestamp": {"dtype": "float32"}, "episode_index": {"dtype": "int64"},
        key: {"dtype": "video"},
    }  # fmt: skip
    end2, end3 = "episode_{episode_index:06d}", "file-{file_index:03d}"
    patterns = {
        "v2": ("data/chunk-{episode_chunk:03d}/" + end2 + ".parquet",
               "videos/chunk-{episode_chunk:03d}/{video_key}/" + end2 + ".mp4"),
        "v3": ("data/chunk-{chunk_index:03d}/" + end3 + ".parquet",
               "videos/{video_key}/chunk-{chunk_index:03d}/" + end3 + ".mp4"),
    }  # fmt: skip
    place: dict[str, Any] = {
        "episode_index": 0, "episode_chunk": 0, "chunk_index": 0, "file_index": 0, "video_key": key
    }  # fmt: skip
    for version, (data, video) in patterns.items():
        home = folder / version
        info = {"codebase_version": f"{version}.0", "total_episodes": 1, "chunks_size": 1000}
        info |= {"features": features, "data_path": data, "video_path": video}
        (home / "meta").mkdir(parents=True)
        (home / "meta" / "info.json").write_text(json.dumps(info))
        states = home / data.format(**place)
        states.parent.mkdir(parents=True)
        rows = pa.FixedSizeListArray.from_arrays(np.arange(24, dtype=np.float32), 2)
        columns = {"observation.state": rows, "timestamp": np.arange(12) / 10}
        pq.write_table(pa.table({**columns, "episode_index": np.zeros(12, int)}), states)
        with video_writer(_parent(home / video.format(**place)), (32, 24), 10) as write:
            for i in range(12):
                write(np.full((24, 32, 3), 20 * i, np.uint8))
    listed = {f"data/{name}": [0] for name in ("chunk_index", "file_index")}
    listed |= {f"videos/{key}/{name}": [0] for name in ("chunk_index", "file_index")}
    listed |= {f"videos/{key}/from_timestamp": [0.0], "episode_index": [0]}
    episodes = _parent(folder / "v3" / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
    pq.write_table(pa.table(listed), episodes)


def _parent(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def calibrated(folder: Path) -> None:
    """A result of `calibrate` beside its inputs, and answers of other verbs made from it."""
    arm(folder, more=False)
    here = str(folder)
    code = quietly("calibrate", f"{here}/run.toml", "--out", f"{here}/out", "--force")
    assert code in (0, 1), code
    assert (folder / "out" / "answer.json").is_file()


def weighed(folder: Path) -> None:
    """A result of `payload`."""
    wrist(folder)
    code = quietly("payload", f"{folder}/run.toml", "--out", f"{folder}/out", "--force")
    assert code in (0, 1), code
    assert (folder / "out" / "answer.json").is_file()


def paired(folder: Path) -> None:
    """A result of `hand-eye`."""
    pairs(folder)
    code = quietly("hand-eye", f"{folder}/run.toml", "--out", f"{folder}/out", "--force")
    assert code in (0, 1), code
    assert (folder / "out" / "answer.json").is_file()
