"""What people have goes in: forms of recordings, large bags, clocks.

    python benchmarks/inputs.py [--parts forms bags clocks] [--gigabytes 1] [--seeds 8] [--json]

forms   one recording of an arm by writers that are not ours; "same" is whether the whole answer of
        `calibrate` is that of CSV to the last digit ("apart" the largest difference, SI). Writers
        that are not installed are run by the Python of ROS or another, whose packages lie in
        BODYSCHEMA_ROS1 and BODYSCHEMA_MCAP (folders with ":" between them).
bags    a bag with pictures of 0.9 MB among joint states at 500 Hz: all joint states are read.
        "mb_per_s" counts the bag's whole size over processor time, "peak_mb" is the resident size
        of a process that does only that, "start_mb" the same before it reads.
clocks  joints at 100 Hz and poses at 30 Hz on clocks of their own, slow (0.1 rad/s) and brisk (1
        rad/s): share of lags within 95 % of what is stated, and the usual error.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import Body, lie
from bodyschema.cli import run as command
from bodyschema.cli.loading import load
from bodyschema.cli.run_file import read_run_file
from bodyschema.estimation.problem import Problem, moved_joints
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import write_table
from input_writers import BOARD, FORMS, JOINTS, POSE

Array = NDArray[np.float64]

ARM = Body.random_chain(6, np.random.default_rng(3))
ZEROS = np.deg2rad([0.0, 2.0, -3.0, 1.5, -2.5, 0.0])
STD = np.array([5e-4] * 3 + [1e-3] * 3)
LAGS = (0.0, 0.05, 0.2, 0.5)

RUN = """
robot = "robot.urdf"
recording = {recording}
{more}
[frames.board]
parent = "base"
[frames.camera]
parent = "tip"
[[senses]]
kind = "poses"
seen_from = "board"
seen = "camera"
layout = "xyz_xyzw"
columns = {columns}
"""


def seen(q: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Columns of the camera's poses in the board, with noise."""
    board = lie.transform(lie.exp_so3([0.1, 0.2, -0.3]), [0.5, 0.1, 0.2])
    camera = lie.transform(lie.exp_so3([0.0, 0.1, 0.2]), [0.02, 0.0, 0.05])
    true = ARM.attach("board", "base", board).attach("camera", "tip", camera)
    T, e = relative_pose(true, q + ZEROS, "board", "camera"), rng.normal(size=(len(q), 6)) * STD
    turned = T[:, :3, :3] @ lie.exp_so3(e[:, 3:])
    values = np.hstack([T[:, :3, 3] + e[:, :3], lie.quaternion_xyzw(turned)])
    return dict(zip(POSE, values.T, strict=True))


def write_run(folder: Path, recording: Any, columns: list[str], more: str = "") -> Path:
    (folder / "robot.urdf").write_bytes(write_urdf(ARM))
    text = RUN.format(recording=json.dumps(recording), columns=json.dumps(columns), more=more)
    (folder / "run.toml").write_text(text)
    return folder / "run.toml"


def forms(rows: int) -> Iterator[dict[str, Any]]:
    """A row a form."""
    rng = np.random.default_rng(0)
    q = rng.uniform(-1.2, 1.2, (rows, 6))
    columns = {**dict(zip(ARM.joints, q.T, strict=True))}
    columns = {
        k: v.astype(np.float32).astype(float) for k, v in {**columns, **seen(q, rng)}.items()
    }
    expected: dict[str, float] = {}
    for form, write in FORMS.items():
        if write is None:
            yield {"form": form, "same": None, "apart": None}
            continue
        with tempfile.TemporaryDirectory() as place:
            found = _answer(Path(place), form, write(columns, Path(place)))
        expected = expected or found
        apart = max(abs(found[name] - value) for name, value in expected.items())
        yield {"form": form, "same": found == expected, "apart": apart}


def _answer(folder: Path, form: str, recording: list[str]) -> dict[str, float]:
    """Every number of an answer."""
    of_set = form.startswith("lerobot")
    names = {joint: f"{joint}.pos" for joint in ARM.joints} if of_set else {}
    joints = "[joints.columns]\n" + "".join(f'{j} = "{c}"\n' for j, c in names.items())
    seen_as = [f"{BOARD}.{name}" for name in POSE] if of_set else list(POSE)
    path = write_run(folder, recording, seen_as, joints if of_set else "")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        command(["calibrate", str(path), "--out", str(folder / "out"), "--json"])
    answer = json.loads(said.getvalue())
    numbers = {f"{p['name']}": p["value"] for p in answer["parameters"]}
    numbers |= {f"{p['name']} std": p["std"] or 0.0 for p in answer["parameters"]}
    return numbers | {"rms": answer["held_out"]["position_mm"]["rms"],
                      "stated": answer["predicted_95_mm"]}  # fmt: skip


READ = """
import json, re, sys, time
from bodyschema.sources.bags import read_bag
import rosbags.highlevel
# Not ru_maxrss, in which the parent's size lives on.
at = lambda: int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1e3
before, begun = at(), time.process_time()
table = read_bag(sys.argv[1])
print(json.dumps([len(table), time.process_time() - begun, before, at()]))
"""


