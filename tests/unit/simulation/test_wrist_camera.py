"""The simulated arm with a wrist camera, and the folders that it is recorded in."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.errors import InputError
from bodyschema.simulation.wrist_camera import (
    WristCamera,
    arm_body,
    simulate_wrist_camera,
    with_camera,
)
from bodyschema.simulation.wrist_folder import FORMS


def test_the_camera_sees_the_board_and_the_truth_explains_it() -> None:
    recorded = simulate_wrist_camera(WristCamera(12, noise_mm=0.0, noise_deg=0.0, lag_ms=0.0))
    true = with_camera(arm_body())
    assert np.rad2deg(np.abs(recorded.offsets)).max() == pytest.approx(3.0)
    for stream in (recorded.postures, recorded.joints, recorded.poses):
        T = bs.relative_pose(true, stream.q + recorded.offsets, "board", "camera")
        assert stream.T_board_camera == pytest.approx(T, abs=1e-12)
        assert (T[:, 2, 3] > 0.1).all(), "above the board"
        assert (T[:, 2, 2] < -0.5).all(), "and looks down at it"


def test_a_stream_is_stamped_late() -> None:
    late, prompt = (simulate_wrist_camera(WristCamera(5, lag_ms=lag)).poses for lag in (40.0, 0.0))
    assert late.time - prompt.time == pytest.approx(0.04)
    assert np.array_equal(late.T_board_camera, prompt.T_board_camera)


def hashes(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".")
    }


@pytest.mark.parametrize("form", [form for form in FORMS if form != "bag"])
def test_a_seed_gives_the_same_bytes(tmp_path: Path, form: str) -> None:
    """A bag's message library writes an order of its own into it, so bags are left out."""
    for name in ("a", "b"):
        where = ["--out", str(tmp_path / name), "--form", form, "--samples", "4"]
        assert run(["simulate", "--scene", "wrist-camera", *where]) == 0
    assert hashes(tmp_path / "a") == hashes(tmp_path / "b")


@pytest.mark.parametrize(("wrong", "said"), [
    ({"n_samples": 1}, "two postures or more, not in 1"),
    ({"noise_mm": -1.0}, "give 0 or more"),
    ({"zero_error_deg": 50.0}, "0 to 45 degrees, not 50"),
])  # fmt: skip
def test_what_is_no_arm_is_refused(wrong: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        WristCamera(**wrong)  # type: ignore[arg-type]


def test_without_the_icub_the_arm_is_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bodyschema.cli.simulate.find_spec", lambda name: None)
    assert run(["simulate", "--samples", "4", "--out", str(tmp_path / "x")]) == 0
    assert "an arm with a wrist camera" in capsys.readouterr().err
    assert (tmp_path / "x" / "arm.urdf").is_file()


def test_the_icub_is_no_bag(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    bag = ["simulate", "--scene", "icub", "--form", "bag", "--out", str(tmp_path / "x")]
    assert run(bag) == 2
    assert "add --scene wrist-camera" in capsys.readouterr().err
