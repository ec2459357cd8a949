"""Studies of Vicente et al. 2016: one run feeds several figures, and premises are said."""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

from bodyschema.cli.study import RunStudy
from bodyschema.simulation.seeing_icub import SeeingIcub
from bodyschema.studies.hand_methods import METHODS
from bodyschema.studies.meeting_hands import both_offsets
from bodyschema.studies.runner import run_study, settings_of
from bodyschema.studies.vicente2016_figure6 import Figure6, Figure7, Figure8
from bodyschema.studies.vicente2016_figure10 import MANY, Figure10
from bodyschema.studies.vicente2016_figure12 import Figure12, Figure13, _seen
from bodyschema.studies.vicente2016_table1 import Table1
from bodyschema.studies.vicente2016_table2 import Figure9, Table2
from bodyschema.studies.watched_hand import believed

pytestmark = pytest.mark.usefixtures("offscreen")

SHORT = {"runs": 1, "particles": 50, "frames": 2, "closed_frames": 1}


def test_figures_of_one_run_find_its_tasks_finished(tmp_path, monkeypatch, capsys):
    folder, done = tmp_path / "runs", []
    work = Table1.work
    monkeypatch.setattr(Table1, "work", lambda self, t: (done.append(t.key), work(self, t))[1])
    for kind in (Table1, Figure6, Figure7, Figure8, Figure10):
        assert RunStudy(kind(**SHORT), workers=1, out=folder, json=True).run() == 0
    assert done == ["run 0", f"run 0, {MANY} particles"]
    printed = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    courses = [printed[k].pop("course") for k in (1, 2, 3)]
    assert printed[0] == printed[1] == printed[3]
    assert courses[0]["4_quarters"] == printed[0]["estimation"]
    assert courses[1]["last"] == printed[0]["reaching"]
    assert courses[2]["last"] != courses[1]["last"]
    assert json.loads((folder / "summary.json").read_text()) == printed[0]
    assert json.loads((folder / "figure10.json").read_text()) == printed[4]
    names = {path.name for path in folder.iterdir()}
    assert {"figure.png", "figure6.png", "figure8.svg", "figure10.png"} <= names


@pytest.mark.parametrize(
    ("one", "other"), [(Table1, Figure10), (Table2, Figure9), (Figure12, Figure13)]
)
def test_who_shares_runs_shares_a_folder_of_the_same_settings_alone(one, other):
    assert settings_of(one()) == settings_of(other())
    assert RunStudy(one()).folder() == RunStudy(other()).folder()
    assert settings_of(one(seed=1)) != settings_of(other())
    assert RunStudy(one(seed=1)).folder() != RunStudy(other()).folder()


def test_the_first_frames_teach_the_filter_and_the_last_do_not():
    """Table 1 in small: the hand is off by 37 mm before and by less than 12 after 15 frames, and
    the particles then weigh alike."""
    study = Table1(runs=1, frames=15, closed_frames=5)
    found = study.summary(run_study(study, 1))
    assert found["without_adaptation"]["position_mm"]["mean"] == pytest.approx(36.9, abs=0.1)
    assert found["estimation"]["position_mm"]["mean"] < 12
    assert found["ess_first"] < 0.97
    assert found["ess_last"] > 0.95
    assert found["mismatched"]["without_adaptation"]["position_mm"]["mean"] > 36.9


def test_figure_10_with_many_particles_and_with_few():
    """The first movement, 15 frames: both see the same hand, 36.9 mm off, and both bring it nearer
    than 12 mm; the many need several times as long."""
    study = Figure10(runs=1, frames=15, closed_frames=1)
    found = study.summary(run_study(study, 1))["particles"]
    few, many = found["200"], found[str(MANY)]
    assert few["without_adaptation"] == many["without_adaptation"]
    assert many["without_adaptation"]["position_mm"] == pytest.approx(36.9, abs=0.1)
    assert many["without_adaptation"]["orientation_deg"] == pytest.approx(11.7, abs=0.1)
    assert max(few["end"]["position_mm"], many["end"]["position_mm"]) < 12
    assert many["seconds_per_frame"] > 2 * few["seconds_per_frame"]


def test_edges_of_a_cluttered_room_tell_the_filter_nothing():
    """With lambda 0.01 all particles weigh alike from the first frames on."""
    for edges in ("hand", "outline"):
        study = Table1(runs=1, particles=50, scene="cluttered", edges=edges, frames=4,
                       closed_frames=1)  # fmt: skip
        assert study.summary(run_study(study, 1))["ess_first"] > 0.97


@pytest.mark.parametrize("kind", [Table1, Table2, Figure12])
def test_the_paper_s_edges_are_the_default_and_reach_the_filter(kind):
    assert kind().edges == "hand"
    mine = believed("identical")
    for edges in ("hand", "outline"):
        learner = METHODS["particle-filter"](edges).build(
            mine.surface, "cluttered", 50, 0, mine.doubts
        )
        assert learner.likelihood.edges == edges
        assert learner.likelihood.rate == 0.01


def test_what_lies_within_the_premises_is_said():
    study = Table1(**SHORT)
    summary = study.summary(run_study(study, 1))
    assert summary["premises"]["identical"].startswith("within the premises")
    assert summary["premises"]["mismatched"].startswith("outside the premises")
    assert [head.split()[0] for head in study.rows(summary).headers[2:]] == ["within", "outside"]


def test_figure_13_shows_what_was_learned_from():
    for scene, levels in (("plain", [60, 150, 255]), ("cluttered", None)):
        views = _seen(SeeingIcub(both_offsets(), scene))
        assert [view.shape for view in views] == [(240, 320, 3)] * 2
        if levels:
            assert set(np.unique(views[0])) <= set(levels)
        else:
            assert len(np.unique(views[0])) > 50
