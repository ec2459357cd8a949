"""Every kind of sense and part of a run file is read as it was written."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import Body, InputError, Sense
from bodyschema.cli import run as main
from bodyschema.cli.loading import blank_senses, load, read_senses
from bodyschema.cli.reading import part_kinds
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.reading.sense_kinds import COMMON, KINDS
from bodyschema.cli.run_file import RunFile, read_run_file, run_from_record, run_from_table
from bodyschema.export.documents import plain
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import Gravity
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.planes import Planes
from bodyschema.senses.poses import Poses
from bodyschema.senses.torques import Torques
from bodyschema.senses.touches import Touches
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]
Columns = dict[str, Array]

HEAD = """
robot = "robot.urdf"
recording = "data.csv"
[frames.eye]
parent = "base"
xyz = [0.4, 0.0, -1.5]
known = "roughly"
[frames.tool]
parent = "tip"
xyz = [0.02, 0.0, 0.05]
known = "exactly"
"""


@pytest.fixture
def arm() -> Body:
    return Body.random_chain(3, np.random.default_rng(3))


@pytest.fixture
def q() -> Array:
    return np.random.default_rng(4).uniform(-1, 1, (6, 3))


@pytest.fixture
def written(tmp_path: Path, arm: Body, q: Array) -> Callable[..., RunFile]:
    """Write a run file of the arm with further lines and columns; returns it as read."""

    def write(lines: str, columns: Columns, name: str = "data.csv", head: str = HEAD) -> RunFile:
        (tmp_path / "robot.urdf").write_bytes(write_urdf(arm))
        joints = {joint: q[:, j] for j, joint in enumerate(arm.joints)}
        write_table(tmp_path / name, {**joints, **columns})
        (tmp_path / "run.toml").write_text(head + lines)
        return read_run_file(tmp_path / "run.toml")

    return write


def body_of(arm: Body) -> Body:
    """The arm with the frames of the run file."""
    eye, tool = np.eye(4), np.eye(4)
    eye[:3, 3], tool[:3, 3] = (0.4, 0.0, -1.5), (0.02, 0.0, 0.05)
    return arm.attach("eye", "base", eye).attach("tool", "tip", tool)


def named(names: str, values: Array) -> Columns:
    return dict(zip(names.split(), np.asarray(values).T, strict=True))


def same(one: Sense, other: Sense) -> bool:
    """Whether two senses are of one kind and hold the same."""
    if type(one) is not type(other) or one.arrays != other.arrays:
        return False
    alike = all(np.allclose(getattr(one, n), getattr(other, n), atol=1e-12) for n in one.arrays)
    words = ("seen_from", "seen", "stated", "clock", "label", "components")
    alike &= all(getattr(one, word) == getattr(other, word) for word in words)
    return alike and np.allclose(one.covariance, other.covariance)


def test_touches_of_columns_in_mm(written: Any, arm: Body, q: Array) -> None:
    both = np.random.default_rng(1).normal(size=(6, 6))
    columns = named("a b c d e f", 1e3 * both)
    run = written(
        """
[[senses]]
kind = "touches"
seen_from = "base"
seen = "tool"
columns = ["a", "b", "c", "d", "e", "f"]
unit = "mm"
std = 2.0
stated = true
""",
        columns,
    )
    made = Touches.make(q, both[:, :3], both[:, 3:], "base", "tool", std=2e-3, stated=True)
    (read,) = load(run).senses
    assert same(read, made)


def test_points_of_one_board_in_wide_columns(written: Any, arm: Body, q: Array) -> None:
    corners = [[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.0, 0.03, 0.0]]
    image = np.random.default_rng(1).uniform(0, 600, (6, 3, 2))
    columns = {f"{c}{i}": image[:, i, k] for i in range(3) for k, c in enumerate("uv")}
    columns["u1"][2] = columns["v1"][2] = np.nan
    run = written(
        f"""
