"""An answer is saved and loaded to the last bit, and a loaded one does what the first one did."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema import lie
from bodyschema.answers.answer import Answer, load
from bodyschema.errors import InputError
from bodyschema.export.result_folder import FORM, UNSTORED
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.settled import settled
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_joints
from bodyschema.trust.trust import Trust
from same import same
from simulated import drawn, forgotten, poses, postures, seen_arm

DOUBT = Trust("limited", ("The halves of the recording disagree by 0.81 mm.",))
UNKNOWN = {"tracker": "no", "tool": "no"}
EDITS: dict[str, Callable[[str], str]] = {
    "cut short": lambda text: text[: len(text) // 2],
    "a list": lambda text: "[1, 2]",
    "without a form": lambda text: text.replace('"form": ', '"firm": '),
    "of words for numbers": lambda text: text.replace('"n_rows": 24', '"n_rows": "many"'),
    "of another level": lambda text: text.replace('"level": "limited"', '"level": "superb"'),
    "without a field": lambda text: text.replace('"verdict": ', '"vredict": '),
    "of a short array": lambda text: text.replace('"offset": [', '"offset": [{}, ', 1),
}


def made(source: Path | None = None) -> Answer:
    """Three joints that are wrong, looked at from 24 postures; answered with a doubt."""
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    wrong = free_joints(body, ["offsets"])
    truth = body.with_variables(wrong, drawn(wrong, rng, 0.5))
    seen = poses(truth, postures(24, body, rng), rng)
    described = body
    if source is not None:
        source.write_bytes(write_urdf(body).replace(b"<robot", b"<!-- mine -->\n<robot"))
        described = Body.from_urdf(source)
    start = forgotten(described, UNKNOWN)
    answer = bs.calibrate(
        start, [seen], UNKNOWN, ["offsets"], described=described, run={"seed": 7, "name": "käfer"}
    )
    return replace(answer, trust=DOUBT, predicted_95=1.0 / 3.0e3)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> Answer:
    return made(tmp_path_factory.mktemp("robot") / "arm.urdf")


@pytest.fixture(scope="module")
def folder(answer: Answer, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("saved") / "calibrated"
    written = answer.save(place)
    assert sorted(written) == sorted(p for p in place.iterdir() if p.name[0] != ".")
    return place


@pytest.fixture(scope="module")
def loaded(folder: Path) -> Answer:
    return load(folder)


def stored(answer: Answer) -> Answer:
    """What the folder holds of an answer."""
    blank = {"senses": (), "sections": (), "files": {}, "run": {}, "seconds": 0.0}
    bare = replace(answer.fit.reference, visuals=())
    assert answer.described is not None
    return replace(
        answer,
        **blank,
        fit=replace(answer.fit, reference=bare),
        described=replace(answer.described, visuals=()),
    )


def test_every_field_that_is_stored_comes_back_to_the_last_bit(
    answer: Answer, loaded: Answer
) -> None:
    one, other = stored(answer), stored(loaded)
    kept = [f.name for f in fields(Answer) if f.name not in UNSTORED]
    assert [name for name in kept if not same(getattr(one, name), getattr(other, name))] == []
    assert loaded.estimate.covariance.dtype == np.float64
    assert loaded.estimate.variables.code.dtype == np.int64


def test_trust_and_the_stated_error_come_back(answer: Answer, loaded: Answer) -> None:
    assert loaded.trust == DOUBT
    assert loaded.predicted_95 == answer.predicted_95 == 1.0 / 3.0e3
    assert loaded.tone == "doubtful"
    assert loaded.verdict == "calibrated"


def test_the_run_comes_back_and_what_was_seen_does_not(answer: Answer, loaded: Answer) -> None:
    assert loaded.run["seed"] == 7
    assert loaded.run["name"] == "käfer"
    assert loaded.senses == ()
    assert loaded.seconds == 0.0


def test_it_is_saved_as_the_same_bytes_twice(
    answer: Answer, folder: Path, loaded: Answer, tmp_path: Path
) -> None:
    answer.save(tmp_path / "again")
    for path in sorted(folder.iterdir()):
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes(), path.name
    loaded.save(tmp_path / "loaded")
    assert (tmp_path / "loaded/answer.json").read_bytes() == (folder / "answer.json").read_bytes()
    assert (tmp_path / "loaded/robot.urdf").read_bytes() == (folder / "robot.urdf").read_bytes()


def test_a_file_of_the_folder_names_it_too(folder: Path, loaded: Answer) -> None:
    assert same(stored(load(folder / "calibration.yaml")), stored(loaded))
    assert bs.load is load


def test_the_summary_says_verdict_trust_and_figures(answer: Answer, loaded: Answer) -> None:
    text = answer.summary()
    assert text.startswith("T_base_tracker\n  xyz ")
    assert "\ncalibrated  tool in tracker off by less than 0.33 mm (95 %)" in text
    assert text.index("0.33 mm") < text.index("The held-out error falls from")
    assert "Trust: limited\n  - The halves of the recording disagree by 0.81 mm." in text
    assert "joint_2.offset" in text
    assert loaded.summary() == text
    narrow = [line for line in answer.summary(60).splitlines() if "  ros2" not in line]
    assert max(len(line) for line in narrow if "<origin" not in line) <= 60


def test_the_rest_is_said_when_asked(answer: Answer) -> None:
    short, whole = answer.summary(), answer.summary(everything=True)
    assert "joint_1.offset" not in short
    assert "2 other parameters (unchanged within their error or not" in " ".join(short.split())
    for only in ("Held-out error over 24 rows", "Predicted error of", "joint_1.offset",
                 "What these data cannot tell"):  # fmt: skip
        assert only in whole
        assert only not in short
    assert "report --all" not in whole


def test_a_cell_shows_a_few_lines(answer: Answer, loaded: Answer) -> None:
    said = repr(answer)
    assert len(said.splitlines()) < 20
    assert len(said) < 1000
    assert "T_base_tracker: xyz " in said
    assert "tool in tracker off by less than 0.33 mm (95 %)" in said
    assert repr(loaded) == said


def test_its_transforms_go_with_the_robot_that_is_written(answer: Answer) -> None:
    found = answer.transforms()
    assert list(found) == ["T_base_tracker", "T_tip_tool"]
    body = settled(answer).body
    for place in found.values():
        assert np.array_equal(place.T, body.placement[body.frame_index(place.frame)])
        assert place.sd.shape == (6,)
    assert replace(answer, verdict="refused").transforms() == {}
    assert 'link name="tracker"' in replace(answer, described=None).to_urdf()


def test_good_trust_is_not_mentioned(answer: Answer) -> None:
    assert "Trust" not in replace(answer, trust=Trust()).summary()


def test_a_notebook_shows_it(answer: Answer, loaded: Answer) -> None:
    page = answer._repr_html_()
    assert answer.explanation in page
    assert "Trust: limited" in page or DOUBT.reasons[0] in page
    words = loaded._repr_html_()
    assert words.startswith("<pre>")
    assert DOUBT.reasons[0] in words
    risky = replace(loaded, explanation="<b>a & b</b>")._repr_html_()
    assert "&lt;b&gt;a &amp; b&lt;/b&gt;" in risky


def test_its_errors_are_drawn_while_what_was_seen_is_there(answer: Answer, loaded: Answer) -> None:
    assert answer.plot().axes
    with pytest.raises(InputError, match="what was seen is not stored with it; give the senses"):
        loaded.plot()


def worst(one: Body, other: Body) -> float:
    """Largest difference of any number of any pose of the frames of the first."""
    q = np.random.default_rng(1).uniform(-2, 2, (20, 3))
    rows = [other.frame_index(frame) for frame in one.frames]
    return float(np.abs(frame_poses(one, q) - frame_poses(other, q)[:, rows]).max())


def test_the_corrected_robot_is_the_own_file_patched(answer: Answer, loaded: Answer) -> None:
    text = answer.to_urdf()
    assert "<!-- mine -->" in text
    assert worst(parse_urdf(text.encode(), Path("arm.urdf"), {}), settled(answer).body) < 1e-9
    assert loaded.to_urdf() == text


def test_without_a_file_the_robot_is_written_anew(answer: Answer, tmp_path: Path) -> None:
    assert answer.described is not None
    lost = replace(answer, described=replace(answer.described, source=str(tmp_path / "gone.urdf")))
    bare = lost.to_urdf()
    assert "<!-- mine -->" not in bare
    assert worst(parse_urdf(bare.encode(), Path("arm.urdf"), {}), settled(answer).body) < 1e-9


def test_a_loaded_answer_checks_new_samples(answer: Answer, loaded: Answer) -> None:
    rng = np.random.default_rng(5)
    q = postures(15, answer.body, rng)
    same_robot = poses(answer.body, q, rng)
    assert not loaded.check([same_robot]).changed
    assert same(loaded.check([same_robot]), answer.check([same_robot]))
    T = lie.transform(np.eye(3), [0.02, 0.0, 0.0])
    moved = answer.body.with_placement("tool", answer.body.placement[-1] @ T)
    assert loaded.check([poses(moved, q, rng)]).changed


def test_a_loaded_answer_plans_for_senses_that_it_is_given(answer: Answer, loaded: Answer) -> None:
    seen = answer.senses
    assert loaded.plan(3, seen).q == pytest.approx(answer.plan(3).q, abs=0)
    with pytest.raises(InputError, match="give the senses"):
        loaded.plan(3)


@pytest.mark.parametrize("edit", EDITS)
def test_a_damaged_file_is_refused_in_a_sentence(edit: str, folder: Path, tmp_path: Path) -> None:
    broken = shutil.copytree(folder, tmp_path / "broken")
    text = (broken / "answer.json").read_text(encoding="utf-8")
    changed = EDITS[edit](text)
    assert changed != text
    (broken / "answer.json").write_text(changed, encoding="utf-8")
    with pytest.raises(InputError, match=r"make it again\.$|Make it again\.$") as error:
        load(broken)
    assert "answer.json" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_lost_or_broken_run_is_refused(folder: Path, tmp_path: Path) -> None:
    broken = shutil.copytree(folder, tmp_path / "broken")
    (broken / "run.json").write_text("{")
    with pytest.raises(InputError, match="cannot be read"):
        load(broken)
    (broken / "run.json").unlink()
    with pytest.raises(InputError, match="cannot be read"):
        load(broken)


def test_another_form_is_named(folder: Path, tmp_path: Path) -> None:
    old = shutil.copytree(folder, tmp_path / "old")
    document = json.loads((old / "answer.json").read_text(encoding="utf-8"))
    document["form"] = FORM - 1
    (old / "answer.json").write_text(json.dumps(document))
    expected = f"has form {FORM - 1}, this version reads {FORM}; make it again"
    with pytest.raises(InputError, match=expected):
        load(old)


def test_a_folder_without_an_answer_is_named(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(InputError, match=f"no answer.json in '{place}'; name a folder"):
            load(place)


def test_an_earlier_result_is_replaced_only_when_told(answer: Answer, tmp_path: Path) -> None:
    blind = replace(answer, senses=())
    blind.save(tmp_path / "out")
    with pytest.raises(InputError, match="overwrite"):
        blind.save(tmp_path / "out")
    replace(blind, explanation="Anew.").save(tmp_path / "out", overwrite=True)
    assert load(tmp_path / "out").explanation == "Anew."


def test_further_files_are_written_and_a_page_of_what_was_seen(
    answer: Answer, folder: Path, tmp_path: Path
) -> None:
    assert (folder / "report.html").is_file()
    blind = replace(answer, senses=(), files={"more.txt": b"more"})
    names = blind.save_into(tmp_path)
    assert "report.html" not in names
    assert (tmp_path / "more.txt").read_bytes() == b"more"
    assert sorted(names) == sorted(path.name for path in tmp_path.iterdir())
