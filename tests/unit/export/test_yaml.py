"""The YAML files: what people and programs read in them is what was found."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bodyschema import lie
from bodyschema.estimation.identifiability import Identifiability, OpenDirection
from bodyschema.export.calibration_yaml import calibration_document, calibration_text
from bodyschema.export.documents import plain, rounded, yaml_text
from bodyschema.export.kinematics_yaml import kinematics_document, kinematics_text
from bodyschema.export.static_transforms import (
    estimated_frames,
    publisher_command,
    transforms_document,
    transforms_text,
)
from bodyschema.export.urdf_edits import described
from bodyschema.judging.settled import settled
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf

Difference = Callable[[Body, Body], float]

# ---- calibration.yaml ------------------------------------------------------------------------


def test_the_text_reads_back_as_the_document(case: Any) -> None:
    text = calibration_text(case.calibration, ["a note: with a colon"])
    document = calibration_document(case.calibration, ["a note: with a colon"])
    assert yaml.safe_load(text) == document
    assert list(yaml.safe_load(text)) == list(document)
    assert text.startswith("# What a calibration found")
    assert calibration_text(case.calibration, ["a note: with a colon"]) == text


def test_what_was_found_is_in_it(case: Any) -> None:
    document = calibration_document(case.calibration)
    assert document["verdict"] == "calibrated"
    assert list(document["offsets"]) == ["joint_1", "joint_2", "joint_3", "joint_4"]
    found = np.array(list(document["offsets"].values()))
    assert found == pytest.approx(settled(case.calibration).body.offset, abs=1e-9)
    assert found == pytest.approx(case.calibration.body.offset, abs=1e-3)
    assert [entry["name"] for entry in document["transforms"]] == ["T_base_camera", "T_tip_marker"]
    before, after = (document["held_out"][when]["position_mm"] for when in ("before", "after"))
    assert 0.05 < after["rms"] < 0.5 < before["rms"]
    assert document["held_out"]["after"]["rotation_deg"] is None
    assert document["noise"] == {"marker seen from camera: position (m)": pytest.approx(1e-4, 0.3)}
    assert document["rows"] == 40
    assert document["versions"].keys() == {"python", "bodyschema", "numpy", "scipy", "numba"}


def test_each_parameter_has_its_row(case: Any) -> None:
    rows = calibration_document(case.calibration)["parameters"]
    estimate = case.calibration.estimate
    assert [row["name"] for row in rows] == list(estimate.variables.names)
    assert list(rows[1]) == [
        "name", "value", "std", "written", "written_std", "unit", "prior_std", "group",
        "identifiable", "combined_with",
    ]  # fmt: skip
    assert (rows[1]["name"], rows[1]["unit"], rows[1]["prior_std"]) == (
        "joint_2.offset",
        "rad",
        0.1,
    )
    assert rows[1]["value"] == pytest.approx(estimate.x[1], rel=1e-8)
    assert rows[1]["std"] == pytest.approx(estimate.std[1], rel=1e-8)
    # An unknown camera on the base of the first joint hides that joint's offset.
    assert rows[0]["identifiable"] is False
    assert rows[0]["std"] is None
    assert (rows[0]["written"], rows[0]["written_std"]) == (0.0, None)
    assert rows[1]["written"] == pytest.approx(estimate.x[1], abs=2 * estimate.std[1])
    assert 0 < rows[1]["written_std"] <= case.calibration.widened.std[1] * (1 + 1e-8)
    assert "camera.turn_y" in rows[0]["combined_with"]


def test_a_parameter_that_is_half_open_is_determined(case: Any) -> None:
    calibration, n = case.calibration, len(case.calibration.estimate.variables)
    shares = np.where(np.arange(n) == 2, 0.51, 0.5)
    direction = OpenDirection(("joint_3.offset", "joint_2.offset"), True, "cannot be told.")
    known = Identifiability(n - 1, (direction,), shares)
    document = calibration_document(replace(calibration, identifiability=known))
    assert [row["name"] for row in document["parameters"] if row["std"] is None] == [
        "joint_3.offset"
    ]
    assert document["parameters"][2]["combined_with"] == ["joint_2.offset"]
    assert document["not_determined"] == ["cannot be told."]


# ---- plain values ----------------------------------------------------------------------------


def test_numbers_are_rounded_to_significant_digits() -> None:
    assert rounded(0.12345678912345) == 0.123456789
    assert rounded(-1.2345678949e-7) == -1.23456789e-7
    assert str(rounded(-0.0)) == "0.0"
    assert rounded(float("nan")) is None
    assert rounded(None) is None


def test_plain_values() -> None:
    mixed = {"p": Path("a/b"), "q": np.arange(2), 3: (np.float64("inf"), True, None, np.int64(4))}
    assert plain(mixed) == {"p": "a/b", "q": [0, 1], "3": [None, True, None, 4]}
    with pytest.raises(TypeError, match="cannot write a set"):
        plain({1})


def test_yaml_is_laid_out_for_people() -> None:
    shared = [1.0, 2.0]
    document = {
        "b": shared,
        "a": shared,
        "none": [],
        "names": ["on", "x.y", "1"],
        "text": ["a sentence with: a colon, and more than eighty characters so that folding shows"],
        "tiny": 1e-5,
    }
    assert yaml_text(document, "first\n\nsecond") == (
        "# first\n#\n# second\n\n"
        "b: [1.0, 2.0]\na: [1.0, 2.0]\nnone: []\nnames: ['on', x.y, '1']\n"
        "text:\n- 'a sentence with: a colon, and more than eighty characters so that folding shows'"
        "\ntiny: 1.0e-05\n"
    )
    assert yaml.safe_load(yaml_text(document, "")) == document


# ---- kinematics.yaml -------------------------------------------------------------------------


def test_kinematics_are_the_joint_frames_with_the_offsets_inside(
    robot: bytes, worst_pose: Difference
) -> None:
    nominal = parse_urdf(robot, Path("robot.urdf"), {})
    body = replace(nominal, offset=np.array([0.01, 0.2, -0.3, 0.004]))
    joints = yaml.safe_load(kinematics_text(body))["kinematics"]
    assert list(joints) == list(body.carriers[1:])
    assert joints["mount_joint"].keys() == {"x", "y", "z", "roll", "pitch", "yaw"}
    assert [joints[name]["offset"] for name in ("rail", "finger_r", "wheel")] == [
        0.01, -0.008, -0.056,
    ]  # fmt: skip
    placement = nominal.placement.copy()
    axis = nominal.axis.copy()
    for k, name in enumerate(body.carriers[1:], start=1):
        entry = joints[name]
        rpy = lie.rotation_from_rpy([entry["roll"], entry["pitch"], entry["yaw"]])
        placement[k] = lie.transform(rpy, [entry["x"], entry["y"], entry["z"]])
        axis[k] = list(entry["axis"].values()) if "axis" in entry else axis[k]
    assert worst_pose(replace(nominal, placement=placement, axis=axis), body) < 1e-12


def test_xacro_loads_the_kinematics(case: Any, tmp_path: Path, worst_pose: Difference) -> None:
    pytest.importorskip("xacro")
    body = described(case.nominal, case.calibration.body)
    (tmp_path / "kinematics.yaml").write_text(kinematics_text(body))
    links = "".join(f'<link name="{frame}"/>' for frame in body.frames)
    joints = "".join(
        f'<joint name="{name}" type="{"continuous" if body.kind[k] else "fixed"}">'
        f"<parent link='{body.frames[k - 1]}'/><child link='{body.frames[k]}'/>"
        f'<xacro:property name="j" value="${{k[\'{name}\']}}"/>'
        "<origin xyz=\"${j['x']} ${j['y']} ${j['z']}\""
        " rpy=\"${j['roll']} ${j['pitch']} ${j['yaw']}\"/>"
        + ('<axis xyz="${j.axis.x} ${j.axis.y} ${j.axis.z}"/>' if body.kind[k] else "")
        + "</joint>"
        for k, name in enumerate(body.carriers)
        if k
    )
    path = tmp_path / "arm.xacro"
    path.write_text(
        '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="k"'
        f" value=\"${{load_yaml('{tmp_path}/kinematics.yaml')['kinematics']}}\"/>{links}{joints}"
        "</robot>"
    )
    # In a process of its own: xacro reads its options from global state.
    script = "import sys, xacro; print(xacro.process_file(sys.argv[1]).toxml())"
    expanded = subprocess.run([sys.executable, "-c", script, path], capture_output=True, check=True)
    assert worst_pose(parse_urdf(expanded.stdout, path, {}), body) < 1e-9


# ---- transforms.yaml -------------------------------------------------------------------------


def test_estimated_frames_can_be_published(case: Any) -> None:
    assert estimated_frames(case.calibration.estimate.variables) == ("camera", "marker")
    camera, marker = yaml.safe_load(transforms_text(case.calibration, case.nominal))["transforms"]
    assert (camera["parent"], camera["child"]) == ("base", "camera")
    assert (marker["parent"], marker["child"]) == ("tip", "marker")
    assert camera["rotation_estimated"] is True
    assert marker["rotation_estimated"] is False
    body = settled(case.calibration).body
    T = body.placement[body.frame_index("camera")]
    assert camera["xyz"] == pytest.approx(T[:3, 3], abs=1e-11)
    rotation = lie.rotation_from_xyzw(camera["quaternion_xyzw"])
    assert rotation == pytest.approx(T[:3, :3], abs=1e-11)
    assert lie.rotation_from_rpy(camera["rpy"]) == pytest.approx(T[:3, :3], abs=1e-11)


def test_the_command_says_the_same_as_the_numbers(case: Any) -> None:
    entry = transforms_document(case.calibration, case.nominal)["transforms"][0]
    words = shlex.split(entry["command"])
    assert words[:4] == ["ros2", "run", "tf2_ros", "static_transform_publisher"]
    given = dict(zip(words[4::2], words[5::2], strict=True))
    numbers = [float(given[f"--{name}"]) for name in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    assert numbers == entry["xyz"] + entry["quaternion_xyzw"]
    assert (given["--frame-id"], given["--child-frame-id"]) == ("base", "camera")


def test_names_are_quoted_for_the_shell() -> None:
    command = publisher_command("my base", "a;b", [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    assert command.endswith("--qw 1.0 --frame-id 'my base' --child-frame-id 'a;b'")


def test_frames_of_the_description_are_left_to_it(case: Any) -> None:
    described_too = case.nominal.attach("camera", "base")
    (only,) = transforms_document(case.calibration, described_too)["transforms"]
    assert only["child"] == "marker"


def test_kinematics_of_a_root_alone() -> None:
    body = Body.build("stone", ["stone"], [""], [-1], [0], [[0, 0, 1]], [np.eye(4)])
    assert kinematics_document(body) == {"kinematics": {}}
