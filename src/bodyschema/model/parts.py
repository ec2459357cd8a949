"""Parts: what a prediction needs besides frames and joints, each a short vector of named numbers.

    lens      f_x f_y c_x c_y and the distortion of a camera, in one of three models    px, 1
    load      ten roots eta of a pseudo-inertia (`inertia`): always a load that can exist
    sensor    what is read = (1 + gain) * what is + offset, one of each for every channel
    clock     lag of a stream behind the joint readings                                s
    target    scale of a board, a tag or a tool that was drawn or measured in wrong units
    drive     inertia, friction, offset and gain of every joint's motor, friction being added up
    edge      how far outward masks or edges lie all round the body                    px
    skin      how much thicker the body is than its mesh, patch by patch               m
    constants anything else that a sense of your own wants to learn

The chart of a part is plain addition: a load's positivity is in its roots already. Planes,
mountings and the direction of gravity are frames of the body, and need no part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.camera import Camera
from bodyschema.model.distortion import FISHEYE, MODELS, PLUMB_BOB, RATIONAL
from bodyschema.model.inertia import Inertia, log_cholesky, phi_of_log_cholesky

Array = NDArray[np.float64]

PINHOLE = ("fx", "fy", "cx", "cy")
PINHOLE_PRIOR = (0.02,) * 4
"""Prior standard deviations in units of f."""

ROOTS = ("alpha", "d1", "d2", "d3", "s12", "s23", "s13", "t1", "t2", "t3")
ROOT_PRIOR = (2.5, 1.2, 1.2, 1.2, 0.1, 0.1, 0.1, 0.5, 0.5, 0.5)
"""Mass within a factor of 150, extent within 3, centre within 0.5 m: next to nothing is known."""

USUAL_ROOTS = (0.5 * np.log(0.5), *[np.log(0.05)] * 3, *[0.0] * 6)
"""Half a kilogram spread over 5 cm: where a load that nobody described begins."""

DRIVE = (
    ("inertia", "kg m^2", 1.0),
    ("viscous", "Nms", 10.0),
    ("coulomb", "Nm", 10.0),
    ("offset", "Nm", 10.0),
    ("gain", "1", 0.02),
)
"""Name, unit and prior of the numbers of a motor, seen from its joint."""

LAG_PRIOR, SCALE_PRIOR, GAIN_PRIOR = 0.1, 0.05, 0.02
"""s, 1 and 1: priors of a lag, of a target's scale and of a sensor's gain."""

EDGE_PRIOR, SKIN_PRIOR = 1.0, 3e-4
"""px and m: masks drawn by people, and meshes of machined links."""


@dataclass(frozen=True)
class Part:
    """One part of the model."""

    kind: str
    """"lens", "load", "sensor", "clock", "target", "drive", "edge", "skin" or "constants"."""
    names: tuple[str, ...]
    """Of the numbers, without the part's own name."""
    units: tuple[str, ...]
    values: Array
    """(k,) in these units."""
    prior_std: Array
    """(k,) how wrong each may be, where the user says nothing else."""

    def __post_init__(self) -> None:
        sizes = {len(self.names), len(self.units), *self.values.shape, *self.prior_std.shape}
        if len(sizes) != 1 or not np.isfinite(self.values).all():
            raise InputError(
                f"a part of kind '{self.kind}' needs as many finite values, units and priors as "
                f"names: {len(self.names)} names, {len(self.units)} units, values {self.values}."
            )

    def moved(self, at: NDArray[np.int64], by: Array) -> Part:
        """The part whose numbers `at` (m,) have moved by (m,)."""
        values = self.values.copy()
        values[at] += by
        return replace(self, values=values)

    def __getitem__(self, name: str) -> float:
        """One number by its name."""
        if name not in self.names:
            raise InputError(f"no '{name}' in a {self.kind}{did_you_mean(name, self.names)}")
        return float(self.values[self.names.index(name)])


def lens(camera: Camera) -> Part:
    """The lens of a camera: focal lengths, centre, and the distortion of its model.

    Five coefficients or fewer are a plumb_bob's, eight a rational lens's.

    Raises:
        InputError: the camera has the thin-prism terms of a longer model.
    """
    given = camera.distortion
    if given[8:].any():
        raise InputError(
            f"camera '{camera.name}' has {len(given)} distortion coefficients; a lens that is to "
            "be learned has k1 k2 p1 p2 k3, or k1 k2 p1 p2 k3 k4 k5 k6, or those of a fisheye."
        )
    name = FISHEYE if camera.fisheye else RATIONAL if len(given) > 5 else PLUMB_BOB
    model = MODELS[name]
    distortion = np.zeros(len(model.names))
    distortion[: len(given)] = given[: len(distortion)]
    prior = [*(float(camera.matrix[0, 0]) * np.array(PINHOLE_PRIOR)), *model.priors]
    units = ("px",) * 4 + ("1",) * len(distortion)
    values = np.concatenate([camera.intrinsics, distortion])
    return Part("lens", (*PINHOLE, *model.names), units, values, np.array(prior))


