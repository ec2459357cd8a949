"""What `calibrate` says of recordings that are not what they are declared to be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.answers.calibrate import calibrate
from bodyschema.answers.lookout import Lookout, recorded
from bodyschema.estimation.problem import Knowledge, Problem
from bodyschema.senses.poses import Poses
from bodyschema.trust.declarations import Recorded
from simulated import points, poses, postures, seen_arm

UNKNOWN: dict[str, Knowledge] = {"tracker": "no", "tool": "no"}


def test_a_wrong_declaration_contradicts_the_answer() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    seen = poses(body, postures(30, body, rng), rng)
    back = replace(seen, observed=np.linalg.inv(seen.observed))
    answer = calibrate(body, [back], UNKNOWN, groups=["offsets"])
    assert answer.trust.level == "contradicted"
    assert answer.withheld
    assert "inverse = true" in answer.trust.reasons[0]


def test_rows_that_do_not_belong_together_contradict_it_without_a_name() -> None:
    rng = np.random.default_rng(1)
    body = seen_arm(5, rng)
    seen = poses(body, postures(30, body, rng), rng)
    mixed = replace(seen, q=seen.q[rng.permutation(30)])
    answer = calibrate(body, [mixed], UNKNOWN, groups=["offsets"])
    assert answer.trust.level == "contradicted"
    assert answer.withheld
    assert any("rows do not belong together" in reason for reason in answer.trust.reasons)


def test_zeros_far_off_are_found_and_told() -> None:
    """A fit that begins at the description ends 380 mm off."""
    rng = np.random.default_rng(0)
    body = seen_arm(6, rng)
    truth = replace(body, offset=np.deg2rad([0, 90, -45, 90, 45, 0]))
    seen = points(truth, postures(40, body, rng), rng)
    answer = calibrate(body, [seen], UNKNOWN, groups=["offsets"])
    assert answer.verdict == "calibrated"
    assert answer.held_out.position.rms < 4e-3
    [told] = [finding for finding in answer.findings if "far from the description" in finding]
    assert "joint_2 +9" in told or "joint_2 +8" in told
    assert "joint_3 -4" in told


def test_a_scale_that_zeros_hide_is_found_by_fits() -> None:
    """A tenth of the length is less than what 6 degrees do."""
    rng = np.random.default_rng(3)
    body = seen_arm(6, rng)
    truth = replace(body, offset=0.1 * rng.normal(size=6))
    seen = points(truth, postures(48, body, rng), rng)
    wrong = replace(seen, observed=seen.observed / 1.1)
    problem = Problem(body, (wrong,), UNKNOWN, body.joints)
    [named, *_] = Lookout.at(problem, {}, True).named
    assert named.declaration.key == "scale"
    assert named.declaration.size == pytest.approx(1.1, abs=0.02)
    right = Problem(body, (seen,), UNKNOWN, body.joints)
    assert not Lookout.at(right, {}, True).named


def test_what_a_run_file_declares() -> None:
    rng = np.random.default_rng(4)
    body = seen_arm(4, rng)
    seen = poses(body, postures(6, body, rng), rng)
    entry = {"kind": "poses", "seen_from": "tracker", "seen": "tool", "layout": "xyz_rpy",
             "unit": "mm", "angle_unit": "deg"}  # fmt: skip
    other = Poses.make(seen.q, seen.pose, "base", "tool")
    found = recorded({"senses": [entry]}, [seen, other])
    assert found == {seen.label: Recorded("xyz_rpy", "mm", "deg")}


def test_a_gain_that_is_free_is_no_wrong_declaration() -> None:
    """What one percent of a lost calibration is, the fit finds itself."""
    rng = np.random.default_rng(2)
    body = seen_arm(5, rng)
    truth = replace(body, gear=np.array([0, 0.25, -0.1, 0.2, 0]))
    seen = poses(truth, postures(30, body, rng), rng)
    problem = Problem(body, (seen,), UNKNOWN, body.joints)
    assert Lookout.at(problem, {}, fits=True).named[0].declaration.joint >= 0
    free = {"free": {"groups": ["offsets", "gears"]}}
    assert not Lookout.at(problem, free, fits=True).named
    right = poses(body, postures(30, body, rng), rng)
    back = replace(right, observed=np.linalg.inv(right.observed))
    other = Lookout.at(replace(problem, senses=(back,)), free, fits=True).named
    assert other, "others are named as ever"
