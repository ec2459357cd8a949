"""The campaign of honest numbers: its truths are true, its runs repeat, its counts are told."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import bodyschema as bs
import honesty
from bodyschema.model.kinematics import relative_pose
from honest.drawing import Plan, draw
from honest.faults import FAULTS
from honest.outcome import Outcome
from honest.pictured import description, draw_pictured
from honest.tally import tally


@pytest.mark.parametrize("sense", ["points", "poses", "pixels"])
def test_without_a_fault_the_world_is_the_true_body(sense):
    scene = draw(Plan((sense,), errors=("full",)), np.random.default_rng(0))
    expected = relative_pose(scene.world.body, scene.motion.q, "tracker", "tool")
    np.testing.assert_allclose(scene.world.poses(scene.motion), expected, atol=1e-12)
    assert scene.error(scene.world.body, np.random.default_rng(0)) < 1e-12


@pytest.mark.parametrize("fault", [f for f in FAULTS if not f.good], ids=lambda fault: fault.name)
def test_every_fault_changes_what_is_seen_or_read(fault):
    plain = draw(fault.plan, np.random.default_rng(3))
    scene = fault.change(plain, np.random.default_rng(4))
    faulty, right = (s.senses(np.random.default_rng(5))[0] for s in (scene, plain))
    same = np.array_equal(faulty.observed, right.observed) and np.array_equal(faulty.q, right.q)
    assert not same or scene.given is not plain.given or fault.change.__name__ == "unchanged"


def test_four_runs_are_counted_and_one_of_them_comes_again(tmp_path, capsys):
    ledger = tmp_path / "ledger.jsonl"
    arguments = ["--runs", "4", "--kinds", "calibrate", "--only", "none", "--workers", "1"]
    assert honesty.main([*arguments, "--json", "--ledger", str(ledger)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["runs"], told["good"]["n"], told["by_fault"]["none"]["n"]) == (4, 4, 4)
    lines = [json.loads(line) for line in ledger.read_text("utf-8").splitlines()]
    assert [line["index"] for line in lines] == [0, 1, 2, 3]
    again = honesty.run(("calibrate", "none", 3), seed=0)
    assert (again.stated, again.true) == (lines[3]["stated"], lines[3]["true"])


def test_runs_are_shared_out_over_kinds_and_faults():
    jobs = honesty.shared_out("hand-eye", 60, "")
    assert len(set(jobs)) == 60
    assert {fault for _, fault, _ in jobs} == {row.fault for row in honesty.rows("hand-eye")}
    assert honesty.shared_out("hand-eye", 9, "mm:7") == [("hand-eye", "mm", 7)]
    assert honesty.shared_out("payload", 9, "late 50 ms") == []


@pytest.mark.parametrize("kind", ["hand-eye", "payload", "touch"])
def test_a_good_run_of_every_kind_states_what_is_true(kind):
    one = next(row for row in honesty.rows(kind) if row.good).run(0, 0)
    assert (one.crash, one.level) == ("", "good")
    assert not one.wrong


def test_faults_have_names_of_their_own_in_every_kind():
    for kind in honesty.KINDS:
        names = [row.fault for row in honesty.rows(kind)]
        assert len(set(names)) == len(names)
        assert not any("," in name for name in names), "--only takes names with commas between"
        assert any(row.good for row in honesty.rows(kind))


def test_the_photographed_arm_is_the_described_one(tmp_path):
    one = draw_pictured(np.random.default_rng(1))
    (tmp_path / "arm.urdf").write_text(description(), "utf-8")
    body = replace(bs.Body.from_urdf(tmp_path / "arm.urdf"), offset=one.offsets)
    there = relative_pose(body, one.q, "base", "hand")[:, :3, 3]
    np.testing.assert_allclose(one.hand(one.q), there, atol=1e-12)


def outcome(stated, true, level="good", verdict="calibrated", withheld=False, good=False):
    about = ("calibrate", "f", 0, good, False, "", "m", stated, true)
    return Outcome(*about, level=level, verdict=verdict, withheld=withheld)


@pytest.mark.parametrize(
    ("one", "wrong", "unflagged"),
    [
        (outcome(1.0, 1.9), False, False),
        (outcome(1.0, 2.1), True, True),
        (outcome(1.0, 2.1, level="limited"), True, False),
        (outcome(1.0, 2.1, verdict="refused", withheld=True), True, False),
        (outcome(None, 2.1), True, True),
        (outcome(1.0, np.nan), True, True),
        (outcome(None, np.nan, verdict="input refused", withheld=True), False, False),
    ],
)
def test_wrong_and_unflagged(one, wrong, unflagged):
    assert (one.wrong, one.unflagged) == (wrong, unflagged)


def test_good_runs_count_their_trust_alone():
    some = [outcome(1.3, 1.0, good=True), outcome(1.1, 1.0, good=True, withheld=True),
            outcome(1.2, 1.0, level="limited", good=True)]  # fmt: skip
    good = tally(some)["good"]
    assert (good["n"], good["flagged"], good["stated_over_true"]) == (3, 1, 1.2)
