"""What pictures and pieces contradict each other widens the error bars by as much as they err."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.images.disagreement import WITHOUT_MASKS, Disagreement, Part
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM).with_prior(np.full(7, 0.1))
POSTURES = (0, 4, 9, 14, 17)


def thicker(millimetres: float, seed: int) -> bs.Surface:
    """The arm with waves on its skin, of so many mm root mean square."""
    rng, skin, parts = np.random.default_rng(seed), arm(), {}
    for k, name in enumerate(skin.frames):
        V = skin.vertices[skin.vo[k] : skin.vo[k + 1]]
        F = skin.faces[skin.fo[k] : skin.fo[k + 1]] - skin.vo[k]
        normal, across = np.zeros_like(V), np.cross(*np.diff(V[F], axis=1).swapaxes(0, 1))
        for corner in range(3):
            np.add.at(normal, F[:, corner], across)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        wave = 2 * np.pi * rng.normal(size=(6, 3)) / (0.7 * np.ptp(V, axis=0).max())
        height = np.cos(V @ wave.T + rng.uniform(0, 2 * np.pi, 6)).sum(axis=1) / np.sqrt(3)
        parts[name] = (V + 1e-3 * millimetres * height[:, None] * normal, F)
    return bs.Surface.build(parts)


@cache
def fitted(millimetres: float, seed: int) -> tuple[MarkerlessFit, Array]:
    """A fit by the meshes as modelled, and its error (7,) rad."""
    truth = np.random.default_rng(seed).uniform(-0.05, 0.05, 7)
    skin = thicker(millimetres, seed) if millimetres else arm()
    body, frames = BODY.with_variables(OFFSETS, truth), []
    for i in POSTURES:
        q = readings(20)[i]
        T = piece_poses(body, q, eyes(), skin.frames)[0]
        shown = tuple(silhouette(skin, pose, c) for pose, c in zip(T, eyes(), strict=True))
        frames.append(Images(float(i), q, tuple(eyes()), shown))
    fit = Markerless(arm(), seeds=0).fit(BODY, OFFSETS, frames)
    return fit, fit.estimate.x - truth


def test_a_mesh_that_is_wrong_by_three_times_the_doubt_is_in_the_error_bars() -> None:
    squares, bare = [], []
    for seed in range(4):
        fit, off = fitted(1.0, seed)
        square = float(off @ np.linalg.solve(fit.estimate.covariance, off)) / 7
        squares.append(square)
        bare.append(square * fit.disagreement.kappa)
    assert np.mean(bare) > 5
    assert np.mean(squares) < 2


def test_where_nothing_is_wrong_nothing_is_widened() -> None:
    for seed in range(2):
        assert fitted(0.0, seed)[0].disagreement.kappa < 1.3


def test_wrong_meshes_are_told_by_the_pieces_themselves() -> None:
    right, wrong = fitted(0.0, 1)[0].disagreement, fitted(1.0, 1)[0].disagreement
    assert wrong.by_piece > 4 * right.by_piece
    assert wrong.by_doubt > 4 * right.by_doubt
    np.testing.assert_allclose(wrong.piece_shares.sum(), wrong.by_piece)


def parts(seed: int, n: int, size: int = 3) -> tuple[list[Part], Array]:
    """Rows of noise 1 in n parts of 40, and the estimate by all."""
    rng, made = np.random.default_rng(seed), []
    x = rng.normal(size=size)
    J = rng.normal(size=(n, 40, size))
    y = J @ x + rng.normal(size=(n, 40))
    H = np.einsum("kni,knj->kij", J, J)
    z = np.linalg.solve(H.sum(axis=0) + np.eye(size), np.einsum("kni,kn->i", J, y))
    for k in range(n):
        made.append(Part(H[k], J[k].T @ (y[k] - J[k] @ z)))
    return made, z


def test_an_estimate_without_a_part_is_that_of_the_others() -> None:
    made, z = parts(0, 4)
    alone = Disagreement(tuple(made), (), (), np.ones(3), z, 3)
    g = sum(part.u + part.H @ z for part in made[1:])
    H = sum(part.H for part in made[1:]) + np.eye(3)
    np.testing.assert_allclose(alone.without(0), np.linalg.solve(H, g), rtol=1e-9)


def test_parts_that_differ_by_noise_alone_have_a_factor_of_one() -> None:
    found = []
    for seed in range(40):
        made, z = parts(seed, 12)
        one = Disagreement(tuple(made), tuple(made), ("",) * 12, np.ones(3), z, 3)
        found.append((one.by_piece, one.by_moment / (2.201 / 1.96) ** 2, one.by_half))
    np.testing.assert_allclose(np.mean(found, axis=0), 1.0, atol=0.2)


def test_one_moment_or_one_piece_contradicts_nobody() -> None:
    made, z = parts(0, 1)
    one = Disagreement(tuple(made), tuple(made), ("",), np.ones(3), z, 3)
    assert one.by_moment == one.by_piece == one.by_half == 1.0
    assert one.kappa == 1.0
    unmasked = Disagreement(tuple(made), tuple(made), ("",), np.ones(3), z, 3, masked=False)
    assert unmasked.kappa == WITHOUT_MASKS
