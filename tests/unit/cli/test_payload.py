"""`bodyschema payload` on recordings in many forms, all of one box."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from bodyschema import Inertia, lie, load
from bodyschema.cli import run
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.tree import Body
from bodyschema.simulation.katana import katana
from bodyschema.simulation.loads import (
    ENCODER,
    Held,
    draw_load,
    draw_motion,
    draw_sensor,
    joined,
    record,
    wire_box,
)
from bodyschema.sources.tables import write_table

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")

BOX = wire_box()
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
MINIMAL = """
recording = "log.csv"
[wrench]
columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
frame = "sensor"
sign = "on_object"
[pose]
columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
"""


@pytest.fixture(scope="module")
def truth():
    """Twelve seconds of the box, and the sensor's faults."""
    rng = np.random.default_rng(5)
    motion, sensor = draw_motion(rng, 12.0, 0.5, 100.0), draw_sensor(rng, np.radians(1))
    return record(motion, [Held(0.0, BOX)], sensor, rng), motion, sensor


def columns(names, values):
    return dict(zip(names, np.asarray(values).T, strict=True))


def pose_columns(samples):
    xyzw = lie.quaternion_xyzw(samples.rotation)
    return columns("xyz", samples.position) | columns(("qx", "qy", "qz", "qw"), xyzw)


@pytest.fixture
def folder(tmp_path, truth):
    samples, _, _ = truth
    table = {"t": samples.time} | columns(WRENCH, samples.wrench) | pose_columns(samples)
    write_table(tmp_path / "log.csv", table)
    (tmp_path / "run.toml").write_text(MINIMAL)
    return tmp_path


def asked(folder: Path, capsys, *more: str) -> tuple[int, dict]:
    command = ["payload", str(folder / "run.toml"), "--out", str(folder / "out"), *more]
    code = run([*command, "--overwrite", "--json"])
    return code, json.loads(capsys.readouterr().out or "{}")


def check_box(answer, com=3e-4):
    load = answer["loads"][0]
    assert load["mass"] == pytest.approx(BOX.mass, rel=2e-3)
    np.testing.assert_allclose(load["com"], BOX.com, atol=com)
    assert load["physical"]
    assert answer["unexplained"] < 0.01


def test_a_minimal_file_gives_the_box_and_all_documents(folder, capsys, truth):
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)
    _, _, sensor = truth
    np.testing.assert_allclose(answer["sensor"]["bias"][:3], sensor.bias[:3], atol=5e-3)
    out = folder / "out"
    document = yaml.safe_load((out / "payload.yaml").read_text())
    assert document["loads"][0]["mass"] == pytest.approx(answer["loads"][0]["mass"])
    assert set(document["loads"][0]["controllers"]) == {"ur", "kuka", "franka", "abb", "xarm"}
    page = (out / "report.html").read_text()
    assert "What the wrist carries" in page
    assert "The wrench before and after" in page
    assert "<svg" in page
    assert [event["event"] for event in answer["events"]] == ["identified"]


def test_base_axes_degrees_pounds_and_uneven_milliseconds(folder, capsys, truth):
    samples, _, _ = truth
    R, rows = samples.rotation, np.sort(np.random.default_rng(0).choice(1200, 1000, replace=False))
    f = -(R @ samples.wrench[:, :3, None])[..., 0]
    tau = -(R @ samples.wrench[:, 3:, None])[..., 0] + np.cross(samples.position, f)
    table = {"stamp": 1e3 * samples.time + 1.7e9}
    table |= columns(("F0", "F1", "F2"), f / 4.4482216152605)
    table |= columns(("M0", "M1", "M2"), 1e3 * tau)
    table |= columns(("p0", "p1", "p2"), 1e3 * samples.position)
    table |= columns(("C", "B", "A"), np.degrees(lie.rpy_from_rotation(R)))
    write_table(folder / "log.csv", {name: values[rows] for name, values in table.items()})
    (folder / "run.toml").write_text(
        'recording = "log.csv"\ntime = "stamp"\ntime_unit = "ms"\n'
        '[wrench]\ncolumns = ["F0", "F1", "F2", "M0", "M1", "M2"]\nframe = "base"\n'
        'about = "base"\nsign = "on_sensor"\nforce_unit = "lbf"\ntorque_unit = "mNm"\n'
        '[pose]\ncolumns = ["p0", "p1", "p2", "C", "B", "A"]\nlayout = "xyz_rpy"\nunit = "mm"\n'
        'angle_unit = "deg"\n'
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)


