"""How far a calibration from rendered boards is from the truth, and from what it says of itself.

The bound is Cramer and Rao's: corners whose noise is that of the corners as detected (against where
they truly are), all else as the fit has it. It is what no unbiased estimate of these numbers beats.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.cli.loading import load
from bodyschema.cli.run_file import read_run_file
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.parts import lens
from bodyschema.senses.pixels import Pixels
from bodyschema.simulation.wrist_camera import WristCamera, simulate_wrist_camera
from rendered_board import Truth, true_camera, write_rendered_folder

Array = NDArray[np.float64]

OFFSETS = ("offsets",)
FRESH, DRAWS, STANDARD = 40, 400, 1.96
"""Postures in which errors are measured, draws from a covariance, and sd of a 95 % bar."""


@dataclass(frozen=True)
class Trial:
    """One rendered run."""

    off: Array
    """(n, 3) m, of the camera in the board at fresh postures."""
    turned: Array
    """(n, 3) rad."""
    bound: float
    """m rms, of `off`."""
    inside: Array
    """(k,) whether zeros and (n, 3) places are within their 95 % bars, in one row."""
    zeros: Array
    """(4,) rad, errors of the zeros that pictures tell."""
    noise: float
    """px rms, of corners as detected."""


def trial(which: str, pictures: int, seed: int) -> Trial:
    """Render, calibrate and compare with the truth."""
    with tempfile.TemporaryDirectory() as name:
        truth = write_rendered_folder(Path(name), which, pictures, seed)
        loaded = load(read_run_file(Path(name) / "run.toml"))
    joints = loaded.nominal.joints[1:-1]
    problem = Problem(loaded.body, loaded.senses, loaded.frames, joints, parts=loaded.parts)
    found = problem.fit(problem.variables(OFFSETS), loaded.senses)
    true = true_body(truth)
    noise = corner_noise(true, [s for s in loaded.senses if isinstance(s, Pixels)])
    q = simulate_wrist_camera(WristCamera(FRESH, 100 + seed, 2.0, 0.0, 0.0)).postures.q
    here, there = (relative_pose(body, q, "board", "camera") for body in (found.body, true))
    error = lie.inverse(there) @ here
    off = here[:, :3, 3] - there[:, :3, 3]
    least = covariance(found, loaded.senses, noise)
    spread = np.sqrt(np.mean(places(found, found.covariance, q) ** 2, axis=0))
    zeros, std = zero_errors(found, truth)
    return Trial(
        off,
        lie.log_so3(error[:, :3, :3]),
        float(np.sqrt(np.mean(np.sum(places(found, least, q) ** 2, axis=2)))),
        np.concatenate([np.abs(zeros) < STANDARD * std, (np.abs(off) < STANDARD * spread).ravel()]),
        zeros,
        noise,
    )


def figures(which: str, pictures: int, seeds: int) -> dict[str, float]:
    """The figures of several seeds."""
    trials = [trial(which, pictures, seed) for seed in range(seeds)]

    def rms(values: list[Array]) -> float:
        return float(np.sqrt(np.mean(np.sum(np.concatenate(values) ** 2, axis=-1))))

    zeros = np.concatenate([one.zeros for one in trials])
    return {
        "camera_mm": round(1e3 * rms([one.off for one in trials]), 3),
        "camera_deg": round(float(np.degrees(rms([one.turned for one in trials]))), 4),
        "bound_mm": round(1e3 * float(np.sqrt(np.mean([one.bound**2 for one in trials]))), 3),
        "coverage": round(float(np.mean(np.concatenate([one.inside for one in trials]))), 3),
        "zero_deg": round(float(np.degrees(np.sqrt(np.mean(zeros**2)))), 4),
        "corner_px": round(float(np.sqrt(np.mean([one.noise**2 for one in trials]))), 3),
    }


def true_body(truth: Truth) -> bs.Body:
    """The arm with its frames, its true zeros and its true lenses."""
    body = truth.body
    zeros = bs.free_joints(body, OFFSETS, truth.believed.joints)
    body = body.with_variables(zeros, truth.offsets)
    for name, one in truth.fixed.items():
        if one.target is None:
            body = body.with_part(f"lens_of_{name}", lens(true_camera(name, one)))
    return body


def corner_noise(true: bs.Body, senses: list[Pixels]) -> float:
    """rms of a coordinate of the corners as detected, px."""
    exact = [s.observed - replace(s, scale="").predict(true) for s in senses]
    return float(np.sqrt(np.mean(np.concatenate(exact) ** 2)))


def covariance(found: Estimate, senses: tuple[bs.Sense, ...], noise: float) -> Array:
    """Cramer and Rao's bound of the variables, for corners of a known noise, px."""
    information = np.diag(found.variables.prior_std**-2.0)
    for sense in senses:
        J = sense.linearize(found.reference, found.variables, found.x).by_parameter
        flat = J.reshape(-1, J.shape[-1])
        information = information + flat.T @ flat / noise**2
    return np.linalg.inv(information)


def places(found: Estimate, spread: Array, q: Array) -> Array:
    """Draws of how far the camera is off in the board, (DRAWS, n, 3) m."""
    rng = np.random.default_rng(0)
    here = relative_pose(found.body, q, "board", "camera")[:, :3, 3]
    draws = rng.multivariate_normal(found.x, spread, DRAWS, check_valid="ignore")
    bodies = (found.reference.with_variables(found.variables, x) for x in draws)
    return np.array([relative_pose(b, q, "board", "camera")[:, :3, 3] - here for b in bodies])


def zero_errors(found: Estimate, truth: Truth) -> tuple[Array, Array]:
    """Errors of the zeros that pictures tell, and their standard deviations, rad."""
    std = np.sqrt(np.diag(found.covariance))
    named = [
        (k, name.removesuffix(".offset"))
        for k, name in enumerate(found.variables.names)
        if name.endswith(".offset")
    ]
    true = [truth.offsets[truth.believed.joints.index(joint)] for _, joint in named]
    which = [k for k, _ in named]
    return found.x[which] - np.array(true), std[which]
