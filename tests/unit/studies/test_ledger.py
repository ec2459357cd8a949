"""Finished tasks on disk: at most the line being written is lost, and damage is seen and said."""

from __future__ import annotations

import json
import os
import stat
from functools import partial
from pathlib import Path

import pytest

from bodyschema.atomic.manifest import MANIFEST
from bodyschema.cli.study import RunStudy
from bodyschema.errors import InputError
from bodyschema.studies.ledger import HEAD, LINES, Ledger, is_earlier
from bodyschema.studies.runner import settings_of
from tiny_study import TinyStudy

STUDY = TinyStudy(runs=3)


def begun(folder: Path, overwrite: bool = False, study: TinyStudy = STUDY) -> Ledger:
    return Ledger.open(folder, settings_of(study), overwrite)


def filled(folder: Path, n: int = 3) -> Ledger:
    ledger = begun(folder)
    for k in range(n):
        ledger.add(f"run {k}", {"mean": float(k), "text": "ü"})
    return ledger


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_lines_come_back(tmp_path: Path) -> None:
    ledger = filled(tmp_path / "out")
    assert ledger.finished() == {f"run {k}": {"mean": float(k), "text": "ü"} for k in range(3)}
    assert ledger.read().damaged == 0
    assert names(tmp_path / "out") == {HEAD, LINES, MANIFEST}
    assert names(tmp_path) == {"out"}


def test_a_line_is_on_the_disk_before_it_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ledger, sync, sizes = begun(tmp_path / "out"), os.fsync, []

    def told(handle: int) -> None:
        sizes.append(os.fstat(handle).st_size)
        sync(handle)

    monkeypatch.setattr("os.fsync", told)
    ledger.add("run 0", {"mean": 0.0})
    assert sizes == [(tmp_path / "out" / LINES).stat().st_size]


def test_a_cut_line_gives_way_to_the_next(tmp_path: Path) -> None:
    ledger = filled(tmp_path / "out")
    lines = tmp_path / "out" / LINES
    whole = lines.read_bytes()
    for cut in range(1, len(whole.splitlines()[-1]) + 1):
        lines.write_bytes(whole[:-cut])
        assert list(ledger.finished()) == ["run 0", "run 1"]
        assert lines.read_bytes() == whole[:-cut], "reading writes nothing"
        ledger.add("run 2", {"mean": 2.0, "text": "ü"})
        assert lines.read_bytes() == whole
    # However long what was cut off is.
    lines.write_bytes(whole + 10_000 * b"x")
    ledger.add("run 0", {"mean": 0.0, "text": "ü"})
    assert lines.read_bytes() == whole + whole.splitlines(keepends=True)[0]
    lines.write_bytes(b"x" * 5000)
    ledger.add("run 0", {"mean": 0.0, "text": "ü"})
    assert lines.read_bytes() == whole.splitlines(keepends=True)[0]


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_killed_while_a_cut_line_is_dropped(tmp_path: Path) -> None:
    """At each step of the next line that is added."""
    from kills import forked, kill_at, stepped

    ledger = filled(tmp_path / "out")
    lines = tmp_path / "out" / LINES
    whole, code, step = lines.read_bytes(), -9, 0
    while code == -9:
        lines.write_bytes(whole + b'{"key": "run 3"')
        step += 1
        add = partial(ledger.add, "run 4", {"mean": 4.0})
        child = forked(partial(stepped, add, partial(kill_at, step)))
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert lines.read_bytes().startswith(whole)
    assert code == 0
    assert step > 10