def test_a_robot_and_its_joints(folder, capsys, truth):
    samples, motion, _ = truth
    arm = katana()
    (folder / "arm.urdf").write_bytes(write_urdf(arm))
    q = motion.q + ENCODER * np.random.default_rng(1).normal(size=motion.q.shape)
    table = {"t": samples.time} | columns(arm.joints, np.degrees(q))
    write_table(folder / "log.csv", table | columns(WRENCH, samples.wrench))
    head = MINIMAL.split("[pose]")[0]
    (folder / "run.toml").write_text(
        'robot = "arm.urdf"\n' + head + '[joints]\nunit = "deg"\n[sensor]\nlink = "hand"\n'
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)
    patched = (folder / "out" / "robot.urdf").read_bytes()
    assert patched.startswith((folder / "arm.urdf").read_bytes().split(b"</robot>")[0])
    body = Body.from_urdf(folder / "out" / "robot.urdf")
    assert body.parent[body.frame_index("payload_load")] == body.frame_index("hand")
    assert f'mass value="{answer["loads"][0]["mass"]:.4f}'.encode() in patched


def test_an_accelerometer_instead_of_poses(folder, capsys, truth):
    samples, motion, _ = truth
    rng = np.random.default_rng(2)
    table = {"t": samples.time} | columns(WRENCH, samples.wrench)
    table |= columns("abc", motion.a_g / 9.80665 + 1e-4 * rng.normal(size=motion.a_g.shape))
    table |= columns("uvw", np.degrees(motion.w) + 0.02 * rng.normal(size=motion.w.shape))
    write_table(folder / "log.csv", table)
    head = MINIMAL.split("[pose]")[0]
    (folder / "run.toml").write_text(
        head + '[gravity]\ncolumns = ["a", "b", "c"]\nunit = "g"\nkind = "accelerometer"\n'
        '[angular_velocity]\ncolumns = ["u", "v", "w"]\nunit = "deg/s"\nframe = "sensor"\n'
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)


def test_flange_axes_and_a_sensor_that_sits_elsewhere(folder, capsys, truth):
    samples, _, _ = truth
    T = lie.transform(lie.rotation_from_rpy([0.0, 0.0, 1.0]), [0.01, 0.02, 0.05])
    poses = lie.transform(samples.rotation, samples.position) @ lie.inverse(T)
    f = samples.wrench[:, :3] @ T[:3, :3].T
    tau = samples.wrench[:, 3:] @ T[:3, :3].T + np.cross(T[:3, 3], f)
    table = {"t": samples.time} | columns(WRENCH, np.hstack([f, tau]))
    names = [f"m{k}" for k in range(16)]
    table |= columns(names, np.swapaxes(poses, 1, 2).reshape(-1, 16))
    write_table(folder / "log.csv", table)
    text = MINIMAL.split("[pose]")[0].replace('"sensor"', '"flange"')
    (folder / "run.toml").write_text(
        text + f"[pose]\ncolumns = {json.dumps(names)}\nlayout = 'matrix4x4_columns'\n"
        "[sensor]\nxyz = [0.01, 0.02, 0.05]\nrpy = [0.0, 0.0, 1.0]\n"
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)
    expected = BOX.in_frame(T)
    np.testing.assert_allclose(answer["loads"][0]["flange"]["com"], expected.com, atol=3e-4)


