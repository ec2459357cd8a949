"""A five-joint arm in MuJoCo with a force/torque sensor in its wrist, which holds something.

What it feels comes from MuJoCo's inverse dynamics, not from `senses.wrenches`: the motion is
prescribed, MuJoCo says what the sensor must exert on the object while something else pushes it.
The sensor's own errors are those of `loads`: noise, steps, offset, a turned mount and, one number
for each reading, a gain.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import MissingExtraError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.katana import katana
from bodyschema.simulation.loads import ENCODER, Path, Sensor
from bodyschema.simulation.real_robot import bare_description

Array = NDArray[np.float64]

STEP = 1e-3
"""s, between the postures whose differences are the joints' speed and acceleration."""


@dataclass(frozen=True)
class Felt:
    """The truth at the wrist, along the mount's axes."""

    time: Array
    """(n,) s."""
    q: Array
    """(n, 5) rad."""
    wrench: Array
    """(n, 6) N and Nm, by the sensor on the object."""
    a_g: Array
    """(n, 3) m/s^2, acceleration less gravity."""
    w: Array
    """(n, 3) rad/s."""
    dw: Array
    """(n, 3) rad/s^2."""


class WristSensor:
    """The arm of `katana` with a sensor at its frame "hand" and an object on it."""

    def __init__(self, load: Inertia) -> None:
        """Take the object.

        Args:
            load: of the object, in the mount's frame.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        try:
            import mujoco
        except ImportError:
            raise MissingExtraError("mujoco", "sim", "the simulated wrist sensor") from None
        spec: Any = mujoco.MjSpec.from_string(bare_description(write_urdf(katana()), {}))
        about = load.moments
        held = spec.body("hand").add_body(
            name="object",
            mass=load.mass,
            ipos=load.com,
            explicitinertial=True,
            fullinertia=about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]],
        )
        held.add_site(name="sensor")
        kinds = mujoco.mjtSensor
        for kind in (kinds.mjSENS_FORCE, kinds.mjSENS_TORQUE, kinds.mjSENS_ACCELEROMETER,
                     kinds.mjSENS_GYRO, kinds.mjSENS_FRAMEANGACC):  # fmt: skip
            spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="sensor")
        self._place, self._invert = mujoco.mj_kinematics, mujoco.mj_inverse
        self._com = load.com
        self._model: Any = spec.compile()
        self._data: Any = mujoco.MjData(self._model)
        self._object = self._model.body("object").id

    def feel(self, path: Path, time: Array, push: Array | None = None) -> Felt:
        """Move along a path.

        Args:
            path: of the joints.
            time: (n,) s.
            push: (n, 6) N and Nm on the object about the mount's origin, along its axes, by
                whatever touches it; nothing when None.
        """
        before, q, after = (path.at(time + shift) for shift in (-STEP, 0.0, STEP))
        speed, rise = (after - before) / (2 * STEP), (before - 2 * q + after) / STEP**2
        n, data = len(time), self._data
        R, out = np.empty((n, 3, 3)), np.empty((n, 15))
        data.xfrc_applied[:] = 0.0
        if push is not None:  # MuJoCo wants the torque about the centre of mass.
            turning = push[:, 3:] - np.cross(self._com, push[:, :3])
        for i in range(n):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[i], speed[i], rise[i]
            self._place(self._model, data)
            R[i] = data.site("sensor").xmat.reshape(3, 3)
            if push is not None:
                data.xfrc_applied[self._object] = [*(R[i] @ push[i, :3]), *(R[i] @ turning[i])]
            self._invert(self._model, data)
            out[i] = data.sensordata
        dw = np.einsum("nji,nj->ni", R, out[:, 12:])
        return Felt(time, q, out[:, :6], out[:, 6:9], out[:, 9:12], dw)


def record(
    felt: Felt,
    sensor: Sensor,
    rng: np.random.Generator,
    gain: ArrayLike = 0.0,
    encoder: float = ENCODER,
) -> WristSamples:
    """What the robot gets to know: the sensor's readings, and poses from noisy encoders.

    Args:
        felt: the truth.
        sensor: what is wrong with the sensor.
        rng: of its noise and that of the encoders.
        gain: (6,) relative error of each reading.
        encoder: rad, noise of each joint.
    """
    R = sensor.R_mount_sensor
    y = np.hstack([felt.wrench[:, :3] @ R, felt.wrench[:, 3:] @ R])
    y = (1 + np.asarray(gain)) * y + sensor.bias + sensor.noise * rng.normal(size=y.shape)
    y = np.round(y / sensor.noise) * sensor.noise
    q = felt.q + encoder * rng.normal(size=felt.q.shape)
    T = relative_pose(katana(), q, "base", "hand")
    return WristSamples(felt.time, y, rotation=T[:, :3, :3], position=T[:, :3, 3])
