"""A joint's zero jumps on a simulated iCub that watches its arm: seen when, blamed on what?

    python benchmarks/image_jump.py [--seeds N] [--seconds S] [--jump DEG] [--json]

The right arm moves between random postures in which both eyes see the hand, ten pairs of masks a
second. Its seven joints are off by the published offsets. The monitor finds them with the published
particle filter (200 particles) and follows them by the arm's outline until the hand's place is
certified to 2 mm; then it watches for S seconds, set to one false alarm a day. After that one joint
jumps by J degrees either way, another one for each seed.

    detected      share of jumps with an alarm within 30 s
    delay_s       from the jump to the alarm
    named_s       from the alarm to the blame
    again_s       from the alarm to the next certificate
    blamed_right  share of jumps after which the joint that jumped is named, and no other
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any

import bodyschema  # noqa: F401  (sets one BLAS thread a process, so it must come before numpy)

# isort: split
import numpy as np

from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.learners.watched_images import WatchedImages, WatchedOutline
from bodyschema.monitoring.monitor import Monitor, MonitorState
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import SeeingIcub
from bodyschema.studies.hand_movements import true_offsets, visible_postures
from bodyschema.studies.watched_hand import believed

RATE = 10.0
"""Pairs of masks a second."""

MOVE = 12
"""Images from one posture to the next."""

AFTER = 30.0
"""s that are watched after a jump."""

PATIENCE = 90.0
"""s within which a body must be certified."""

State = MonitorState[WatchedOutline, Images]


def monitor(seed: int) -> Monitor[WatchedOutline, Images]:
    """The monitor round the particle filter."""
    mine = believed("identical")
    finder = ParticleFilter(mine.surface, seed=seed)
    learner = WatchedImages(mine.body, icub.RIGHT_ARM, icub.HAND, finder)
    return Monitor(learner, samples=24 * 3600 * RATE)


class Arm:
    """An arm that wanders, as its eyes see it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.offsets, self.rng = dict(true_offsets()), rng
        self.robot = SeeingIcub(self.offsets)
        self.postures = visible_postures(3000, 0)
        self.way = list(self.postures[rng.integers(len(self.postures))][None])

    def jump(self, joint: str, by: float) -> None:
        """A zero moves, rad."""
        self.offsets[joint] += by
        self.robot = SeeingIcub(self.offsets)

    def look(self) -> Images:
        """The next pair of masks."""
        if len(self.way) == 1:
            there = self.postures[self.rng.integers(len(self.postures))]
            self.way = list(joint_trajectory(self.way[0], there, MOVE + 1))
        self.robot.command(self.way.pop(0))
        return self.robot.look()


def watch(
    m: Monitor[WatchedOutline, Images], state: State, arm: Arm, seconds: float, until: str = ""
) -> tuple[State, list[tuple[float, str, str]]]:
    """Run the monitor for so long, or until something is reported; events in s."""
    events = []
    for i in range(round(seconds * RATE)):
        state, report = m.step(state, (arm.look(),))
        if report.event:
            events.append(((i + 1) / RATE, report.event, report.block))
        if until and report.event == until:
            break
    return state, events


def run(seed: int, jump: float, calm_s: float) -> dict[str, Any]:
    """One arm: learned, watched, and changed."""
    rng = np.random.default_rng(seed)
    arm, m = Arm(rng), monitor(seed)
    state, events = watch(m, m.start(), arm, PATIENCE, "identified")
    found: dict[str, Any] = {"joint": icub.RIGHT_ARM[seed % len(icub.RIGHT_ARM)]}
    if not events or state.mode != "observe":
        return found | {"certified_s": None}
    found["certified_s"] = events[-1][0]
    state, quiet = watch(m, state, arm, calm_s)
    found["hours"] = calm_s / 3600
    found["false_alarms"] = sum(name == "alarm" for _, name, _ in quiet)
    found["false_changes"] = sum(name == "changed" for _, name, _ in quiet)
    noise = state.belief.noise
    found["noise"] = {"level": noise.level, "correlation": noise.correlation}
    if state.mode != "observe":
        return found
    arm.jump(found["joint"], float(jump * rng.choice([-1, 1])))
    state, events = watch(m, state, arm, AFTER)
    alarm = next((t for t, name, _ in events if name == "alarm"), None)
    blame = [(t, block) for t, name, block in events if name == "changed"]
    again = [t for t, name, _ in events if name == "identified"]
    found["events"] = events
    found["delay_s"] = alarm
    if alarm is not None:
        found["named_s"] = blame[0][0] - alarm if blame else None
        found["again_s"] = again[0] - alarm if again else None
    found["right"] = [block for _, block in blame] == [found["joint"]]
    return found


def spread(values: list[float | None]) -> dict[str, float | None]:
    """Median and 90 % point of those that are known."""
    known = [v for v in values if v is not None]
    if not known:
        return {"median": None, "p90": None}
    return {"median": float(np.median(known)), "p90": float(np.quantile(known, 0.9))}


def measure(seeds: int, jump_deg: float, seconds: float) -> dict[str, Any]:
    """All figures."""
    begin = time.process_time()
    runs = [run(seed, np.deg2rad(jump_deg), seconds) for seed in range(seeds)]
    jumps = [r for r in runs if "right" in r]
    hours = sum(r.get("hours", 0.0) for r in runs)
    alarms = sum(r.get("false_alarms", 0) for r in runs)
    return {
        "seeds": seeds,
        "jump_deg": jump_deg,
        "certified": float(np.mean([r["certified_s"] is not None for r in runs])),
        "certified_s": spread([r["certified_s"] for r in runs]),
        "jumps": len(jumps),
        "detected": float(np.mean([r["delay_s"] is not None for r in jumps])) if jumps else None,
        "delay_s": spread([r["delay_s"] for r in jumps]),
        "named_s": spread([r.get("named_s") for r in jumps]),
        "again_s": spread([r.get("again_s") for r in jumps]),
        "blamed_right": float(np.mean([r["right"] for r in jumps])) if jumps else None,
        "hours_watched": hours,
        "false_alarms": alarms,
        "false_alarms_per_hour": alarms / hours if hours else None,
        "confirmed_false_alarms": sum(r.get("false_changes", 0) for r in runs),
        "cpu_s": time.process_time() - begin,
        "runs": runs,
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="A joint's zero jumps before the robot's eyes.")
    parser.add_argument("--seeds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=120.0, help="without a change, a seed")
    parser.add_argument("--jump", type=float, default=1.0, help="degrees")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = measure(options.seeds, options.jump, options.seconds)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
