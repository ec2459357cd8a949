"""What is written of a body that was tracked: what is not told stays as modelled."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bodyschema import Body, free_frame, free_joints
from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability, OpenDirection
from bodyschema.export.corrections import read_corrections
from bodyschema.export.tracked_files import Settled
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.variables import join


@dataclass(frozen=True)
class Fit:
    """As much of a fit as is read."""

    estimate: Estimate
    identifiability: Identifiability
    lost: bool = False


def fitted(open_names: tuple[str, ...]) -> Fit:
    """Three offsets and a camera, correlated, one direction of them open."""
    rng = np.random.default_rng(4)
    body = Body.random_chain(3, rng).attach("eye", "base")
    offsets = free_joints(body, ["offsets"])
    variables = join(offsets.with_prior(np.full(3, 0.1)), free_frame(body, "eye", 0.05, 0.1))
    A = rng.normal(size=(20, len(variables)))
    x = 0.05 * rng.normal(size=len(variables))
    share = np.array([0.9 if name in open_names else 0.0 for name in variables.names])
    known = Identifiability(8, (OpenDirection(open_names, True, "open."),), share)
    return Fit(Estimate(body, variables, x, 1e3 * A.T @ A), known)


def settled(fit: Any) -> Settled:
    return Settled.of(fit)


def test_an_open_offset_stays_as_modelled_and_the_others_follow() -> None:
    fit = fitted(("joint_2.offset",))
    names, x_hat = fit.estimate.variables.names, fit.estimate.x
    open_one = names.index("joint_2.offset")
    found = settled(fit)
    assert found.kept == ("joint_2.offset",)
    assert found.x[open_one] == 0
    # The least costly point of the belief among those with that offset at zero.
    L = np.linalg.cholesky(fit.estimate.information).T
    free = np.arange(len(names)) != open_one
    best = np.linalg.lstsq(L[:, free], L @ x_hat, rcond=None)[0]
    np.testing.assert_allclose(found.x[free], best, atol=1e-12)
    assert set(found.corrections) == {"joint_1.offset", "joint_2.offset", "joint_3.offset"}


def test_an_offset_that_goes_with_a_camera_is_kept_with_it(tmp_path: Path) -> None:
    fit = fitted(("joint_1.offset", "eye.turn_z"))
    found = settled(fit)
    assert found.kept == ()
    np.testing.assert_array_equal(found.x, fit.estimate.x)
    nominal = Body.random_chain(3, np.random.default_rng(4))
    (tmp_path / "arm.urdf").write_bytes(write_urdf(nominal))
    files = found.files(tmp_path / "arm.urdf", nominal)
    assert set(files) == {"robot.urdf", "kinematics.yaml", "transforms.yaml"}
    (entry,) = yaml.safe_load(files["transforms.yaml"])["transforms"]
    k = found.body.frame_index("eye")
    np.testing.assert_allclose(entry["xyz"], found.body.placement[k, :3, 3], atol=1e-9)
    (tmp_path / "new.urdf").write_bytes(files["robot.urdf"])
    again = Body.from_urdf(tmp_path / "new.urdf")
    assert not np.allclose(again.placement, nominal.placement)


def test_corrections_are_read_back_from_an_answer_of_track(tmp_path: Path) -> None:
    path = tmp_path / "track.json"
    path.write_text('{"lost": false, "corrections": {"elbow.offset": 0.1}}')
    assert read_corrections(tmp_path) == {"elbow.offset": 0.1}
    path.write_text('{"lost": true, "corrections": {}}')
    with pytest.raises(InputError, match="was not found"):
        read_corrections(tmp_path)
    path.write_text('{"lost": false}')
    with pytest.raises(InputError, match="no answer of track"):
        read_corrections(tmp_path)
