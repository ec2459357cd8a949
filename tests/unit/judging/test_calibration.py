"""What an answer holds besides its numbers: how good the news are, and what may be used of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import Errors
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.estimation.prediction import PredictedError
from bodyschema.estimation.solver import Solver
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import CONTRADICTED, VERDICTS, WITHHELD, Calibration
from bodyschema.model.variables import free_joints
from bodyschema.trust.trust import Trust
from simulated import points, postures, seen_arm

LIMITED = Trust("limited", ("The halves disagree by 0.8 mm.",))
AGAINST = Trust("contradicted", ("The camera moved by 9 mm at row 40.",))


def fitted() -> Estimate:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    seen = points(body, postures(12, body, rng), rng)
    return Solver().fit(body, free_joints(body, ["offsets"]), [seen])


@pytest.fixture(scope="module")
def answer() -> Calibration:
    errors = Accuracy({("position", "m"): Errors(1e-3, 1e-3, 2e-3)}, {("position", "m"): 36})
    known = Identifiability(3, (), np.zeros(3))
    return Calibration("calibrated", "It falls.", fitted(), errors, errors, known, (), 12)


def test_an_answer_is_believed_until_something_speaks_against_it(answer: Calibration) -> None:
    assert answer.trust == Trust()
    assert (answer.tone, answer.withheld) == ("good", False)
    assert answer.believed(Trust()).trust == Trust()
    assert answer.believed(Trust()).verdict == "calibrated"


def test_limited_is_usable_and_doubtful(answer: Calibration) -> None:
    doubted = answer.believed(LIMITED)
    assert (doubted.verdict, doubted.tone, doubted.withheld) == ("calibrated", "doubtful", False)
    assert doubted.trust == LIMITED


def test_contradicted_is_the_verdict_and_nothing_is_used(answer: Calibration) -> None:
    refuted = answer.believed(AGAINST)
    assert (refuted.verdict, refuted.tone, refuted.withheld) == (CONTRADICTED, "bad", True)
    assert refuted.explanation == answer.explanation


@pytest.mark.parametrize("first", [LIMITED, AGAINST])
def test_further_trust_is_added_to_what_is_known(answer: Calibration, first: Trust) -> None:
    other = AGAINST if first is LIMITED else LIMITED
    both = answer.believed(first).believed(other)
    assert both.verdict == CONTRADICTED
    assert both.trust.reasons == (*AGAINST.reasons, *LIMITED.reasons)
    # What is good adds nothing and takes nothing away.
    assert both.believed(Trust()).trust == both.trust


@pytest.mark.parametrize("verdict", [v for v in WITHHELD if v != CONTRADICTED])
def test_an_answer_that_is_withheld_keeps_its_verdict(answer: Calibration, verdict: str) -> None:
    refused = replace(answer, verdict=verdict).believed(AGAINST)
    assert refused.verdict == verdict
    assert refused.trust == AGAINST
    assert (refused.tone, refused.withheld) == ("bad", True)


@pytest.mark.parametrize(
    ("verdict", "tone"),
    [("calibrated", "good"), ("learned", "good"), ("only frames", "doubtful"), ("refused", "bad")],
)
def test_verdicts_have_tones(answer: Calibration, verdict: str, tone: str) -> None:
    assert verdict in VERDICTS
    assert replace(answer, verdict=verdict).tone == tone
    limited = replace(answer, verdict=verdict, trust=LIMITED).tone
    assert limited == ("doubtful" if tone == "good" else tone)


def test_the_stated_error_is_what_the_verb_says_or_the_worst_predicted(answer: Calibration) -> None:
    assert answer.stated_95 is None
    none = np.zeros(1)
    predicted = tuple(
        PredictedError("tracker", "tool", none, none, error, 0.1) for error in (2e-3, 5e-3, 3e-3)
    )
    assert replace(answer, predicted=predicted).stated_95 == 5e-3
    assert replace(answer, predicted=predicted, predicted_95=4e-3).stated_95 == 4e-3
    assert replace(answer, predicted_95=0.0).stated_95 == 0.0
