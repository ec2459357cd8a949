"""Calibrate an arm from positions of a marker, when nobody knows where tracker and marker sit.

python examples/01_calibrate_points.py
"""

from __future__ import annotations

import numpy as np

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.kinematics import relative_pose

rng = np.random.default_rng(1)

# The robot as its makers describe it: six joints, from "base" to "tip".
arm = bs.Body.random_chain(6, rng)

# The robot as it is: zeros off by a few degrees, a tracker in the room, a marker on the tip.
offsets = bs.free_joints(arm, ["offsets"])
truth = arm.with_variables(offsets, rng.normal(scale=np.deg2rad(3), size=6))
truth = truth.attach("tracker", "base", lie.transform(lie.exp_so3([0.3, -0.2, 1.1]), [0.8, 0.4, 1]))
truth = truth.attach("marker", "tip", lie.transform(np.eye(3), [0.02, 0.0, 0.05]))

# The recording: readings of the joints (rad), and where the tracker saw the marker (m).
q = rng.uniform(-1.5, 1.5, (60, 6))
seen = relative_pose(truth, q, "tracker", "marker")[:, :3, 3] + rng.normal(scale=5e-4, size=(60, 3))
seen[[7, 31]] += 0.1  # two wrong matches; nobody says which

# What is known: the arm's model, and on which links tracker and marker sit; "no" means unmeasured.
nominal = arm.attach("tracker", "base").attach("marker", "tip")
points = bs.Points.make(q, seen, seen_from="tracker", seen="marker")
answer = bs.calibrate(nominal, [points], frames={"tracker": "no", "marker": "no"})

print(answer.verdict + ":", answer.explanation)
print("outlier rows:", *answer.outliers)

print("\njoint       true   found     std  deg")
rows = zip(arm.joints, truth.offset, answer.body.offset, strict=True)
for name, true, found in rows:
    i = answer.estimate.variables.names.index(f"{name}.offset")
    told = answer.identifiability.open_share[i] <= 0.5
    std = f"{np.rad2deg(answer.estimate.std[i]):7.3f}" if told else "cannot be told"
    print(f"{name:8} {np.rad2deg(true):+7.3f} {np.rad2deg(found):+7.3f} {std}")
for sentence in answer.identifiability.sentences:
    print("-", sentence)

# Wrong zeros that cannot be told do no harm: their effects cancel in what the tracker sees.
new = rng.uniform(-1.5, 1.5, (1000, 6))
miss = relative_pose(answer.body, new, "tracker", "marker")[:, :3, 3]
miss = 1e3 * np.linalg.norm(miss - relative_pose(truth, new, "tracker", "marker")[:, :3, 3], axis=1)
promised = 1e3 * answer.predicted[0].position_overall
print(f"\nOn 1000 new postures 95 % of the errors are below {np.quantile(miss, 0.95):.2f} mm;")
print(f"predicted from the recording alone: {promised:.2f} mm.")
