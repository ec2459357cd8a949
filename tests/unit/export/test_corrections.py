"""Corrections and loads of an answer in another description of the robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.export.corrections import corrected_urdf, joint_corrections
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.tree import Body

FLANGE = {"mass": 0.5, "com": [0.0, 0.0, 0.1], "inertia": np.diag([1e-3, 1e-3, 1e-3]).tolist()}
LOADED = {"loads": [{"name": "cup", "flange": FLANGE}], "sensor": {"link": "tip"}}


def test_joints_are_corrected_and_frames_left_out(case: Any) -> None:
    wanted = joint_corrections(case.calibration)
    # What the unknown camera and marker hide is not written: the first joint's zero, and the last.
    assert set(wanted) == {"joint_2.offset", "joint_3.offset"}
    patched, changed = corrected_urdf(case.calibration, case.source, case.nominal)
    assert changed == ["joint_2", "joint_3"]
    assert patched != case.source


def test_a_load_is_hung_on_its_link(case: Any) -> None:
    answer = replace(case.calibration, details=LOADED)
    patched, changed = corrected_urdf(answer, case.source, case.nominal)
    assert changed[-1] == "tip: cup"
    assert b'<link name="payload_cup">' in patched


def test_what_may_not_be_put_on_a_robot_is_refused(case: Any) -> None:
    for verdict in ("refused", "not found", "not known"):
        with pytest.raises(InputError, match="nothing to export"):
            corrected_urdf(replace(case.calibration, verdict=verdict), case.source, case.nominal)
    none = case.calibration.estimate.variables.where(["frame:camera"])
    kept = [case.calibration.estimate.variables.names.index(name) for name in none.names]
    fit = case.calibration.estimate
    bare = replace(
        fit,
        variables=none,
        x=fit.x[kept],
        data_information=fit.data_information[np.ix_(kept, kept)],
    )
    with pytest.raises(InputError, match="corrects no joint"):
        corrected_urdf(replace(case.calibration, fit=bare), case.source, case.nominal)


def test_another_robot_is_told_apart(case: Any) -> None:
    other = Body.random_chain(2, np.random.default_rng(0))
    with pytest.raises(InputError, match="has no joint_3"):
        corrected_urdf(case.calibration, write_urdf(other), other)