[parts.lens]
kind = "lens"
fx = 600.0
size = [640, 480]
distortion = [0.1, 0.0, 0.0, 0.0, 0.0]
[parts.board]
kind = "target"
scale = 1.02
[[senses]]
kind = "pixels"
seen_from = "eye"
seen = "tool"
columns = ["u{{i}}", "v{{i}}"]
lens = "lens"
scale = "board"
target = {corners}
""",
        columns,
    )
    loaded = load(run)
    (read,) = loaded.senses
    assert isinstance(read, Pixels)
    assert len(read) == 17
    assert read.rows.tolist() == [r for r in range(6) for i in range(3) if (r, i) != (2, 1)]
    seen = np.array([image[r, i] for r in range(6) for i in range(3) if (r, i) != (2, 1)])
    assert read.observed == pytest.approx(seen)
    assert read.target[:3] == pytest.approx(np.array(corners))
    assert read.points(loaded.body)[1] == pytest.approx([0.0306, 0, 0])
    assert loaded.body.part("lens").values == pytest.approx(
        [600, 600, 319.5, 239.5, 0.1, 0, 0, 0, 0]
    )
    assert loaded.parts == {"lens": None, "board": None}
    assert loaded.frames == {"eye": "roughly"}


def test_pixels_with_the_point_in_each_row(written: Any, arm: Body, q: Array) -> None:
    values = np.random.default_rng(1).uniform(0, 600, (6, 5))
    run = written(
        """
[parts.lens]
kind = "lens"
fx = 600.0
cx = 320.0
cy = 240.0
known = "exactly"
[[senses]]
kind = "pixels"
seen_from = "eye"
seen = "tool"
columns = ["u", "v", "x", "y", "z"]
unit = "mm"
lens = "lens"
""",
        named("u v x y z", values),
    )
    loaded = load(run)
    made = Pixels.make(q, values[:, :2], "eye", "tool", "lens", values[:, 2:] / 1e3)
    assert same(loaded.senses[0], made)
    assert not loaded.parts


def test_distances_planes_and_gravity(written: Any, arm: Body, q: Array) -> None:
    rng = np.random.default_rng(1)
    d, up = rng.uniform(0.3, 0.9, 6), rng.normal(size=(6, 3))
    up *= 9.81 / np.linalg.norm(up, axis=1, keepdims=True)
    run = written(
        """
