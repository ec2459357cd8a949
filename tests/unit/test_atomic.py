"""Files and folders appear whole or not at all, and replace what was there only when done."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from bodyschema.atomic import check_new_folder, new_file, new_folder
from bodyschema.errors import InputError


def contents(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_when_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "er" / "a.txt"
    with new_file(path) as temporary:
        assert temporary.parent == path.parent
        assert temporary.suffix == ".txt"
        temporary.write_text("done")
        assert not path.exists()
    assert path.read_text() == "done"
    assert contents(path.parent) == ["a.txt"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o644


def test_a_failing_block_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def interrupted() -> None:
        with new_file(path) as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "old"
    assert contents(tmp_path) == ["a.txt"]
    with new_file(path) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_a_link_keeps_pointing_to_the_new_content(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    target, link = tmp_path / "store" / "real.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    with new_file(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert contents(tmp_path / "store") == ["real.txt"]


def test_places_where_no_file_can_be(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(InputError, match=r"cannot write to .*file.*; choose a folder that you may"),
        new_file(tmp_path / "file" / "child" / "a.txt"),
    ):
        pytest.fail("the block must not run")
    with pytest.raises(InputError, match="is a folder; name a file"), new_file(tmp_path):
        pytest.fail("the block must not run")
    assert contents(tmp_path) == ["file"]


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX's")
def test_a_folder_that_may_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    monkeypatch.setattr("tempfile.mkdtemp", refuse)
    message = r"cannot write to '.*' \(Permission denied\); choose a folder that you may write"
    with pytest.raises(InputError, match=message), new_file(tmp_path / "a"):
        pytest.fail("the block must not run")
    with pytest.raises(InputError, match=message), new_folder(tmp_path / "a"):
        pytest.fail("the block must not run")
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(InputError, match=message):
        check_new_folder(tmp_path / "deep" / "er")


def test_a_new_folder_appears_when_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "results"
    with new_folder(path) as temporary:
        (temporary / "a").write_text("1")
        assert not path.exists()
    assert contents(path) == ["a"]
    assert contents(path.parent) == ["results"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o755


def test_an_empty_folder_may_be_filled_and_a_full_one_not(tmp_path: Path) -> None:
    path = tmp_path / "results"
    path.mkdir()
    with new_folder(path) as temporary:
        (temporary / "a").touch()
    for refuse in (check_new_folder, lambda p: new_folder(p).__enter__()):
        with pytest.raises(InputError, match="is not empty; name another folder or pass --over"):
            refuse(path)
    check_new_folder(path, overwrite=True)
    with new_folder(path, overwrite=True) as temporary:
        (temporary / "b").touch()
    assert contents(path) == ["b"]
    assert contents(tmp_path) == ["results"]


def test_a_failing_block_leaves_the_old_folder(tmp_path: Path) -> None:
    path = tmp_path / "results"
    path.mkdir()
    (path / "old").touch()

    def stopped() -> None:
        with new_folder(path, overwrite=True) as temporary:
            (temporary / "half").touch()
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        stopped()
    assert contents(path) == ["old"]
    assert contents(tmp_path) == ["results"]


def test_a_failing_rename_brings_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "results"
    path.mkdir()
    (path / "old").touch()
    rename, calls = Path.rename, []

    def second_fails(self: Path, target: Path) -> Path:
        calls.append(self)
        if len(calls) == 2:
            raise OSError(5, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", second_fails)
    with (
        pytest.raises(OSError, match="Input/output error"),
        new_folder(path, overwrite=True) as temporary,
    ):
        (temporary / "new").touch()
    assert contents(path) == ["old"]
    assert contents(tmp_path) == ["results"]


def test_places_where_no_folder_can_be(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for refuse in (check_new_folder, lambda p: new_folder(p).__enter__()):
        with pytest.raises(InputError, match=r"'.*file' is a file; name a folder for the results"):
            refuse(tmp_path / "file")
        with pytest.raises(InputError, match=r"cannot write to '.*file'"):
            refuse(tmp_path / "file" / "child" / "results")
    assert contents(tmp_path) == ["file"]


def test_checking_writes_nothing(tmp_path: Path) -> None:
    check_new_folder(tmp_path / "deep" / "er" / "results")
    assert not list(tmp_path.iterdir())
