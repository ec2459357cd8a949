"""The command as a process of its own: signals, closed and full streams, encodings, no home."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import bodyschema

COMMAND = [sys.executable, "-m", "bodyschema"]

SLOW = """
import sys, time
from bodyschema.cli import endings, process
process.own_process()
def work():
    try:
        print("begun", flush=True)
        time.sleep(30)
    finally:
        print("cleared up", flush=True)
sys.exit(endings.ended(work, True))
"""
"""A verb that takes long and clears up behind itself."""


def run(
    arguments: Sequence[str], code: str | None = None, **settings: Any
) -> subprocess.CompletedProcess[str]:
    """The command, or a program that uses it, in a process of its own."""
    command = [*COMMAND, *arguments] if code is None else [sys.executable, "-c", code]
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | settings
    return subprocess.run(command, text=True, check=False, timeout=120, **settings)


@pytest.mark.parametrize(
    ("sent", "code", "name"), [(signal.SIGINT, 130, "Ctrl-C"), (signal.SIGTERM, 143, "SIGTERM")]
)
def test_a_signal_ends_it_in_one_line(sent: signal.Signals, code: int, name: str) -> None:
    program = [sys.executable, "-c", SLOW]
    with subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as slow:
        assert slow.stdout is not None
        assert slow.stdout.readline() == "begun\n"
        slow.send_signal(sent)
        printed, told = slow.communicate(timeout=20)
    assert slow.returncode == code
    assert printed == "cleared up\n"
    assert told == f"bodyschema: stopped by {name}.\n"


@pytest.mark.parametrize("by", ["print('x' * 100000)", "Console().print('x ' * 100000)"])
def test_a_reader_that_leaves_is_no_answer(by: str) -> None:
    code = f"""
import sys
from rich.console import Console
from bodyschema.cli import endings, process
process.own_process()
sys.exit(endings.ended(lambda: {by} or 0, True))
"""
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "wb") as gone:
        done = run([], code, stdout=gone)
    assert done.returncode == 141
    assert done.stderr == ""


def test_a_full_disk_is_told() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:
        done = run(["doctor", "--help"], stdout=full)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "No space left" in done.stderr


@pytest.mark.parametrize("closed", [0, 1, 2])
def test_streams_may_be_closed(closed: int) -> None:
    shell = f'exec "$0" -m bodyschema --version {closed}{"<" if closed == 0 else ">"}&-'
    done = subprocess.run(
        ["/bin/sh", "-c", shell, sys.executable], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.startswith("bodyschema ") == (closed != 1)


def test_text_that_the_locale_lacks_is_spelt_out() -> None:
    code = """
from bodyschema.cli.process import own_process
own_process()
print("\\u0394 5 \\u00b5m")
"""
    plain = os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = run([], code, env=plain)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "\\u0394 5 \\xb5m\n"


def test_help_without_docstrings_a_terminal_or_colours() -> None:
    bare = {"COLUMNS": "40", "TERM": "dumb", "NO_COLOR": "1", "PYTHONOPTIMIZE": "2"}
    bare |= {"PYTHONDONTWRITEBYTECODE": "1", "LC_ALL": "C"}
    done = run(["calibrate", "--help"], env=os.environ | bare, stdin=subprocess.DEVNULL)
    assert done.returncode == 0, done.stderr
    assert "Correct a robot's model from a" in done.stdout
    assert "--overwrite" in done.stdout
    assert "\x1b" not in done.stdout


def test_a_fault_of_ours_is_not_the_answer_no() -> None:
    code = """
import sys
from bodyschema.cli import endings
sys.exit(endings.ended(lambda: 1 // 0, True))
"""
    done = run([], code)
    assert done.returncode == 70
    assert "ZeroDivisionError" in done.stderr
    assert done.stderr.rstrip().endswith("Please report it with the lines above.")


def test_an_error_of_the_system_is_one_sentence() -> None:
    code = """
import sys
from bodyschema.cli import endings
sys.exit(endings.ended(lambda: len(open("/nowhere/at all").read()), True))
"""
    done = run([], code)
    assert done.returncode == 2
    assert done.stderr == "bodyschema: cannot use /nowhere/at all (No such file or directory).\n"


KINEMATICS = """
import sys
from bodyschema.cli import endings, process
process.own_process()
def work():
    import bodyschema as bs
    body = bs.Body.random_chain(2, __import__("numpy").random.default_rng(0))
    print(bs.relative_pose(body, [0.0, 0.0], "base", "tip").shape)
    return 0
code = endings.ended(work, True)
process.said_after()
sys.exit(code)
"""


@pytest.fixture
def nowhere(tmp_path: Path) -> dict[str, str]:
    """The environment of one who can write neither at home nor in the installation."""
    source = Path(bodyschema.__file__).parent
    copy = tmp_path / "read_only" / "bodyschema"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for room in [copy, *(path for path in copy.rglob("*") if path.is_dir())]:
        (room / "__pycache__").touch()  # no folder can be made there, not even by root
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    return environment | {
        "HOME": "/dev/null",
        "XDG_CACHE_HOME": "/dev/null/cache",
        "PYTHONPATH": os.pathsep.join([str(copy.parent), *filter(None, sys.path)]),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def test_nowhere_to_write(nowhere: dict[str, str]) -> None:
    done = run([], KINEMATICS, env=nowhere)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "(4, 4)\n"
    assert done.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in done.stderr


def test_another_user_without_a_name(nowhere: dict[str, str], tmp_path: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root can run a process as another user")
    tmp_path.chmod(0o755)
    try:
        done = run([], KINEMATICS, env=nowhere, user=54321, group=54321, extra_groups=[], cwd="/")
    except PermissionError:
        pytest.skip("another user cannot reach this Python")
    if "No module named" in done.stderr:
        pytest.skip("another user cannot read these packages")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("\n") == 1


def test_compiling_is_told_once_with_its_seconds(tmp_path: Path) -> None:
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first, second = run([], KINEMATICS, env=cold), run([], KINEMATICS, env=cold)
    assert first.returncode == second.returncode == 0
    begun, took = first.stderr.splitlines()
    assert begun.startswith("Compiling for this machine (once")
    assert took.startswith("Compiling took ")
    assert second.stderr == ""
