"""The simulated iCub: its truth, its noise, its folder, and MuJoCo against our kinematics."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import eyes, icub, world
from bodyschema.simulation.folder import FILES, write_simulation
from bodyschema.simulation.picture import draw_before_after
from bodyschema.simulation.scoring import describe_errors, hand_error, load_truth
from bodyschema.simulation.world import SimulatedRecording, Simulation, simulate
from bodyschema.sources.tables import open_recording

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")

QUIET = Simulation(n_samples=40, seed=3, pixel_noise=0.0, encoder_noise_deg=0.0, outliers=0.0)


@pytest.fixture(scope="module")
def simulated() -> SimulatedRecording:
    return simulate(Simulation())


@pytest.fixture(scope="module")
def folder(simulated: SimulatedRecording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_simulation(simulated, tmp_path_factory.mktemp("runs") / "icub")


def test_the_same_seed_gives_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    again = write_simulation(simulate(Simulation()), tmp_path / "again")
    for name in FILES:
        assert (again / name).read_bytes() == (folder / name).read_bytes()


def test_another_seed_gives_another_recording(simulated: SimulatedRecording) -> None:
    other = simulate(Simulation(seed=1))
    assert not np.array_equal(other.q, simulated.q)
    assert not np.array_equal(other.test.q, simulated.test.q)


def test_test_postures_are_not_those_of_the_recording(simulated: SimulatedRecording) -> None:
    moved = [simulated.joints.index(name) for name in icub.MOVED]
    distance = np.abs(simulated.q[:, None] - simulated.test.q)[..., moved].max(axis=-1)
    assert distance.min() > np.deg2rad(1)


def test_our_kinematics_at_the_true_parameters_agree_with_mujoco() -> None:
    body, test = world.true_icub(QUIET), world.hand_pose_truth(QUIET)
    predicted = relative_pose(body, test.q, icub.LEFT_EYE, icub.HAND)
    np.testing.assert_allclose(predicted, test.T_left_eye_hand, rtol=0, atol=1e-9)


def test_a_quiet_recording_is_the_truth() -> None:
    quiet, body = simulate(QUIET), world.true_icub(QUIET)
    np.testing.assert_allclose(quiet.points, quiet.true_points, rtol=0, atol=1e-9)
    for mark, seen in zip(icub.LANDMARKS, np.moveaxis(quiet.points, 1, 0), strict=True):
        predicted = relative_pose(body, quiet.q, icub.LEFT_EYE, mark)[:, :3, 3]
        np.testing.assert_allclose(predicted, seen, rtol=0, atol=1e-9)


def test_the_truth_is_the_nominal_body_plus_the_stated_errors() -> None:
    settings = Simulation(offsets_deg={"r_elbow": 4.0}, eye_error_mm=(1.0, 2.0, 3.0))
    nominal, true = icub.nominal_icub(), world.true_icub(settings)
    assert np.flatnonzero(true.offset).tolist() == [true.joint_index("r_elbow")]
    k = true.frame_index(icub.LEFT_EYE)
    shift = true.placement[k, :3, 3] - nominal.placement[k, :3, 3]
    turn = lie.log_so3(nominal.placement[k, :3, :3].T @ true.placement[k, :3, :3])
    np.testing.assert_allclose(shift, [0.001, 0.002, 0.003], atol=1e-15)
    np.testing.assert_allclose(np.rad2deg(turn), settings.eye_error_deg, atol=1e-12)
    q = np.zeros(len(true.joints))
    baseline = relative_pose(true, q, icub.LEFT_EYE, icub.RIGHT_EYE)
    np.testing.assert_allclose(
        baseline, relative_pose(nominal, q, icub.LEFT_EYE, icub.RIGHT_EYE), atol=1e-15
    )
    assert np.linalg.norm(baseline[:3, 3]) == pytest.approx(icub.BASELINE)


def test_both_eyes_see_every_mark(simulated: SimulatedRecording) -> None:
    T_right_left = relative_pose(icub.nominal_icub(), simulated.q[0], icub.RIGHT_EYE, icub.LEFT_EYE)
    right = simulated.true_points @ T_right_left[:3, :3].T + T_right_left[:3, 3]
    for p in (simulated.true_points, right):
        pixel, distance = eyes.project(p), np.linalg.norm(p, axis=-1)
        assert (p[..., 2] > 0).all()
        assert pixel.min() > 0
        assert (pixel < [eyes.WIDTH - 1, eyes.HEIGHT - 1]).all()
        assert 0.15 <= distance.min() <= distance.max() <= 0.6


def test_stereo_noise_has_the_expected_size() -> None:
    """First order: depth z^2 / (f b) sqrt(2) sigma, off the ray z / f sigma / sqrt(2)."""
    settings = Simulation(n_samples=400, encoder_noise_deg=0.0, outliers=0.0)
    simulated = simulate(settings)
    z = simulated.true_points[..., 2]
    error = simulated.points - simulated.true_points
    sigma, f = settings.pixel_noise, eyes.FOCAL_LENGTH
    deep = z**2 / (f * icub.BASELINE) * np.sqrt(2) * sigma
    aside = z / f * sigma / np.sqrt(2)
    assert np.std(error[..., 2] / deep) == pytest.approx(1, abs=0.15)
    off_ray = error[..., 1] - simulated.true_points[..., 1] / z * error[..., 2]
    assert np.std(off_ray / aside) == pytest.approx(1, abs=0.15)


def test_the_stated_share_of_points_is_wrong_by_centimetres() -> None:
    settings = Simulation(n_samples=400, pixel_noise=0.0, outliers=0.1)
    simulated = simulate(settings)
    error = np.abs(simulated.points - simulated.true_points).max(axis=-1)
    wrong = error > 1e-6
    assert wrong.mean() == pytest.approx(0.1, abs=0.03)
    assert error.max() <= world.OUTLIER_SIZE
    assert np.median(error[wrong]) > 0.05


def test_encoder_noise_has_the_stated_size() -> None:
    noisy = simulate(Simulation(n_samples=50, encoder_noise_deg=0.1))
    exact = simulate(Simulation(n_samples=50, encoder_noise_deg=0.0))
    assert np.rad2deg(np.std(noisy.q - exact.q)) == pytest.approx(0.1, rel=0.1)


def test_the_folder_holds_what_a_user_would_have(
    folder: Path, simulated: SimulatedRecording
) -> None:
    assert sorted(path.name for path in folder.iterdir()) == sorted([*FILES, ".bodyschema.json"])
    assert (folder / "robot.urdf").read_bytes() == icub.urdf_path().read_bytes()
    columns = open_recording(folder / "recording.csv").columns
    marks = [f"{mark}_{axis}" for mark in icub.LANDMARKS for axis in "xyz"]
    assert list(columns) == ["time", *simulated.joints, *marks]
    np.testing.assert_array_equal(
        np.stack([columns[name] for name in simulated.joints], axis=-1), simulated.q
    )
    np.testing.assert_array_equal(columns["hand_2_z"], simulated.points[:, 1, 2])


def test_the_run_file_tells_the_nominal_body(folder: Path) -> None:
    run = tomllib.loads((folder / "run.toml").read_text())
    assert (run["robot"], run["recording"]) == ("robot.urdf", "recording.csv")
    assert run["joints"] == {"unit": "rad"}
    eye = run["frames"]["left_eye"]
    assert (eye["parent"], eye["known"]) == ("head", "roughly")
    placement = lie.transform(lie.rotation_from_rpy(eye["rpy"]), eye["xyz"])
    np.testing.assert_allclose(placement, icub.eye_mounting(icub.LEFT_EYE), atol=1e-15)
    assert [sense["seen"] for sense in run["senses"]] == list(icub.LANDMARKS)
    for sense in run["senses"]:
        mark = run["frames"][sense["seen"]]
        assert mark["xyz"] == list(icub.LANDMARKS[sense["seen"]])
        assert (mark["parent"], mark["known"]) == ("r_hand", "exactly")
        assert sense["columns"] == [f"{sense['seen']}_{axis}" for axis in "xyz"]
        assert (sense["kind"], sense["seen_from"], sense["unit"]) == ("points", "left_eye", "m")


def test_the_truth_reads_back_and_scores(folder: Path, simulated: SimulatedRecording) -> None:
    truth = load_truth(folder)
    assert truth.settings == simulated.settings
    np.testing.assert_array_equal(truth.hand.q, simulated.test.q)
    nominal = hand_error(icub.nominal_icub(), truth)
    true = hand_error(world.true_icub(truth.settings), truth)
    assert nominal.position.mean() > 0.03
    assert true.position.max() < 1e-9
    assert true.rotation.max() < 1e-7
    assert "mm mean" in describe_errors(nominal, true)
    assert "scoring only" in json.loads((folder / "truth.json").read_text())["purpose"]


def test_an_older_simulation_is_replaced_only_on_request(
    simulated: SimulatedRecording, tmp_path: Path
) -> None:
    write_simulation(simulated, tmp_path / "run")
    with pytest.raises(InputError, match="not empty"):
        write_simulation(simulated, tmp_path / "run")
    write_simulation(simulated, tmp_path / "run", overwrite=True)


def test_a_folder_with_other_files_is_never_replaced(
    simulated: SimulatedRecording, tmp_path: Path
) -> None:
    run = write_simulation(simulated, tmp_path / "run")
    (run / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"notes\.txt"):
        write_simulation(simulated, run, overwrite=True)
    assert (run / "notes.txt").read_text() == "mine"
    (run / "notes.txt").unlink()
    # What a version wrote that made no list is known by its names and by its purpose.
    (run / ".bodyschema.json").unlink()
    write_simulation(simulated, run, overwrite=True)
    for spoilt in ((run / ".bodyschema.json").unlink, (run / "truth.json").unlink):
        spoilt()
    with pytest.raises(InputError, match="is no result"):
        write_simulation(simulated, run, overwrite=True)


def test_a_wrong_name_is_met_with_the_right_one() -> None:
    with pytest.raises(InputError, match="'r_elbow'"):
        simulate(Simulation(offsets_deg={"r_elbw": 3.0}))


@pytest.mark.parametrize(
    "settings", [{"n_samples": 0}, {"pixel_noise": -1.0}, {"outliers": 1.5}], ids=str
)
def test_settings_without_sense_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(InputError):
        Simulation(**settings)  # type: ignore[arg-type]


def test_a_file_that_is_no_truth_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no truth"):
        load_truth(tmp_path)
    (tmp_path / "truth.json").write_text('{"settings": {}}')
    with pytest.raises(InputError, match="simulate again"):
        load_truth(tmp_path)


def test_the_picture_is_drawn(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    truth = load_truth(folder)
    path = draw_before_after(
        icub.nominal_icub(), world.true_icub(truth.settings), truth, tmp_path / "before_after.png"
    )
    assert path.read_bytes().startswith(b"\x89PNG")
    assert path.stat().st_size > 20_000


def test_what_is_wrong_is_said() -> None:
    text = world.describe_simulation(Simulation())
    assert "r_wrist_pitch -7" in text
    assert "[+8 -5 +6] mm" in text