def test_the_offset_is_told_with_the_sign_of_the_recording(folder, capsys, truth):
    samples, _, sensor = truth
    table = {"t": samples.time} | columns(WRENCH, -samples.wrench) | pose_columns(samples)
    write_table(folder / "log.csv", table)
    (folder / "run.toml").write_text(
        MINIMAL.replace("on_object", "on_sensor") + '[sensor]\nrpy = [0, 0, 1.5]\nknown = "no"\n'
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    found = answer["sensor"]
    np.testing.assert_allclose(found["bias"], -sensor.bias, atol=5e-3)
    off = (np.array(found["bias"]) + sensor.bias) / found["bias_std"]
    assert np.abs(off).max() < 4


@pytest.mark.parametrize("about", ["tcp", "base"])
def test_poses_of_a_tool_and_torques_about_it(folder, capsys, truth, about):
    samples, _, _ = truth
    T_flange_tool = lie.transform(lie.rotation_from_rpy([0.1, 0.0, 0.3]), [0.0, 0.02, 0.15])
    T_base_sensor = lie.transform(samples.rotation, samples.position)
    T_flange_sensor = lie.transform(np.eye(3), [0.0, 0.0, 0.03])
    poses = T_base_sensor @ lie.inverse(T_flange_sensor) @ T_flange_tool
    f = (samples.rotation @ samples.wrench[:, :3, None])[..., 0]
    tau = (samples.rotation @ samples.wrench[:, 3:, None])[..., 0]
    point = poses[:, :3, 3] if about == "tcp" else np.zeros(3)
    tau += np.cross(samples.position - point, f)
    turns = np.array([lie.log_so3(R) for R in poses[:, :3, :3]])
    names = [f"actual_TCP_pose_{k}" for k in range(6)]
    table = {"timestamp": samples.time} | columns(WRENCH, np.hstack([f, tau]))
    write_table(folder / "log.csv", table | columns(names, np.hstack([poses[:, :3, 3], turns])))
    text = MINIMAL.split("[pose]")[0].replace('"sensor"', f'"base"\nabout = "{about}"')
    (folder / "run.toml").write_text(
        text + f"[pose]\ncolumns = {json.dumps(names)}\nlayout = 'xyz_rotvec'\n"
        "xyz = [0.0, 0.02, 0.15]\nrpy = [0.1, 0.0, 0.3]\n[sensor]\nxyz = [0.0, 0.0, 0.03]\n"
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer)
    expected = BOX.in_frame(T_flange_sensor)
    np.testing.assert_allclose(answer["loads"][0]["flange"]["com"], expected.com, atol=3e-4)


def test_poses_that_are_held_with_gaps_between(folder, capsys, truth):
    samples, _, sensor = truth
    rows = np.repeat(np.linspace(0, len(samples) - 1, 8).astype(int), 100)
    rest = np.einsum("nji,j->ni", samples.rotation[rows], [0, 0, 9.81]) * BOX.mass
    y = np.hstack([rest, np.cross(BOX.com, rest)])
    y += sensor.noise * np.random.default_rng(3).normal(size=y.shape)
    time = np.concatenate([5.0 * k + np.arange(100) / 100 for k in range(8)])
    write_table(
        folder / "log.csv", {"t": time} | columns(WRENCH, y) | pose_columns(samples.take(rows))
    )
    code, answer = asked(folder, capsys)
    assert code == 0
    check_box(answer, com=2e-3)


def test_gravity_in_an_undeclared_unit_is_refused(folder, capsys, truth):
    samples, _, _ = truth
    down = -samples.rotation[:, 2]
    table = {"t": samples.time} | columns(WRENCH, samples.wrench) | columns("abc", down)
    write_table(folder / "log.csv", table)
    text = MINIMAL.split("[pose]")[0] + '[gravity]\ncolumns = ["a", "b", "c"]\n'
    (folder / "run.toml").write_text(text)
    assert run(["payload", str(folder / "run.toml"), "--out", str(folder / "out")]) == 2
    assert 'unit = "g"' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ('frame = "sensor"', 'frame = "sensor"\ntorque_unit = "Nmm"', "denser than any metal"),
        ('frame = "sensor"', 'frame = "sensor"\ntorque_unit = "kgfm"', 'torque_unit = "Nm"'),
        ("[pose]", '[pose]\nlayout = "xyz_wxyz"', 'layout = "xyz_xyzw" under [pose]'),
    ],
)
def test_the_entry_that_is_wrong_is_named(folder, capsys, old, new, hint):
    (folder / "run.toml").write_text(MINIMAL.replace(old, new))
    code, answer = asked(folder, capsys)
    assert code == 1
    assert answer["trust"]["level"] == "contradicted"
    assert any(hint in reason for reason in answer["trust"]["reasons"]), answer["trust"]
    assert not (folder / "out").exists()


