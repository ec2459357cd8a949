"""An iCub with a wrong arm and a wrong eye watches its own hand: the recording and the truth.

The robot stands in random postures in which both eyes see four points of the right hand. Each
point is found in both images with pixel noise and triangulated with the nominal baseline, as the
robot would; a few matches are grossly wrong. Encoders report the true angle minus the offset.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.simulation import eyes, icub
from bodyschema.simulation.postures import draw_postures, landmarks
from bodyschema.simulation.real_robot import RealRobot

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

PAPER_OFFSETS_DEG = dict(zip(icub.RIGHT_ARM, (5.0, 4.0, 3.0, -2.0, 3.0, -7.0, 3.0), strict=True))
"""Vicente, Jamone, Bernardino 2016, section 5: the offsets of the right arm, shoulder to wrist."""

OUTLIER_SIZE = 0.1
"""m; a wrong match moves each coordinate by up to this."""


@dataclass(frozen=True)
class Simulation:
    """What is wrong with the robot, how long it is watched, and how noisy its senses are."""

    n_samples: int = 60
    """Postures in the recording."""
    seed: int = 0
    """The same seed gives the same numbers."""
    offsets_deg: Mapping[str, float] = field(default_factory=lambda: dict(PAPER_OFFSETS_DEG))
    """True joint angle minus encoder reading, by joint."""
    eye_error_mm: Vector = (8.0, -5.0, 6.0)
    """True minus designed position of the eye pair, along the axes of the head link."""
    eye_error_deg: Vector = (2.0, -3.0, 1.5)
    """Rotation vector of the eye pair's mounting error, in the left eye: R = R_designed exp(w)."""
    pixel_noise: float = 0.3
    """Standard deviation of an image coordinate, pixels."""
    encoder_noise_deg: float = 0.02
    """Standard deviation of a reading."""
    outliers: float = 0.05
    """Share of the points that are wrong matches."""

    def __post_init__(self) -> None:
        if self.n_samples < 1:
            raise InputError(f"a recording needs at least one sample, not {self.n_samples}.")
        if min(self.pixel_noise, self.encoder_noise_deg) < 0:
            raise InputError("noise is a standard deviation; give 0 or more.")
        if not 0 <= self.outliers < 1:
            raise InputError(f"outliers is a share; give 0 to 1, not {self.outliers}.")


@dataclass(frozen=True)
class HandPoseTruth:
    """Where the hand truly is in the left eye, for postures that no learner has seen."""

    joints: tuple[str, ...]
    """Names of the columns of q."""
    q: Array
    """(n, n_joints) encoder readings without noise, rad."""
    T_left_eye_hand: Array
    """(n, 4, 4) true pose of the hand link in the left eye."""


@dataclass(frozen=True)
class SimulatedRecording:
    """A recording, the settings behind it and the truth to score against."""

    settings: Simulation
    joints: tuple[str, ...]
    """Names of the columns of q."""
    time: Array
    """(n,) s."""
    q: Array
    """(n, n_joints) encoder readings, rad."""
    points: Array
    """(n, n_landmarks, 3) triangulated landmarks in the left eye, m."""
    true_points: Array
    """(n, n_landmarks, 3) where they truly are, m."""
    test: HandPoseTruth


def simulate(settings: Simulation) -> SimulatedRecording:
    """Record the robot of the settings; the result depends on nothing else.

    Raises:
        InputError: an offset names no joint, or the hand never comes into view.
        MissingExtraError: MuJoCo or icub-models is not installed.
    """
    body = icub.bare_icub()
    robot = real_icub(settings, body.joints)
    rng = np.random.default_rng([settings.seed, 0])
    readings = draw_postures(robot, body, settings.n_samples, rng)
    p_left, p_right = landmarks(robot, readings)
    sigma = np.deg2rad(settings.encoder_noise_deg)
    return SimulatedRecording(
        settings=settings,
        joints=body.joints,
        time=np.arange(settings.n_samples, dtype=np.float64),
        q=readings + sigma * rng.normal(size=readings.shape),
        points=_observe(p_left, p_right, settings, rng),
        true_points=p_left,
        test=hand_pose_truth(settings),
    )


