"""Reach with a body that was learned by looking.

A humanoid of 24 joints knows which joint hangs on which, and nothing else: no length, no axis. It
stands in random postures, sees its hands and feet, and learns. Then it is to bring its right hand
to points that its head sees. MuJoCo says where the hand truly is.

python examples/07_reach_with_a_learned_body.py    needs the extra sim
"""

from __future__ import annotations

import numpy as np

import bodyschema as bs
from bodyschema.learners.published.online_gradient import from_nothing
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.simulation.humanoid import ENDS, EYE, humanoid
from bodyschema.simulation.moving_robot import MovingRobot

POSTURES, TARGETS = 60, 100
NOISE = 1e-3  # m, of every coordinate that is seen
rng = np.random.default_rng(7)

true = humanoid()
robot = MovingRobot(true)
skeleton = bs.free_skeleton(true)
untaught = from_nothing(true, skeleton, length=0.1, rng=rng)
solver = bs.InverseKinematics(starts=2)


def stand_anywhere() -> np.ndarray:
    """Move to a random posture within the joint ranges."""
    q = rng.uniform(true.lower, true.upper)
    robot.command(q)
    return q


def look(q: np.ndarray, limb: str, time: int) -> bs.Points:
    """Where the eye sees a limb now, roughly."""
    seen = robot.see(EYE, limb) + NOISE * rng.normal(size=3)
    return bs.Points.make(q, seen, seen_from=EYE, seen=limb, std=NOISE, time=[time])


def miss(body: bs.Body, target: np.ndarray) -> float:
    """mm between the hand and the target, after reaching for it by this body."""
    bs.reach(robot, body, bs.Aim(seen_from=EYE, seen="r_hand", position=target), solver)
    return 1e3 * float(np.linalg.norm(robot.see(EYE, "r_hand") - target))


learner = Pool()
state = learner.start(untaught, skeleton)
print("postures   what it says   error of its next prediction, mm")
for time in range(POSTURES):
    q = stand_anywhere()
    sights = [look(q, limb, time) for limb in ENDS]
    error = np.mean([np.linalg.norm(sight.residual(state.body)) for sight in sights])
    if time % 6 == 0:
        print(f"{time:8}   {state.phase:12} {1e3 * error:9.2f}")
    for sight in sights:
        state, _ = learner.step(state, (sight,))

targets = []
for _ in range(TARGETS):
    stand_anywhere()
    targets.append(robot.see(EYE, "r_hand"))
print(f"\n{TARGETS} targets for the right hand, miss in mm      mean   largest")
for name, body in (("true body", true), ("learned", state.body), ("untaught", untaught)):
    misses = [miss(body, target) for target in targets]
    print(f"  {name:41} {np.mean(misses):9.2f} {np.max(misses):9.2f}")

told = bs.determinable(true, skeleton, sights)
print(
    f"\nOf {told.variables} numbers that make the skeleton, looking at hands and feet can tell "
    f"{told.rank}.\nThe hand gets there all the same; what stays open moves nothing that is seen:"
)
for direction in told.directions[::6]:
    print(f"  {direction.sentence}")