def test_an_object_is_told_from_the_gripper_by_its_segments(folder, capsys):
    rng = np.random.default_rng(7)
    grip = draw_load(rng, 0.4)
    motion, sensor = draw_motion(rng, 24.0, 0.5, 100.0), draw_sensor(rng, 0.02)
    held = [Held(0.0, grip), Held(12.0, joined(grip, BOX))]
    samples = record(motion, held, sensor, rng)
    table = {"t": samples.time} | columns(WRENCH, samples.wrench) | pose_columns(samples)
    write_table(folder / "log.csv", table)
    code, answer = asked(folder, capsys)
    assert [event["event"] for event in answer["events"]] == ["identified", "grasp"]
    assert [load["name"] for load in answer["loads"]] == ["load 1", "load 2"]
    (folder / "run.toml").write_text(MINIMAL + "[segments]\nempty = [0, 11]\nloaded = [13, 24]\n")
    code, answer = asked(folder, capsys)
    assert code == 0
    assert [load["name"] for load in answer["loads"]] == ["gripper", "object"]
    assert answer["loads"][1]["mass"] == pytest.approx(BOX.mass, rel=2e-3)


def test_postures_without_a_clock_tell_no_inertia(folder, capsys, truth):
    samples, _, sensor = truth
    rows = np.linspace(0, len(samples) - 1, 12).astype(int)
    rest = np.einsum("nji,j->ni", samples.rotation[rows], [0, 0, 9.81]) * BOX.mass
    y = np.hstack([rest, np.cross(BOX.com, rest)])
    y += sensor.noise * np.random.default_rng(3).normal(size=y.shape)
    part = samples.take(rows)
    write_table(folder / "log.csv", columns(WRENCH, y) | pose_columns(part))
    code, answer = asked(folder, capsys)
    assert code == 0
    assert answer["loads"][0]["mass"] == pytest.approx(BOX.mass, rel=0.01)
    assert {one["what"] for one in answer["loads"][0]["not_told"]} >= {"I_xx", "I_yy", "I_zz"}


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"on_object"', '"on_sensor"', "other sign"),
        ('"on_object"', '"up"', "sign = 'up'"),
        (
            "[pose]",
            '[cameras.eye]\nparent = "base"\nsize = [2, 2]\nlens = [1, 1, 1, 1]\n[pose]',
            "is read by 'bodyschema track'",
        ),
        ('"fy"', '"fyy"', "did you mean 'fy'"),
        ('frame = "sensor"\n', "", "lacks the key 'frame'"),
        ('frame = "sensor"', 'frame = "tool9"', "about = 'tool9'"),
        ("[pose]", "[pse]", "unknown key 'pse'"),
        ('recording = "log.csv"', 'recording = "log.csv"\ntime_unit = "us"', "would move at"),
        ("[pose]", '[pose]\nunit = "furlong"', "unknown unit 'furlong'"),
        ("[pose]", '[pose]\nlayout = "xyz_rpy"', "has 6 columns, 7 were named"),
        ('"qw"]', '"qw"]\n[segments]\nempty = [90, 99]', "holds 0 rows"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(folder, capsys, old, new, says):
    (folder / "run.toml").write_text(MINIMAL.replace(old, new))
    assert run(["payload", str(folder / "run.toml"), "--out", str(folder / "out")]) == 2
    message = capsys.readouterr().err
    assert says in message
    assert message.count("\n") == 1


@pytest.mark.parametrize("fault", ["nan", "backward"])
def test_bad_recordings_are_refused_in_one_sentence(folder, capsys, fault):
    lines = (folder / "log.csv").read_text().splitlines()
    cells = lines[9].split(",")
    cells[1 if fault == "nan" else 0] = "nan" if fault == "nan" else "0.01"
    lines[9] = ",".join(cells)
    (folder / "log.csv").write_text("\n".join(lines))
    assert run(["payload", str(folder / "run.toml"), "--out", str(folder / "out")]) == 2
    message = capsys.readouterr().err
    assert "row 8" in message
    assert message.count("\n") == 1


def test_a_wrong_frame_is_a_no_with_the_entry_to_look_at(folder, capsys):
    (folder / "run.toml").write_text(MINIMAL.replace('frame = "sensor"', 'frame = "base"'))
    code, answer = asked(folder, capsys)
    assert code == 1
    assert any('frame = "sensor"' in reason for reason in answer["trust"]["reasons"])


def test_one_posture_is_a_no(folder, capsys, truth):
    samples, _, _ = truth
    part = samples.take(np.zeros(5, dtype=int))
    write_table(folder / "log.csv", columns(WRENCH, part.wrench) | pose_columns(part))
    code, answer = asked(folder, capsys)
    assert code == 1
    assert {"mass", "com"} <= {one["what"] for one in answer["loads"][0]["not_told"]}


def test_a_folder_is_reported_checked_planned_and_exported(folder, capsys, truth):
    samples, motion, sensor = truth
    arm = katana()
    (folder / "arm.urdf").write_bytes(write_urdf(arm))
    table = {"t": samples.time} | columns(arm.joints, motion.q) | columns(WRENCH, samples.wrench)
    write_table(folder / "log.csv", table)
    head = MINIMAL.split("[pose]")[0]
    (folder / "run.toml").write_text('robot = "arm.urdf"\n' + head + '[sensor]\nlink = "hand"\n')
    _, answer = asked(folder, capsys)
    out, robot = str(folder / "out"), str(folder / "arm.urdf")
    keys = {"verdict", "explanation", "nominal", "held_out", "unidentifiable", "parameters"}
    assert keys | {"outliers", "seconds", "loads", "sensor", "events"} <= set(answer)
    assert answer["held_out"]["force_N"]["rms"] < 0.02 < answer["nominal"]["force_N"]["rms"]
    stored = load(out)
    assert stored.details["loads"] == answer["loads"]
    assert run(["report", out]) == 0
    assert "load: 0.5" in capsys.readouterr().out
    assert run(["plan", out]) == 0
    assert "nothing more is needed" in capsys.readouterr().out
    assert run(["export", out, "--robot", robot, "-o", str(folder / "copy.urdf")]) == 0
    assert (folder / "copy.urdf").read_bytes() == (folder / "out" / "robot.urdf").read_bytes()
    capsys.readouterr()
    again = ["check", out, "--recording", str(folder / "log.csv"), "--json"]
    assert run(again) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "still true"
    heavier = Inertia(1.03 * BOX.mass, BOX.com, BOX.moments)
    other = record(motion, [Held(0.0, heavier)], sensor, np.random.default_rng(9))
    write_table(folder / "log.csv", table | columns(WRENCH, other.wrench))
    assert run(again) == 1
    (suspect,) = json.loads(capsys.readouterr().out)["suspects"]
    assert suspect["part"] == "mass"
    assert suspect["change"]["load.mass"] == pytest.approx(0.03 * BOX.mass, rel=0.1)


def test_inputs_and_other_things_are_never_replaced(folder, capsys):
    (folder / "other").mkdir()
    (folder / "other" / "thesis.tex").write_text("years of work")
    for out, message in (
        (folder, "inputs are never touched"),
        (folder / "other", "which is no result"),
    ):
        assert run(["payload", str(folder / "run.toml"), "--out", str(out), "--overwrite"]) == 2
        assert message in capsys.readouterr().err
    assert (folder / "log.csv").is_file()
    assert (folder / "other" / "thesis.tex").is_file()
