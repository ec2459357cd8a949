"""Learn while the robot works: one sample at a time, and again after a joint has slipped.

A learner is a frozen object of settings; its state goes in and comes out. Half way joint 3 slips by
3 degrees. One learner never forgets, the other remembers about 50 samples.

python examples/03_online.py
"""

from __future__ import annotations

import numpy as np

import bodyschema as bs
from bodyschema.estimation.prediction import predict_error
from bodyschema.learners.learner import run
from bodyschema.model.kinematics import relative_pose

SAMPLES, EVERY = 600, 60
rng = np.random.default_rng(3)

nominal = bs.Body.random_chain(6, rng)
offsets = bs.free_joints(nominal, ["offsets"])
first = rng.normal(scale=0.05, size=6)
slipped = first + np.deg2rad([0, 0, 3, 0, 0, 0])
before, after = (nominal.with_variables(offsets, x) for x in (first, slipped))

# The stream: the tip, seen from the base with 2 mm of noise, at the readings q.
q = rng.uniform(-1.5, 1.5, (SAMPLES, 6))
half = SAMPLES // 2
tip = np.concatenate(
    [
        relative_pose(before, q[:half], "base", "tip")[:, :3, 3],
        relative_pose(after, q[half:], "base", "tip")[:, :3, 3],
    ]
)
stream = bs.Points.make(
    q, tip + rng.normal(scale=2e-3, size=tip.shape), seen_from="base", seen="tip", std=2e-3
)

work = rng.uniform(-1.5, 1.5, (40, 6))  # postures in which the robot is to be right


def errors(belief: bs.Estimate, truth: bs.Body) -> tuple[float, float]:
    """mm: 95 % of the errors at work stay below this, as predicted and in truth."""
    predicted = predict_error(belief, work, "base", "tip").position_overall
    there = relative_pose(belief.body, work, "base", "tip")[:, :3, 3]
    miss = np.linalg.norm(there - relative_pose(truth, work, "base", "tip")[:, :3, 3], axis=1)
    return 1e3 * predicted, 1e3 * float(np.quantile(miss, 0.95))


learners = {"never forgets": bs.Filter(), "forgets": bs.Filter(forgetting=0.98)}
runs = [run(learner, learner.start(nominal, offsets), [stream]) for learner in learners.values()]

print("95 % error at work in mm, predicted and true, and the estimate of joint_3.offset in deg\n")
print("        " + "".join(f"{name:^28}" for name in learners))
print("samples " + "  predicted    true  joint_3 " * len(learners))
for n, steps in enumerate(zip(*runs, strict=True), start=1):
    if n % EVERY:
        continue
    truth = before if n <= half else after
    row = ""
    for state, _ in steps:
        predicted, true = errors(state.estimate, truth)
        row += f"{predicted:11.2f} {true:7.2f} {np.rad2deg(state.x[2]):+8.2f} "
    print(f"{n:7} {row}")
    if n == half:
        print("        joint_3 slips: its offset is now", f"{np.rad2deg(slipped[2]):+.2f} deg")

print("""
Who never forgets is surest while nothing changes, and far too sure afterwards. Who forgets pays
with a wider error bar and comes back, but not at once: at first the change looks like outliers and
noise, and the predicted error is too small. To notice a change quickly, test for it:
bodyschema.monitoring.change, or `bodyschema check`.""")
