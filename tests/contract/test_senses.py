"""What every sense must keep: a new one joins by one line in SENSES."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense, concatenate
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]

SENSES: dict[str, Callable[[Array, Array], Sense]] = {
    "points": lambda q, T: Points.make(q, T[:, :3, 3], "camera", "tip"),
    "poses": lambda q, T: Poses.make(q, T, "camera", "tip"),
    "touches": lambda q, T: Touches.make(q, T[:, :3, :3] @ V + T[:, :3, 3], V, "camera", "tip"),
}
"""Name -> observations from q (n, n_joints) and the true T_camera_tip (n, 4, 4)."""

N = 6
V = np.array([0.1, -0.2, 0.3])


@pytest.fixture(scope="module")
def reference() -> Body:
    """A camera on the first link looks at the tip of the same arm: up-paths and down-paths."""
    arm = Body.random_chain(4, np.random.default_rng(0))
    return arm.attach("camera", "link_1", lie.transform(lie.exp_so3([0.3, 0.2, 0.9]), [0.2] * 3))


@pytest.fixture(scope="module")
def variables(reference: Body) -> Variables:
    return join(
        free_joints(reference), free_frame(reference, "camera"), free_frame(reference, "tip")
    )


@pytest.fixture(scope="module")
def truth(variables: Variables) -> Array:
    return np.random.default_rng(1).uniform(-0.3, 0.3, len(variables))


@pytest.fixture(scope="module", params=SENSES)
def sense(
    request: pytest.FixtureRequest, reference: Body, variables: Variables, truth: Array
) -> Sense:
    q = np.random.default_rng(2).uniform(-1, 1, (N, 4))
    body = reference.with_variables(variables, truth)
    return SENSES[request.param](q, relative_pose(body, q, "camera", "tip"))


def test_the_residual_is_zero_at_the_truth(
    sense: Sense, reference: Body, variables: Variables, truth: Array
) -> None:
    assert np.abs(sense.residual(reference.with_variables(variables, truth))).max() < 1e-14
    assert np.abs(sense.residual(reference)).max() > 1e-2


@pytest.mark.parametrize("at", ["zero", "near-truth"])
def test_linearize_agrees_with_the_residual_and_its_differences(
    sense: Sense, reference: Body, variables: Variables, truth: Array, at: str
) -> None:
    x, step = (0.0 if at == "zero" else 0.9) * truth, 1e-6
    L = sense.linearize(reference, variables, x)
    body = reference.with_variables(variables, x)
    assert L.residual == pytest.approx(sense.residual(body), abs=1e-14)
    for i, d in enumerate(step * np.eye(len(variables))):
        forth = sense.residual(reference.with_variables(variables, x + d))
        back = sense.residual(reference.with_variables(variables, x - d))
        assert L.by_parameter[:, :, i] == pytest.approx((forth - back) / (2 * step), abs=1e-7)
    for j, d in enumerate(step * np.eye(4)):
        forth = replace(sense, q=sense.q + d).residual(body)
        back = replace(sense, q=sense.q - d).residual(body)
        assert L.by_joint[:, :, j] == pytest.approx((forth - back) / (2 * step), abs=1e-7)


def test_shapes(sense: Sense, reference: Body, variables: Variables) -> None:
    m = len(sense.covariance)
    L = sense.linearize(reference, variables, np.zeros(len(variables)))
    assert L.residual.shape == sense.residual(reference).shape == (N, m)
    assert L.by_parameter.shape == (N, m, len(variables))
    assert L.by_joint.shape == (N, m, 4)


def test_the_covariance_is_symmetric_and_positive(sense: Sense) -> None:
    assert (sense.covariance == sense.covariance.T).all()
    assert np.linalg.eigvalsh(sense.covariance).min() > 0


def test_components_cover_every_row_once(sense: Sense) -> None:
    m = len(sense.covariance)
    covered = [row for _, _, part in sense.components for row in range(m)[part]]
    assert sorted(covered) == list(range(m))
    names = [name for name, _, _ in sense.components]
    assert len(set(names)) == len(names)
    assert {unit for _, unit, _ in sense.components} <= {"m", "rad", "px", "N", "N m", "1"}


@pytest.mark.parametrize("rows", [[4, 1], [0], [], slice(2, 5), np.arange(N) % 2 == 0])
def test_take_keeps_the_rows_it_is_asked_for(
    sense: Sense, reference: Body, variables: Variables, rows: object
) -> None:
    some = sense.take(rows)  # type: ignore[arg-type]
    assert type(some) is type(sense)
    for name in sense.arrays:
        assert (getattr(some, name) == getattr(sense, name)[rows]).all()
    assert some.residual(reference) == pytest.approx(sense.residual(reference)[rows], abs=1e-14)
    L = some.linearize(reference, variables, np.zeros(len(variables)))
    assert L.by_parameter.shape[0] == len(some) == len(np.arange(N)[rows])


def test_concatenate_undoes_take(sense: Sense, reference: Body) -> None:
    back = concatenate([sense.take(slice(0, 2)), sense.take([]), sense.take(slice(2, N))])
    assert type(back) is type(sense)
    assert back.residual(reference) == pytest.approx(sense.residual(reference), abs=1e-14)
    assert back.rows.tolist() == list(range(N))


def test_samples_that_are_no_numbers_are_refused(sense: Sense) -> None:
    for name in sense.arrays:
        if name == "rows":
            continue
        spoiled = getattr(sense, name).copy()
        spoiled[3] = np.nan
        with pytest.raises(InputError, match=rf"{sense.label}: .* row 3"):
            replace(sense, **{name: spoiled})
