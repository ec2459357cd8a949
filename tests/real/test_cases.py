"""Cases that people met in public, each with the right answer that its README states.

The arm of the cases has true zeros 0, 2, -3, 1.5, -2.5, 0 deg; noise is 0.5 mm and 1 mrad.
"""

from __future__ import annotations

import json
import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.cli.reading.robot import robot_of
from bodyschema.cli.run_file import run_from_table
from bodyschema.errors import InputError
from bodyschema.export.urdf_patch import JointEdit, patch_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import open_recording

Folder = Callable[[str], Path]

ZEROS = {"j2": 2.0, "j3": -3.0, "j4": 1.5, "j5": -2.5}
"""deg; those of j1 and j6 cannot be told apart from the frames."""

Verb = Callable[..., tuple[int, dict[str, Any], str]]


@pytest.fixture
def calibrate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Verb:
    """Calibrate by a run file: exit code, the JSON object, and everything that was said."""

    def verb(run_file: Path, *flags: str) -> tuple[int, dict[str, Any], str]:
        code = run(["calibrate", str(run_file), "--out", str(tmp_path / "out"), "--json", *flags])
        said = capsys.readouterr()
        answer = json.loads(said.out) if said.out else {}
        return code, answer, said.out + said.err

    return verb


def written(case: Path, folder: Path, *changes: tuple[str, str]) -> Path:
    """The case's run file with other words, its paths absolute, in a folder of the test."""
    text = (case / "run.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    text = re.sub(r'"([\w./]+\.(?:csv|urdf))"', lambda m: f'"{(case / m[1]).resolve()}"', text)
    (folder / "run.toml").write_text(text)
    return folder / "run.toml"


def assert_right(answer: dict[str, Any], rms_mm: float = 1.2, deg: float = 0.3) -> None:
    """The zeros of the arm, and errors that are those of the noise."""
    assert answer["verdict"] == "calibrated"
    assert answer["held_out"]["position_mm"]["rms"] < rms_mm
    found = {p["name"]: np.degrees(p["value"]) for p in answer["parameters"]}
    for joint, zero in ZEROS.items():
        assert found[f"{joint}.offset"] == pytest.approx(zero, abs=deg), joint


# ---- declarations ----------------------------------------------------------------------------


def test_angles_in_degrees(shared_cases: Folder, calibrate: Verb) -> None:
    """An angle of 170 is no rad."""
    code, _, said = calibrate(shared_cases("B_angles_in_degrees") / "run.toml")
    assert code != 0
    assert "deg" in said


def test_angles_declared_in_degrees(shared_cases: Folder, calibrate: Verb, tmp_path: Path) -> None:
    case = shared_cases("B_angles_in_degrees")
    declared = ('layout = "xyz_rpy"', 'layout = "xyz_rpy"\nangle_unit = "deg"')
    code, answer, _ = calibrate(written(case, tmp_path, declared))
    assert code == 0
    assert_right(answer)
    assert answer["held_out"]["rotation_deg"]["rms"] < 0.15


def test_millimetres(shared_cases: Folder, calibrate: Verb) -> None:
    code, _, said = calibrate(shared_cases("D_millimetres") / "run.toml")
    assert code == 2
    assert 'unit = "mm"' in said


def test_inverse_poses(shared_cases: Folder, calibrate: Verb) -> None:
    code, answer, _ = calibrate(shared_cases("E_inverse") / "run.toml")
    assert code == 1
    reasons = [r for r in answer["trust"]["reasons"] if "inverse = true" in r]
    assert any(0.5 < float(mm) < 2 for r in reasons for mm in re.findall(r"([\d.]+) mm", r))


# ---- clocks ----------------------------------------------------------------------------------


def test_late_joints(shared_cases: Folder, calibrate: Verb) -> None:
    code, answer, _ = calibrate(shared_cases("H_lag") / "run.toml")
    assert code == 1
    assert answer["trust"]["level"] == "contradicted"
    named = [r for r in answer["trust"]["reasons"] if re.search("clock|lag", r)]
    lags = [float(x) for r in named for x in re.findall(r"(\d+\.?\d*) ?s\b", r)]
    lags += [float(x) / 1e3 for r in named for x in re.findall(r"(\d+\.?\d*) ?ms\b", r)]
    assert any(abs(lag - 0.35) < 0.02 for lag in lags)


def test_stamps_in_nanoseconds() -> None:
    """What the case's make.py does."""
    t = np.arange(0, 10, 0.05) * 1e9
    T = np.tile(np.eye(4), (len(t), 1, 1))
    angle = np.sin(t / 1e9)
    T[:, 0, 0] = T[:, 1, 1] = np.cos(angle)
    T[:, 1, 0] = np.sin(angle)
    T[:, 0, 1] = -np.sin(angle)
    with pytest.raises(InputError, match=r"\bns\b"):
        bs.join_streams(t, T, t, T)


# ---- hand-eye --------------------------------------------------------------------------------


def test_eye_on_the_base(shared_cases: Folder) -> None:
    """The wanted camera is 9 to 18 mm off, and its covariance says so."""
    made = runpy.run_path(str(shared_cases("K_eye_on_base_verdict") / "make.py"))
    solved = made["s"]
    largest = float(np.sqrt(np.linalg.eigvalsh(solved.covariance[6:9, 6:9])[-1]))
    assert solved.largest_std == pytest.approx(largest, rel=1e-6)
    assert f"{1e3 * largest:.2g} mm" in solved.verdict


# ---- recordings ------------------------------------------------------------------------------


def test_percent_of_the_limits(shared_cases: Folder, calibrate: Verb, tmp_path: Path) -> None:
    code, _, said = calibrate(shared_cases("R_motor_units") / "run.toml")
    assert code == 2
    assert '"percent" if its numbers are -100 to 100 of the limits' in said
    code, answer, _ = calibrate(shared_cases("R_motor_units") / "run_pct.toml")
    assert code == 0
    assert_right(answer)


def test_motors_with_scale_sign_and_zero(
    shared_cases: Folder, calibrate: Verb, tmp_path: Path
) -> None:
    """The same recording with one motor that turns the other way and counts from elsewhere."""
    case = shared_cases("R_motor_units")
    rows = (case / "data.csv").read_text().splitlines()
    turned = [",".join([repr(500.0 - float(row.split(",")[0])), *row.split(",")[1:]])
              for row in rows[1:]]  # fmt: skip
    (tmp_path / "data.csv").write_text("\n".join([rows[0], *turned]) + "\n")
    sizes = {"j1": 0.029, "j2": 0.02, "j3": 0.025, "j4": 0.029, "j5": 0.021, "j6": 0.029}
    more = {"j1": ", sign = -1, zero = 500"}
    joints = "".join(
        f'{j} = {{ column = "{j}.pos", scale = {size}{more.get(j, "")} }}\n'
        for j, size in sizes.items()
    )
    path = written(case, tmp_path)
    text = re.sub(r"columns = \{.*\}\n", lambda _: joints, path.read_text(), count=1)
    path.write_text(re.sub(r'"[^"]*data.csv"', '"data.csv"', text))
    code, answer, _ = calibrate(path)
    assert code == 0
    assert_right(answer)


def test_two_days(shared_cases: Folder, calibrate: Verb, tmp_path: Path) -> None:
    """The same columns on both, and a board that was moved over night."""
    case = shared_cases("S_two_recordings")
    code, _, said = calibrate(case / "run.toml")
    assert code == 2
    assert "append = [...]" in said
    changes = (
        ("recording = [", "append = ["),
        ('parent = "base"', 'parent = "base"\nper_recording = true'),
    )
    code, answer, _ = calibrate(written(case, tmp_path, *changes))
    assert code == 0
    assert_right(answer)
    assert not answer["outliers"]


def test_joints_and_poses_of_their_own_clocks(
    shared_cases: Folder, calibrate: Verb, tmp_path: Path
) -> None:
    """What is to be added to the stamps of the poses is -0.35 s."""
    case = shared_cases("T_two_clocks")
    code, _, said = calibrate(case / "run.toml")
    assert code == 2
    assert 'join = "time"' in said
    code, answer, _ = calibrate(
        written(case, tmp_path, ("[frames.board]", 'join = "time"\n[frames.board]'))
    )
    assert code == 0
    assert_right(answer)
    (note,) = [note for note in answer["notes"] if "'poses.csv'" in note]
    (lag,) = re.findall(r"([-+][\d.]+) s was added", note)
    assert float(lag) == pytest.approx(-0.35, abs=0.002)


def test_bags_and_lerobot(shared_cases: Folder, calibrate: Verb) -> None:
    """The bag has the joints alone, the data set no rows: both end in a sentence on what to do."""
    case = shared_cases("V_bag_mcap_lerobot")
    code, _, said = calibrate(case / "run.toml")
    assert code == 2
    assert "pip install 'bodyschema[bags]'" in said or "no column 'x' in 'rec.mcap" in said
    code, _, said = calibrate(case / "run_lerobot.toml")
    assert code == 2
    assert "without a Parquet file under data; was it downloaded whole" in said


def test_photographs_of_a_board(shared_cases: Folder, calibrate: Verb) -> None:
    code, _, said = calibrate(shared_cases("U_board_images") / "run.toml")
    assert code == 2
    assert "docs/board_photographs.md" in said


# ---- robot descriptions ----------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_without_encoders(shared_cases: Folder, kind: str) -> None:
    body = bs.Body.from_urdf(shared_cases("N_floating_planar") / f"{kind}.urdf")
    tip = relative_pose(body, np.zeros(2), "world", "tip")
    assert tip[:3, 3] == pytest.approx([0.3, 0, 0.6])
    assert any(f"'root' is {kind}" in remark for remark in body.remarks)


def test_a_prefix_that_nobody_declared(shared_cases: Folder) -> None:
    path = shared_cases("O_unbound_prefix") / "arm.urdf"
    assert bs.Body.from_urdf(path).joints == ("j1",)
    source = path.read_bytes()
    patched = patch_urdf(source, {"j1": JointEdit(xyz=(0.0, 0.0, 0.2))})
    assert patched == source.replace(b'xyz="0 0 0.1"', b'xyz="0 0 0.2"')


def test_limits_of_no_width(
    shared_cases: Folder, calibrate: Verb, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They count as unknown; a plan stays within what was recorded and repeats no posture."""
    case = shared_cases("G_zero_limits")
    code, answer, _ = calibrate(case / "run.toml")
    assert code == 0
    assert_right(answer)
    assert any("leave no range" in note for note in answer["notes"])
    (predicted,) = answer["predicted"]
    assert predicted["anywhere_position_mm_95"] > 0.9 * predicted["position_mm_95"]
    plan = tmp_path / "plan.csv"
    assert run(["plan", str(tmp_path / "out"), "-n", "5", "--out", str(plan), "--json"]) == 0
    table, recorded = open_recording(plan), open_recording(case / "data.csv")
    poses = np.column_stack([table.columns[f"j{i}"] for i in range(1, 7)])
    readings = np.column_stack([recorded.columns[f"j{i}"] for i in range(1, 7)])
    assert len(np.unique(poses.round(3), axis=0)) == 5
    assert (poses >= readings.min(axis=0)).all()
    assert (poses <= readings.max(axis=0)).all()


def test_a_zero_that_the_urdf_states_itself(shared_cases: Folder, calibrate: Verb) -> None:
    code, answer, _ = calibrate(shared_cases("Q_calibration_rising") / "run.toml")
    assert code == 0
    found = {p["name"]: p["value"] for p in answer["parameters"]}
    assert found["j2.offset"] == pytest.approx(0.2, abs=0.005)
    (note,) = [note for note in answer["notes"] if "'j2'" in note]
    assert 'rising="0.2"' in note
    assert "turns by both" in note


def test_arguments_of_xacro(shared_cases: Folder) -> None:
    pytest.importorskip("xacrodoc")
    path = shared_cases("P_xacro_args") / "arm.urdf.xacro"
    with pytest.raises(InputError, match=r'robot_arguments = \{ reach = "\.\.\." \}'):
        bs.Body.from_urdf(path)
    table = {"robot": str(path), "recording": "none.csv", "robot_arguments": {"reach": "0.3"}}
    body = robot_of(run_from_table(table, path.parent, "'run.toml'"))
    assert body.placement[body.frame_index("l1"), 2, 3] == pytest.approx(0.3)
