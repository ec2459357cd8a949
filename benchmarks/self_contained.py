"""A two-armed robot calibrates itself, and a tracker that the fit never saw says how well.

    python benchmarks/self_contained.py [--seeds 5] [--size 1.0] [--errors 1.0] [--json]

Baxter, with wrong joint zeros (1.7 degrees), axes (0.3 degrees) and links (2 mm) in both arms and
the neck, or a share of that. Where its frames really are comes from Pinocchio, out of a URDF of the
true robot.

touches     each fingertip on the skin of the other forearm, 2 mm
distances   a ball on either hand, in contact with the other, 0.5 mm; where they sit nobody measured
planes      the same balls on a table that nobody measured, 0.5 mm
pixels      a board on either hand before the camera on the head, 0.3 px; camera and boards are
            where nobody measured, the lens is known to a per cent
gravity     accelerometers in the hands, of known mounting, 0.03 m/s^2, with offsets

For each sense alone, all four, and all with gravity: `after_mm` the rms error of both hands at
fresh postures, up to the tracker's own mounting; `nominal_mm` that of the robot as modelled;
`stated_mm` what the covariance says of it; `told` in how many of the trials the fit settled and its
correction is at least twice as large as what it states to be left: otherwise the answer is that
these data cannot tell. `worse` and `worse_though_told`: trials that end farther off than the robot
as modelled. `open` is the number of directions that the data leave as they were believed.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import identifiability
from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.seeds.closed_forms import align_points
from bodyschema.senses.sense import Sense
from two_arms import COUNT, GROUPS, NOISE, SENSES, SIDES, Robot, arms, draw_robot, postures

Array = NDArray[np.float64]

FRAMES = {
    "touches": (),
    "distances": ("left_ball", "right_ball"),
    "planes": ("table", "left_ball", "right_ball"),
    "pixels": ("eye", "left_board", "right_board"),
    "gravity": (),
}
"""Frames that nobody measured, by sense."""

PARTS = {"pixels": ("lens",), "gravity": ("left_feel", "right_feel")}
FOUR = ("touches", "distances", "planes", "pixels")
SETS = {**{name: (name,) for name in NOISE}, "four": FOUR, "all": (*FOUR, "gravity")}


@dataclass(frozen=True)
class Tracker:
    """Both hands at fresh postures, as a tracker of unknown mounting would have them."""

    q: Array
    hands: Array
    """(2 n, 3) m, true, in the robot's base."""

    @classmethod
    def watching(cls, robot: Robot, n: int, rng: np.random.Generator) -> Tracker:
        """At n random postures, by Pinocchio."""
        q = postures(robot.truth, n, rng)
        seen = [robot.poses(q, "base", f"{side}_gripper")[:, :3, 3] for side in SIDES]
        return cls(q, np.concatenate(seen))

    def hands_of(self, body: bs.Body) -> Array:
        """(2 n, 3) m, as a body has them."""
        return np.concatenate(
            [relative_pose(body, self.q, "base", f"{side}_gripper")[:, :3, 3] for side in SIDES]
        )

    def error(self, body: bs.Body, true: Array | None = None) -> float:
        """rms distance from the true hands, or from others, after the best mounting, m."""
        theirs, mine = self.hands if true is None else true, self.hands_of(body)
        T = align_points(mine, theirs, np.ones(len(mine)))
        left = mine @ T[:3, :3].T + T[:3, 3] - theirs
        return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))

    def stated(self, fit: Estimate) -> float:
        """rms error of the hands that an estimate admits to, after the best mounting, m."""
        J = np.concatenate(
            [
                relative_pose_derivatives(
                    fit.reference, fit.variables, fit.x, self.q, "base", f"{side}_gripper"
                ).by_parameter[:, :3]
                for side in SIDES
            ]
        )
        moves = np.concatenate([np.tile(np.eye(3), (len(J), 1, 1)), lie.skew(self.hands)], axis=2)
        basis = np.linalg.qr(moves.reshape(-1, 6))[0]
        flat = J.reshape(-1, J.shape[2])
        flat = flat - basis @ (basis.T @ flat)
        return float(np.sqrt(np.einsum("ij,jk,ik->", flat, fit.covariance, flat) / len(J)))


