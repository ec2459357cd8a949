"""What is written of a body that was tracked: what is not told stays as modelled."""

from __future__ import annotations

import numpy as np

from bodyschema import Body, free_frame, free_joints
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability, OpenDirection
from bodyschema.learners.images.settled import settled
from bodyschema.model.variables import join


def fitted(open_names: tuple[str, ...]) -> tuple[Estimate, Identifiability]:
    """Three offsets and a camera, correlated, one direction of them open."""
    rng = np.random.default_rng(4)
    body = Body.random_chain(3, rng).attach("eye", "base")
    offsets = free_joints(body, ["offsets"])
    variables = join(offsets.with_prior(np.full(3, 0.1)), free_frame(body, "eye", 0.05, 0.1))
    A = rng.normal(size=(20, len(variables)))
    x = 0.05 * rng.normal(size=len(variables))
    share = np.array([0.9 if name in open_names else 0.0 for name in variables.names])
    known = Identifiability(8, (OpenDirection(open_names, True, "open."),), share)
    return Estimate(body, variables, x, 1e3 * A.T @ A), known


def test_an_open_offset_stays_as_modelled_and_the_others_follow() -> None:
    estimate, known = fitted(("joint_2.offset",))
    names = estimate.variables.names
    open_one = names.index("joint_2.offset")
    found, kept = settled(estimate, known)
    assert kept == ("joint_2.offset",)
    assert found.x[open_one] == 0
    # The least costly point of the belief among those with that offset at zero.
    L = np.linalg.cholesky(estimate.information).T
    free = np.arange(len(names)) != open_one
    best = np.linalg.lstsq(L[:, free], L @ estimate.x, rcond=None)[0]
    np.testing.assert_allclose(found.x[free], best, atol=1e-12)


def test_an_offset_that_goes_with_a_camera_is_kept_with_it() -> None:
    estimate, known = fitted(("joint_1.offset", "eye.turn_z"))
    found, kept = settled(estimate, known)
    assert kept == ()
    np.testing.assert_array_equal(found.x, estimate.x)
