"""`bodyschema touch`: odd recordings are read, touches are told, and bad files are refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie, load
from bodyschema.cli import run

pytest.importorskip("mujoco")

from bodyschema.simulation.contacts import draw_contact
from bodyschema.studies.touch_runs import draw_wrist

BOX = """
recording = "log.csv"
time = "ms"
time_unit = "ms"
[wrench]
columns = ["fx", "fy", "fz", "mx", "my", "mz"]
frame = "base"
sign = "on_sensor"
torque_unit = "mNm"
[pose]
columns = ["x", "y", "z", "qw", "qx", "qy", "qz"]
layout = "xyz_wxyz"
unit = "mm"
"""
SURFACE = "[surface]\nbox = [0.10, 0.12, 0.18]\nxyz = [0.0161846, -0.0214352, 0.0923942]\n"
TOUCH = "[touch]\nquiet = [0.0, 15.0]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording in millimetres, along the base's axes, with one touch; and the touch."""
    rng = np.random.default_rng(1)
    wrist = draw_wrist("box", "identified", 0.5, rng)
    contact = draw_contact(wrist.held.solid, 2.0, "point", 16.0, rng)
    samples = wrist.move(18.0, rng, [contact])
    R = samples.rotation
    force = -np.einsum("nij,nj->ni", R, samples.wrench[:, :3])
    torque = -1e3 * np.einsum("nij,nj->ni", R, samples.wrench[:, 3:])
    turn = lie.quaternion_xyzw(R)[:, [3, 0, 1, 2]]
    table = np.column_stack([1e3 * samples.time, force, torque, 1e3 * samples.position, turn])
    path = tmp_path_factory.mktemp("touch")
    names = "ms,fx,fy,fz,mx,my,mz,x,y,z,qw,qx,qy,qz"
    np.savetxt(path / "log.csv", table, delimiter=",", header=names, comments="", fmt="%.12g")
    return path, contact


def told(folder: Path, text: str, capsys, *flags) -> tuple[int, str, str]:
    """Exit code and output of the verb on a file."""
    (folder / "run.toml").write_text(text, encoding="utf-8")
    out = str(folder / "touched")
    code = run(["touch", str(folder / "run.toml"), "--out", out, "--overwrite", *flags])
    out, err = capsys.readouterr()
    return code, out, err


def test_a_touch_is_found_in_a_recording_of_odd_units(folder, capsys):
    path, contact = folder
    code, out, _ = told(path, BOX + SURFACE + TOUCH, capsys, "--json")
    answer = json.loads(out)
    assert code == 0
    assert answer["load"]["mass"] == pytest.approx(0.594409, rel=3e-3)
    (touch,) = answer["touches"]
    assert touch["verdict"] == "point"
    assert touch["begins"] == pytest.approx(contact.begins, abs=0.2)
    assert touch["places"][0]["point"] == pytest.approx(contact.point, abs=1.5e-3)
    assert np.linalg.norm(touch["force"]) == pytest.approx(2.0, abs=0.1)
    assert answer["verdict"] == "touched"
    assert answer["held_out"]["force_N"]["rms"] < 0.1 < answer["nominal"]["force_N"]["rms"]
    stored = load(path / "touched")
    assert stored.details["touches"] == answer["touches"]
    assert "Touches" in (path / "touched" / "report.html").read_text()
    assert run(["report", str(path / "touched")]) == 0
    assert "± 95 %" in capsys.readouterr().out


def test_words_for_people(folder, capsys):
    path, _ = folder
    code, out, _ = told(path, BOX + SURFACE + TOUCH, capsys)
    assert code == 0
    assert "2.0" in out
    assert "± 95 %" in out


def test_a_surface_that_is_exact_makes_a_place_surer(folder, capsys):
    path, _ = folder
    bars = {}
    for mm in ("0", "2"):
        code, out, _ = told(path, BOX + SURFACE + TOUCH, capsys, "--json", "--surface-mm", mm)
        assert code == 0
        bars[mm] = json.loads(out)["predicted_95_mm"]
    assert bars["2"] > bars["0"] + 1
    assert load(path / "touched").run["surface_mm"] == 2.0
    code, _, err = told(path, BOX + SURFACE + TOUCH, capsys, "--surface-mm", "-1")
    assert code == 2
    assert "--surface-mm is -1; give 0 or more" in err


def test_without_a_surface_the_line_is_told(folder, capsys):
    path, _ = folder
    code, out, _ = told(path, BOX + TOUCH, capsys, "--json")
    assert code == 0
    (touch,) = json.loads(out)["touches"]
    assert touch["places"][0]["normal"] is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOX + SURFACE, "quiet = \\[from, to\\]"),
        (BOX + SURFACE + "[touch]\nquiet = [0.0, 2.0]\n", "5 s of motion or more"),
        (BOX + SURFACE + "[touch]\nquiet = [5.0, 1.0]\n", "must be \\[from, to\\]"),
        (BOX + SURFACE + TOUCH + "gians = 0.1\n", "did you mean 'gains'"),
        (BOX + "[surface]\nscale = 1.0\n" + TOUCH, "no shape"),
        (BOX + "[surface]\nball = [0.1]\nbox = [1.0, 1.0, 1.0]\n" + TOUCH, "box and ball"),
        (BOX + "[surface]\ncylinder = [0.1]\n" + TOUCH, "cylinder = \\[radius, length\\]"),
        (BOX + '[surface]\nmesh = "cup.stl"\n' + TOUCH, "cup.stl"),
        (BOX + '[surface]\nlink = "cup"\n' + TOUCH, "needs robot"),
        (BOX.replace("fz", "fzz", 1) + SURFACE + TOUCH, "fzz"),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence(folder, text, words, capsys):
    path, _ = folder
    code, out, err = told(path, text, capsys)
    assert code == 2
    assert not out
    assert len(err.strip().splitlines()) == 1

    assert re.search(words, err), err
