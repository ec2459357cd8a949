"""Shared fixtures: where the recorded data of the tests lies."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

import bodyschema  # sets one BLAS thread a process, so it must come before numpy
import bodyschema.simulation  # noqa: F401  (lets mujoco draw without a screen, so before mujoco)

SHARED = Path(os.environ.get("BODYSCHEMA_SHARED", Path(__file__).resolve().parents[2] / "shared"))


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the tests out of the user's cache folder."""
    os.environ["BODYSCHEMA_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Return the folder of a recorded data set; skip where there is none, fail in CI."""
    return lambda name: _shared("data", name, "recorded data set")


@pytest.fixture(scope="session")
def shared_cases() -> Callable[[str], Path]:
    """Return the folder of a case that people met; skip where there is none, fail in CI."""
    return lambda name: _shared("cases", name, "case")


def _shared(kind: str, name: str, what: str) -> Path:
    path = SHARED / kind / name
    if not path.is_dir():
        message = f"the {what} '{name}' is not on this machine (looked in {path})"
        if os.environ.get("CI") == "true":
            pytest.fail(message)
        pytest.skip(message)
    return path


@pytest.fixture(scope="session")
def offscreen() -> None:
    """Skip where MuJoCo cannot draw pictures: it needs OpenGL without a window (libegl1)."""
    import mujoco

    try:
        mujoco.Renderer(mujoco.MjModel.from_xml_string("<mujoco/>"), 8, 8).close()
    except Exception as error:  # each platform has an error of its own
        pytest.skip(f"MuJoCo cannot draw here: {error}")
