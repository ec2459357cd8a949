"""How often does the monitor cry wolf? Hours of a body that does not change.

    python benchmarks/false_alarms.py [--hours H] [--json]

An arm moves at random for twenty minutes a run before a stereo camera with noise of 0.5 pixels;
the monitor identifies hand and eye from one tracked point, then watches. H hours each of

    white       independent noise
    correlated  noise of the same size with a correlation of 0.9 from sample to sample
    wild        2 % of the samples anywhere in the images
    late        images 33 ms late; the lag is estimated from the first 30 s, then taken out

Printed are the hours watched, alarms, alarms that were confirmed as a change, and certificates
that are wrong (beyond 0.2 degrees, 5 mm or 2 mm). The monitor is set to one false alarm a day.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import bodyschema  # noqa: F401  (sets one BLAS thread a process, so it must come before numpy)

# isort: split
import numpy as np

from bodyschema import lie
from bodyschema.learners.hand_eye.clock import ClockSearch, LatePoints
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.model.kinematics import relative_pose
from bodyschema.monitoring.monitor import Monitor
from bodyschema.simulation.katana import (
    Noise,
    Scene,
    Stream,
    delayed,
    draw_scene,
    katana,
    stereo,
    stream,
)

CONDITIONS = {
    "white": (Noise(), 0.0),
    "correlated": (Noise(correlation=0.9), 0.0),
    "wild": (Noise(wild=0.02), 0.0),
    "late": (Noise(), 0.033),
}
"""Name -> noise and lag in s."""

MINUTES = 20


def corrected(seen: Stream) -> tuple[Stream, float]:
    """The stream with the lag taken out that its first 30 s tell: 10 s coarsely, 20 s finely."""
    clock = ClockSearch(HandEyePoints(stereo()))
    coarse = lag_of(clock, seen, 0.0, 10.0)
    lag = lag_of(clock.finer(coarse), seen, 10.0, 30.0)
    T = relative_pose(katana(), delayed(seen.time, seen.q, lag), "base", "hand")
    return Stream(seen.time, seen.q, T, seen.pixels), lag


def lag_of(clock: ClockSearch, seen: Stream, begin: float, end: float) -> float:
    """The lag in s that a stretch of the stream tells."""
    part = (seen.time >= begin) & (seen.time < end)
    poses = np.stack(
        [
            relative_pose(katana(), delayed(seen.time, seen.q, lag)[part], "base", "hand")
            for lag in clock.lags
        ],
        axis=1,
    )
    state = clock.start()
    for T, pixels in zip(poses, seen.pixels[part], strict=True):
        state, _ = clock.step(state, (LatePoints(T, pixels),))
    return clock.solve(state).seconds


def wrong(found: Scene, true: Scene) -> bool:
    """Whether an answer is beyond 0.2 degrees, 5 mm or 2 mm."""
    R, S = found.T_world_cam, true.T_world_cam
    turn = np.degrees(np.linalg.norm(lie.log_so3(R[:3, :3] @ S[:3, :3].T)))
    away = np.linalg.norm(R[:3, 3] - S[:3, 3])
    return bool(turn > 0.2 or away > 5e-3 or np.linalg.norm(found.points - true.points) > 2e-3)


def watch(condition: str, run: int, minutes: float = MINUTES) -> dict[str, float]:
    """Counts of one run."""
    noise, lag = CONDITIONS[condition]
    rng = np.random.default_rng([list(CONDITIONS).index(condition), run])
    scene = draw_scene(rng)
    seen = stream(scene, 60 * minutes, stereo(), rng, noise=noise, lag=lag)
    count = {"hours": 0.0, "alarms": 0.0, "confirmed": 0.0, "certificates": 0.0, "wrong": 0.0}
    if lag:
        seen, found = corrected(seen)
        count["lag_error_ms"] = 1e3 * abs(found - lag)
    monitor = Monitor(HandEyePoints(stereo()))
    state = monitor.start()
    for i in range(len(seen)):
        state, report = monitor.step(state, (seen.sample(i),))
        count["hours"] += (report.mode == "observe") / 108_000
        count["alarms"] += report.event == "alarm"
        count["confirmed"] += report.event == "changed"
        if report.event == "identified":
            theta = state.belief.theta
            count["certificates"] += 1
            count["wrong"] += wrong(Scene(theta.T_world_cam, theta.points), scene)
    return count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--hours", type=float, default=1.0, help="of each condition")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    answer, begin = {}, time.process_time()
    for condition in CONDITIONS:
        runs = max(1, round(arguments.hours * 60 / MINUTES))
        total: dict[str, float] = {}
        for run in range(runs):
            for name, value in watch(condition, run).items():
                most = name == "lag_error_ms"
                old = total.get(name, 0.0)
                total[name] = max(old, value) if most else old + value
            print(condition, run + 1, total, file=sys.stderr, flush=True)
        answer[condition] = total | {"alarms_per_hour": total["alarms"] / total["hours"]}
    answer["cpu_seconds"] = time.process_time() - begin
    print(json.dumps(answer) if arguments.json else json.dumps(answer, indent=2))


if __name__ == "__main__":
    main()
