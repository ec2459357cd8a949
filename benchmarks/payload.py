"""What a payload costs, how well changes of it are noticed; an arm's torques beside a reference.

    python benchmarks/payload.py [--changes 100] [--hours 4] [--tx40 FOLDER] [--json]

sample_us      one sample (100 a second) through averaging, watch and learner, and that in the last
               tenth of ten minutes over that in the second
changes        objects of 50 g to 2 kg grasped, swapped and released at half joint speed: delay of
               the alarm, missed, misnamed, and the time until the load is certified again
false_per_hour alarms per hour of motion in which nothing changes, at three speeds
torque_percent held-out torque residual of the TX40 recording, if its folder is given

All is simulated (see `bodyschema.simulation.loads`) but the last. CPU times of one process.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import bodyschema  # noqa: F401  (sets one BLAS thread a process, so it must come before numpy)

# isort: split
import numpy as np

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrench_stream import WrenchStream
from bodyschema.simulation.loads import (
    RATE,
    Held,
    draw_load,
    draw_motion,
    draw_sensor,
    joined,
    record,
)

HOLD = 15.0
"""s from one change to the next."""


def cost(seconds: float = 600.0) -> dict[str, float]:
    """A stream, sample by sample."""
    rng = np.random.default_rng(0)
    motion = draw_motion(rng, seconds, 0.5, RATE)
    samples = record(motion, [Held(0, draw_load(rng, 0.6))], draw_sensor(rng, 0.02), rng)
    stream, watch = WrenchStream(), Monitor(LoadLearner())
    buffer, state = stream.start(), watch.start()
    tenth, pieces, begin = len(samples) // 10, [], time.process_time()
    for i in range(len(samples)):
        buffer, mean = stream.step(buffer, samples.take(slice(i, i + 1)))
        if mean is not None:
            state, _ = watch.step(state, (mean,))
        if i % tenth == tenth - 1:
            pieces.append(1e6 * (time.process_time() - begin) / tenth)
            begin = time.process_time()
    return {"sample_us": float(np.median(pieces[1:])), "drift": pieces[-1] / pieces[1]}


def follow(samples: Any) -> tuple[list[float], list[tuple[float, str]]]:
    """Times of alarms, and events with their times, as they are told."""
    averaging, watch = Averaging(), Monitor(LoadLearner())
    means, state = averaging.means(samples), watch.start()
    alarms, events = [], []
    for k in range(len(means)):
        state, report = watch.step(state, (means.take(slice(k, k + 1)),))
        told = float(means.time[k]) + averaging.window / 2
        if report.event == "alarm":
            alarms.append(told)
        elif report.event:
            events.append((told, report.change or report.event))
    return alarms, events


def changes(count: int) -> dict[str, Any]:
    """A grasp, a swap and a release in each run."""
    delay, named, again, missed, wrong = [], 0, [], 0, []
    for run in range(count):
        rng = np.random.default_rng([1, run])
        grip = draw_load(rng, rng.uniform(0.2, 0.8))
        masses = np.exp(rng.uniform(np.log(0.05), np.log(2.0), 2))
        first, second = (joined(grip, draw_load(rng, m)) for m in masses)
        at = [HOLD * k + rng.uniform(0, 3) for k in (1, 2, 3)]
        held = [Held(0, grip), Held(at[0], first), Held(at[1], second), Held(at[2], grip)]
        motion = draw_motion(rng, 4 * HOLD + 3, 0.5, RATE)
        alarms, events = follow(record(motion, held, draw_sensor(rng, 0.02), rng))
        for since, expected, until in zip(
            at, ("grasp", "swap", "release"), (*at[1:], np.inf), strict=True
        ):
            noticed = [t - since for t in alarms if since < t < until]
            told = [(t - since, e) for t, e in events if since < t < until and e != "same"]
            if not noticed:
                missed += 1
                wrong.append([run, expected, masses.tolist(), "missed"])
                continue
            delay.append(noticed[0])
            if told and told[0][1] == expected:
                named += 1
                again.append(told[0][0])
            else:
                wrong.append([run, expected, masses.tolist(), told])
    return {
        "count": 3 * count,
        "missed": missed,
        "delay_s": _quantiles(delay),
        "named_share": named / (3 * count),
        "certified_again_s": _quantiles(again),
        "wrong": wrong,
    }


def _quantiles(values: list[float]) -> dict[str, float]:
    return {"median": float(np.median(values)), "p95": float(np.quantile(values, 0.95))}


def false_alarms(hours: float) -> dict[str, float]:
    """Hours of motion at each speed, in pieces of ten minutes with other loads and sensors."""
    found = {}
    for speed in (0.15, 0.5, 1.0):
        alarms, pieces = 0, max(1, round(6 * hours))
        for piece in range(pieces):
            rng = np.random.default_rng([2, piece, round(100 * speed)])
            motion = draw_motion(rng, 600, speed, RATE)
            load = draw_load(rng, np.exp(rng.uniform(np.log(0.2), np.log(2.0))))
            heard, _ = follow(record(motion, [Held(0, load)], draw_sensor(rng, 0.02), rng))
            alarms += len(heard)
        found[f"{speed:g}"] = 6 * alarms / pieces
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--changes", type=int, default=100)
    parser.add_argument("--hours", type=float, default=4.0)
    parser.add_argument("--tx40", type=Path)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    answer: dict[str, Any] = cost()
    answer["changes"] = changes(arguments.changes)
    answer["false_per_hour"] = false_alarms(arguments.hours)
    if arguments.tx40:
        from arm_torques import torque_percent

        answer["torque_percent"] = torque_percent(arguments.tx40)
    print(json.dumps(answer) if arguments.json else json.dumps(answer, indent=2))


if __name__ == "__main__":
    main()