def fit_set(robot: Robot, seen: dict[str, list[Sense]], names: Sequence[str]) -> Estimate:
    """The product's own fit of some of the senses, from frames that nobody measured."""
    senses = [sense for name in names for sense in seen[name]]
    frames = dict.fromkeys((f for name in names for f in FRAMES[name]), "no")
    free = dict.fromkeys(part for name in names for part in PARTS.get(name, ()))
    problem = Problem(robot.nominal, tuple(senses), frames, arms(robot.nominal), parts=free)
    return problem.fit(problem.variables(GROUPS), senses)


def trial(
    seed: int, size: float = 1.0, errors: float = 1.0, sets: Sequence[str] = tuple(SETS)
) -> dict[str, dict[str, Any]]:
    """One robot, each set of senses.

    Args:
        seed: of the robot and of all noise.
        size: share of the usual number of samples.
        errors: share of the usual errors of the joints.
        sets: names in SETS.
    """
    rng = np.random.default_rng(seed)
    robot = draw_robot(rng, errors)
    used = {name for chosen in sets for name in SETS[chosen]}
    seen = {
        name: make(robot, int(size * COUNT[name]), rng)
        for name, make in SENSES.items()
        if name in used
    }
    tracker = Tracker.watching(robot, 100, rng)
    nominal, found = tracker.error(robot.nominal), {}
    for chosen in sets:
        begin = time.process_time()
        fit = fit_set(robot, seen, SETS[chosen])
        seconds = time.process_time() - begin
        stated = tracker.stated(fit)
        correction = tracker.error(fit.body, tracker.hands_of(robot.nominal))
        senses = [sense for name in SETS[chosen] for sense in seen[name]]
        found[chosen] = {
            "nominal_mm": 1e3 * nominal,
            "after_mm": 1e3 * tracker.error(fit.body),
            "stated_mm": 1e3 * stated,
            "correction_mm": 1e3 * correction,
            "tells": bool(fit.converged and correction > 2 * stated),
            "settled": bool(fit.converged),
            "open": len(identifiability(fit, senses).directions),
            "variables": len(fit.variables),
            "cpu_s": seconds,
        }
    return found


def measure(seeds: int, size: float, errors: float) -> dict[str, Any]:
    """All figures: medians over the seeds, and how often a set tells and ends worse."""
    trials = [trial(seed, size, errors) for seed in range(seeds)]
    figures: dict[str, Any] = {}
    for name in SETS:
        rows = [found[name] for found in trials]
        told = [row for row in rows if row["tells"]]
        figures[name] = {
            key: float(np.median([row[key] for row in rows]))
            for key in ("nominal_mm", "after_mm", "stated_mm", "open", "variables", "cpu_s")
        }
        figures[name] |= {
            "told": len(told),
            "settled": sum(row["settled"] for row in rows),
            "worse": sum(row["after_mm"] > row["nominal_mm"] for row in rows),
            "worse_though_told": sum(row["after_mm"] > row["nominal_mm"] for row in told),
            "over_stated": float(
                np.mean([(row["after_mm"] / row["stated_mm"]) ** 2 for row in rows])
            ),
        }
    return {"seeds": seeds, "size": size, "errors": errors, "sets": figures, "trials": trials}


def show(figures: dict[str, Any]) -> None:
    """A table for people."""
    n = figures["seeds"]
    print(
        "senses      nominal   after  stated mm  told worse worse_though_told open (after/stated)^2"
    )
    for name, row in figures["sets"].items():
        lengths = " ".join(f"{row[key]:7.2f}" for key in ("nominal_mm", "after_mm", "stated_mm"))
        counts = f"{row['told']:2}/{n:<2} {row['worse']:5} {row['worse_though_told']:16}"
        print(f"{name:10} {lengths}   {counts} {row['open']:6.0f} {row['over_stated']:8.2f}")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Two arms calibrate themselves.")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--size", type=float, default=1.0, help="share of the usual samples")
    parser.add_argument("--errors", type=float, default=1.0, help="share of the usual errors")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = measure(options.seeds, options.size, options.errors)
    if options.json:
        print(json.dumps(figures))
    else:
        show(figures)


if __name__ == "__main__":
    main()