[parts.drum]
kind = "sensor"
channels = "distance"
free = ["offset"]
std = { offset_d = 0.2 }
[parts.imu]
kind = "sensor"
channels = "acceleration"
offset = [0.1, 0.0, 0.0]
known = "no"
[[senses]]
kind = "distances"
seen_from = "base"
seen = "tool"
columns = ["wire"]
unit = "cm"
anchor = [0.1, 0.2, 0.0]
sensor = "drum"
[[senses]]
kind = "distances"
seen_from = "link_1"
seen = "tool"
distance = 0.05
[[senses]]
kind = "planes"
seen_from = "eye"
seen = "tool"
height = 0.01
point = [0.0, 0.0, 0.1]
[[senses]]
kind = "gravity"
seen_from = "tool"
seen = "base"
columns = ["gx", "gy", "gz"]
unit = "mm/s^2"
sensor = "imu"
""",
        {"wire": 1e2 * d, **named("gx gy gz", 1e3 * up)},
    )
    loaded = load(run)
    anchor = [0.1, 0.2, 0.0]
    made = (
        Distances.make(q, d, "base", "tool", anchor, sensor="drum"),
        Distances.make(q, 0.05, "link_1", "tool"),
        Planes.make(q, "eye", "tool", 0.01, [0, 0, 0.1]),
        Gravity.make(q, up, "tool", "base", "imu"),
    )
    assert all(map(same, loaded.senses, made))
    drum, imu = loaded.body.part("drum"), loaded.body.part("imu")
    assert loaded.parts == {"drum": ("offset_d",), "imu": None}
    assert drum.prior_std.tolist() == [0.2, parts.GAIN_PRIOR]
    assert imu["offset_ax"] == 0.1
    assert imu.prior_std == pytest.approx(10 * parts.accelerometer().prior_std)


WRENCHES = """
[parts.gripper]
kind = "load"
mass_kg = 0.8
com_m = [0.0, 0.0, 0.06]
moments_kgm2 = [0.001, 0.001, 0.0008]
[parts.cell]
kind = "sensor"
known = "exactly"
[[senses]]
kind = "wrenches"
seen_from = "tool"
seen = "base"
columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
torque_unit = "Nmm"
sign = "on_sensor"
loads = ["gripper"]
sensor = "cell"
std = [0.1, 5.0]
"""


def test_wrenches_at_rest(written: Any, arm: Body, q: Array) -> None:
    felt = np.random.default_rng(1).normal(size=(6, 6))
    columns = named("fx fy fz tx ty tz", -felt * [1, 1, 1, 1e3, 1e3, 1e3])
    loaded = load(written(WRENCHES, columns))
    more = {"loads": ("gripper",), "sensor": "cell", "std": (0.1, 5e-3)}
    assert same(loaded.senses[0], WristWrenches.make(q, felt, "tool", "base", **more))
    inertia = Inertia(0.8, np.array([0, 0, 0.06]), np.diag([0.001, 0.001, 0.0008]))
    assert loaded.body.part("gripper").values == pytest.approx(parts.load(inertia).values)
    assert (loaded.body.part("gripper").prior_std < parts.ROOT_PRIOR).all()


def test_wrenches_of_a_motion(written: Any, arm: Body, q: Array) -> None:
    felt = np.random.default_rng(1).normal(size=(6, 6))
    time = 0.1 * np.arange(6.0)
    columns = {"t": time, **named("fx fy fz tx ty tz", felt)}
    (read,) = load(written(WRENCHES + "moving = true\n", columns)).senses
    assert isinstance(read, WristWrenches)
    speed = np.gradient(q, time, axis=0)
    assert read.dq == pytest.approx(speed)
    assert read.ddq == pytest.approx(np.gradient(speed, time, axis=0))
    columns.pop("t")
    with pytest.raises(InputError, match=r"no column of times.*speeds = \"d_\{joint\}\""):
        load(written(WRENCHES + "moving = true\n", columns))
    columns |= {f"d_{joint}": speed[:, j] for j, joint in enumerate(arm.joints)}
    columns |= {f"a_{joint}": 2 * speed[:, j] for j, joint in enumerate(arm.joints)}
    told = 'moving = true\nspeeds = "d_{joint}"\naccelerations = "a_{joint}"\n'
    (read,) = load(written(WRENCHES + told, columns)).senses
    assert isinstance(read, WristWrenches)
    assert read.dq == pytest.approx(speed)
    assert read.ddq == pytest.approx(2 * speed)


def test_torques_of_currents(written: Any, arm: Body, q: Array) -> None:
    torque = np.random.default_rng(1).normal(size=(6, 3))
    amperes = torque / [10.0, 5.0, 2.0]
    run = written(
        """
[parts.fore]
kind = "load"
known = "no"
[parts.motors]
kind = "drive"
[[senses]]
kind = "torques"
seen_from = "base"
seen = "base"
columns = ["i_{joint}"]
per_ampere = [10.0, 5.0, 2.0]
loads = { link_3 = "fore" }
drive = "motors"
""",
        {f"i_{joint}": amperes[:, j] for j, joint in enumerate(arm.joints)},
    )
    loaded = load(run)
    made = Torques.make(q, torque, {"link_3": "fore"}, "base", "base", drive="motors")
    assert same(loaded.senses[0], made)
    assert loaded.body.part("motors").names[0] == f"inertia_{arm.joints[0]}"


def test_torques_without_columns(written: Any, arm: Body) -> None:
    """Found by the fuzz bench: an IndexError."""
    load_of = '[parts.fore]\nkind = "load"\nknown = "no"\n[[senses]]\nkind = "torques"\n'
    ends = 'seen_from = "base"\nseen = "base"\ncolumns = []\nloads = { link_3 = "fore" }\n'
    with pytest.raises(InputError, match="torques has 3 columns, 0 were named"):
        load(written(load_of + ends, {"i": np.zeros(6)}))


def test_a_late_stream(written: Any, arm: Body, q: Array) -> None:
    time = 0.1 * np.arange(6.0)
    run = written(
        """
