"""Studies over processes: the same answer however they are run, and nothing finished is lost."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from bodyschema.errors import InputError
from bodyschema.studies.ledger import LINES, Ledger
from bodyschema.studies.runner import run_study, settings_of
from tiny_study import TinyStudy

STUDY = TinyStudy(runs=5, seed=3)


class Forbidden(TinyStudy):
    """A study whose tasks must not be done again."""

    def work(self, task):
        raise AssertionError(f"{task.key} was done again")


def open_ledger(folder: Path, study: TinyStudy = STUDY, overwrite: bool = False) -> Ledger:
    return Ledger.open(folder, settings_of(study), overwrite)


def test_answer_does_not_depend_on_the_number_of_workers(tmp_path):
    alone = run_study(STUDY, 1)
    pooled = run_study(STUDY, 2, open_ledger(tmp_path / "pooled"))
    assert json.dumps(pooled) == json.dumps(alone)
    assert list(pooled) == [task.key for task in STUDY.tasks()]


def test_results_are_json_even_before_they_were_stored():
    assert run_study(STUDY, 1)["run 0"]["ends"] == [0, 1]


def test_a_result_that_json_cannot_hold_is_refused():
    class Bad(TinyStudy):
        def work(self, task):
            return {"mean": float("nan")}

    with pytest.raises(ValueError, match="JSON compliant"):
        run_study(Bad(), 1)


def test_finished_tasks_are_not_done_again(tmp_path):
    first = run_study(STUDY, 1, open_ledger(tmp_path))
    done = []
    again = run_study(Forbidden(5, 3), 1, open_ledger(tmp_path), lambda n, of: done.append((n, of)))
    assert again == first
    assert done == [(5, 5)]


def test_a_torn_last_line_is_done_again(tmp_path):
    whole = run_study(STUDY, 1, open_ledger(tmp_path))
    lines = tmp_path / LINES
    lines.write_bytes(lines.read_bytes()[:-9])
    ledger = open_ledger(tmp_path)
    assert len(ledger.finished()) == 4
    assert run_study(STUDY, 1, ledger) == whole
    assert len(open_ledger(tmp_path).finished()) == 5


def test_other_settings_are_not_mixed_in(tmp_path):
    run_study(STUDY, 1, open_ledger(tmp_path))
    other = replace(STUDY, seed=4)
    with pytest.raises(InputError, match=r"seed = 3 \(now 4\).*--overwrite"):
        open_ledger(tmp_path, other)
    assert open_ledger(tmp_path, other, overwrite=True).finished() == {}
    with pytest.raises(InputError, match=r"seed = 4 \(now 3\)"):
        open_ledger(tmp_path)


def test_a_folder_with_something_else_is_refused(tmp_path):
    (tmp_path / "letters.txt").write_text("dear")
    with pytest.raises(InputError, match="not empty"):
        open_ledger(tmp_path)
    (tmp_path / "study.json").write_text("no json")
    with pytest.raises(InputError, match="cannot be read"):
        open_ledger(tmp_path)


@pytest.mark.skipif(os.name != "posix", reason="sends a POSIX signal")
@pytest.mark.parametrize("workers", [1, 2])
def test_interruption_keeps_what_is_finished(tmp_path, workers):
    script = tmp_path / "interrupted.py"
    script.write_text(
        "import sys\n"
        f"sys.path[:0] = [{str(Path(__file__).parents[2])!r}]\n"
        "from pathlib import Path\n"
        "from tiny_study import TinyStudy\n"
        "from bodyschema.cli.study import RunStudy\n"
        "if __name__ == '__main__':\n"
        "    study = TinyStudy(runs=100, pause=0.2)\n"
        f"    sys.exit(RunStudy(study, workers={workers}, out=Path('out')).run())\n"
    )
    process = subprocess.Popen(
        [sys.executable, str(script)], cwd=tmp_path, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    lines = tmp_path / "out" / LINES
    try:
        begin = time.monotonic()
        while not (lines.is_file() and lines.read_text().count("\n") >= 2):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() - begin < 100
            time.sleep(0.02)
        # As a terminal does: to the whole group.
        os.killpg(process.pid, signal.SIGINT)
        out, messages = process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 130
    assert out == ""
    assert "The same command goes on from there" in messages
    assert "Traceback" not in messages
    kept = Ledger(tmp_path / "out").finished()
    assert 2 <= len(kept) < 100
    alone = TinyStudy(runs=100)
    assert all(
        kept[task.key]["mean"] == alone.work(task)["mean"]
        for task in alone.tasks()
        if task.key in kept
    )
