"""Run files of wrong types, names that are markup or speak to a terminal, and a fuzz bench."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.cli.run_file import read_run_file
from bodyschema.errors import InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.sources.tables import write_table

HERE = Path(__file__).parents[3]

RUN = """
robot = "arm.toml"
recording = "[red]data.csv"
[frames."[/]t\\u001b[5m"]
parent = "flange"
[frames."eye[bold]"]
parent = "base"
known = "exactly"
[[senses]]
kind = "points"
seen_from = "eye[bold]"
seen = "[/]t\\u001b[5m"
columns = ["[x]", "y", "z"]
[free]
groups = ["offsets"]
"""
JOINT = """
[[joint]]
name = "{}"
a = 0.3
alpha = {}
d = 0.2
"""
NAMES = ("[/]a", "[red]b\x1b[31m", "c<b>&'; touch P")


def record(path: Path, body: bs.Body, n: int, seed: int) -> None:
    """A recording of an arm whose second joint is 3 degrees off."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, (n, 3))
    seen = bs.relative_pose(body, q, "base", "flange")[:, :3, 3] + 1e-4 * rng.normal(size=(n, 3))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*NAMES, "[x]", "y", "z"])
        writer.writerows(np.hstack([q + np.array([0, 0.05, 0]), seen]).tolist())


@pytest.mark.filterwarnings("ignore:Glyph 27:UserWarning")  # no font has it
def test_names_are_texts_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = [JOINT.format(n.replace("\x1b", "\\u001b"), 0.5 + i) for i, n in enumerate(NAMES)]
    Path("arm.toml").write_text('name = "[bold]r[/]\\u001b[2J"\n' + "".join(rows))
    Path("run.toml").write_text(RUN)
    body = bs.Body.from_dh("arm.toml")
    record(Path("[red]data.csv"), body, 40, 1)
    record(Path("new.csv"), body, 20, 2)
    out = "o[red];x"
    for verb in (
        ["calibrate", "run.toml", "--out", out],
        ["report", out, "--all"],
        ["check", out, "--recording", "new.csv"],
        ["plan", out, "-n", "2", "--candidates", "50", "--out", "p[/].csv"],
    ):
        assert run(verb) == 0, verb
        said = "".join(capsys.readouterr())
        assert "\x1b" not in said, verb
        if verb[0] == "calibrate":
            assert "bodyschema export 'o[red];x' --robot" in said
            assert "[/]t\\x1b[5m" in said
    assert run(["report", "[/]no\x1b[31m"]) == 2
    assert "'[/]no\\x1b[31m'" in capsys.readouterr().err
    page = (tmp_path / out / "report.html").read_text()
    assert "c<b>" not in page
    assert "c&lt;b&gt;&amp;" in page


@pytest.mark.parametrize(
    "line",
    [
        "recording = 1", "recording = [1]", "frames = 3", "frames.a = 3", "senses = 1",
        "senses = [1]", "parts = []", "parts.a = 1", "packages = 1", "packages.a = 1", "free = 2",
        "wanted = 2", "wanted = [2]", "joints = 1", "joints.each = 1", "wrist = [1]", "append = 1",
        "append = [1]", "pictures = 'x'", "robot_arguments = 1", "seed = -1", "seed = 'a'",
        "folds = 1000000000", "robot = 3", "skeleton = 3", "hand_eye = 1", "time = 3",
        "[[senses]]\nkind = []\nseen_from = 'a'", "[[senses]]\nkind = 'points'\nrecording = {}",
        "[[senses]]\nkind = 'outlines'\nlens = 'l'\nseen_from = 'a'\nmasks = 1",
        "[parts.a]\nkind = {}", "[frames.a]\nparent = 'b'\nxyz = [1e308, 0, 0]",
        "[frames.a]\nparent = 'b'\nxyz = [1e-320, 0, 0]",
    ],
)  # fmt: skip
def test_every_entry_has_its_type(tmp_path: Path, line: str) -> None:
    own = line.partition(" ")[0]
    usual = {"robot": 'robot = "a.urdf"', "recording": 'recording = "a.csv"'}
    text = "\n".join([*(v for k, v in usual.items() if k != own), line])
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(InputError) as error:
        read_run_file(tmp_path / "run.toml")
    assert str(error.value).endswith((".", "?")), "a sentence"


def test_a_hundred_thousand_columns(tmp_path: Path) -> None:
    names = [f"c{i}" for i in range(100_000)]
    (tmp_path / "wide.csv").write_text("\n".join([",".join(names), ",".join("0" for _ in names)]))
    assert len(bs.open_recording(tmp_path / "wide.csv").columns) == len(names)


def test_mutants_are_read_or_refused() -> None:
    command = [sys.executable, "benchmarks/fuzz.py", "--mutants", "200", "--jobs", "1"]
    for reader in ("urdf", "dh", "calibrate run", "lerobot"):
        command += ["--reader", reader]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert done.stdout.splitlines()[-1].endswith("mutants, 0 failed")


@pytest.mark.parametrize("name", ["a\0b.csv", "x" * 300 + ".csv", "\udcff.csv"])
def test_odd_names_of_a_recording_to_check(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Found by the fuzz bench: `Path.resolve` raises of its own."""
    recording = tmp_path / "data.csv"
    arm = bs.Body.random_chain(3, np.random.default_rng(0))
    record_of(arm, recording)
    out = tmp_path / "out"
    columns = ["--columns", "x", "y", "z", "--hand", "tip"]
    flags = ["--robot", str(tmp_path / "arm.urdf"), "--recording", str(recording), *columns]
    assert run(["calibrate", *flags, "--free", "offsets", "--out", str(out), "--json"]) == 0
    capsys.readouterr()
    assert run(["check", str(out), "--recording", name]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def record_of(arm: bs.Body, path: Path) -> None:
    """A robot, and a recording of its tip, the second joint 3 degrees off."""
    rng = np.random.default_rng(1)
    q = rng.uniform(-1, 1, (20, 3))
    seen = bs.relative_pose(arm, q + np.array([0, 0.05, 0]), "base", "tip")[:, :3, 3]
    seen = seen + 1e-3 * rng.normal(size=seen.shape)
    columns = dict(zip([*arm.joints, *"xyz"], np.hstack([q, seen]).T, strict=True))
    write_table(path, columns)
    path.with_name("arm.urdf").write_bytes(write_urdf(arm))
