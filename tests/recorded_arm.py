"""An arm whose second joint is off by 0.05 rad, and a recording of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bodyschema import Body
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import write_table

RUN = """
robot = "robot.urdf"
recording = "data.csv"
folds = 3
[free]
groups = ["offsets"]
[frames.tracker]
parent = "base"
[frames.marker]
parent = "tip"
[[senses]]
kind = "points"
seen_from = "tracker"
seen = "marker"
columns = ["x", "y", "z"]
"""


def recorded_arm(folder: Path) -> Path:
    """Write its URDF, the recording and a run file; the path of the last."""
    rng = np.random.default_rng(3)
    arm = Body.random_chain(3, rng)
    q = rng.uniform(-1.2, 1.2, (25, 3))
    body = arm.attach("tracker", "base").attach("marker", "tip")
    seen = relative_pose(body, np.add(q, [0.0, 0.05, 0.0]), "tracker", "marker")[:, :3, 3]
    seen += 1e-3 * rng.normal(size=seen.shape)
    columns = dict(zip([*arm.joints, *"xyz"], np.hstack([q, seen]).T, strict=True))
    write_table(folder / "data.csv", columns)
    (folder / "robot.urdf").write_bytes(write_urdf(arm))
    (folder / "run.toml").write_text(RUN)
    return folder / "run.toml"