[parts.late]
kind = "clock"
lag_ms = 20.0
[[senses]]
kind = "points"
seen_from = "eye"
seen = "tool"
columns = ["x", "y", "z"]
clock = "late"
""",
        {"time": time, **named("x y z", q)},
    )
    loaded = load(run)
    (read,) = loaded.senses
    assert read.rate == pytest.approx(np.gradient(q, time, axis=0))
    assert read.readings(loaded.body) == pytest.approx(q - 0.02 * read.rate)


OWN = """
robot = "robot.urdf"
recording = "data.csv"
[frames.eye]
parent = "base"
[frames.tool]
parent = "tip"
[[senses]]
kind = "points"
seen_from = "eye"
seen = "tool"
columns = ["x", "y", "z"]
[[senses]]
kind = "points"
seen_from = "eye"
seen = "tool"
columns = ["x", "y", "z"]
recording = "tuesday.csv"
[[senses]]
kind = "poses"
seen_from = "eye"
seen = "tool"
columns = ["x", "y", "z", "i", "j", "k"]
layout = "xyz_rotvec"
recording = "wednesday.csv"
"""


def test_recordings_of_several_days(written: Any, arm: Body, q: Array) -> None:
    """Those that differ in nothing else are one sense; rows are numbered through."""
    for name in ("tuesday.csv", "wednesday.csv", "data.csv"):
        run = written(OWN, named("x y z i j k", np.hstack([q, q])), name, head="")
    loaded = load(run)
    points, poses = loaded.senses
    assert points.rows.tolist() == list(range(12))
    assert isinstance(poses, Poses)
    assert poses.rows.tolist() == list(range(12, 18))
    assert loaded.first_rows == {"'data.csv'": 0, "'tuesday.csv'": 6, "'wednesday.csv'": 12}
    assert [Path(name).name for name in run.inputs] == ["tuesday.csv", "wednesday.csv"]


def test_a_message_names_the_recording(written: Any, arm: Body, q: Array) -> None:
    columns = named("x y z i j k", np.hstack([q, q]))
    for name in ("tuesday.csv", "data.csv"):
        run = written(OWN.replace("xyz_rotvec", "matrix3x4"), columns, name, head="")
    turned = {f"m{i}": np.ones(6) for i in range(12)}
    twelve = ", ".join(f'"m{i}"' for i in range(12))
    lines = OWN.replace("xyz_rotvec", "matrix3x4").replace(
        '["x", "y", "z", "i", "j", "k"]', f"[{twelve}]"
    )
    run = written(lines, turned, "wednesday.csv", head="")
    with pytest.raises(InputError, match=r"row 12 .*Rows of 'wednesday\.csv' count from 12"):
        load(run)


KEYS = 'columns = ["x", "y", "z"]\nseen_from = "eye"\nseen = "tool"\n'


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('[[senses]]\nkind = "point"\n' + KEYS, "did you mean 'points'"),
        ('[[senses]]\nkind = "points"\nlayout = "xyz_rpy"\n' + KEYS, "is for senses of poses, not"),
        ('[[senses]]\nkind = "poses"\nloads = ["a"]\n' + KEYS, "of wrenches and torques, not of p"),
        ('[[senses]]\nkind = "pixels"\n' + KEYS, "lacks the key 'lens', which pixels need"),
        ('[[senses]]\nkind = "points"\nlence = "a"\n' + KEYS, "unknown key 'lence'"),
        ('[[senses]]\nkind = "points"\nunit = "deg"\n' + KEYS, "unknown unit 'deg'"),
        ('[[senses]]\nkind = "points"\nstd = [1.0, 2.0]\n' + KEYS, "std of a sense of points is"),
        ('[[senses]]\nkind = "points"\nclock = "late"\n' + KEYS, "no part 'late'"),
        ('[[senses]]\nkind = "gravity"\nsensor = "c"\n' + KEYS, "kind 'clock' where a sense of g"),
        ('[[senses]]\nkind = "points"\n' + KEYS, "no [[senses]] entry names the part 'c'"),
        ('[parts.d]\nkind = "lense"\n', "did you mean 'lens'"),
        ('[parts.d]\nkind = "lens"\nlag_ms = 3.0\n', "'lag_ms' in [parts.d] of 'run.toml' is for"),
        ('[parts.d]\nkind = "lens"\nfx = 3.0\n', "needs fx, cx and cy"),
        ('[parts.d]\nkind = "load"\n', 'needs mass_kg, com_m and moments_kgm2, or known = "no"'),
        ('[parts.d]\nkind = "sensor"\nfree = ["ofset"]\n', "did you mean 'offset'"),
        ('[parts.d]\nkind = "constants"\nvalues = { a = 1.0 }\n', "lacks units of 'a'"),
        ('[parts.d]\nkind = "clock"\nknown = "yes"\n', "known = 'yes'"),
    ],
)
def test_what_cannot_be_used_is_said(written: Any, q: Array, lines: str, words: str) -> None:
    clock = '[parts.c]\nkind = "clock"\n'
    with pytest.raises(InputError) as refused:
        load(written(clock + lines, {"time": np.arange(6.0), **named("x y z", q)}))
    assert words in str(refused.value)


def test_a_record_is_the_run(written: Any, arm: Body, q: Array) -> None:
    felt = np.random.default_rng(1).normal(size=(6, 6))
    run = written(WRENCHES, named("fx fy fz tx ty tz", felt))
    again = run_from_record({**plain(asdict(run)), "versions": {}})
    assert again == run


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_keys_are_fields_of_an_entry(kind: str) -> None:
    names = {entry.name for entry in fields(SenseEntry)}
    assert {*COMMON, *KINDS[kind].keys, *KINDS[kind].needed} <= names


def test_a_recording_that_is_gone_leaves_blank_senses(written: Any, arm: Body, q: Array) -> None:
    felt = np.random.default_rng(1).normal(size=(6, 6))
    run = written(WRENCHES, named("fx fy fz tx ty tz", felt))
    body = load(run).body
    (blank,) = blank_senses(run, body)
    assert len(blank) == 0
    assert blank.label == load(run).senses[0].label
    assert len(blank.imagined(body, q)) == 6
    gone = replace(run, recording=("/nowhere/data.csv",))
    with pytest.raises(InputError, match="no recording at"):
        read_senses(gone, body)


def test_what_is_read_is_what_a_body_shows(written: Any, arm: Body, q: Array) -> None:
    """A pose of each row, inverse and in mm, as its own body predicts it."""
    body = body_of(arm)
    T = relative_pose(body, q, "tool", "eye")
    columns = {f"m{i}": v for i, v in enumerate((T[:, :3] * [1, 1, 1, 1e3]).reshape(6, 12).T)}
    twelve = ", ".join(f'"m{i}"' for i in range(12))
    run = written(
        f"""
