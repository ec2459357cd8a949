"""Random serial chains, drawn in compiled code: what the studies of chains have in common.

Node 0 is the root, nodes 1 .. n turn about unit axes that are uniform on the sphere, and node n + 1
is a fixed tip. All n + 1 links point anywhere, with lengths uniform in 0.5 .. 1.5, so that the mean
link is L = 1. An untaught chain has axes uniform on the sphere as well, and links whose coordinates
are normal with standard deviation 0.05.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kernels import FIXED, REVOLUTE, kernel
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Generator = Any
"""np.random.Generator; compiled code draws the same numbers from it as Python does."""

SHORTEST, LONGEST = 0.5, 1.5
SMALL = 0.05


def run_generator(seed: int, n_joints: int, run: int) -> np.random.Generator:
    """The randomness of one run: the same in whatever order and process the runs are done."""
    return np.random.default_rng([seed, n_joints, run])


def chain_kinds(n_joints: int) -> Ints:
    """(n + 2,) kinds of the nodes."""
    return np.array([FIXED, *[REVOLUTE] * n_joints, FIXED], dtype=np.int64)


def chain_body(axes: Array, links: Array) -> Body:
    """The body of a chain, frames "base", "link_1" .. "link_n", "tip"."""
    n = len(axes) - 2
    numbers = [str(i) for i in range(1, n + 1)]
    return Body.build(
        name=f"chain_{n}",
        frames=["base", *("link_" + i for i in numbers), "tip"],
        carriers=["", *("joint_" + i for i in numbers), "tip_joint"],
        parent=range(-1, n + 1),
        kind=chain_kinds(n).tolist(),
        axis=axes,
        placement=lie.transform(np.tile(np.eye(3), (n + 2, 1, 1)), links),
    )


@kernel
def fill(rng: Generator, out: Array) -> None:
    """Uniform numbers in 0 .. 1; in blocks, as a generator is slow to hand from call to call."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = rng.random()


@kernel
def direction(u: float, w: float, out: Array) -> None:
    """The unit vector of two numbers in 0 .. 1, uniform on the sphere if they are (Archimedes)."""
    z, phi = 2.0 * u - 1.0, 2.0 * np.pi * w
    across = np.sqrt(1.0 - z * z)
    out[0], out[1], out[2] = across * np.cos(phi), across * np.sin(phi), z


@kernel
def draw_chain(rng: Generator, axes: Array, links: Array) -> None:
    """A true chain: axes and links (n + 2, 3)."""
    for k in range(axes.shape[0]):
        direction(rng.random(), rng.random(), axes[k])
        direction(rng.random(), rng.random(), links[k])
        length = SHORTEST + (LONGEST - SHORTEST) * rng.random()
        for j in range(3):
            links[k, j] *= length
    links[0] = 0.0


@kernel
def draw_untaught(rng: Generator, axes: Array, links: Array) -> None:
    """The chain of a learner that knows nothing: axes and links (n + 2, 3)."""
    for k in range(axes.shape[0]):
        direction(rng.random(), rng.random(), axes[k])
        for j in range(3):
            links[k, j] = SMALL * rng.standard_normal()
    links[0] = 0.0


@kernel
def length_of(rows: Array) -> float:
    """Summed lengths of vectors (n, 3)."""
    total = 0.0
    for k in range(rows.shape[0]):
        total += np.sqrt(rows[k, 0] ** 2 + rows[k, 1] ** 2 + rows[k, 2] ** 2)
    return total
