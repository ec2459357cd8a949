"""A folder appears whole or not at all, and replaces nothing but what was written by us."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from bodyschema.atomic import check_new_folder, new_folder
from bodyschema.atomic.leftovers import SIGN
from bodyschema.atomic.manifest import MANIFEST
from bodyschema.atomic.swap import swapped
from bodyschema.errors import InputError

HIDDEN = [MANIFEST]


def contents(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_new_folder_appears_when_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "results"
    with new_folder(path) as temporary:
        (temporary / "a").write_text("1")
        assert not path.exists()
    assert contents(path) == [*HIDDEN, "a"]
    assert contents(path.parent) == ["results"]


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
    assert contents(path) == [*HIDDEN, "b"]
    assert contents(tmp_path) == ["results"]


def result(path: Path, name: str = "old", overwrite: bool = False) -> Path:
    with new_folder(path, overwrite) as temporary:
        (temporary / name).write_text(name)
    return path


def test_a_failing_block_leaves_the_old_folder(tmp_path: Path) -> None:
    path = result(tmp_path / "results")

    def stopped() -> None:
        with new_folder(path, overwrite=True) as temporary:
            (temporary / "half").touch()
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        stopped()
    assert contents(path) == [*HIDDEN, "old"]
    assert contents(tmp_path) == ["results"]


@pytest.mark.parametrize("can_swap", [True, False])
def test_an_earlier_result_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, can_swap: bool
) -> None:
    if not can_swap:
        monkeypatch.setattr("bodyschema.atomic.folder.swapped", lambda *_: False)
    path = result(tmp_path / "results")
    result(path, "new", overwrite=True)
    assert contents(path) == [*HIDDEN, "new"]
    assert contents(tmp_path) == ["results"]


def test_a_failing_rename_brings_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = result(tmp_path / "results")
    monkeypatch.setattr("bodyschema.atomic.folder.swapped", lambda *_: False)
    rename, calls = Path.rename, []

    def second_fails(self: Path, target: Path) -> Path:
        calls.append(self)
        if len(calls) == 2:
            raise OSError(5, "Input/output error", str(self))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", second_fails)
    with pytest.raises(InputError, match="Input/output error"):
        result(path, "new", overwrite=True)
    assert contents(path) == [*HIDDEN, "old"]
    assert contents(tmp_path) == ["results"]


def test_only_what_was_written_is_ever_replaced(tmp_path: Path) -> None:
    path = result(tmp_path / "results")
    theirs = path / "notes.txt"
    theirs.write_text("mine")
    (path / ".git").mkdir()
    (path / "src").mkdir()
    with pytest.raises(
        InputError, match=r"holds '\.git', 'notes\.txt', 'src', which bodyschema did"
    ):
        check_new_folder(path, overwrite=True)
    (path / "t").touch()
    with pytest.raises(InputError, match=r"'src' and 1 more, which bodyschema did not write"):
        result(path, "new", overwrite=True)
    assert theirs.read_text() == "mine"
    for name in (".git", "src"):
        (path / name).rmdir()
    for name in ("notes.txt", "t"):
        (path / name).unlink()
    (path / "old").write_text("my edit")
    with pytest.raises(InputError, match=r"'old' was changed since bodyschema wrote it.*move it"):
        result(path, "new", overwrite=True)
    assert (path / "old").read_text() == "my edit"
    (path / "old").unlink()  # what is gone is missed by nobody
    result(path, "new", overwrite=True)
    assert contents(path) == [*HIDDEN, "new"]


def test_a_link_or_folder_of_a_name_of_ours_is_not_ours(tmp_path: Path) -> None:
    path = result(tmp_path / "results")
    (tmp_path / "dear").write_text("old")
    (path / "old").unlink()
    (path / "old").symlink_to(tmp_path / "dear")
    with pytest.raises(InputError, match="holds 'old', which"):
        check_new_folder(path, overwrite=True)
    (path / "old").unlink()
    (path / "old").mkdir()
    with pytest.raises(InputError, match="holds 'old', which"):
        check_new_folder(path, overwrite=True)


@pytest.mark.parametrize("text", ["", "[]", '{"files": 3}', '{"files": {"mine": 3}}', "{" * 9999])
def test_a_damaged_list_vouches_for_nothing(tmp_path: Path, text: str) -> None:
    path = result(tmp_path / "results", "mine")
    (path / MANIFEST).write_text(text)
    with pytest.raises(InputError, match="'mine', which is no result"):
        check_new_folder(path, overwrite=True)


def test_a_forged_list_reaches_nothing_outside(tmp_path: Path) -> None:
    (tmp_path / "dear").write_text("mine")
    path = result(tmp_path / "results")
    (path / MANIFEST).write_text('{"files": {"../dear": [], "old": []}}')
    result(path, "new", overwrite=True)
    assert (tmp_path / "dear").read_text() == "mine"
    assert contents(tmp_path) == ["dear", "results"]


def test_what_comes_while_the_result_is_made_stays(tmp_path: Path) -> None:
    path = result(tmp_path / "results")

    def edited() -> None:
        with new_folder(path, overwrite=True) as temporary:
            (temporary / "new").touch()
            (path / "notes.txt").write_text("mine")

    with pytest.raises(InputError, match=r"holds 'notes\.txt'"):
        edited()
    assert (path / "notes.txt").read_text() == "mine"
    assert contents(tmp_path) == ["results"]


@pytest.mark.parametrize("can_swap", [True, False])
def test_what_comes_just_before_the_swap_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, can_swap: bool
) -> None:
    path = result(tmp_path / "results")

    def late(one: Path, other: Path) -> bool:
        if not (one / "notes.txt").exists():
            (path / "notes.txt").write_text("mine")
        return can_swap and swapped(one, other)

    monkeypatch.setattr("bodyschema.atomic.folder.swapped", late)
    with pytest.raises(InputError, match=r"holds 'notes\.txt'"):
        result(path, "new", overwrite=True)
    assert contents(path) == [*HIDDEN, "notes.txt", "old"]
    assert contents(tmp_path) == ["results"]


def test_folders_in_use_are_never_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stood, home = tmp_path / "a" / "stood", tmp_path / "b" / "home"
    for folder in (stood, home):
        folder.mkdir(parents=True)
    monkeypatch.chdir(stood)
    monkeypatch.setenv("HOME", str(home))
    for place, words in (
        (Path(), "is the current directory"),
        (Path("..") / "stood", "is the current directory"),
        (stood.parent, "holds the current directory"),
        (home, "is the home folder"),
        (home.parent, "holds the home folder"),
        (Path("/"), "holds the current directory"),
    ):
        with pytest.raises(InputError, match=f"{words}, and is never replaced; name a new folder"):
            check_new_folder(place, overwrite=True)
        with pytest.raises(InputError, match="never replaced"):
            result(place, overwrite=True)
    monkeypatch.setattr("os.path.ismount", lambda path: Path(path) == tmp_path / "a")
    monkeypatch.chdir(home)
    with pytest.raises(InputError, match="where a disk is mounted"):
        check_new_folder(tmp_path / "a", overwrite=True)


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX's")
def test_a_folder_that_may_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    message = r"cannot write to '.*' \(Permission denied\); choose a folder that you may write"

    def refuse(place: object, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(place))

    with monkeypatch.context() as patched:
        patched.setattr("os.mkdir", refuse)
        for deep in ("a", "b/c"):
            with pytest.raises(InputError, match=message):
                result(tmp_path / deep)
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(InputError, match=message):
        check_new_folder(tmp_path / "deep" / "er")
    assert contents(tmp_path) == []


def test_places_where_no_folder_can_be(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for refuse in (check_new_folder, lambda p: new_folder(p).__enter__()):
        with pytest.raises(InputError, match=r"'.*file' is a file; name a folder for the results"):
            refuse(tmp_path / "file")
        for odd in ("file/child/results", "n" * 300, "nul\0"):
            with pytest.raises(InputError, match=r"cannot write to '"):
                refuse(tmp_path / odd)
    assert contents(tmp_path) == ["file"]


def test_checking_writes_nothing(tmp_path: Path) -> None:
    check_new_folder(tmp_path / "deep" / "er" / "results")
    assert not list(tmp_path.iterdir())


def test_permissions_are_those_the_user_gives(tmp_path: Path) -> None:
    path = tmp_path / "results"
    before = os.umask(0o027)
    try:
        result(path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o750
        path.chmod(0o700)
        result(path, "new", overwrite=True)
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o700


def test_all_is_on_the_disk_before_the_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A power cut leaves the old or the new result, with no empty file in it."""
    path, sync = result(tmp_path / "results"), os.fsync
    synced: list[int] = []
    before: list[set[int]] = []

    def told_sync(handle: int) -> None:
        synced.append(os.fstat(handle).st_ino)
        sync(handle)

    def told_swap(fresh: Path, other: Path) -> bool:
        inodes = {fresh.stat().st_ino, *(file.stat().st_ino for file in fresh.iterdir())}
        before.append(inodes - {*synced})
        return swapped(fresh, other)

    monkeypatch.setattr("os.fsync", told_sync)
    monkeypatch.setattr("bodyschema.atomic.folder.swapped", told_swap)
    result(path, "new", overwrite=True)
    assert before == [set()]
    assert synced[-1] == tmp_path.stat().st_ino


