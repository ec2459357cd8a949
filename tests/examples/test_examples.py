"""Every numbered example runs by itself, anywhere, without a warning."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("[0-9][0-9]_*.py"))


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 4


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_prints(path: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(path)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )

    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 4
    assert "nan" not in done.stdout.split()
    assert not any(tmp_path.iterdir()), "an example leaves files behind"


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_one_page_and_says_how_to_run_it(path: Path) -> None:
    text = path.read_text(encoding="utf-8")

    assert len(text.splitlines()) <= 100
    assert f"python examples/{path.name}" in text


BARE = """
import runpy, sys
for package in ("cv2", "av", "mujoco", "icub_models", "matplotlib", "jinja2", "pyarrow", "trimesh"):
    sys.modules[package] = None
runpy.run_path(sys.argv[1], run_name="__main__")
"""
"""Runs an example as where only the core is installed."""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_that_needs_extras_says_which(path: Path, tmp_path: Path) -> None:
    heading = path.read_text(encoding="utf-8").split('"""')[1]
    if "simulation" not in path.read_text(encoding="utf-8"):
        assert "needs the extra" not in heading
        return
    command = [sys.executable, "-c", BARE, str(path)]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode != 0) == ("needs the extra" in heading), done.stderr
    if done.returncode != 0:
        assert "run: pip install 'bodyschema[" in done.stderr.splitlines()[-1]


def test_a_sense_of_ones_own_goes_through_every_verb(tmp_path: Path) -> None:
    """A line for each of calibrate, check, plan and report, of a class of fifteen lines at most."""
    path = next(path for path in EXAMPLES if path.stem == "12_a_sense_of_your_own")
    done = subprocess.run(
        [sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    verbs = [line.split(":")[0] for line in done.stdout.splitlines()]
    assert verbs == ["calibrate", "check", "plan", "report"]
    text = path.read_text(encoding="utf-8").splitlines()
    first = text.index("class Wire(bs.Sense):")
    last = next(i for i in range(first, len(text)) if text[i].startswith("def "))
    assert len([line for line in text[first:last] if line.strip()]) <= 15
