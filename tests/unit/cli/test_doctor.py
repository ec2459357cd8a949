"""What an installation has and lacks."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import metadata
from typing import Any

import pytest

from bodyschema.cli import doctor, run


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """OpenGL takes a process of its own."""
    monkeypatch.setattr(doctor, "opengl", lambda: "not tried")


def test_all_is_told_in_json_and_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["bodyschema"] == metadata.version("bodyschema")
    assert found["packages"]["numba"] == metadata.version("numba")
    assert found["cores"]["usable"] >= 1
    assert {"data", "report", "sim", "vision"} <= set(found["extras"])
    assert not {"dev", "docs"} & set(found["extras"])
    assert found["cache"]["folder"] is None or isinstance(found["cache"]["warm"], bool)
    assert run(["doctor"]) == 0
    told = capsys.readouterr().out
    assert f"bodyschema {found['bodyschema']}" in told
    assert "[vision]" in told
    for pool in found["blas"]:
        assert f"{pool['library']} {pool['version']}, threads {pool['threads']}" in told


def test_what_is_missing_or_old_comes_with_its_line(monkeypatch: pytest.MonkeyPatch) -> None:
    here = {"viser": None, "rich": "13.2", "mujoco": "3.3.0"}

    def version(package: str) -> str:
        found = here[package]
        if found is None:
            raise metadata.PackageNotFoundError(package)
        return found

    monkeypatch.setattr(doctor.metadata, "version", version)
    view = doctor.state("view", {"viser": "1.0", "rich": "13"})
    assert view == {
        "complete": False,
        "packages": {"viser": None, "rich": "13.2"},
        "install": "pip install 'viser>=1.0'",
    }
    assert doctor.state("sim", {"mujoco": "3.3.3"})["install"] == "pip install 'mujoco>=3.3.3'"
    assert doctor.state("sim", {"mujoco": "3.3"})["complete"]


def test_the_needs_are_those_of_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [
        "numpy>=2.0",
        'jinja2>=3.1; extra == "report"',
        'bodyschema[report]; extra == "sim"',
        'mujoco>=3.3.3; extra == "sim"',
        'ruff>=0.8; extra == "dev"',
    ]
    monkeypatch.setattr(doctor.metadata, "requires", lambda _: lines)
    assert doctor.requirements() == {
        "": {"numpy": "2.0"},
        "report": {"jinja2": "3.1"},
        "sim": {"mujoco": "3.3.3"},
    }


@pytest.mark.parametrize(
    ("code", "stderr", "says"), [(0, "", "works"), (1, "a\n  b\nGLError: no", "GLError: no")]
)
def test_opengl(monkeypatch: pytest.MonkeyPatch, code: int, stderr: str, says: str) -> None:
    monkeypatch.undo()
    pytest.importorskip("mujoco")

    def done(command: Any, **_: Any) -> subprocess.CompletedProcess[str]:
        assert command[0] == sys.executable
        return subprocess.CompletedProcess(command, code, "", stderr)

    monkeypatch.setattr(doctor.subprocess, "run", done)
    assert says in doctor.opengl()
