"""The folder of a result: whole or not at all, inputs untouched, and every file what it says."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import bodyschema
from bodyschema.atomic.manifest import MANIFEST
from bodyschema.errors import InputError
from bodyschema.export.result_folder import (
    check_place,
    is_earlier,
    refuse_inputs,
    sha256,
    write_result,
)
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.settled import settled
from bodyschema.model.dh import read_dh
from bodyschema.model.tree import Body
from bodyschema.model.urdf import read_urdf

Difference = Callable[[Body, Body], float]
FILES = [
    "robot.urdf",
    "calibration.yaml",
    "kinematics.yaml",
    "answer.json",
    "transforms.yaml",
    "run.json",
]


@pytest.fixture
def source(case: Any, tmp_path: Path) -> Path:
    path = tmp_path / "in" / "arm.urdf"
    path.parent.mkdir()
    path.write_bytes(case.source.replace(b"<robot", b"<!-- mine -->\n<robot"))
    return path


def notes(folder: Path) -> list[str]:
    found = yaml.safe_load((folder / "calibration.yaml").read_text())["notes"]
    assert isinstance(found, list)
    return found


def test_a_urdf_comes_back_corrected(
    case: Any, source: Path, tmp_path: Path, worst_pose: Difference
) -> None:
    before = source.read_bytes()
    out = tmp_path / "out"
    written = write_result(case.calibration, case.nominal, source, out, {}, False)
    assert written == [out / name for name in FILES]
    assert sorted(out.iterdir()) == sorted([*written, out / MANIFEST])
    assert worst_pose(read_urdf(out / "robot.urdf", {}), settled(case.calibration).body) < 1e-9
    assert b"<!-- mine -->" in (out / "robot.urdf").read_bytes()
    assert source.read_bytes() == before
    assert notes(out) == ["robot.urdf is corrected at 2 joints."]


def test_only_frames_leaves_the_urdf_as_it_is(case: Any, source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    calibration = replace(case.calibration, verdict="only frames", groups=())
    write_result(calibration, case.nominal, source, out, {}, False)
    assert (out / "robot.urdf").read_bytes() == source.read_bytes()
    assert notes(out) == ["robot.urdf is the robot as described: nothing in it was changed."]
    offsets = [j.get("offset", 0.0) for j in _kinematics(out).values()]
    assert offsets == [0.0] * 5
    assert (out / "transforms.yaml").is_file()


def _kinematics(folder: Path) -> dict[str, dict[str, float]]:
    found = yaml.safe_load((folder / "kinematics.yaml").read_text())["kinematics"]
    assert isinstance(found, dict)
    return found


def test_only_frames_still_places_a_frame_that_the_urdf_has(
    case: Any, tmp_path: Path, worst_pose: Difference
) -> None:
    described = case.nominal.attach("camera", "base").attach("marker", "tip")
    source = tmp_path / "arm.urdf"
    source.write_bytes(write_urdf(described))
    calibration = replace(case.calibration, verdict="only frames")
    out = tmp_path / "out"
    write_result(calibration, described, source, out, {}, False)
    patched = read_urdf(out / "robot.urdf", {})
    placed = described
    for frame in ("camera", "marker"):
        k = calibration.body.frame_index(frame)
        placed = placed.with_placement(frame, settled(calibration).body.placement[k])
    assert worst_pose(patched, placed) < 1e-9
    assert not (out / "transforms.yaml").exists()
    assert notes(out) == ["robot.urdf is corrected at 2 joints."]


def test_a_refused_calibration_says_so_in_its_files(
    case: Any, source: Path, tmp_path: Path
) -> None:
    calibration = replace(case.calibration, verdict="refused")
    write_result(calibration, case.nominal, source, tmp_path / "out", {}, False)
    assert notes(tmp_path / "out")[0].startswith("This calibration was refused")


def test_gears_are_named_in_the_notes(case: Any, source: Path, tmp_path: Path) -> None:
    fit = case.calibration.fit
    geared = replace(fit.reference, gear=np.array([0.0, 0.02, 0.0, 0.0]))
    estimate = replace(fit, reference=geared)
    calibration = replace(case.calibration, fit=estimate)
    write_result(calibration, case.nominal, source, tmp_path / "out", {}, False)
    assert notes(tmp_path / "out")[1].startswith("joint 'joint_2' moves 1.02 times as far")
    document = yaml.safe_load((tmp_path / "out" / "calibration.yaml").read_text())
    assert document["gears"] == {"joint_2": 0.02}


def test_a_xacro_comes_back_expanded(
    case: Any, source: Path, tmp_path: Path, worst_pose: Difference
) -> None:
    pytest.importorskip("xacrodoc")
    xacro = source.with_suffix(".xacro")
    xacro.write_bytes(
        case.source.replace(b"<robot", b'<robot xmlns:xacro="http://www.ros.org/wiki/xacro"')
    )
    out = tmp_path / "out"
    write_result(case.calibration, case.nominal, xacro, out, {}, False)
    assert worst_pose(read_urdf(out / "robot.urdf", {}), settled(case.calibration).body) < 1e-9
    assert set(_kinematics(out)) == set(case.nominal.carriers[1:])


def test_a_dh_table_becomes_a_urdf(tmp_path: Path, worst_pose: Difference) -> None:
    table = tmp_path / "arm.toml"
    rows = ["a = 0.3", "a = 0.2\nalpha = 1.2", "d = 0.2\nalpha = -0.7", "a = 0.25"]
    table.write_text("".join(f"[[joint]]\n{row}\n" for row in rows))
    nominal = read_dh(table)
    rng = np.random.default_rng(0)
    body = nominal.attach("camera", "base")
    truth = replace(body, offset=np.array([0.0, 0.05, -0.04, 0.03]))
    q = rng.uniform(-2, 2, (30, 4))
    seen = bodyschema.Points.make(q, np.zeros((30, 3)), "camera", "flange").imagined(truth, q)
    noisy = replace(seen, observed=seen.position + rng.normal(0, 1e-4, (30, 3)))
    calibration = bodyschema.calibrate(body, [noisy], {"camera": "roughly"}, ["offsets"], folds=2)
    assert calibration.verdict == "calibrated"
    out = tmp_path / "out"
    write_result(calibration, nominal, table, out, {"robot": str(table)}, False)
    back = read_urdf(out / "robot.urdf", {})
    assert back.frames == nominal.frames
    assert worst_pose(back, settled(calibration).body) < 1e-9
    # No file at all gives the same robot.
    write_result(calibration, nominal, None, tmp_path / "other", {}, False)
    assert (tmp_path / "other" / "robot.urdf").read_bytes() == (out / "robot.urdf").read_bytes()


# ---- the record ------------------------------------------------------------------------------


def test_the_run_is_recorded_with_hashes_and_versions(
    case: Any, source: Path, tmp_path: Path
) -> None:
    data = tmp_path / "data.csv"
    data.write_text("t\n1\n")
    run = {"robot": str(source), "recording": (str(data), "tcp://robot"), "seed": 3, "tol": np.inf}
    out = tmp_path / "out"
    write_result(case.calibration, case.nominal, source, out, run, False, {"report.html": b"<p>"})
    record = json.loads((out / "run.json").read_text())
    assert record["recording"] == [str(data), "tcp://robot"]
    assert record["seed"] == 3
    assert record["tol"] is None
    assert record["sha256"] == {
        str(source): hashlib.sha256(source.read_bytes()).hexdigest(),
        str(data): hashlib.sha256(b"t\n1\n").hexdigest(),
    }
    assert record["versions"]["numpy"] == np.__version__
    assert (out / "report.html").read_bytes() == b"<p>"


def test_a_folder_is_hashed_by_names_and_contents(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    (folder / "deep").mkdir(parents=True)
    (folder / "deep" / "a").write_bytes(b"1")
    first = sha256(folder)
    assert sha256(folder) == first
    (folder / "deep" / "a").rename(folder / "deep" / "b")
    assert sha256(folder) != first


# ---- what is refused -------------------------------------------------------------------------


def test_inputs_are_never_replaced(case: Any, source: Path, tmp_path: Path) -> None:
    before = source.read_bytes()
    for folder in (source.parent, source, tmp_path):
        with pytest.raises(InputError, match="inputs are never touched; name another folder"):
            write_result(case.calibration, case.nominal, source, folder, {}, True)
    recorded = tmp_path / "set"
    recorded.mkdir()
    run = {"recording": [str(recorded)]}
    with pytest.raises(InputError, match=r"the input '.*set' lies there"):
        write_result(case.calibration, case.nominal, source, recorded / "out", run, True)
    assert source.read_bytes() == before
    assert [path.name for path in recorded.iterdir()] == []


def test_a_link_to_the_input_is_followed(case: Any, source: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(source.parent, target_is_directory=True)
    with pytest.raises(InputError, match="inputs are never touched"):
        write_result(case.calibration, case.nominal, source, tmp_path / "link", {}, True)


def test_results_are_kept_unless_told_otherwise(case: Any, source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "old").touch()
    with pytest.raises(InputError, match="not empty"):
        write_result(case.calibration, case.nominal, source, out, {}, False)
    with pytest.raises(InputError, match="will not remove it"):
        write_result(case.calibration, case.nominal, source, out, {}, True)
    assert [path.name for path in out.iterdir()] == ["old"]
    (out / "old").unlink()
    write_result(case.calibration, case.nominal, source, out, {}, False)
    write_result(case.calibration, case.nominal, source, out, {}, True)
    assert sorted(path.name for path in out.iterdir()) == sorted([*FILES, MANIFEST])
    for name in ("notes.txt", ".git"):
        (out / name).mkdir()
        with pytest.raises(InputError, match=f"holds '{name}', which bodyschema did not write"):
            write_result(case.calibration, case.nominal, source, out, {}, True)
        (out / name).rmdir()
    edited = out / "robot.urdf"
    edited.write_bytes(edited.read_bytes() + b"<!-- mine -->")
    with pytest.raises(InputError, match=r"'robot\.urdf' was changed since bodyschema wrote it"):
        write_result(case.calibration, case.nominal, source, out, {}, True)
    assert edited.read_bytes().endswith(b"mine -->")


def test_a_result_of_an_earlier_version_is_known_by_its_names_and_its_record(
    case: Any, source: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    write_result(case.calibration, case.nominal, source, out, {}, False)
    (out / MANIFEST).unlink()
    (out / "overlay_0007.png").touch()
    assert is_earlier(out)
    for name in ("notes.txt", "overlay_x.png", "robot.urdf.bak"):
        (out / name).touch()
        assert not is_earlier(out)
        with pytest.raises(InputError, match="will not remove it"):
            check_place(out, True)
        (out / name).unlink()
    (out / "mask.png").mkdir()
    assert not is_earlier(out)
    (out / "mask.png").rmdir()
    check_place(out, True)
    record = (out / "run.json").read_text()
    for other in ("{}", "no json", '{"versions": {"other": "1"}}', '{"versions": 1}', "[]"):
        (out / "run.json").write_text(other)
        assert not is_earlier(out)
    (out / "run.json").write_text(record)
    write_result(case.calibration, case.nominal, source, out, {}, True)
    assert not (out / "overlay_0007.png").exists()


def test_somebody_elses_calibration_yaml_is_no_result(
    case: Any, source: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "calibration.yaml").write_text("camera: mine")
    (out / "robot.urdf").write_text("<robot/>")
    with pytest.raises(InputError, match=r"'calibration\.yaml', 'robot\.urdf', which is no result"):
        write_result(case.calibration, case.nominal, source, out, {}, True)
    assert (out / "calibration.yaml").read_text() == "camera: mine"


def test_another_name_of_an_input_is_that_input(tmp_path: Path) -> None:
    read, other = tmp_path / "in.urdf", tmp_path / "other.urdf"
    read.touch()
    other.hardlink_to(read)
    with pytest.raises(InputError, match="inputs are never touched"):
        refuse_inputs(other, [read])
    refuse_inputs(tmp_path / "third.urdf", [read])


def test_a_failure_leaves_nothing_behind(case: Any, source: Path, tmp_path: Path) -> None:
    source.write_bytes(case.source.replace(b"joint_2", b"joint_x"))
    with pytest.raises(InputError, match="no joint 'joint_x'"):
        write_result(case.calibration, case.nominal, source, tmp_path / "out", {}, False)
    assert [path.name for path in tmp_path.iterdir()] == ["in"]