def bags(gigabytes: float) -> Iterator[dict[str, Any]]:
    """A row a kind of bag."""
    for form in ("ros1", "sqlite3", "mcap"):
        with tempfile.TemporaryDirectory() as place:
            bag, messages = _large(Path(place), form, gigabytes * 1e9)
            files = bag.rglob("*") if bag.is_dir() else [bag]
            size = sum(file.stat().st_size for file in files if file.is_file()) / 1e6
            asked = [sys.executable, "-c", READ, f"{bag}#{JOINTS}"]
            done = subprocess.run(asked, check=True, capture_output=True, text=True)
        count, seconds, start, peak = json.loads(done.stdout)
        assert count == messages
        yield {"bag": form, "mb": size, "joint_states": count, "mb_per_s": size / seconds,
               "start_mb": start, "peak_mb": peak}  # fmt: skip


def _large(folder: Path, form: str, size: float) -> tuple[Path, int]:
    """A bag of about so many bytes, and how many joint states it has."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    first = form == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    types: Any = store.types
    place = folder / ("large.bag" if first else "large")
    plugin = StoragePlugin.MCAP if form == "mcap" else StoragePlugin.SQLITE3
    opened = Writer1(place) if first else Writer(place, version=9, storage_plugin=plugin)
    pack = store.serialize_ros1 if first else store.serialize_cdr
    picture, none = np.zeros(480 * 640 * 3, dtype=np.uint8), np.zeros(0)
    count = 0
    with opened as writer:
        topics = {
            kind: writer.add_connection(topic, kind, typestore=store)
            for topic, kind in ((JOINTS, "sensor_msgs/msg/JointState"),
                                ("/camera", "sensor_msgs/msg/Image"))
        }  # fmt: skip
        for frame in range(int(size / 930_000)):
            for k in range(17):
                ns = frame * 33_333_333 + k * 1_960_000
                stamp = types["builtin_interfaces/msg/Time"](
                    sec=1 + ns // 10**9, nanosec=ns % 10**9
                )
                header = types["std_msgs/msg/Header"](**({"seq": 0} if first else {}), stamp=stamp,
                                                      frame_id="")  # fmt: skip
                q = np.full(6, float(count))
                kind = "sensor_msgs/msg/JointState"
                state = types[kind](header, list(ARM.joints), q, none, none)
                writer.write(topics[kind], 10**9 + ns, pack(state, kind))
                count += 1
            kind = "sensor_msgs/msg/Image"
            image = types[kind](header, 480, 640, "rgb8", 0, 1920, picture)
            writer.write(topics[kind], 10**9 + ns, pack(image, kind))
    return place, count


def motion(at: Array, speed: float) -> Array:
    """(n, 6) rad: a sum of swings in every joint, of so much rad/s at the usual time."""
    periods = np.array([7.0, 5.3, 4.1, 6.2, 3.7, 5.9]) * (0.6 / speed)
    phases = np.arange(6.0)
    slow = 0.8 * np.sin(2 * np.pi * at[:, None] / periods + phases)
    return np.asarray(slow + 0.2 * np.sin(2 * np.pi * at[:, None] / (0.41 * periods) + 2 * phases))


def clocks(seeds: int) -> Iterator[dict[str, Any]]:
    """A row a lag and speed."""
    for speed in (0.1, 1.0):
        for lag in LAGS:
            begin = round(1e4 * lag)  # no two lags share their noise
            found = (_lag(lag, speed, begin + seed) for seed in range(seeds))
            errors, stds = zip(*found, strict=True)
            within = np.abs(errors) < 1.96 * np.array(stds)
            yield {"lag_ms": 1e3 * lag, "rad_per_s": speed, "within_95": float(within.mean()),
                   "error_ms": 1e3 * float(np.median(np.abs(errors))),
                   "stated_std_ms": 1e3 * float(np.median(stds))}  # fmt: skip


def _lag(lag: float, speed: float, seed: int) -> tuple[float, float]:
    """Error of a lag and its standard deviation, s."""
    rng = np.random.default_rng(seed)
    begin = rng.uniform(0, 100)
    joints, eye = begin + np.arange(0, 40, 1 / 100), begin + np.arange(0.5, 39, 1 / 30)
    q = motion(joints, speed) + 1e-4 * rng.normal(size=(len(joints), 6))
    with tempfile.TemporaryDirectory() as place:
        here = Path(place)
        write_table(
            here / "joints.csv", {"time": joints, **dict(zip(ARM.joints, q.T, strict=True))}
        )
        write_table(here / "poses.csv", {"time": eye + lag, **seen(motion(eye, speed), rng)})
        path = write_run(here, ["joints.csv", "poses.csv"], list(POSE), 'join = "time"')
        loaded = load(read_run_file(path))
    moved = moved_joints(loaded.body, loaded.senses)
    problem = Problem(loaded.body, loaded.senses, loaded.frames, moved, parts=loaded.parts)
    fit = problem.fit(problem.variables(("offsets",)), problem.senses)
    (row,) = [i for i, name in enumerate(fit.variables.names) if name.endswith(".lag")]
    part = fit.body.part("clock_of_poses")
    return part["joined"] + part["lag"] - lag, float(fit.std[row])


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", nargs="+", default=["forms", "bags", "clocks"])
    parser.add_argument("--gigabytes", type=float, default=0.1)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    made = {"forms": lambda: forms(40), "bags": lambda: bags(asked.gigabytes),
            "clocks": lambda: clocks(asked.seeds)}  # fmt: skip
    found: dict[str, Any] = {}
    begun = time.process_time()
    for part in asked.parts:
        found[part] = []
        for row in made[part]():
            found[part].append(row)
            if not asked.json:
                print({k: float(f"{v:.4g}") if isinstance(v, float) else v for k, v in row.items()})
    found["processor_s"] = time.process_time() - begun
    if asked.json:
        print(json.dumps(found))


if __name__ == "__main__":
    main()
