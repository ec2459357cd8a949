"""What a verb does with its answer: written or not, the exit code, and what is printed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodyschema.answers.answer import Answer, load
from bodyschema.cli.result import finish, how_to_see_all, prepare
from bodyschema.errors import InputError
from bodyschema.estimation.held_out import Errors
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.estimation.solver import Solver
from bodyschema.judging.accuracy import Accuracy
from bodyschema.model.variables import free_joints
from bodyschema.trust.trust import Trust
from simulated import points, postures, seen_arm

LIMITED = Trust("limited", ("The halves disagree by 0.8 mm.",))
AGAINST = Trust("contradicted", ("The camera moved by 9 mm at row 40.", "The halves disagree."))


@pytest.fixture(scope="module")
def answer() -> Answer:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    seen = points(body, postures(12, body, rng), rng)
    fit = Solver().fit(body, free_joints(body, ["offsets"]), [seen])
    errors = Accuracy({("position", "m"): Errors(1e-3, 1e-3, 2e-3)}, {("position", "m"): 36})
    known = Identifiability(3, (), np.zeros(3))
    about = ("calibrated", "It falls.", fit, errors, errors, known, (), 12, ("offsets",))
    return Answer(*about, predicted_95=1.25e-3)


def test_a_good_answer_is_written(
    answer: Answer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert finish(answer, tmp_path / "out", False, False, then="Next: look \x1b[31m.") == 0
    text = capsys.readouterr().out
    assert "Trust" not in text
    assert "all numbers:" in text
    assert text.rstrip().endswith(r"Next: look \x1b[31m.")
    assert load(tmp_path / "out").trust == Trust()


def test_how_to_see_all_is_quoted() -> None:
    assert how_to_see_all(Path("a b;\x1b")) == r"`bodyschema report 'a b;\x1b' --all`"


def test_a_limited_one_is_written_and_says_why(
    answer: Answer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert finish(answer.believed(LIMITED), tmp_path / "out", False, False) == 0
    text = capsys.readouterr().out
    assert "calibrated  off by less than 1.2 mm (95 %)\nIt falls." in text
    assert "Trust: limited\n  - The halves disagree by 0.8 mm." in text
    assert load(tmp_path / "out").trust == LIMITED


def test_a_contradicted_one_is_not_written(
    answer: Answer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert finish(answer.believed(AGAINST), out, False, False, then="Next: use it.") == 1
    assert list(tmp_path.iterdir()) == []
    text = capsys.readouterr().out
    assert "contradicted  It falls." in text
    first, second = (text.index(f"  - {reason}") for reason in AGAINST.reasons)
    assert first < second
    assert "Nothing was written." in text
    assert "--force" in text
    assert "Next" not in text
    assert str(out) not in text


def test_a_contradicted_one_leaves_an_earlier_result_alone(answer: Answer, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer.save(out)
    before = (out / "answer.json").read_bytes()
    assert finish(answer.believed(AGAINST), out, True, True) == 1
    assert (out / "answer.json").read_bytes() == before


def test_force_writes_it_and_the_news_stay_bad(
    answer: Answer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert finish(answer.believed(AGAINST), out, False, False, force=True) == 1
    assert "Trust: contradicted" in capsys.readouterr().out
    back = load(out)
    assert (back.verdict, back.trust) == ("contradicted", AGAINST)
    assert back.withheld


@pytest.mark.parametrize(("trust", "code"), [(Trust(), 0), (LIMITED, 0), (AGAINST, 1)])
def test_json_is_one_object_with_trust_and_the_stated_error(
    answer: Answer, trust: Trust, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert finish(answer.believed(trust), out, False, True, {"more": float("nan")}) == code
    printed = capsys.readouterr().out
    assert printed.count("\n") == 1
    found = json.loads(printed, parse_constant=pytest.fail)
    assert found["trust"] == trust.document
    assert found["predicted_95_mm"] == pytest.approx(1.25)
    assert found["more"] is None
    assert found.get("folder") == (str(out) if code == 0 else None)
    assert out.exists() == (code == 0)


def test_a_refused_one_that_nothing_contradicts_is_written(answer: Answer, tmp_path: Path) -> None:
    assert finish(replace(answer, verdict="not known"), tmp_path / "out", False, True) == 1
    assert load(tmp_path / "out").verdict == "not known"


def test_a_place_is_refused_before_any_work(answer: Answer, tmp_path: Path) -> None:
    answer.save(tmp_path / "out")
    with pytest.raises(InputError, match="overwrite"):
        prepare(tmp_path / "out", False, None, {})
    prepare(tmp_path / "out", True, None, {})
    run_file = tmp_path / "in" / "run.toml"
    run_file.parent.mkdir()
    run_file.write_text("")
    with pytest.raises(InputError, match=r"the input '.*run\.toml' lies there"):
        prepare(run_file.parent, True, run_file, {})
    with pytest.raises(InputError, match="lies there"):
        prepare(run_file.parent, True, None, {}, [run_file])
