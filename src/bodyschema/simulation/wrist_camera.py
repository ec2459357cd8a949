"""An arm with wrong joint zeros looks at a board with its wrist camera: recording and truth.

Six joints in the proportions of a small industrial arm. The camera hangs on the flange and the
board lies beside the base; the robot's description has neither. From each posture the camera looks
at the board from another side, 0.25 to 0.45 m away, rolled and off the middle. It reports its pose
in the board; encoders report the true angle minus the offset. Between postures the arm moves
smoothly, and what the camera reports is stamped late.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from bodyschema import lie
from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics
from bodyschema.errors import InputError
from bodyschema.model.dh import DHRow, body_from_dh
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

FLANGE, BASE, BOARD, CAMERA = "flange", "base", "board", "camera"

PI = float(np.pi)

ROWS = (
    ("shoulder_pan", 0.0, PI / 2, 0.16),
    ("shoulder_lift", -0.42, 0.0, 0.0),
    ("elbow", -0.39, 0.0, 0.0),
    ("wrist_1", 0.0, PI / 2, 0.13),
    ("wrist_2", 0.0, -PI / 2, 0.1),
    ("wrist_3", 0.0, 0.0, 0.1),
)
"""Joint, a (m), alpha (rad) and d (m): standard Denavit-Hartenberg, theta 0."""

HOME = (0.3, -1.2, 1.4, -1.8, -1.57, 0.4)
"""rad: a posture that looks down beside the base; searches begin here."""

T_BASE_BOARD = lie.transform(lie.exp_so3([0.02, -0.03, 0.6]), [-0.48, -0.14, 0.03])
T_FLANGE_CAMERA = lie.transform(lie.exp_so3([0.03, -0.02, 1.57]), [0.012, -0.065, 0.041])

STEP = 1.0
"""s from one posture to the next."""

WRONG = (0.0, 0.7, -1.0, 0.5, -0.8, 0.0)
"""How wrong each zero is, relative to the worst. The first zero is a turn of the board and the last
one of the camera, which no picture tells apart: neither is made wrong."""


@dataclass(frozen=True)
class WristCamera:
    """What is wrong with the arm, how long it is watched, and how noisy its camera is."""

    n_samples: int = 60
    """Postures."""
    seed: int = 0
    """The same seed gives the same numbers."""
    zero_error_deg: float = 3.0
    """Joint zeros are wrong by up to this; the same seed or another, it is the same robot."""
    noise_mm: float = 0.5
    """Standard deviation of a coordinate of the camera's place in the board."""
    noise_deg: float = 0.05
    """Standard deviation of its turn about an axis."""
    lag_ms: float = 40.0
    """How much later than taken a pose of a stream is stamped."""

    def __post_init__(self) -> None:
        if self.n_samples < 2:
            raise InputError(f"an arm is seen in two postures or more, not in {self.n_samples}.")
        if min(self.noise_mm, self.noise_deg) < 0:
            raise InputError("noise is a standard deviation; give 0 or more.")
        if not 0 <= self.zero_error_deg <= 45:
            raise InputError(f"zeros can be wrong by 0 to 45 degrees, not {self.zero_error_deg:g}.")


@dataclass(frozen=True)
class Stream:
    """Rows of one clock."""

    time: Array
    """(n,) s."""
    q: Array
    """(n, 6) encoder readings, rad."""
    T_board_camera: Array
    """(n, 4, 4) what the camera reports; a stream's were taken earlier than its stamps say."""


@dataclass(frozen=True)
class WristRecording:
    """A simulated arm, what is believed of it, and what was wrong."""

    settings: WristCamera
    believed: Body
    """The robot's description: right but for the zeros, without camera and board."""
    offsets: Array
    """(6,) true angle minus reading, rad."""
    postures: Stream
    """The arm at rest, a row a posture."""
    joints: Stream
    """The same postures in one motion, 50 rows a second."""
    poses: Stream
    """Ten rows a second of that motion, stamped late."""


