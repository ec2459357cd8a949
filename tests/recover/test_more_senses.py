"""Pixels, distances, planes and gravity find a body whose frames nobody measured, honestly.

Joint zeros, a lens, a drum's zero and an accelerometer's offsets are drawn from their priors; the
frames at both ends are forgotten, placed by closed form and fitted. The normalised squared error of
what was drawn has mean 1 when the stated uncertainty is right.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.solver import Solver
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.seeds.pixel_poses import seen_poses
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import G, Gravity
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.planes import Planes
from bodyschema.senses.sense import Sense
from simulated import drawn, forgotten, random_pose

Array = NDArray[np.float64]

SEEDS, SAMPLES = 10, 60
ZEROS = 0.05
"""rad: prior of the joints' offsets."""

LEFT = {"pixels": 0.002, "distances": 0.006, "planes": 0.006, "gravity": 0.004}
"""rad: median over the seeds of the largest error of a middle joint's zero."""

CAMERA = Camera("a", "a", 640, 480, np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]]))
BOARD = 0.05 * np.stack([*np.mgrid[-1:2, -1:2], np.zeros((3, 3))], axis=-1).reshape(-1, 3)


@dataclass(frozen=True)
class Kind:
    """How a sense is made and which of its words are free."""

    see: Callable[[Body, Array], Sense]
    """From a body and postures (n, n_joints); observations need not be right."""
    part: tuple[str, parts.Part]


def boards(body: Body, q: Array) -> Pixels:
    """Nine corners in each of a quarter of the postures, those in the view."""
    n, m = SAMPLES // 2, len(BOARD)
    x, y, z = np.moveaxis(relative_pose(body, q, "a", "b")[:, :3, 3], 1, 0)
    q = q[(z > 0.6) & (np.hypot(x, y) < 0.5 * z)][:n]
    rows = np.repeat(np.arange(len(q)), m)
    target = np.tile(BOARD, (len(q), 1))
    image = np.zeros((len(rows), 2))
    return Pixels.make(q[rows], image, "a", "b", "part", target, time=rows, rows=rows)


def on_the_table(body: Body, q: Array) -> Planes:
    z = relative_pose(body, q, "a", "b")[:, 2, 3]
    near = np.argsort(np.abs(z - 0.02))[:SAMPLES]
    return Planes.make(q[near], "a", "b", z[near])


KINDS = {
    "pixels": Kind(boards, ("part", parts.lens(CAMERA))),
    "distances": Kind(
        lambda body, q: Distances.make(q[:SAMPLES], 1.0, "a", "b", sensor="part"),
        ("part", parts.sensor(("length",), ("m",), 0.05)),
    ),
    "planes": Kind(on_the_table, ("unused", parts.clock())),
    "gravity": Kind(
        lambda body, q: Gravity.make(
            q[:SAMPLES], np.tile([0, 0, G], (SAMPLES, 1)), "a", "b", sensor="part"
        ),
        ("part", parts.accelerometer()),
    ),
}


def robot(name: str, rng: np.random.Generator) -> Body:
    """An arm that carries b and has a beside it; for gravity the sensor a is on the arm."""
    arm = Body.random_chain(5, rng)
    part, made = KINDS[name].part
    arm = arm.with_part(part, made)
    if name == "gravity":
        return arm.attach("a", "tip", random_pose(rng)).attach("b", "base")
    if name == "planes":
        table = lie.transform(lie.exp_so3([*rng.normal(0, 0.2, 2), 0]), [0, 0, 0.05])
        return arm.attach("a", "base", table).attach("b", "tip", random_pose(rng, 0.1))
    far = 1.2 if name == "pixels" else 0.5
    R = lie.exp_so3(rng.normal(size=3))
    arm = arm.attach("a", "base", lie.transform(R, -far * R[:, 2]))
    return arm.attach("b", "tip", random_pose(rng, 0.1))


def variables_of(name: str, body: Body, sense: Sense) -> Variables:
    frames = [free_frame(body, f, only=s) for f, s in zip("ab", sense.shows, strict=True)]
    frames = [frame for frame in frames if name != "gravity" or "a." in frame.names[0]]
    joints = free_joints(body, ["offsets"])
    joints = joints.with_prior(np.full(len(joints), ZEROS))
    used = [free_part(body, "part")] if "part" in body.parts else []
    return join(joints, *frames, *used)


def started(name: str, body: Body, sense: Sense) -> Body:
    """With both ends placed from the samples; up is known."""
    unknown = ["a"] if name == "gravity" else ["a", "b"]
    blind = forgotten(body, unknown)
    if isinstance(sense, Pixels):
        poses = seen_poses(blind, sense)
        assert poses is not None
        return start_frames(blind, unknown, [poses])
    found = sense.start(blind, unknown)
    assert found is not None
    return found


def normalised_error(name: str, seed: int) -> tuple[Array, float]:
    """Error of what was drawn in the metric of its stated covariance; largest error of a zero, rad,
    of the middle joints: the first and the last go with an unknown frame.
    """
    rng = np.random.default_rng(seed)
    nominal = robot(name, rng)
    q = rng.uniform(-2, 2, (20 * SAMPLES, 5))
    variables = variables_of(name, nominal, KINDS[name].see(nominal, q))
    named = [i for i, group in enumerate(variables.groups) if "frame:" not in group]
    x = np.zeros(len(variables))
    x[named] = drawn(variables.take(named), rng)
    truth = nominal.with_variables(variables, x)
    sense = KINDS[name].see(truth, q)
    shown = sense.predict(truth)
    noise = np.sqrt(sense.covariance[0, 0]) * rng.normal(size=shown.shape)
    sense = replace(sense, observed=shown + noise, stated=True)
    solver = Solver(Loss(np.inf), learn_levels=False)
    fit = solver.fit(started(name, nominal, sense), variables, [sense])
    assert fit.converged
    left = (fit.x - x)[named]
    C = fit.covariance[np.ix_(named, named)]
    return left @ np.linalg.solve(C, left) / len(named), float(np.abs(left[1:4]).max())


@pytest.mark.parametrize("name", KINDS)
def test_errors_are_as_large_as_stated(name: str) -> None:
    errors, zeros = zip(*(normalised_error(name, seed) for seed in range(SEEDS)), strict=True)
    # 10 seeds of 5 to 14 numbers: one standard deviation is 0.12 to 0.2.
    assert 0.6 < np.mean(errors) < 1.5
    assert np.median(zeros) < LEFT[name]
