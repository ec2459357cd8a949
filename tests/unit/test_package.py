"""Importing the package: quick, quiet, and every public name there."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import metadata

import pytest

import bodyschema

HEAVY = {"numpy", "scipy", "numba", "mujoco", "matplotlib", "tyro", "pyarrow", "xacrodoc"}


def run(code: str, **environment: str) -> str:
    """What a fresh interpreter prints, without the thread counts of this one."""
    inherited = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=inherited | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    return done.stdout


def test_importing_loads_nothing_heavy() -> None:
    loaded = set(run("import bodyschema, sys; print(*sys.modules)").split())
    assert "bodyschema" in loaded
    assert not loaded & HEAVY


def test_public_names_load_only_what_they_need() -> None:
    code = "import bodyschema, sys; bodyschema.Body, bodyschema.Recording; print(*sys.modules)"
    loaded = run(code).split()
    assert "numba" in loaded
    assert HEAVY & set(loaded) <= {"numpy", "scipy", "numba"}


def test_the_process_of_others_is_left_alone() -> None:
    code = """
import os, signal, logging
before = dict(os.environ), signal.getsignal(signal.SIGTERM), list(logging.root.handlers)
import bodyschema
bodyschema.Body.random_chain, bodyschema.calibrate, bodyschema.plan_poses
assert dict(os.environ) == before[0]
assert signal.getsignal(signal.SIGTERM) == before[1]
assert list(logging.root.handlers) == before[2]
print("same")
"""
    assert run(code).strip() == "same"


def test_version() -> None:
    assert bodyschema.__version__ == metadata.version("bodyschema")


@pytest.mark.parametrize("name", bodyschema.__all__)
def test_every_public_name_exists(name: str) -> None:
    value = getattr(bodyschema, name)
    assert value.__name__ == name
    assert value.__module__.startswith("bodyschema.")
    assert value.__doc__


def test_the_list_of_names_is_sorted_and_complete() -> None:
    assert list(bodyschema.__all__) == sorted(bodyschema.__all__)
    assert dir(bodyschema) == sorted(bodyschema.__all__)
    assert set(bodyschema.__all__) == set(bodyschema._HOMES)


def test_unknown_names_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="module 'bodyschema' has no attribute 'Bdy'"):
        _ = bodyschema.Bdy  # type: ignore[attr-defined]