def test_long_names_have_room_for_what_is_made_of_them(tmp_path: Path) -> None:
    for name in ("r" * 255, "ö" * 127):
        assert contents(result(tmp_path / name)) == [*HIDDEN, "old"]
        result(tmp_path / name, "new", overwrite=True)
    assert len(contents(tmp_path)) == 2
    assert not any(SIGN in name for name in contents(tmp_path))


def test_two_runs_at_once_leave_one_result_whole(tmp_path: Path) -> None:
    path = tmp_path / "results"
    with new_folder(path, overwrite=True) as first, new_folder(path, overwrite=True) as second:
        (first / "first").touch()
        (second / "second").touch()
    assert contents(path) == [*HIDDEN, "first"]
    assert contents(tmp_path) == ["results"]

    def late() -> None:
        with new_folder(tmp_path / "other") as fresh:
            (fresh / "late").touch()
            result(tmp_path / "other", "early")

    with pytest.raises(InputError, match="not empty"):
        late()
    assert contents(tmp_path / "other") == [*HIDDEN, "early"]


def test_folders_inside_are_listed_and_anything_else_in_them_is_kept(tmp_path: Path) -> None:
    target = tmp_path / "set"

    def write(text: str) -> None:
        with new_folder(target, overwrite=True) as fresh:
            (fresh / "meta").mkdir()
            (fresh / "meta" / "info.json").write_text(text)

    write("1")
    write("2")
    assert (target / "meta" / "info.json").read_text() == "2"
    (target / "meta" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"'meta/notes\.txt', which bodyschema did not write"):
        write("3")
    (target / "meta" / "notes.txt").unlink()
    (target / "empty").mkdir()
    with pytest.raises(InputError, match="'empty'"):
        write("3")
    (target / "empty").rmdir()
    (target / "meta" / "info.json").write_text("edited")
    with pytest.raises(InputError, match=r"'meta/info\.json' was changed"):
        write("3")
