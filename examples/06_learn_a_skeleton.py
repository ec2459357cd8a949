"""Learn a robot that has no description: from which joint hangs on which, and 60 postures.

A torso with a camera on its neck watches its own hand. The learner is given the arrangement and
a recording; it finds axes and links of all joints and writes a URDF.

python examples/06_learn_a_skeleton.py
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import bodyschema as bs
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.skeleton import Skeleton

POSTURES, NOISE = 60, 2e-3

ARRANGEMENT = """
name = "torso"
root = "pelvis"

[joints]
neck = "pelvis"
shoulder = "pelvis"
upper_arm = "shoulder"
elbow = "upper_arm"

[markers]
hand = "elbow"

[camera]
name = "eye"
parent = "neck"
"""

rng = np.random.default_rng(6)
folder = Path(tempfile.mkdtemp())
(folder / "torso.toml").write_text(ARRANGEMENT)
unknown = bs.Body.from_arrangement(folder / "torso.toml")

# The robot as it is, which the learner never sees.
axes = {"neck": [0, 0, 1], "shoulder": [0, 1, 0], "upper_arm": [1, 0, 0], "elbow": [0, 1, 0]}
links = {
    "neck_link": [0.02, 0.0, 0.45], "shoulder_link": [0.0, 0.18, 0.38], "hand": [0.03, 0.0, -0.24],
    "upper_arm_link": [0.0, 0.03, 0.0], "elbow_link": [0.0, 0.02, -0.26], "eye": [0.08, 0.03, 0.1],
}  # fmt: skip
bare = Skeleton.of(unknown)
true_axes, true_links = bare.axes.copy(), bare.links.copy()
for joint, axis in axes.items():
    true_axes[unknown.frame_index(f"{joint}_link")] = axis
for frame, link in links.items():
    true_links[unknown.frame_index(frame)] = link
truth = replace(bare, axes=true_axes, links=true_links).into(unknown)


def hand_seen(body: bs.Body, q: np.ndarray) -> np.ndarray:
    """Where the eye sees the hand, (n, 3) m."""
    return relative_pose(body, q, "eye", "hand")[:, :3, 3]


q = rng.uniform(-1.2, 1.2, (POSTURES, len(unknown.joints)))
seen = hand_seen(truth, q) + rng.normal(scale=NOISE, size=(POSTURES, 3))
seen[::15] += 0.3  # four postures in which something else was taken for the hand

answer = bs.learn_skeleton(unknown, [bs.Points.make(q, seen, seen_from="eye", seen="hand")])
print(answer.verdict, "-", answer.explanation)
print(f"wrong postures found: {list(answer.outliers)}\n")

print("joint       true axis            learned axis         off by")
learned, names = Skeleton.of(answer.body), unknown.frames
for joint in unknown.joints:
    k = unknown.frame_index(f"{joint}_link")
    a, b = true_axes[k], learned.axes[k]
    angle = np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    shown = [" ".join(f"{c:+.2f}" for c in axis) for axis in (a, b)]
    print(f"{joint:11} {shown[0]:20} {shown[1]:20} {angle:5.2f} deg")

fresh = rng.uniform(-1.2, 1.2, (1000, len(unknown.joints)))
miss = np.linalg.norm(hand_seen(answer.body, fresh) - hand_seen(truth, fresh), axis=1)
print(f"\nhand in 1000 new postures: {1e3 * np.sqrt(np.mean(miss**2)):.2f} mm rms off")
print(f"from points with {1e3 * NOISE:.0f} mm of noise a coordinate; the arm is 0.5 m long\n")

print("No motion tells:")
for sentence in answer.identifiability.sentences:
    print(" -", sentence)

(folder / "torso.urdf").write_bytes(write_urdf(answer.body))
print(f"\nwritten: {folder / 'torso.urdf'}")
print("The same from the command line: bodyschema calibrate --skeleton torso.toml --recording ...")
