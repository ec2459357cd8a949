"""Seeds of robots in other forms, lens files, calibrations of motors, and bags that break off."""

from __future__ import annotations

import json
from pathlib import Path

from fuzzing import seeds

MJCF = """<mujoco model="arm"><compiler angle="degree"/><default><geom rgba="1 0 0 1"/></default>
<asset><mesh name="part" file="part.stl" scale="1 1 1"/></asset><worldbody>
<camera name="eye" pos="1 0 1" euler="10 20 30"/><body name="base" pos="0 0 0.3" euler="5 -10 20">
<geom type="box" size="0.1 0.2 0.3"/><body name="upper" pos="0.1 0.2 0.3" quat="0.9 0.1 0.3 -0.2">
<joint name="yaw" axis="0 0 1" ref="20" range="-90 90"/>
<joint name="pitch" axis="0 1 1" pos="0 0.05 0.1" ref="-35"/><geom type="sphere" size="0.1"/>
<body name="fore" pos="0.4 0 0"><joint name="slide" type="slide" axis="1 0 1" range="-1 1"/>
<geom type="mesh" mesh="part"/><site name="tool" pos="0 0 0.1" euler="0 90 0"/>
<body name="thumb"><joint name="thumb" axis="1 0 0"/><geom type="capsule" size="0.02 0.1"/></body>
</body></body></body></worldbody>
<equality><joint joint1="thumb" joint2="pitch" polycoef="0.1 -2 0 0 0"/></equality></mujoco>"""
BRANCHES = """name = "two arms"
convention = "modified"
unit = "mm"
angle_unit = "deg"
[[joint]]
name = "waist"
d = 400.0
[[joint]]
name = "left"
parent = "waist"
xyz = [0.0, 200.0, 0.0]
alpha = -90.0
[[joint]]
name = "right"
parent = "link_1"
rpy = [0.0, 0.1, 0.0]
type = "prismatic"
limits = [-1.0, 1.0]
tool = [0.0, 0.0, 50.0]
"""
SCREWS = """name = "two"
form = "{}"
[[joint]]
name = "j1"
screw = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
limits = [-2.0, 2.0]
[[joint]]
name = "j2"
axis = [0.0, 1.0, 0.0]
point = [0.0, 0.0, 0.4]
parent = "j1"
[[joint]]
axis = [1.0, 0.0, 0.0]
type = "prismatic"
[[frame]]
name = "tool"
joint = "joint_3"
"""
AT = ('xyz = [0.6, 0.0, 0.4]\nrpy = [0.0, 0.1, 0.0]\n',
      "matrix = [[1.0, 0.0, 0.0, 0.6], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.4], "
      "[0.0, 0.0, 0.0, 1.0]]\n")  # fmt: skip
CELL = """name = "cell"
[[robot]]
description = "branches.toml"
[[robot]]
description = "boxes.urdf"
parent = "flange_left"
prefix = "left_"
xyz = [0.0, 0.0, 0.02]
rpy = [0.0, 0.0, 1.57]
[packages]
arm = "."
"""
ROS = """image_width: 640
image_height: 480
camera_name: eye
camera_matrix:
  rows: 3
  cols: 3
  data: [615.5, 0, 320.25, 0, 616.5, 241.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 1e-05, 0.002, 0]}
binning_x: 0
roi: {x_offset: 0, y_offset: 0}
"""
KALIBR = """cam0:
  camera_model: pinhole
  distortion_coeffs: [0.1, 0.02, -0.003, 0.0004]
  distortion_model: equidistant
  intrinsics: [461.0, 460.0, 363.0, 248.0]
  resolution: [752, 480]
cam1:
  distortion_coeffs: [0.1, 0.02, -0.003, 0.0004]
  distortion_model: radtan
  intrinsics: [461.0, 460.0, 363.0, 248.0]
  resolution: [752, 480]
"""
MATRIX = '{} type_id="opencv-matrix"><rows>{}</rows><cols>{}</cols><dt>d</dt><data>{}</data>'
OPENCV = (
    '<?xml version="1.0"?><opencv_storage><image_width>640</image_width>'
    "<image_height>480</image_height>"
    f"<{MATRIX.format('camera_matrix', 3, 3, '615.5 0. 320. 0. 616.5 241. 0. 0. 1.')}"
    "</camera_matrix>"
    f"<{MATRIX.format('distortion_coefficients', 5, 1, '0.1 -0.2 1e-05 0.002 0.')}"
    "</distortion_coefficients></opencv_storage>"
)
MARKED = """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 615.5, 0., 320., 0., 616.5, 241., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ 0.1, 0.01, 0.001, 0. ]
fisheye_model: 1
"""
CELLS = {"homing_offset": -514, "range_min": 901, "range_max": 3091}


def robots(folder: Path) -> None:
    """An MJCF with a mesh; joint tables with branches, screws in both forms, and a cell."""
    import mujoco  # noqa: F401  here, as its windows ask for their version in a process

    seeds.described(folder)
    (folder / "arm.xml").write_text(MJCF)
    (folder / "branches.toml").write_text(BRANCHES)
    for form, at in zip(("space", "body"), AT, strict=True):
        (folder / f"{form}.toml").write_text(SCREWS.format(form) + at)
    (folder / "cell.toml").write_text(CELL)


def lenses(folder: Path) -> None:
    """One lens as ROS, OpenCV and Kalibr write it."""
    (folder / "ros.yaml").write_text(ROS)
    (folder / "kalibr.yaml").write_text(KALIBR)
    (folder / "marked.yml").write_text(MARKED)
    (folder / "opencv.xml").write_text(OPENCV)
    matrix = {"rows": 3, "cols": 3, "data": [615.5, 0, 320.25, 0, 616.5, 241.75, 0, 0, 1]}
    bent = {"rows": 1, "cols": 8, "data": [0.1, 0.2, 0.0, 0.0, 0.1, 0.1, 0.01, 0.001]}
    lens = {"image_width": 640, "image_height": 480, "cameraMatrix": matrix, "dist_coeffs": bent}
    (folder / "lens.json").write_text(json.dumps(lens))


def motors(folder: Path) -> None:
    """LeRobot's calibration file of two motors and a gripper."""
    named = enumerate(("shoulder_pan", "elbow_flex", "gripper"), start=1)
    table = {name: {"id": i, "drive_mode": i % 2, **CELLS} for i, name in named}
    (folder / "motors.json").write_text(json.dumps(table, indent=4))


def cut_bags(folder: Path) -> None:
    """MCAP files, packed and not, with and without chunks, still whole: mutations cut them."""
    from rosbags.typesys import Stores, get_typestore

    seeds.bags(folder)
    (whole,) = (folder / "mcap").glob("*.mcap")
    (folder / "one.mcap").write_bytes(whole.read_bytes())
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer(folder / "packed", version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        seeds._states(writer, store, store.serialize_cdr)
    (packed,) = (folder / "packed").glob("*.mcap")
    (folder / "two.mcap").write_bytes(packed.read_bytes())
