"""`calibrate --skeleton`: arrangement and recording in, URDF out; and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import write_table
from simulated_skeleton import arrangement, true_torso, watched, write_recording


@pytest.fixture(scope="module")
def torso(tmp_path_factory):
    """A folder with arrangement and recording, and the true body."""
    folder = tmp_path_factory.mktemp("robot")
    rng = np.random.default_rng(2)
    truth = true_torso(arrangement(folder), rng)
    write_recording(folder / "data.csv", truth, watched(truth, 40, rng))
    return folder, truth


@pytest.fixture(scope="module")
def learned(torso):
    folder, _ = torso
    out = folder / "learned"
    flags = ["--skeleton", str(folder / "torso.toml"), "--recording", str(folder / "data.csv")]
    assert run(["calibrate", *flags, "--out", str(out)]) == 0
    return out


def test_the_urdf_predicts_what_is_seen(torso, learned):
    _, truth = torso
    body = Body.from_urdf(learned / "robot.urdf")
    assert body.joints == truth.joints
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (200, 3))
    for marker in ("hand", "elbow"):
        there, true = (relative_pose(b, q, "eye", marker)[:, :3, 3] for b in (body, truth))
        assert np.sqrt(np.mean(np.sum((there - true) ** 2, axis=1))) < 1.5e-3


def test_the_folder_says_how_it_was_made(learned, capsys):
    record = json.loads((learned / "run.json").read_text())
    assert record["skeleton"].endswith("torso.toml")
    assert record["skeleton"] in record["sha256"]
    assert record["robot"] == ""
    assert record["learner"] == "batch"
    assert "--skeleton" in (learned / "report.html").read_text()
    assert run(["report", str(learned), "--all"]) == 0
    shown = capsys.readouterr().out
    for words in ("learned", "markers that stand still", "the learned skeleton", "upper_arm"):
        assert words in shown


def test_the_learned_robot_can_be_checked(torso, learned, tmp_path):
    _, truth = torso
    rng = np.random.default_rng(9)
    write_recording(tmp_path / "same.csv", truth, watched(truth, 30, rng))
    assert run(["check", str(learned), "--recording", str(tmp_path / "same.csv")]) == 0
    senses = watched(truth, 30, rng)
    for sense in senses:
        sense.q[:, truth.joint_index("shoulder")] -= 0.05
    write_recording(tmp_path / "slipped.csv", truth, senses)
    assert run(["check", str(learned), "--recording", str(tmp_path / "slipped.csv")]) == 1


def test_a_run_file_and_other_columns(torso, tmp_path, capsys):
    folder, truth = torso
    [hand, _] = watched(truth, 40, np.random.default_rng(3))
    columns = {j: np.rad2deg(hand.q[:, i]) for i, j in enumerate(truth.joints)}
    columns |= {name: 1e3 * hand.position[:, i] for i, name in enumerate("abc")}
    write_table(tmp_path / "data.csv", columns)
    (tmp_path / "run.toml").write_text(
        f'skeleton = "{folder / "torso.toml"}"\nrecording = "data.csv"\nfolds = 2\n'
        '[joints]\nunit = "deg"\n'
        '[[senses]]\nkind = "points"\nseen_from = "eye"\nseen = "hand"\n'
        'columns = ["a", "b", "c"]\nunit = "mm"\n'
    )
    code = run(["calibrate", str(tmp_path / "run.toml"), "--out", str(tmp_path / "o"), "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert code == 0
    assert answer["verdict"] == "learned"
    assert set(answer["skeleton"]) == set(truth.joints)


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--recording", "data.csv", "--robot", "arm.urdf"], "--robot cannot go with --skeleton"),
        ([], "give also --recording"),
        (["--recording", "data.csv", "--columns", "a", "b"], "three columns each; 2 columns"),
        (["--recording", "data.csv", "--learner", "gauss-newton"], "needs a body to begin with"),
        (["--recording", "none.csv"], "none.csv"),
    ],
)
def test_what_does_not_fit_together_is_refused(flags, message, torso, monkeypatch, capsys):
    monkeypatch.chdir(torso[0])
    assert run(["calibrate", "--skeleton", "torso.toml", "--out", "new", *flags]) == 2
    assert message in capsys.readouterr().err


def test_a_run_file_names_one_of_robot_and_skeleton(tmp_path, capsys):
    path = tmp_path / "run.toml"
    path.write_text('skeleton = "a.toml"\nrobot = "a.urdf"\nrecording = "data.csv"\n')
    assert run(["calibrate", str(path)]) == 2
    assert "a robot and a skeleton" in capsys.readouterr().err
    path.write_text('skeleton = "a.toml"\nrecording = "d.csv"\n[frames.x]\nparent = "y"\n')
    assert run(["calibrate", str(path)]) == 2
    assert "in the arrangement" in capsys.readouterr().err
    path.write_text('robot = "a.urdf"\nrecording = "data.csv"\nlearner = "batsh"\n')
    assert run(["calibrate", str(path)]) == 2
    assert "did you mean 'batch'" in capsys.readouterr().err
