"""Fits that are hard for one reason each, for the benchmark and the tests of the solver.

All but the recordings are random arms whose joints, axes and links are wrong by a third of their
prior, with a tracker beside the base and a tool on the tip that nobody has measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import bodyschema as bs
import recordings
from bodyschema import lie
from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.sense import Sense

FULL = ("offsets", "axes", "links")
MODELS = (("offsets",), ("offsets", "axes"), FULL)
WRONG = 0.3
"""Of the prior: how wrong an arm is."""


@dataclass(frozen=True)
class Bed:
    """What is to be fitted."""

    problem: Problem
    groups: tuple[str, ...] = FULL
    bad: tuple[np.ndarray, ...] = ()
    """(n,) which samples of each sense were spoiled."""

    def fit(self, solver: bs.Solver) -> bs.Estimate:
        """Fit all samples; the frames have been placed before."""
        p = self.problem
        return solver.fit(p.begun, p.variables(self.groups), p.senses)


def bed(
    body: bs.Body,
    senses: Sequence[Sense],
    frames: Sequence[str],
    groups: tuple[str, ...] = FULL,
    bad: Sequence[np.ndarray] = (),
) -> Bed:
    """A bed in which all joints may be wrong and some frames are unknown."""
    problem = Problem(body, tuple(senses), dict.fromkeys(frames, "no"), body.joints)
    return Bed(problem, groups, tuple(bad))


def arm(n_joints: int, rng: np.random.Generator, reach: float = 1.0) -> tuple[bs.Body, bs.Body]:
    """An arm as modelled, without its frames, and the real one; the tracker within +-reach m."""
    body = bs.Body.random_chain(n_joints, rng).attach("tracker", "base").attach("tool", "tip")
    wrong = bs.free_joints(body, FULL)
    truth = body.with_variables(wrong, WRONG * wrong.prior_std * rng.normal(size=len(wrong)))
    for frame, within in (("tracker", reach), ("tool", 0.1)):
        truth = truth.with_placement(frame, placed(rng, rng.uniform(-within, within, 3)))
    return body, truth


def placed(rng: np.random.Generator, at: np.ndarray) -> np.ndarray:
    """A random orientation at a place, (4, 4)."""
    return lie.transform(lie.exp_so3(rng.normal(size=3)), at)


def seen(
    truth: bs.Body,
    q: np.ndarray,
    noise: tuple[float, float],
    kind: str,
    rng: np.random.Generator,
    ends: tuple[str, str] = ("tracker", "tool"),
    read: np.ndarray | None = None,
) -> Sense:
    """Points or poses with noise (m and rad); the encoders read `read` where the arm is at q."""
    T = relative_pose(truth, q, *ends).copy()
    T[:, :3, 3] += noise[0] * rng.normal(size=(len(q), 3))
    if kind == "points":
        return bs.Points.make(q if read is None else read, T[:, :3, 3], *ends)
    T[:, :3, :3] = lie.exp_so3(noise[1] * rng.normal(size=(len(q), 3))) @ T[:, :3, :3]
    return bs.Poses.make(q if read is None else read, T, *ends)


def spoil(
    sense: Sense, share: float, size: float, rng: np.random.Generator
) -> tuple[Sense, np.ndarray]:
    """A share of the samples shifted by `size` m in random directions, and which."""
    bad = np.zeros(len(sense), dtype=bool)
    bad[rng.choice(len(sense), round(share * len(sense)), replace=False)] = True
    shift = rng.normal(size=(len(sense), 3))
    shift *= size * bad[:, None] / np.linalg.norm(shift, axis=1, keepdims=True)
    observed = sense.observed.copy()
    (observed if observed.ndim == 2 else observed[:, :3, 3])[...] += shift
    return replace(sense, observed=observed), bad


def grid(
    seed: int,
    outliers: int = 22,
    rows: int = 148,
    noise: float = 6e-6,
    wave: float = 0.15e-3,
    distance: float = 2.8,
    reach: float = 0.4,
    still: bool = True,
    kind: str = "points",
    groups: tuple[str, ...] = FULL,
) -> Bed:
    """A precise tracker, a timid arm: six joints go through a grid of three freedoms.

    Args:
        seed: of the arm.
        outliers: rows that are off by 3 cm.
        rows: of the 216 of the grid.
        noise: m; rotations of poses have 0.1 mrad.
        wave: rad, amplitude of a sine error of every encoder.
        distance: m, of the tracker.
        reach: rad; joints go 0.15 to this far either way.
        still: a turntable below that never moves.
        kind: "points" or "poses".
        groups: of the model.
    """
    rng = np.random.default_rng(seed)
    body, truth = arm(7 if still else 6, rng)
    away = rng.normal(size=3)
    there = placed(rng, distance * away / np.linalg.norm(away))
    truth = truth.with_placement("tracker", there)
    nodes = np.stack(np.meshgrid(*[np.linspace(-1, 1, 6)] * 3, indexing="ij"), axis=-1)
    at = nodes.reshape(-1, 3)[rng.choice(216, rows, replace=False)]
    swing = rng.choice([-1.0, 1.0], 6) * rng.uniform(0.15, reach, 6)
    q = rng.uniform(-1, 1, 6) + np.tile(at, 2) * swing
    if still:
        q = np.hstack([np.full((rows, 1), 0.3), q])
    real = q + wave * np.sin(3 * q + rng.uniform(0, 6, q.shape[1]))
    sense = seen(truth, real, (noise, 1e-4), kind, rng, read=q)
    sense, bad = spoil(sense, outliers / rows, 0.03, rng)
    return bed(body, [sense], ("tracker", "tool"), groups, [bad])


VARIANTS: dict[str, dict[str, float | int | bool | str]] = {
    "as it was": {},
    "clean": {"outliers": 0},
    "no wave": {"wave": 0.0},
    "large wave": {"wave": 1e-3},
    "60 um": {"noise": 60e-6},
    "1 mm": {"noise": 1e-3},
    "near": {"distance": 1.0},
    "far": {"distance": 6.0},
    "timid": {"reach": 0.2},
    "bold": {"reach": 1.0},
    "60 rows": {"rows": 60, "outliers": 9},
    "all rows": {"rows": 216, "outliers": 32},
    "no turntable": {"still": False},
    "poses": {"kind": "poses"},
    "one in twenty": {"outliers": 7},
    "one in four": {"outliers": 37},
}
"""The bed of `grid` and what else may be wrong with it."""


def narrow(kind: str = "points", noise: float = 6e-6, seed: int = 0) -> Bed:
    """A hundred postures within 0.15 rad of one."""
    rng = np.random.default_rng(seed)
    body, truth = arm(6, rng, 1.5)
    q = rng.uniform(-1, 1, 6) + 0.15 * rng.uniform(-1, 1, (100, 6))
    return bed(body, [seen(truth, q, (noise, 1e-3), kind, rng)], ("tracker", "tool"))


def many(n: int, kind: str = "points", seed: int = 0) -> Bed:
    """Seven joints, n samples, one in ten off by 3 cm."""
    rng = np.random.default_rng(seed)
    body, truth = arm(7, rng)
    sense = seen(truth, rng.uniform(-2, 2, (n, 7)), (1e-3, 5e-3), kind, rng)
    sense, bad = spoil(sense, 0.1, 0.03, rng)
    return bed(body, [sense], ("tracker", "tool"), bad=[bad])


def three_senses(seed: int = 0) -> Bed:
    """A camera, and a tracker of two markers; one in twenty off by 20 cm."""
    rng = np.random.default_rng(seed)
    body, truth = arm(6, rng)
    for name, parent, reach in (("camera", "base", 1.0), ("marker", "link_4", 0.1)):
        body = body.attach(name, parent)
        truth = truth.attach(name, parent, placed(rng, rng.uniform(-reach, reach, 3)))
    looks = (
        ("poses", 150, (2e-3, 4e-3), ("camera", "tool")),
        ("points", 120, (1e-3, 0.0), ("tracker", "tool")),
        ("points", 120, (5e-4, 0.0), ("tracker", "marker")),
    )
    clean = [
        seen(truth, rng.uniform(-2, 2, (n, 6)), noise, kind, rng, ends)
        for kind, n, noise, ends in looks
    ]
    senses, bad = zip(*(spoil(sense, 0.05, 0.2, rng) for sense in clean), strict=True)
    return bed(body, senses, ("tracker", "camera", "tool", "marker"), bad=bad)


def drawn(seed: int) -> Bed:
    """A random arm, spread, noise, sense, share of outliers and model."""
    rng = np.random.default_rng(1000 + seed)
    joints, n = int(rng.integers(3, 8)), int(rng.integers(40, 250))
    kind, noise = str(rng.choice(["points", "poses"])), 10 ** rng.uniform(-5, -2.3)
    body, truth = arm(joints, rng)
    spread = rng.uniform(0.3, 2) * rng.uniform(-1, 1, (n, joints))
    q = rng.uniform(-1, 1, joints) + spread
    sense, bad = spoil(
        seen(truth, q, (noise, 3 * noise), kind, rng), rng.choice([0, 0.05, 0.15]), 0.03, rng
    )
    return bed(body, [sense], ("tracker", "tool"), MODELS[rng.integers(3)], [bad])


def fr3(data: Path, size: float) -> Bed:
    """FR3 eye in hand, 15 % of its poses shifted by `size` m."""
    body, q, pose = recordings.fr3(data)
    sense = bs.Poses.make(q, recordings.corrupted(pose, size), "board", "camera")
    return bed(body, [sense], ("board", "camera"))


def talos(data: Path) -> Bed:
    """The left arm of TALOS."""
    body, sense = recordings.talos_recording(data)
    return bed(body, [sense], ("tracker", "point"))


def table(data: Path) -> dict[str, Callable[[], Bed]]:
    """The beds of the benchmark."""
    return {
        "fr3 clean": lambda: fr3(data, 0.0),
        "fr3, 15 % at 3 cm": lambda: fr3(data, 0.03),
        "fr3, 15 % at 20 cm": lambda: fr3(data, 0.2),
        "talos": lambda: talos(data),
        "narrow points": narrow,
        "narrow poses": lambda: narrow("poses", 1e-4, 1),
        "7 joints, 300 points": lambda: many(300),
        "7 joints, 3,000 poses": lambda: many(3000, "poses"),
        "7 joints, 10,000 points": lambda: many(10_000),
        "three senses": three_senses,
        "grid, a joint that never moves": lambda: grid(0),
    }
