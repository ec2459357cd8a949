"""Seconds of the processor for what runs most, one thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import bodyschema as bs
import imagination
import payload
import recordings
import speed
from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from key_figures.figure import Values

UNKNOWN = {"tracker": "no", "marker": "no"}


def watched_arm(rows: int) -> tuple[bs.Body, bs.Points]:
    """A 7-joint arm, nominal, and a point of it as a tracker saw it, 1 mm of noise."""
    rng = np.random.default_rng(0)
    body = bs.Body.random_chain(7, rng).attach("tracker", "base").attach("marker", "tip")
    T_tracker = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
    truth = body.with_placement("tracker", T_tracker)
    wrong = bs.free_joints(truth, ("offsets", "axes", "links"))
    truth = truth.with_variables(wrong, 0.5 * wrong.prior_std * rng.normal(size=len(wrong)))
    q = rng.uniform(-1.5, 1.5, (rows, 7))
    seen = relative_pose(truth, q, "tracker", "marker")[:, :3, 3] + 1e-3 * rng.normal(
        size=(rows, 3)
    )
    return body, bs.Points.make(q, seen, "tracker", "marker", time=np.arange(rows) / 10)


def taken(work: Callable[[], object]) -> float:
    """Seconds of one call."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def calibrated(rows: int) -> float:
    """Seconds of `calibrate` that chooses its model, once all is compiled."""
    body, few = watched_arm(60)
    bs.calibrate(body, [few], UNKNOWN)
    body, seen = watched_arm(rows)
    return taken(lambda: bs.calibrate(body, [seen], UNKNOWN))


def calibrate_300(data: Path) -> Values:
    """300 rows."""
    return {"cpu": calibrated(300)}


def calibrate_3000(data: Path) -> Values:
    """3,000 rows."""
    return {"cpu": calibrated(3000)}


def calibrate_fr3(data: Path) -> Values:
    """114 poses of a real arm, the second time."""
    body, q, pose = recordings.fr3(data)
    seen = bs.Poses.make(q, pose, "board", "camera")

    def work() -> object:
        return bs.calibrate(body, [seen], {"board": "no", "camera": "no"})

    work()
    return {"cpu": min(taken(work) for _ in range(2))}


def steps(data: Path) -> Values:
    """What runs for every sample, posture or picture."""
    score = imagination.scores(0, 200)["jaccard_chamfer"]
    score(1)
    return {
        "filter": speed.recursive_update()["us"],
        "kinematics": speed.batch_kinematics()["ours_ms"],
        "imagination": imagination.best(lambda: score(1), 15)[0],
        "payload": payload.cost(60)["sample_us"],
    }