def describe_simulation(settings: Simulation) -> str:
    """What is wrong with the robot, in words, for the command line."""
    wrong = [f"{name} {deg:+g}" for name, deg in settings.offsets_deg.items() if deg]
    shift = " ".join(f"{value:+g}" for value in settings.eye_error_mm)
    turn = " ".join(f"{value:+g}" for value in settings.eye_error_deg)
    return (
        f"joint offsets (deg): {', '.join(wrong) or 'none'}\n"
        f"eye mounting: [{shift}] mm, [{turn}] deg\n"
        f"recording: {settings.n_samples} postures, {settings.pixel_noise:g} px noise, "
        f"{settings.encoder_noise_deg:g} deg encoder noise, "
        f"{100 * settings.outliers:g} % wrong matches, seed {settings.seed}"
    )


def hand_pose_truth(settings: Simulation, n: int = 200) -> HandPoseTruth:
    """True hand poses in n fresh postures, drawn apart from those of the recording."""
    body = icub.bare_icub()
    robot = real_icub(settings, body.joints)
    q = draw_postures(robot, body, n, np.random.default_rng([settings.seed, 1]))
    pose = robot.poses(q, icub.LEFT_EYE, [icub.HAND])[:, 0]
    return HandPoseTruth(body.joints, q, pose)


def true_frames(settings: Simulation) -> dict[str, tuple[str, Array]]:
    """Where eyes and marks truly are: the mounting error moves both eyes as one rigid pair."""
    frames = icub.nominal_frames()
    T_head_left, T_head_right = frames[icub.LEFT_EYE][1], frames[icub.RIGHT_EYE][1]
    T_left_right = eyes.eye_transform(T_head_left, T_head_right)
    turn = lie.exp_so3(np.deg2rad(settings.eye_error_deg))
    shift = np.asarray(settings.eye_error_mm) / 1000
    T = lie.transform(T_head_left[:3, :3] @ turn, T_head_left[:3, 3] + shift)
    return frames | {
        icub.LEFT_EYE: (icub.HEAD, T),
        icub.RIGHT_EYE: (icub.HEAD, T @ T_left_right),
    }


def real_icub(settings: Simulation, joints: tuple[str, ...]) -> RealRobot:
    """The real robot of the settings."""
    offsets = {name: float(np.deg2rad(deg)) for name, deg in settings.offsets_deg.items()}
    return RealRobot(icub.urdf_path().read_bytes(), true_frames(settings), joints, offsets)


def true_icub(settings: Simulation) -> Body:
    """The body that a perfect calibration would find."""
    body = icub.nominal_icub()
    offset = np.zeros(len(body.joints))
    for name, deg in settings.offsets_deg.items():
        offset[body.joint_index(name)] = np.deg2rad(deg)
    for frame, (_, placement) in true_frames(settings).items():
        body = body.with_placement(frame, placement)
    return replace(body, offset=offset)


def _observe(
    p_left: Array, p_right: Array, settings: Simulation, rng: np.random.Generator
) -> Array:
    """What stereo vision makes of the points, (n, n_landmarks, 3) m in the left eye."""
    shape = (*p_left.shape[:-1], 2)
    left = eyes.project(p_left) + settings.pixel_noise * rng.normal(size=shape)
    right = eyes.project(p_right) + settings.pixel_noise * rng.normal(size=shape)
    designed = [icub.eye_mounting(eye) for eye in (icub.LEFT_EYE, icub.RIGHT_EYE)]
    seen = eyes.triangulate(left, right, eyes.eye_transform(*designed))
    wrong = rng.uniform(size=seen.shape[:-1]) < settings.outliers
    jump = rng.uniform(-OUTLIER_SIZE, OUTLIER_SIZE, size=seen.shape)
    return np.asarray(seen + wrong[..., None] * jump)
