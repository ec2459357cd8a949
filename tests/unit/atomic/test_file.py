"""A file appears whole or not at all, and replaces only a plain file that was named."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from bodyschema.atomic import check_new_file, new_file, new_folder
from bodyschema.atomic.leftovers import SIGN
from bodyschema.errors import InputError


def contents(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def written(path: Path, text: str = "new", overwrite: bool = True) -> None:
    with new_file(path, overwrite) as temporary:
        temporary.write_text(text)


def test_a_file_appears_when_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "er" / "a.txt"
    with new_file(path) as temporary:
        assert temporary.parent == path.parent
        assert temporary.suffix == ".txt"
        temporary.write_text("done")
        assert not path.exists()
    assert path.read_text() == "done"
    assert contents(path.parent) == ["a.txt"]


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX's")
def test_permissions_are_those_the_user_gives(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    before = os.umask(0o027)
    try:
        written(path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
        path.chmod(0o600)
        written(path)
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


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
    written(path)
    assert path.read_text() == "new"


def test_nothing_is_replaced_without_being_asked(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    for refuse in (check_new_file, lambda p: new_file(p, overwrite=False).__enter__()):
        with pytest.raises(InputError, match="exists; name another file or pass --overwrite"):
            refuse(path)
    check_new_file(path, overwrite=True)
    # One that appears while the block runs is as dear.
    path.unlink()

    def overtaken() -> None:
        with new_file(path, overwrite=False) as temporary:
            temporary.write_text("new")
            path.write_text("first")

    with pytest.raises(InputError, match="exists"):
        overtaken()
    assert path.read_text() == "first"
    assert contents(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("linkless", [False, True])
def test_one_that_comes_at_the_last_instant_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, linkless: bool
) -> None:
    path, link = tmp_path / "a.txt", os.link

    def late(*names: Path) -> None:
        if linkless:
            raise OSError(1, "Operation not permitted")
        path.write_text("first")
        link(*names)

    monkeypatch.setattr("os.link", late)
    if linkless:
        written(path, overwrite=False)
        assert path.read_text() == "new"
    else:
        with pytest.raises(InputError, match="written by another run meanwhile"):
            written(path, overwrite=False)
        assert path.read_text() == "first"
    assert contents(tmp_path) == ["a.txt"]


def special(folder: Path) -> list[Path]:
    """A thing of each kind that is no plain file, in a folder of its own; as far as we may."""
    (folder / "file").write_text("mine")
    (folder / "link").symlink_to(folder / "file")
    (folder / "lost").symlink_to(folder / "nothing")
    (folder / "folder").mkdir()
    (folder / "to_folder").symlink_to(folder / "folder")
    os.mkfifo(folder / "pipe")
    found = [folder / name for name in ("link", "lost", "folder", "to_folder", "pipe")]
    try:
        os.mknod(folder / "device", 0o600 | stat.S_IFCHR, os.makedev(1, 3))
        found.append(folder / "device")
    except OSError:
        pass
    return found


@pytest.mark.skipif(os.name != "posix", reason="makes POSIX's kinds of files")
def test_what_is_no_plain_file_is_refused_and_stays(tmp_path: Path) -> None:
    for path in special(tmp_path):
        before = os.lstat(path)
        with pytest.raises(InputError, match=r"is a .* name "):
            check_new_file(path, overwrite=True)
        with pytest.raises(InputError, match=r"is a .* name "):
            written(path)
        if path.name != "folder":
            with pytest.raises(InputError, match=r"is a .* name "):
                new_folder(path, overwrite=True).__enter__()
        after = os.lstat(path)
        assert (after.st_mode, after.st_ino, after.st_rdev, after.st_ctime_ns) == (
            before.st_mode, before.st_ino, before.st_rdev, before.st_ctime_ns,
        )  # fmt: skip
    assert (tmp_path / "file").read_text() == "mine"
    assert not any(SIGN in name for name in contents(tmp_path))


def test_links_above_a_file_are_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    written(tmp_path / "link" / "a.txt")
    assert contents(tmp_path / "real") == ["a.txt"]


def test_a_file_of_a_result_stays_as_it_is(tmp_path: Path) -> None:
    with new_folder(tmp_path / "out") as fresh:
        (fresh / "robot.urdf").write_text("<robot/>")
    with pytest.raises(InputError, match="belongs to the result in"):
        check_new_file(tmp_path / "out" / "robot.urdf", overwrite=True)
    check_new_file(tmp_path / "out" / "mine.urdf")


def test_places_where_no_file_can_be(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(InputError, match=r"cannot write to .*file.*; choose a folder that you may"),
        new_file(tmp_path / "file" / "child" / "a.txt"),
    ):
        pytest.fail("the block must not run")
    with pytest.raises(InputError, match="is a folder; name a file"), new_file(tmp_path):
        pytest.fail("the block must not run")
    for odd in ("n" * 300, "nul\0", "", "/"):
        with pytest.raises(InputError, match=r"cannot write|is a folder"):
            check_new_file(tmp_path / odd if odd else Path())
    assert contents(tmp_path) == ["file"]


def test_the_content_is_on_the_disk_before_the_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A power cut leaves the old or the new, never an empty file of that name."""
    done: list[str] = []
    sync, replace = os.fsync, os.replace

    def told_sync(handle: int) -> None:
        done.append("content" if stat.S_ISREG(os.fstat(handle).st_mode) else "names")
        sync(handle)

    def told_replace(one: Path, other: Path) -> None:
        done.append("replace")
        replace(one, other)

    monkeypatch.setattr("os.fsync", told_sync)
    monkeypatch.setattr("os.replace", told_replace)
    written(tmp_path / "a.txt")
    assert done == ["content", "replace", "names"]


def test_a_full_disk_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match=r"No space left on device.*Make room"):
        written(path)
    assert path.read_text() == "old"
    assert contents(tmp_path) == ["a.txt"]


def test_errors_of_other_files_are_let_through(tmp_path: Path) -> None:
    def careless() -> None:
        with new_file(tmp_path / "a.txt"):
            (tmp_path / "missing").read_bytes()

    with pytest.raises(FileNotFoundError):
        careless()
    assert contents(tmp_path) == []
