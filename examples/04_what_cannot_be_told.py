"""What a recording cannot tell, in words, and three ways to close it: move, look, measure.

python examples/04_what_cannot_be_told.py
"""

from __future__ import annotations

import numpy as np

import bodyschema as bs
from bodyschema import lie
from bodyschema.acting.next_poses import plan_poses
from bodyschema.model.kinematics import relative_pose

rng = np.random.default_rng(4)

# A marker sits on the last axis: turning joint 5 does not move it.
arm = bs.Body.random_chain(5, rng)
on_axis = lie.transform(np.eye(3), 0.08 * arm.axis[arm.frame_index("link_5")])
nominal = arm.attach("marker", "link_5", on_axis).attach("tracker", "base")
zeros = bs.free_joints(nominal, ["offsets"])
truth = nominal.with_variables(zeros, rng.normal(scale=0.04, size=5))
truth = truth.with_placement("tracker", lie.transform(lie.exp_so3([0.2, 0.1, 0.7]), [0.6, 0, 0.3]))


def points(q: np.ndarray) -> bs.Points:
    """Positions of the marker, with 0.5 mm of noise."""
    position = relative_pose(truth, q, "tracker", "marker")[:, :3, 3]
    return bs.Points.make(
        q, position + rng.normal(scale=5e-4, size=(len(q), 3)), "tracker", "marker"
    )


def poses(q: np.ndarray) -> bs.Poses:
    """The same with the marker's orientation, with 3 mrad of noise."""
    pose = relative_pose(truth, q, "tracker", "marker")
    pose[:, :3, 3] += rng.normal(scale=5e-4, size=(len(q), 3))
    pose[:, :3, :3] = lie.exp_so3(rng.normal(scale=3e-3, size=(len(q), 3))) @ pose[:, :3, :3]
    return bs.Poses.make(q, pose, "tracker", "marker")


def tell(title: str, body: bs.Body, sense: bs.Points | bs.Poses, frames: dict) -> bs.Answer:
    """Calibrate the zeros and say what stays open."""
    answer = bs.calibrate(body, [sense], frames, groups=["offsets"])
    known, n = answer.identifiability, len(answer.estimate.variables)
    print(f"\n{title}\n  {known.rank} of {n} directions are determined")
    for sentence in known.sentences:
        print("  -", sentence)
    return answer


unmeasured = {"tracker": "no"}
timid = rng.uniform(-0.02, 0.02, (30, 5))
answer = tell("1. Timid postures, all within 1 degree", nominal, points(timid), unmeasured)

plan = plan_poses(answer.estimate, [points(timid)], n=8)
print(f"  Planned: 8 poses in the view so far would raise the rank to {plan.rank[-1]}.")

bold = np.concatenate([timid, rng.uniform(-1.5, 1.5, (20, 5))])
tell("2. Move: twenty wide postures more", nominal, points(bold), unmeasured)

tell("3. Look: the marker's orientation as well", nominal, poses(bold), unmeasured)

k = truth.frame_index("tracker")
measured = nominal.with_placement("tracker", truth.placement[k])
tell("4. Measure: the tracker's mounting is known", measured, poses(bold), {})
