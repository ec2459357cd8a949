"""A torso that watches its hand and its elbow: what the tests of unknown skeletons share."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kinematics import relative_pose
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

TORSO = """
name = "torso"
root = "pelvis"

[joints]
neck = "pelvis"
shoulder = "pelvis"
upper_arm = "shoulder"

[markers]
hand = "upper_arm"
elbow = "shoulder"

[camera]
name = "eye"
parent = "neck"
"""

NOISE = 1e-3
"""m."""


def arrangement(folder: Path) -> Path:
    """The file of the torso."""
    path = folder / "torso.toml"
    path.write_text(TORSO)
    return path


def true_torso(path: Path, rng: np.random.Generator) -> Body:
    """The torso with random axes and links of about 0.3 m."""
    body = Body.from_arrangement(path)
    bare = Skeleton.of(body)
    axes = rng.normal(size=bare.axes.shape)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    links = rng.normal(size=bare.links.shape)
    links *= 0.3 / np.linalg.norm(links, axis=1, keepdims=True)
    links[0] = 0.0
    return replace(bare, axes=axes, links=links).into(body)


def watched(truth: Body, n: int, rng: np.random.Generator) -> list[Points]:
    """Hand and elbow seen from the eye in n postures; the elbow in every other one."""
    q = rng.uniform(-1.5, 1.5, (n, len(truth.joints)))
    senses = []
    for marker, step in (("hand", 1), ("elbow", 2)):
        rows = np.arange(0, n, step)
        place = relative_pose(truth, q[rows], "eye", marker)[:, :3, 3]
        seen = place + rng.normal(scale=NOISE, size=place.shape)
        senses.append(Points.make(q[rows], seen, "eye", marker, time=1.0 * rows, rows=rows))
    return senses


def write_recording(path: Path, truth: Body, senses: list[Points]) -> None:
    """A table of joints and markers, empty where a marker was not seen."""
    n = len(senses[0])
    columns: dict[str, Array] = {joint: senses[0].q[:, j] for j, joint in enumerate(truth.joints)}
    for sense in senses:
        for c, axis in enumerate("xyz"):
            column = np.full(n, np.nan)
            column[sense.rows] = sense.position[:, c]
            columns[f"{sense.seen}_{axis}"] = column
    write_table(path, columns)
