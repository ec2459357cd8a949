"""What killed runs leave is put back or cleared away, and nothing of the living or of others is."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bodyschema.atomic import check_new_folder, found_again, new_file, new_folder
from bodyschema.atomic.leftovers import aside, held, tidy
from bodyschema.atomic.manifest import MANIFEST
from bodyschema.errors import InputError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="locks are POSIX's")


def contents(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def result(path: Path, name: str = "old") -> Path:
    with new_folder(path, overwrite=True) as temporary:
        (temporary / name).write_text(name)
    return path


def test_an_old_result_is_put_back(tmp_path: Path) -> None:
    """As after a kill between the two renames of a system that cannot swap."""
    path = tmp_path / "results"
    for find in (found_again, check_new_folder):
        result(path).rename(aside(path, ".old"))
        if find is check_new_folder:
            check_new_folder(path, overwrite=True)
        else:
            assert found_again(path)
        assert contents(tmp_path) == ["results"]
        assert not found_again(path)
    assert not found_again(tmp_path / "never was")


def test_the_latest_of_several_is_put_back(tmp_path: Path) -> None:
    path = tmp_path / "results"
    for name, time in (("a", 100), ("b", 300), ("c", 200)):
        old = result(tmp_path / name, name).rename(aside(path, ".old"))
        os.utime(old, (time, time))
    assert found_again(path)
    assert contents(path) == [MANIFEST, "b"]


def test_what_an_earlier_version_took_away_is_put_back(tmp_path: Path) -> None:
    path = tmp_path / "results"
    result(path).rename(tmp_path / ".results.ab12_xyz.old")
    assert found_again(path)


def test_what_a_living_run_took_away_is_left_to_it(tmp_path: Path) -> None:
    path = tmp_path / "results"
    old = result(path).rename(aside(path, ".old"))
    with held(old):
        assert not found_again(path)
    assert found_again(path)


def test_leftovers_are_cleared_away_and_nothing_else(tmp_path: Path) -> None:
    path = result(tmp_path / "results")
    half, old, file = aside(path, ".new"), aside(path, ".old"), aside(path, ".csv")
    half.mkdir()
    (half / "robot.urdf").touch()
    result(tmp_path / "gone").rename(old)
    file.touch()
    others = [
        ".results.bodyschema-12345678x", ".results.bodyschema-123456.new", ".results.abc",
        ".other.bodyschema-12345678.new", "results.bodyschema-12345678.new", ".results.ab12_xyz",
    ]  # fmt: skip
    for name in others:
        (tmp_path / name).mkdir()
    (tmp_path / ".results.bodyschema-99999999.new").symlink_to(tmp_path / others[0])
    living = aside(path, ".new")
    living.mkdir()
    with held(living):
        tidy(path)
    kept = sorted([*others, ".results.bodyschema-99999999.new", living.name, "results"])
    assert contents(tmp_path) == kept
    result(path, "new")
    assert contents(tmp_path) == [name for name in kept if name != living.name]


def test_a_file_clears_away_its_own(tmp_path: Path) -> None:
    path = tmp_path / "plan.csv"
    left, other = aside(path, ".csv"), aside(tmp_path / "other.csv", ".csv")
    left.touch()
    other.touch()
    with new_file(path) as temporary:
        temporary.write_text("1")
    assert contents(tmp_path) == sorted([other.name, "plan.csv"])


def test_what_was_left_inside_a_result_does_not_bar_it(tmp_path: Path) -> None:
    path = result(tmp_path / "results")
    for name in ("old", MANIFEST, "new.json"):
        aside(path / name, Path(name).suffix).touch()
    living = aside(path / "old", ".txt")
    living.touch()
    with held(living), pytest.raises(InputError, match=f"holds '{living.name}', which"):
        check_new_folder(path, overwrite=True)
    result(path, "new")
    assert contents(path) == [MANIFEST, "new"]
    # Of what is no result nothing is cleared away.
    (path / MANIFEST).unlink()
    living.touch()
    with pytest.raises(InputError, match="is no result"):
        check_new_folder(path, overwrite=True)
    assert living.exists()


def test_between_two_renames_the_old_one_is_the_writers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, rename, asked = result(tmp_path / "results"), Path.rename, []
    monkeypatch.setattr("bodyschema.atomic.folder.swapped", lambda *_: False)

    def watched(self: Path, target: Path) -> Path:
        if target == path:
            asked.append(found_again(path))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", watched)
    result(path, "new")
    assert asked == [False]
    assert contents(path) == [MANIFEST, "new"]


def test_a_writer_at_work_is_not_cleared_away(tmp_path: Path) -> None:
    with new_folder(tmp_path / "results") as first:
        (first / "first").touch()
        with new_file(tmp_path / "results.csv") as table:
            tidy(tmp_path / "results")
            tidy(tmp_path / "results.csv")
            assert first.is_dir()
            assert table.is_file()
    assert contents(tmp_path / "results") == [MANIFEST, "first"]


def test_a_leftover_that_somebody_put_something_into_stays(tmp_path: Path) -> None:
    path = result(tmp_path / "results")
    left = result(tmp_path / "gone").rename(aside(path, ".new"))
    (left / "notes.txt").write_text("mine")
    result(path, "new")
    assert (left / "notes.txt").read_text() == "mine"
    assert (left / "old").read_text() == "old"


def test_half_removed_it_is_not_put_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = result(tmp_path / "results")
    result(tmp_path / "gone").rename(aside(path, ".old"))

    def killed(_: Path) -> None:
        raise OSError(5, "killed")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", killed)
        tidy(path)
    path.rename(tmp_path / "moved")
    assert not found_again(path)
