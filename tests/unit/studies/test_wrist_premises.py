"""The published form inside its premises and outside: small runs whose numbers are held."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.published.paper_payload import paper_courses, paper_rows, standing
from bodyschema.simulation.loads import NOISE, RATE, draw_motion, wire_box
from bodyschema.studies.nabeshima_payload import Payload
from bodyschema.studies.payload_summary import late, times_text
from bodyschema.studies.runner import run_study
from bodyschema.studies.wrist_premises import Premises, WristPremises


@pytest.fixture(scope="module")
def answer():
    study = Payload(runs=3, seconds=20.0)
    return study.summary(run_study(study, 1))


def seconds(cell):
    return cell["seconds_to_1pct_1mm"]["median"]


def test_the_premises_are_the_default_and_are_stated(answer):
    assert answer["premises"] == Payload().within.stated()
    assert answer["premises"]["force_offset_n"] == answer["premises"]["turn_deg"] == 0
    assert answer["premises_outside"]["speed"] == 0.5
    for key in ("faithful", "better", "faithful_outside", "better_outside"):
        assert list(answer[key]["speeds"]) == ["0.15", "0.5", "1"]
        own = answer["premises_outside" if "outside" in key else "premises"]["speed"]
        top = {name: value for name, value in answer[key].items() if name != "speeds"}
        assert top == answer[key]["speeds"][f"{own:g}"]


def test_within_its_premises_the_published_form_is_as_fast_as_ours_and_right(answer):
    theirs = answer["faithful"]
    assert 1.0 < seconds(theirs) < 6.0
    assert seconds(theirs) < seconds(answer["better"])
    assert theirs["mass_pct"] < 0.1
    assert theirs["com_mm"] < 0.15


def test_fast_motion_needs_the_reading_that_looks_at_rest_only(answer):
    fast = answer["faithful"]["speeds"]["1"]
    assert seconds(fast) is None
    assert fast["com_mm"] > 1.0
    assert seconds(fast["readings"]["at rest"]) < 5.0


def test_an_offset_keeps_every_reading_from_it_and_not_ours(answer):
    for cell in answer["faithful_outside"]["speeds"].values():
        assert all(seconds(reading) is None for reading in cell["readings"].values())
    assert seconds(answer["better_outside"]) < 3.0


def test_a_sensor_within_the_premises_has_nothing_to_remove():
    sensor = WristPremises().within.draw_sensor(np.random.default_rng(0))
    assert not sensor.bias.any()
    assert np.array_equal(sensor.R_mount_sensor, np.eye(3))
    drawn = [Premises(2.0, 0.0, 1.0).draw_sensor(np.random.default_rng(k)).bias for k in range(200)]
    assert np.std(drawn, axis=0) == pytest.approx([2.0] * 3 + [0.08] * 3, rel=0.2)


def test_the_arm_stands_between_its_moves():
    motion = draw_motion(np.random.default_rng(3), 20.0, 0.5, RATE)
    still = standing(motion.R, motion.time)
    assert 0.03 < still.mean() < 0.4
    assert np.linalg.norm(motion.w[still], axis=1).max() < 0.1


@pytest.mark.parametrize("reading", ["printed", "weighted", "least squares", "at rest"])
def test_every_reading_is_exact_of_a_load_at_rest(reading):
    box, motion = wire_box(), draw_motion(np.random.default_rng(4), 20.0, 0.5, RATE)
    down = np.array([0.0, 0.0, -9.81])
    force = -box.mass * np.einsum("nji,j->ni", motion.R, down)
    A = paper_rows(motion.R, force, np.cross(box.com, force), down)
    x = paper_courses(A, NOISE, standing(motion.R, motion.time), reading)[-1]
    assert 1 / x[0] == pytest.approx(box.mass, rel=1e-6)
    assert x[1:4] == pytest.approx(box.com, abs=1e-6)


def test_a_time_that_is_mostly_never_reached_is_never():
    assert late([1.0, None, None], 0.5) is None
    assert times_text({"median": 1.0, "p90": late([1.0, 1.2, None], 0.9)}) == "1.0/never"
    assert times_text({"median": None, "p90": None}) == "never"