[[senses]]
kind = "poses"
seen_from = "eye"
seen = "tool"
columns = [{twelve}]
unit = "mm"
inverse = true
""",
        columns,
    )
    loaded = load(run)
    assert np.abs(loaded.senses[0].residual(loaded.body)).max() < 1e-9


PAGE = (Path(__file__).parents[3] / "docs" / "run_file.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("block", re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL))
def test_the_examples_of_the_page_are_read(block: str, tmp_path: Path) -> None:
    table = tomllib.loads(block)
    alone = "hand_eye" in table
    base = {} if alone else {"robot": "arm.urdf", "recording": "data.csv"}
    base |= {"recording": []} if "append" in table else {}
    run = run_from_table({**base, **table}, tmp_path, "the page")
    assert len(run.senses) == len(table.get("senses", [])) * len(table.get("append", ["one"]))


def test_the_tables_of_the_page_have_every_kind_and_key() -> None:
    rows = {
        line.split("|")[1].strip().strip("`"): set(re.findall(r"`(\w+)`", line))
        for line in PAGE.splitlines()
        if line.startswith("| `")
    }
    for name, kind in KINDS.items():
        assert rows[name] - {name, "calibrate"} == {*kind.keys}, name
        assert kind.columns.split(",")[0] in PAGE
    for name, part in part_kinds.KINDS.items():
        assert rows[name] - {name, "std"} == {*part.keys}, name


def test_two_days_with_a_board_that_moved(
    shared_data: Callable[[str], Path], tmp_path: Path
) -> None:
    """Same columns in both tables, frames of their own (easy_handeye#72)."""
    cases = shared_data("ur5_artag_handeye").parents[1] / "cases"
    text = f'robot = "{cases}/common/arm.urdf"\n[frames.camera]\nparent = "flange"\n'
    for day in ("mon", "tue"):
        text += f"""
[frames.board_{day}]
parent = "base"
[[senses]]
kind = "poses"
recording = "{cases}/S_two_recordings/{day}.csv"
seen_from = "board_{day}"
seen = "camera"
layout = "xyz_xyzw"
columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
"""
    (tmp_path / "run.toml").write_text(text)
    loaded = load(read_run_file(tmp_path / "run.toml"))
    answer = bs.calibrate(loaded.body, loaded.senses, loaded.frames, ["offsets"], folds=2)
    found = np.rad2deg(answer.body.offset[1:5])
    assert found == pytest.approx([2.0, -3.0, 1.5, -2.5], abs=0.1)


def test_arguments_of_a_xacro_file(tmp_path: Path) -> None:
    base = {"robot": "arm.urdf.xacro", "recording": "data.csv"}
    given = {"dof": 7, "reach": 0.3, "gripper": False, "name": "left"}
    run = run_from_table({**base, "robot_arguments": given}, tmp_path, "run.toml")
    words = {"dof": "7", "reach": "0.3", "gripper": "false", "name": "left"}
    assert run.robot_arguments == words, "as xacro takes them"
    with pytest.raises(InputError, match="did you mean 'robot_arguments'"):
        run_from_table({**base, "robot_argument": given}, tmp_path, "run.toml")
    with pytest.raises(InputError, match=r"robot_arguments = .* expected a section of keys"):
        run_from_table({**base, "robot_arguments": {"a": [1]}}, tmp_path, "run.toml")


TOOL = """<xacro:arg name="tool"/><link name="$(arg tool)"/><joint name="t" type="fixed">
<parent link="tip"/><child link="$(arg tool)"/></joint></robot>"""


def test_the_corrected_robot_is_expanded_with_the_same_arguments(tmp_path: Path, arm: Body) -> None:
    """Where it is written, and where another description is corrected by `export`."""
    pytest.importorskip("xacrodoc")
    text = write_urdf(arm).decode().replace("</robot>", TOOL)
    text = text.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    (tmp_path / "arm.urdf.xacro").write_text(text)
    rng = np.random.default_rng(5)
    q = rng.uniform(-1, 1, (20, 3))
    p = relative_pose(arm, q + 0.05, "base", "tip")[:, :3, 3] + 1e-3 * rng.normal(size=(20, 3))
    columns = {joint: q[:, j] for j, joint in enumerate(arm.joints)}
    write_table(tmp_path / "data.csv", {**columns, **named("x y z", p)})
    (tmp_path / "run.toml").write_text(
        'robot = "arm.urdf.xacro"\nrobot_arguments = { tool = "pen" }\nrecording = "data.csv"\n'
        '[frames.eye]\nparent = "base"\n[frames.mark]\nparent = "pen"\n[[senses]]\n'
        'kind = "points"\nseen_from = "eye"\nseen = "mark"\ncolumns = ["x", "y", "z"]\n'
    )
    out, other = tmp_path / "out", tmp_path / "other.urdf"
    calibrate = ["calibrate", str(tmp_path / "run.toml"), "-o", str(out), "--free", "offsets"]
    assert main(calibrate) == 0
    assert '<link name="pen"/>' in (out / "robot.urdf").read_text()
    given = ["--robot", str(tmp_path / "arm.urdf.xacro"), "--out", str(other)]
    assert main(["export", str(out), *given]) == 0
    assert '<link name="pen"/>' in other.read_text()
