"""Compiling with a cache, without one, with a damaged or a full one."""

from __future__ import annotations

import errno
import importlib.util
import logging
from collections.abc import Callable
from pathlib import Path

import pytest
from numba.core.caching import CompileResultCacheImpl, FunctionCache

from bodyschema.model import compiled
from bodyschema.model.compiled import COMPILING, Compiling, Kept, Unkept

SOURCE = """
from bodyschema.model.compiled import kernel, step

@step
def twice(x):
    return 2.0 * x

@kernel
def more(x):
    return twice(x) + 1.0
"""


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> Compiling:
    """Nothing compiled or told yet."""
    monkeypatch.setattr(compiled, "COMPILING", Compiling())
    return compiled.COMPILING


def loops(folder: Path) -> Callable[[float], float]:
    """The loops above as a process finds them that has just imported their file."""
    place = folder / "loops.py"
    if not place.exists():
        place.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("loops", place)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: Callable[[float], float] = module.more
    return found


def test_what_was_compiled_is_kept_and_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, fresh: Compiling
) -> None:
    with caplog.at_level(logging.INFO, "bodyschema"):
        assert loops(tmp_path)(3.0) == 7.0
    assert [record.levelname for record in caplog.records] == ["INFO"]
    assert "once" in caplog.text
    assert fresh.seconds > 0
    assert fresh.folder is not None
    seconds = fresh.seconds
    assert loops(tmp_path)(4.0) == 9.0
    assert fresh.seconds == seconds


def test_where_nothing_can_be_written_it_is_compiled_and_said_once(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    fresh: Compiling,
) -> None:
    monkeypatch.setattr(CompileResultCacheImpl, "_locator_classes", [])
    for _ in range(2):
        more = loops(tmp_path)
        assert isinstance(more._cache, Unkept)  # type: ignore[attr-defined]
        assert more(3.0) == 7.0
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert "NUMBA_CACHE_DIR" in caplog.text
    assert fresh.seconds > 0
    assert fresh.folder is None


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_cache_costs_time_alone(tmp_path: Path, ending: str, fresh: Compiling) -> None:
    assert loops(tmp_path)(3.0) == 7.0
    (damaged,) = (tmp_path / "__pycache__").glob(f"loops.more*.{ending}")
    damaged.write_bytes(damaged.read_bytes()[:40])
    seconds = fresh.seconds
    assert loops(tmp_path)(3.0) == 7.0
    assert fresh.seconds > seconds
    seconds = fresh.seconds
    assert loops(tmp_path)(3.0) == 7.0
    assert fresh.seconds == seconds


def test_a_full_disk_costs_the_cache_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fresh: Compiling
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(FunctionCache, "save_overload", full)
    assert loops(tmp_path)(3.0) == 7.0
    assert fresh.folder is None
    assert fresh.depth == 0


def test_the_loops_of_the_house_are_kept() -> None:
    from bodyschema.model import kernels

    assert isinstance(kernels.relative_poses._cache, Kept)  # type: ignore[attr-defined]
    assert COMPILING.depth == 0
