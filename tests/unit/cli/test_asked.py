"""Which verb was asked for: near misses, the version, completion."""

from __future__ import annotations

import subprocess
import sys

import pytest

from bodyschema.cli import run
from bodyschema.cli.verbs import VERBS


def test_a_near_miss_of_a_verb(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrte", "run.toml"]) == 2
    assert "no verb 'calibrte'; did you mean 'calibrate'?" in capsys.readouterr().err


def test_a_near_miss_of_a_flag(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run(["report", "folder", "--jsn"])
    assert ended.value.code == 2
    printed = capsys.readouterr()
    assert "--json" in printed.out + printed.err


def test_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("bodyschema ")


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_help_names_every_verb(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run(arguments)
    assert ended.value.code == 0
    told = capsys.readouterr().out
    assert all(f"• {verb} " in told for verb in VERBS)


def test_completion_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run(["--tyro-print-completion", "bash"])
    assert not ended.value.code
    assert "bodyschema" in capsys.readouterr().out


def test_help_compiles_nothing_and_loads_no_compiler() -> None:
    code = """
import contextlib, io, sys
from bodyschema.cli import run
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
    run(["--help"])
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numba", "scipy", "matplotlib", "mujoco"} & set(done.stdout.split())


def test_only_the_verb_that_was_asked_for_is_loaded() -> None:
    code = """
import sys
from bodyschema.cli.verbs import verb_of
verb_of(["report", "folder"])
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "bodyschema.cli.report" in loaded
    assert not {"bodyschema.cli.track", "numpy", "numba"} & loaded