def load(inertia: Inertia | None = None) -> Part:
    """A load in its own frame; None for one of which nothing is known.

    Raises:
        InputError: no distribution of positive mass has this inertia.
    """
    eta = np.array(USUAL_ROOTS) if inertia is None else log_cholesky(inertia.phi)
    units = ("1",) * 7 + ("m",) * 3
    return Part("load", ROOTS, units, eta, np.array(ROOT_PRIOR))


def load_phi(part: Part) -> tuple[Array, Array]:
    """Inertial parameters of a load, (10,), and their derivatives by its roots, (10, 10)."""
    phi, slope = phi_of_log_cholesky(part.values)
    return phi, slope


def sensor(channels: Sequence[str], unit: Sequence[str], offset_std: ArrayLike) -> Part:
    """Offset and gain of every channel of a sensor, both zero at first.

    Args:
        channels: names, such as "fx" or "ax".
        unit: of each channel.
        offset_std: (k,) or a number: prior of the offsets, in these units.
    """
    names = tuple(f"offset_{c}" for c in channels) + tuple(f"gain_{c}" for c in channels)
    k = len(channels)
    std = np.concatenate([np.broadcast_to(offset_std, k), np.full(k, GAIN_PRIOR)])
    return Part("sensor", names, (*unit, *["1"] * k), np.zeros(2 * k), std.astype(np.float64))


def force_sensor() -> Part:
    """Offsets and gains of a six-axis force and torque sensor."""
    channels = ("fx", "fy", "fz", "tx", "ty", "tz")
    return sensor(channels, ("N",) * 3 + ("Nm",) * 3, [50.0] * 3 + [5.0] * 3)


def accelerometer() -> Part:
    """Offsets and gains of a three-axis accelerometer."""
    return sensor(("ax", "ay", "az"), ("m/s^2",) * 3, 1.0)


def drive(joints: Sequence[str]) -> Part:
    """Motors, all zero at first: what their torques hold besides what moves the links.

    Args:
        joints: name of each motor, that of the joint it turns.
    """
    names = tuple(f"{what}_{joint}" for joint in joints for what, _, _ in DRIVE)
    units = tuple(unit for _ in joints for _, unit, _ in DRIVE)
    std = np.array([std for _ in joints for _, _, std in DRIVE])
    return Part("drive", names, units, np.zeros(len(names)), std)


def clock(lag: float = 0.0) -> Part:
    """How long before its time stamp a stream was taken, s."""
    return Part("clock", ("lag",), ("s",), np.array([lag]), np.array([LAG_PRIOR]))


def joined_clock(part: Part) -> Part:
    """The clock of a stream whose readings were joined at its lag: what is left of it is small.

    "joined" is that lag, which the readings have in them and nobody frees.
    """
    values, std = np.array([0.0, part["lag"]]), np.append(part.prior_std[:1], LAG_PRIOR)
    return Part("clock", ("lag", "joined"), ("s", "s"), values, std)


def target(scale: float = 1.0) -> Part:
    """The scale of a target's own coordinates."""
    return Part("target", ("scale",), ("1",), np.array([scale]), np.array([SCALE_PRIOR]))


def edge() -> Part:
    """How far outward of the body a mask, or an edge in images, lies all round it."""
    return Part("edge", ("outward",), ("px",), np.zeros(1), np.array([EDGE_PRIOR]))


def skin(patches: int) -> Part:
    """How much thicker the body is than its mesh at each of so many patches of it."""
    names = tuple(f"patch_{k + 1}" for k in range(patches))
    return Part("skin", names, ("m",) * patches, np.zeros(patches), np.full(patches, SKIN_PRIOR))


def constants(
    values: Mapping[str, float], units: Mapping[str, str], prior_std: Mapping[str, float]
) -> Part:
    """Numbers that a sense of your own wants to learn, with a unit and a prior each."""
    names = tuple(values)
    return Part(
        "constants",
        names,
        tuple(units[name] for name in names),
        np.array([values[name] for name in names], dtype=np.float64),
        np.array([prior_std[name] for name in names], dtype=np.float64),
    )