def test_what_is_cut_off_is_never_rewritten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whole lines stand in the file at every instant, also while a cut one is dropped."""
    ledger = filled(tmp_path / "out")
    lines = tmp_path / "out" / LINES
    whole = lines.read_bytes()
    lines.write_bytes(whole + b'{"key": "run 3"')
    seen = []

    def killed(_: int) -> None:
        seen.append(lines.read_bytes())
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", killed)
    with pytest.raises(InputError, match="No space left on device"):
        ledger.add("run 4", {"mean": 4.0})
    assert seen[0].startswith(whole)
    assert set(ledger.finished()) == {"run 0", "run 1", "run 2", "run 4"}


@pytest.mark.parametrize(
    "damage",
    [
        b"{", b"\xff\xfe", b"[]", b"3", b'{"key": 1, "result": {}}', b'{"key": "run 1"}',
        b'{"key": "run 1", "result": [1]}', b"[" * 50_000,
    ],
    ids=range(8),
)  # fmt: skip
def test_a_damaged_line_is_left_out_and_counted(tmp_path: Path, damage: bytes) -> None:
    ledger = filled(tmp_path / "out")
    lines = tmp_path / "out" / LINES
    first, _, last = lines.read_bytes().splitlines(keepends=True)
    lines.write_bytes(first + damage + b"\n\n" + last)
    assert set(ledger.finished()) == {"run 0", "run 2"}
    assert ledger.read().damaged == 1


def test_a_digit_that_changed_is_damage(tmp_path: Path) -> None:
    ledger = filled(tmp_path / "out")
    lines = tmp_path / "out" / LINES
    lines.write_bytes(lines.read_bytes().replace(b"1.0", b"7.0"))
    assert set(ledger.finished()) == {"run 0", "run 2"}
    assert ledger.read().damaged == 1


def test_damage_is_said_and_its_task_done_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    verb = RunStudy(STUDY, workers=1, out=tmp_path / "out", json=True)
    assert verb.run() == 0
    lines = tmp_path / "out" / LINES
    whole = lines.read_bytes()
    right, said = capsys.readouterr()
    assert "damaged" not in said
    for count, spoilt in (
        (1, whole.replace(b"run 1", b"run x")),
        (2, whole.replace(b"run", b"ru")),
    ):
        lines.write_bytes(spoilt.replace(b'ru 2"', b'run 2"').replace(b"ru 2", b"run 2"))
        assert verb.run() == 0
        again, said = capsys.readouterr()
        assert again == right
        assert ("1 line of tasks.jsonl is" if count == 1 else "2 lines are") + " damaged" in said


def test_lines_of_earlier_versions_are_read(tmp_path: Path) -> None:
    ledger = begun(tmp_path / "out")
    (tmp_path / "out" / LINES).write_text('{"key": "run 0", "result": {"mean": 1.0}}\n')
    assert ledger.finished() == {"run 0": {"mean": 1.0}}


def test_another_study_is_replaced_in_one_step(tmp_path: Path) -> None:
    filled(tmp_path / "out")
    other = TinyStudy(seed=4)
    assert begun(tmp_path / "out", True, other).finished() == {}
    assert json.loads((tmp_path / "out" / HEAD).read_text())["seed"] == 4
    assert names(tmp_path) == {"out"}


def test_nothing_but_a_study_is_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"
    filled(out).keep({"summary.json": b"{}"})
    (out / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds 'notes\.txt', which bodyschema did not write"):
        begun(out, overwrite=True)
    assert begun(out).finished(), "to go on is no harm"
    (out / "notes.txt").unlink()
    (out / "summary.json").write_text('{"mine": 1}')
    for again in (True, False):
        with pytest.raises(InputError, match=r"summary\.json'.* (was changed|is not what)"):
            begun(out, overwrite=again)
    assert (out / "summary.json").read_text() == '{"mine": 1}'


def test_what_was_made_of_results_replaces_only_itself(tmp_path: Path) -> None:
    out = tmp_path / "out"
    ledger = filled(out)
    for content in (b"1", b"2", b"2", b"3"):
        ledger.keep({"summary.json": content})
        assert (out / "summary.json").read_bytes() == content
    (out / "figure.png").write_bytes(b"mine")
    with pytest.raises(InputError, match=r"figure\.png' is not what this study wrote there"):
        ledger.keep({"summary.json": b"4", "figure.png": b"ours"})
    assert (out / "figure.png").read_bytes() == b"mine"
    assert (out / "summary.json").read_bytes() == b"3"


def test_killed_between_list_and_file_both_are_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    ledger = filled(out)
    ledger.keep({"summary.json": b"1"})
    write = Ledger._write

    def killed(self: Ledger, name: str, content: bytes) -> None:
        if name == "summary.json":
            raise KeyboardInterrupt
        write(self, name, content)

    with monkeypatch.context() as patched:
        patched.setattr(Ledger, "_write", killed)
        with pytest.raises(KeyboardInterrupt):
            ledger.keep({"summary.json": b"2"})
    assert (out / "summary.json").read_bytes() == b"1"
    ledger.keep({"summary.json": b"3"})
    assert (out / "summary.json").read_bytes() == b"3"


def test_a_study_of_an_earlier_version_is_known(tmp_path: Path) -> None:
    out = tmp_path / "out"
    filled(out).keep({"summary.json": b"1"})
    (out / MANIFEST).unlink()
    assert is_earlier(out)
    begun(out).keep({"summary.json": b"2"})
    (out / MANIFEST).unlink()
    (out / "src").mkdir()
    assert not is_earlier(out)
    (out / "src").rmdir()
    (out / HEAD).write_text('{"paper": "mine"}')
    assert not is_earlier(out)
    with pytest.raises(InputError, match="which is no result"):
        begun(out, overwrite=True)


@pytest.mark.skipif(os.name != "posix", reason="makes POSIX's kinds of files")
def test_only_a_plain_file_is_appended_to(tmp_path: Path) -> None:
    ledger = begun(tmp_path / "out")
    lines, dear = tmp_path / "out" / LINES, tmp_path / "dear.txt"
    dear.write_text("mine")
    lines.symlink_to(dear)
    with pytest.raises(InputError, match="is no plain file; move it away"):
        ledger.add("run 0", {})
    assert ledger.finished() == {}
    lines.unlink()
    os.mkfifo(lines)
    with pytest.raises(InputError, match="is a pipe; move it away"):
        ledger.add("run 0", {})
    assert ledger.finished() == {}
    assert stat.S_ISFIFO(lines.lstat().st_mode)
    assert dear.read_text() == "mine"


def test_two_runs_of_one_study_share_its_folder(tmp_path: Path) -> None:
    first, second = begun(tmp_path / "out"), begun(tmp_path / "out")
    first.add("run 0", {"mean": 0.0})
    second.add("run 1", {"mean": 1.0})
    first.add("run 1", {"mean": 1.0})
    assert set(first.finished()) == {"run 0", "run 1"}
