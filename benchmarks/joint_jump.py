"""A joint's zero jumps by one degree: how soon is it noticed, and is the right joint blamed?

    python benchmarks/joint_jump.py [--seeds N] [--minutes M] [--sense points|poses] [--json]

A UR5 moves at random, half as fast as it may, 30 samples a second, and a tracker of unknown place
sees a marker (points, 1 mm of noise; or poses, 1 mm and 0.2 degrees) at an unknown place on the
tool. The monitor learns the six joint zeros, the tracker's and the marker's frames with the
recursive Gauss-Newton learner until the prediction is certified to 2 mm in the whole workspace,
then watches, set to one false alarm a day. One joint after the other, seed by seed, jumps at 60 s,
by a degree either way. Then the arm is watched without any change for M minutes a seed.

    detected      share of jumps with an alarm while it is watched
    delay_s       from the jump to the alarm
    named_s       from the alarm to the blame
    again_s       from the alarm to the next certificate
    blamed_right  share of jumps after which the joint that jumped is named, and no other part
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import numpy as np

from arms import robots
from bodyschema import lie
from bodyschema.learners.filter import Filter
from bodyschema.learners.watched_body import WatchedBelief, WatchedBody
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.variables import free_frame, free_joints, join
from bodyschema.monitoring.monitor import Monitor, MonitorState
from bodyschema.senses.sense import Sense

URDF = "ur_description/urdf/ur5_robot.urdf"
RATE = 30.0
JUMP = np.deg2rad(1.0)
AT = 60.0
"""s."""

AFTER = 30.0
"""s that are watched after the jump."""

CENTRE = np.array([0.0, -1.2, 1.4, -0.6, 1.2, 0.0])
REACH = np.array([1.2, 0.7, 0.8, 1.2, 1.2, 2.0])
"""rad."""

SPEED = 0.5 * 3.15
"""rad/s, peak."""

TRACKER = np.array([1.5, 0.0, 0.5])
"""m: where it is, give or take a metre."""

NOISE = (1e-3, np.deg2rad(0.2))
"""m and rad."""


def nominal() -> bs.Body:
    """The arm as modelled, tracker and marker not placed."""
    body = bs.Body.from_urdf(robots() / URDF)
    return body.attach("tracker", "base_link").attach("marker", "wrist_3_link")


def draw_truth(rng: np.random.Generator) -> bs.Body:
    """An arm with wrong zeros, and where tracker and marker are."""
    body = nominal()
    zeros = free_joints(body, ("offsets",))
    body = body.with_variables(zeros, rng.normal(size=6) * 0.02)
    T_tracker = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3) + TRACKER)
    T_marker = lie.transform(lie.exp_so3(rng.normal(size=3)), [0.08, 0.05, 0.12])
    return body.with_placement("tracker", T_tracker).with_placement("marker", T_marker)


def draw_motion(seconds: float, rng: np.random.Generator) -> np.ndarray:
    """Minimum-jerk moves between random way points with short rests, (n, 6) rad."""
    pieces, n = [], round(seconds * RATE)
    here = CENTRE + rng.uniform(-1, 1, 6) * REACH
    while sum(map(len, pieces)) < n:
        there = CENTRE + rng.uniform(-1, 1, 6) * REACH
        length = max(0.4, float(np.max(np.abs(there - here))) * 1.875 / SPEED)
        s = np.arange(0, length, 1 / RATE)[:, None] / length
        pieces.append(here + (there - here) * s**3 * (10 - 15 * s + 6 * s * s))
        pieces.append(np.tile(there, (rng.integers(0, 9), 1)))
        here = there
    return np.concatenate(pieces)[:n]


def see(
    body: bs.Body, q: np.ndarray, time_s: np.ndarray, sense: str, rng: np.random.Generator
) -> Sense:
    """What the tracker sees of the marker."""
    T = relative_pose(body, q, "tracker", "marker")
    position = T[:, :3, 3] + NOISE[0] * rng.normal(size=(len(q), 3))
    if sense == "points":
        return bs.Points.make(q, position, "tracker", "marker", time=time_s)
    turned = lie.exp_so3(NOISE[1] * rng.normal(size=(len(q), 3))) @ T[:, :3, :3]
    return bs.Poses.make(q, lie.transform(turned, position), "tracker", "marker", time=time_s)


def monitor_for(sense: str) -> Monitor[WatchedBelief, Sense]:
    """The monitor round the recursive learner."""
    body = nominal()
    turns = None if sense == "points" else 1.0
    variables = join(
        free_joints(body, ("offsets",)),
        free_frame(body, "tracker"),
        free_frame(body, "marker", turn_std=turns),
    )
    learner = Filter(unknown=("tracker", "marker"), burn_in=300)
    return Monitor(WatchedBody(body, variables, learner))


@dataclass(frozen=True)
class Event:
    """Something that the monitor reported."""

    time: float
    name: str
    block: str


def watch(
    monitor: Monitor[WatchedBelief, Sense], state: MonitorState[WatchedBelief, Sense], seen: Sense
) -> tuple[MonitorState[WatchedBelief, Sense], list[Event]]:
    """Run the monitor over a stream."""
    events = []
    for i in range(len(seen)):
        state, report = monitor.step(state, (seen.take([i]),))
        if report.event:
            events.append(Event(float(seen.time[i]), report.event, report.block))
    return state, events


def jump(seed: int, sense: str) -> dict[str, Any]:
    """One jump."""
    rng = np.random.default_rng(seed)
    truth, q = draw_truth(rng), draw_motion(AT + AFTER, rng)
    joint = seed % 6
    zeros = free_joints(truth, ("offsets",))
    moved = truth.with_variables(zeros, JUMP * rng.choice([-1, 1]) * (np.arange(6) == joint))
    at, moment = round(AT * RATE), np.arange(len(q)) / RATE
    monitor = monitor_for(sense)
    before = see(truth, q[:at], moment[:at], sense, rng)
    after = see(moved, q[at:], moment[at:], sense, rng)
    state, early = watch(monitor, monitor.start(), before)
    _, late = watch(monitor, state, after)
    found: dict[str, Any] = {
        "joint": truth.joints[joint],
        "certified_s": next((e.time for e in early if e.name == "identified"), None),
        "early_alarms": sum(e.name == "alarm" for e in early),
        "events": [(round(e.time - AT, 2), e.name, e.block) for e in late],
    }
    alarm = next((e.time for e in late if e.name == "alarm"), None)
    blame = [e for e in late if e.name == "changed"]
    again = next((e.time for e in late if e.name == "identified"), None)
    found["delay_s"] = None if alarm is None else alarm - AT
    found["named_s"] = blame[0].time - alarm if blame and alarm is not None else None
    found["again_s"] = again - alarm if again is not None and alarm is not None else None
    found["right"] = [e.block for e in blame] == [truth.joints[joint]]
    return found


def calm(seed: int, sense: str, minutes: float) -> tuple[float, int, int]:
    """Hours watched without a change; alarms, and those that were confirmed."""
    rng = np.random.default_rng(1000 + seed)
    truth, q = draw_truth(rng), draw_motion(60 * minutes, rng)
    monitor = monitor_for(sense)
    seen = see(truth, q, np.arange(len(q)) / RATE, sense, rng)
    _, events = watch(monitor, monitor.start(), seen)
    begin = next((e.time for e in events if e.name == "identified"), 60 * minutes)
    alarms = sum(e.name == "alarm" for e in events)
    confirmed = sum(e.name == "changed" for e in events)
    return (60 * minutes - begin) / 3600, alarms, confirmed


def median_and_most(values: list[float | None]) -> dict[str, float | None]:
    """Median and 90 % point of those that are known."""
    known = [v for v in values if v is not None]
    if not known:
        return {"median": None, "p90": None}
    return {"median": float(np.median(known)), "p90": float(np.quantile(known, 0.9))}


def measure(seeds: int, minutes: float, sense: str) -> dict[str, Any]:
    """All figures."""
    begin = time.process_time()
    jumps = [jump(seed, sense) for seed in range(seeds)]
    watched = [calm(seed, sense, minutes) for seed in range(seeds)]
    hours = sum(h for h, _, _ in watched) or float("nan")
    hours += sum(AT - j["certified_s"] for j in jumps if j["certified_s"] is not None) / 3600
    alarms = sum(n for _, n, _ in watched) + sum(j["early_alarms"] for j in jumps)
    return {
        "sense": sense,
        "seeds": seeds,
        "certified_s": median_and_most([j["certified_s"] for j in jumps]),
        "detected": float(np.mean([j["delay_s"] is not None for j in jumps])),
        "delay_s": median_and_most([j["delay_s"] for j in jumps]),
        "named_s": median_and_most([j["named_s"] for j in jumps]),
        "again_s": median_and_most([j["again_s"] for j in jumps]),
        "blamed_right": float(np.mean([j["right"] for j in jumps])),
        "hours_watched": hours,
        "false_alarms": alarms,
        "false_alarms_per_hour": alarms / hours,
        "confirmed_false_alarms": sum(n for _, _, n in watched),
        "cpu_s": time.process_time() - begin,
        "jumps": jumps,
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="A joint's zero jumps by one degree.")
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--minutes", type=float, default=5.0, help="without a change, a seed")
    parser.add_argument("--sense", choices=("points", "poses"), default="points")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = measure(options.seeds, options.minutes, options.sense)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