def simulate_wrist_camera(settings: WristCamera) -> WristRecording:
    """Record the arm of the settings; the result depends on nothing else.

    Raises:
        InputError: fewer than two postures, a negative noise.
    """
    arm = arm_body()
    rng = np.random.default_rng([settings.seed, 3])
    offsets: Array = np.deg2rad(settings.zero_error_deg) * np.array(WRONG)
    q = draw_postures(arm, settings.n_samples, rng)
    end = STEP * (len(q) - 1)
    path = CubicSpline(np.linspace(0.0, end, len(q)), q)
    dense = np.arange(0.0, end, 0.02, dtype=np.float64)
    seen_at = np.arange(0.5, end, 0.1, dtype=np.float64)
    late = seen_at + settings.lag_ms / 1e3
    return WristRecording(
        settings,
        arm,
        offsets,
        _stream(arm, STEP * np.arange(len(q), dtype=np.float64), q, offsets, settings, rng),
        _stream(arm, dense, path(dense), offsets, settings, rng),
        replace(_stream(arm, seen_at, path(seen_at), offsets, settings, rng), time=late),
    )


def describe_wrist_camera(recorded: WristRecording) -> str:
    """What is wrong with the arm, in words, for the command line."""
    wrong = zip(recorded.believed.joints, np.rad2deg(recorded.offsets), strict=True)
    named = ", ".join(f"{name} {deg:+.2f}" for name, deg in wrong if deg)
    settings = recorded.settings
    return (
        f"joint zeros (deg): {named or 'right'}\n"
        "camera on the flange, board beside the base: nobody knows where\n"
        f"recording: {settings.n_samples} postures, {settings.noise_mm:g} mm and "
        f"{settings.noise_deg:g} deg noise, seed {settings.seed}"
    )


def arm_body() -> Body:
    """The arm as its maker describes it."""
    rows = [DHRow(*row, limits=(-3.1, 3.1)) for row in ROWS]
    return body_from_dh(rows, name="arm")


def with_camera(body: Body) -> Body:
    """The arm with camera and board where they truly are."""
    return body.attach(CAMERA, FLANGE, T_FLANGE_CAMERA).attach(BOARD, BASE, T_BASE_BOARD)


def draw_postures(arm: Body, n: int, rng: np.random.Generator) -> Array:
    """True joint angles (n, 6), rad, of postures from which the camera sees the board."""
    seeing, q = with_camera(arm), np.array(HOME)
    solver = InverseKinematics(tolerance=1e-4, starts=0)
    found: list[Array] = []
    while len(found) < n:
        T = _view(rng)
        reached = solver.solve(seeing, Aim(BOARD, CAMERA, T[:3, 3], T[:3, :3]), q)
        if reached.converged:
            found.append(reached.q)
    return np.array(found)


def _view(rng: np.random.Generator) -> Array:
    """T_board_camera of a place over the board; z looks at a point near its middle."""
    tilt, round_, roll = rng.uniform(0.1, 0.7), rng.uniform(0.0, 2 * PI), rng.uniform(-1.2, 1.2)
    direction = [np.sin(tilt) * np.cos(round_), np.sin(tilt) * np.sin(round_), np.cos(tilt)]
    place = rng.uniform(0.25, 0.45) * np.array(direction)
    z = np.append(rng.uniform(-0.05, 0.05, 2), 0.0) - place
    z /= np.linalg.norm(z)
    x = np.cross([-np.sin(roll), np.cos(roll), 0.0], z)
    x /= np.linalg.norm(x)
    return lie.transform(np.stack([x, np.cross(z, x), z], axis=1), place)


def _stream(
    arm: Body,
    time: Array,
    q: Array,
    offsets: Array,
    settings: WristCamera,
    rng: np.random.Generator,
) -> Stream:
    """What encoders and camera report at true angles q."""
    T = relative_pose(with_camera(arm), q, BOARD, CAMERA)
    T[:, :3, 3] += settings.noise_mm / 1e3 * rng.normal(size=(len(q), 3))
    turn = np.deg2rad(settings.noise_deg) * rng.normal(size=(len(q), 3))
    T[:, :3, :3] = T[:, :3, :3] @ lie.exp_so3(turn)
    return Stream(time, q - offsets, T)
