"""One estimate from senses that each tell something else.

    python benchmarks/together.py [--json] [--seeds N] [--cli]

arm4    A four-joint arm that MuJoCo moves, draws and weighs (`seen_and_felt`): 12 points of 3 mm
        from a tracker, 4 masks of 640 x 480 from a camera, 20 wrenches at rest. Unknown are the
        zeros of three joints (0.1 rad; the first is where the base points), the placements of
        camera, tracker and marker, the load and the offset of the force sensor. "std_deg" is the
        stated standard deviation of each joint, mean over the seeds, of each sense alone and of
        all; "within_95" the share of all joints, senses and seeds whose error is within 1.96 of it.
arm7    A seven-joint arm: corners of a board on its hand in a fixed camera (poses of both, lens and
        size of the board unknown), touches of its finger on its own base (place of the finger
        roughly known), and an accelerometer in the hand (offsets unknown). "open" names the joints'
        directions that each sense leaves open, alone and together.

With --cli the arm4 of the first seed goes through `bodyschema calibrate RUN.toml --json` alone: one
run file with three recordings and the masks as pictures (`together_run`).

Times are of the processor.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
import seven_joints
from bodyschema import lie
from bodyschema.estimation.identifiability import identifiability
from bodyschema.estimation.solver import Solver
from bodyschema.model import parts
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.outlines import Outlines
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense
from bodyschema.senses.wrist_wrenches import WristWrenches
from seen_and_felt import EYE, JOINTS, MARKER, TRACKER, RealArm, camera, nominal
from together_run import calibrated, write_run

Array = NDArray[np.float64]
Senses = dict[str, Sense]

POINT_STD, FORCE_STD, TORQUE_STD = 3e-3, 0.05, 2e-3
"""m, N and Nm."""

JUDGED = JOINTS[1:]

BAND = 1.96
"""Standard deviations: 95 % of normal errors."""


def believed(folder: Path) -> tuple[bs.Body, Variables]:
    """The arm as drawn, and what may be wrong with it."""
    body = nominal(folder).with_part("edge", parts.edge())
    offsets = [name for name in body.part("ft").names if name.startswith("offset")]
    return body, join(
        free_joints(body, ["offsets"], JUDGED),
        free_frame(body, "camera", 0.05, 0.05),
        free_frame(body, "tracker", 0.1, 0.1),
        free_frame(body, "marker", 0.005, None),
        free_part(body, "load"),
        free_part(body, "ft", offsets),
        free_part(body, "edge"),
    )


def drawn(seed: int) -> tuple[RealArm, np.random.Generator]:
    """An arm as it was built."""
    rng = np.random.default_rng([7, seed])
    offsets = np.array([0.0, *0.1 * rng.normal(size=3)])

    def moved(T: Array, position: float, turn: float) -> Array:
        step = lie.transform(lie.exp_so3(turn * rng.normal(size=3)), position * rng.normal(size=3))
        return np.asarray(T @ step)

    eye, tracker = moved(EYE, 0.02, 0.02), moved(TRACKER, 0.05, 0.05)
    marker = MARKER[:3, 3] + 0.005 * rng.normal(size=3)
    bias = np.repeat([5.0, 0.5], 3) * rng.normal(size=6)
    return RealArm(offsets, eye, tracker, marker, bias), rng


def arm4_senses(real: RealArm, rng: np.random.Generator, body: bs.Body, scale: int = 1) -> Senses:
    """What is seen and felt of one arm; masks are `scale` times smaller."""
    few, views, held = (rng.uniform(body.lower, body.upper, (n, 4)) for n in (12, 4, 20))
    lens, surface = camera(640 // scale, 480 // scale), bs.Surface.of(body)
    noise = np.repeat([FORCE_STD, TORQUE_STD], 3) * rng.normal(size=(20, 6))
    places = real.markers(few) + POINT_STD * rng.normal(size=(12, 3))
    return {
        "points": Points.make(few, places, "tracker", "marker", POINT_STD),
        "outlines": Outlines.make(
            body, views, real.masks(views, lens), lens, surface, reach=60.0 / scale, edge="edge"
        ),
        "wrenches": WristWrenches.make(
            held,
            real.wrenches(held) + noise,
            "sensor",
            "base",
            (FORCE_STD, TORQUE_STD),
            sensor="ft",
        ),
    }


def with_all(senses: Senses) -> dict[str, Sequence[Sense]]:
    """Each alone, and all."""
    return {**{name: [sense] for name, sense in senses.items()}, "all": list(senses.values())}


def arm4(seeds: int, scale: int = 1) -> tuple[dict[str, Array], dict[str, Array]]:
    """Stated standard deviations and errors, (n_seeds, 3) deg, by senses."""
    std: dict[str, list[Array]] = {}
    off: dict[str, list[Array]] = {}
    with tempfile.TemporaryDirectory() as folder:
        body, free = believed(Path(folder))
    columns = [free.names.index(f"{joint}.offset") for joint in JUDGED]
    for seed in range(seeds):
        real, rng = drawn(seed)
        for name, senses in with_all(arm4_senses(real, rng, body, scale)).items():
            found = Solver().fit(start_frames(body, ("load", "ft"), senses), free, senses)
            std.setdefault(name, []).append(np.rad2deg(found.std[columns]))
            off.setdefault(name, []).append(np.rad2deg(found.x[columns] - real.offsets[1:]))
    return tuple({k: np.array(v) for k, v in one.items()} for one in (std, off))  # type: ignore[return-value]


def arm7(seeds: int) -> dict[str, Any]:
    """Stated standard deviations, open directions and coverage of the seven-joint arm."""
    body, free = seven_joints.believed()
    std: dict[str, list[Array]] = {}
    opened: dict[str, list[str]] = {}
    inside = []
    for seed in range(seeds):
        truth, senses = seven_joints.drawn(body, free, seed)
        for name, some in with_all(senses).items():
            found = Solver().fit(body, free, some)
            std.setdefault(name, []).append(np.rad2deg(found.std[:7]))
            inside.append(np.abs(found.x - truth)[:7] < BAND * found.std[:7])
            if not seed:
                told = identifiability(found, some)
                opened[name] = [
                    direction.sentence
                    for direction in told.directions
                    if any(member.endswith(".offset") for member in direction.members)
                ]
    return {
        "std_deg": {name: named(np.mean(each, axis=0), body.joints) for name, each in std.items()},
        "open": opened,
        "within_95": float(np.mean(inside)),
    }


def named(values: Array, joints: Sequence[str]) -> dict[str, float]:
    return {joint: round(float(value), 4) for joint, value in zip(joints, values, strict=True)}


def measure(seeds: int) -> dict[str, Any]:
    """All figures."""
    begin = time.process_time()
    std, off = arm4(seeds)
    inside = [np.abs(off[name]) < BAND * std[name] for name in std]
    return {
        "std_deg": {name: named(each.mean(axis=0), JUDGED) for name, each in std.items()},
        "rms_error_deg": {
            name: named(np.sqrt(np.mean(each**2, axis=0)), JUDGED) for name, each in off.items()
        },
        "within_95": float(np.mean(inside)),
        "arm7": arm7(max(seeds // 4, 1)),
        "seconds": time.process_time() - begin,
    }


def through_cli() -> dict[str, Any]:
    """Stated standard deviations and errors of the first arm, from one run file."""
    begin = time.process_time()
    real, rng = drawn(0)
    with tempfile.TemporaryDirectory() as there:
        body, _ = believed(Path(there))
        few, views, held = (rng.uniform(body.lower, body.upper, (n, 4)) for n in (12, 4, 20))
        places = real.markers(few) + POINT_STD * rng.normal(size=(12, 3))
        noise = np.repeat([FORCE_STD, TORQUE_STD], 3) * rng.normal(size=(20, 6))
        felt = WristWrenches.make(held, real.wrenches(held) + noise, "sensor", "base")
        seen = Points.make(few, places, "tracker", "marker")
        masks = real.masks(views, camera())
        path = write_run(Path(there), seen, felt, views, masks, camera())
        answer = calibrated(path)
    told = {entry["name"]: entry for entry in answer["parameters"]}
    rows = [told[f"{joint}.offset"] for joint in JUDGED]
    off = np.array([row["value"] for row in rows]) - real.offsets[1:]
    return {
        "verdict": answer["verdict"],
        "explanation": answer["explanation"],
        "std_deg": named(np.rad2deg([row["std"] for row in rows]), JUDGED),
        "error_deg": named(np.rad2deg(off), JUDGED),
        "held_out": answer["held_out"],
        "seconds": time.process_time() - begin,
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="One estimate from all senses.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--seeds", type=int, default=20, help="arms that are drawn")
    parser.add_argument("--cli", action="store_true", help="one arm through the command line")
    options = parser.parse_args()
    figures = through_cli() if options.cli else measure(options.seeds)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
