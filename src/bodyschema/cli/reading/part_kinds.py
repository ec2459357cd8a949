"""Parts of the model from their sections in a run file.

`known` says how much the numbers of a part are worth: "exactly" fixes them, "roughly" frees them
within the priors of `model.parts`, "no" within ten times as much. A load that is known roughly has
its mass within a fifth and its centre within 2 cm; of one that is not known next to nothing is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.entry_types import one_of
from bodyschema.cli.reading.part_entry import PartEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.distortion import FISHEYE, MODELS
from bodyschema.model.inertia import Inertia, symmetric
from bodyschema.model.parts import Part
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Maker = Callable[[PartEntry, str, Body], Part]
"""Makes a part of its entry, its place in the run file for messages, and the body."""

COMMON = ("kind", "known", "free", "std")
"""Keys of every kind."""

UNKNOWN = 10.0
"""Priors of a part that is not known, in units of those of one that is known roughly."""

ROUGH_LOAD = (0.1, *[0.3] * 3, *[0.05] * 3, *[0.02] * 3)
"""Priors of the roots of a load that is known roughly: mass within 20 %, centre within 2 cm."""

USUAL_RADIUS = 0.05
"""m of a ball whose moments a load has where nobody gives them."""

USUAL_FOV = 60.0
"""deg, of a lens that nobody knows; the size of its priors, and no more, comes from it."""

DISTANCE_OFFSET = 0.05
"""m: prior of the offset of a sensor that reads a distance."""


def made(entry: PartEntry, name: str, body: Body) -> Part:
    """The part, with the priors that its knowledge gives it.

    Raises:
        InputError: its numbers do not make one.
    """
    where = f"[parts.{name}]"
    part = KINDS[entry.kind].make(entry, where, body)
    std = part.prior_std.copy()
    if entry.kind == "load":
        std = np.array(parts.ROOT_PRIOR if entry.known == "no" else ROUGH_LOAD)
    elif entry.known == "no":
        std *= UNKNOWN
    for start, size in entry.std.items():
        std[_numbers(part, start, where)] = size
    return replace(part, prior_std=std)


def freed(entry: PartEntry, name: str, part: Part) -> tuple[str, ...] | None:
    """Names of the numbers of a part that are free; None for all.

    "offset" is that of every channel. The distortion of a lens is free where it is given, or asked
    for, and of a lens of which nothing is known.
    """
    if entry.free:
        chosen = {i for start in entry.free for i in _numbers(part, start, f"[parts.{name}]")}
        return tuple(part.names[i] for i in sorted(chosen))
    stated = entry.kind == "lens" and not unstated(entry)
    return part.names[:4] if stated and not entry.distortion else None


def camera(entry: PartEntry, frame: str, where: str) -> Camera:
    """The camera of a lens.

    Raises:
        InputError: its size or focal length is missing.
    """
    if len(entry.size) != 2:
        raise InputError(f"{where} needs size = [width, height] of the pictures, px.")
    if entry.fx is None and entry.fov_deg is None:
        raise InputError(
            f"{where} needs fx, the focal length in px, or fov_deg; where pictures of a board are "
            'to tell it, known = "no".'
        )
    width, height = entry.size
    fov = float(np.deg2rad(60.0 if entry.fov_deg is None else entry.fov_deg))
    f, _, middle_x, middle_y = Camera.from_fov(frame, frame, width, height, fov).intrinsics
    fx = f if entry.fx is None else entry.fx
    fy = fx if entry.fy is None else entry.fy
    cx = middle_x if entry.cx is None else entry.cx
    cy = middle_y if entry.cy is None else entry.cy
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    given = _distortion(entry, where)
    return Camera(frame, frame, width, height, K, given, fisheye=entry.model == FISHEYE)


def _distortion(entry: PartEntry, where: str) -> Array:
    """Coefficients of a lens, as many as its model has where one is named."""
    given = np.array(entry.distortion, dtype=np.float64)
    if not entry.model:
        return given
    one_of("model", entry.model, MODELS, where)
    names = MODELS[entry.model].names
    if len(given) > len(names):
        raise InputError(
            f"distortion in {where} has {len(given)} numbers, and a lens of model "
            f"'{entry.model}' has {len(names)}: {' '.join(names)}."
        )
    return np.pad(given, (0, len(names) - len(given)))


def unstated(entry: PartEntry) -> bool:
    """Whether a lens has no focal length, so that pictures of a board have to tell it."""
    return entry.kind == "lens" and entry.fx is None and entry.fov_deg is None


def _numbers(part: Part, start: str, where: str) -> list[int]:
    """Which numbers of a part are called so, or begin so."""
    found = [i for i, n in enumerate(part.names) if n == start or n.startswith(f"{start}_")]
    if not found:
        starts = {n.rsplit("_", 1)[0]: None for n in part.names}
        raise InputError(f"no '{start}' in {where}{did_you_mean(start, [*starts, *part.names])}")
    return found


def _lens(entry: PartEntry, where: str, body: Body) -> Part:
    whole = bool(entry.size)
    if unstated(entry) and entry.known == "no":
        entry = replace(entry, fov_deg=USUAL_FOV)
    if not whole and (entry.fx is None or entry.cx is None or entry.cy is None):
        raise InputError(
            f"{where} needs fx, cx and cy in px, or the size = [width, height] of the pictures "
            "with fx or fov_deg."
        )
    # Nobody asks for the size where the centre is given.
    return parts.lens(camera(entry if whole else replace(entry, size=(1, 1)), "lens", where))


def _load(entry: PartEntry, where: str, body: Body) -> Part:
    mass = entry.mass_kg
    if mass is None:
        if entry.known != "no":
            raise InputError(f'{where} needs mass_kg, com_m and moments_kgm2, or known = "no".')
        return parts.load()
    if len(entry.com_m) != 3 or len(entry.moments_kgm2) not in (0, 3, 6):
        raise InputError(f"{where} needs three numbers com_m and three or six moments_kgm2.")
    moments = np.array(entry.moments_kgm2 or [0.4 * mass * USUAL_RADIUS**2] * 3)
    about = np.diag(moments) if len(moments) == 3 else symmetric(moments)
    return parts.load(Inertia(mass, np.array(entry.com_m), about))


def _sensor(entry: PartEntry, where: str, body: Body) -> Part:
    sensors: dict[str, Callable[[], Part]] = {
        "force": parts.force_sensor,
        "acceleration": parts.accelerometer,
        "distance": _distance_sensor,
    }
    if entry.channels not in sensors:
        hint = did_you_mean(entry.channels, sensors)
        raise InputError(f"channels = '{entry.channels}' in {where}{hint}")
    part = sensors[entry.channels]()
    k = len(part.values) // 2
    values = part.values.copy()
    for first, given in ((0, entry.offset), (k, entry.gain)):
        if len(given) not in (0, k):
            raise InputError(
                f"{where} has {k} channels; {len(given)} offsets or gains were given, give one of "
                "each."
            )
        values[first : first + len(given)] = given
    return replace(part, values=values)


def _distance_sensor() -> Part:
    return parts.sensor(("d",), ("m",), DISTANCE_OFFSET)


def _clock(entry: PartEntry, where: str, body: Body) -> Part:
    return parts.clock(entry.lag_ms / 1e3)


def _target(entry: PartEntry, where: str, body: Body) -> Part:
    return parts.target(entry.scale)


def _drive(entry: PartEntry, where: str, body: Body) -> Part:
    return parts.drive(body.joints)


def _edge(entry: PartEntry, where: str, body: Body) -> Part:
    return parts.edge()


def _constants(entry: PartEntry, where: str, body: Body) -> Part:
    if not entry.values:
        raise InputError(f"{where} needs values, such as {{ zero = 0.0 }}.")
    std = dict.fromkeys(entry.values, 1.0) if entry.known == "exactly" else entry.std
    for key, given in (("units", entry.units), ("std", std)):
        missing = [name for name in entry.values if name not in given]
        if missing:
            raise InputError(f"{where} lacks {key} of '{missing[0]}': {key} = {{ ... }}.")
    return parts.constants(entry.values, entry.units, std)


class Kind(NamedTuple):
    """One kind of part."""

    keys: tuple[str, ...]
    """That it has besides `COMMON`."""
    make: Maker


KINDS: dict[str, Kind] = {
    "lens": Kind(("fx", "fy", "cx", "cy", "fov_deg", "distortion", "model", "size", "file"), _lens),
    "load": Kind(("mass_kg", "com_m", "moments_kgm2"), _load),
    "sensor": Kind(("channels", "offset", "gain"), _sensor),
    "clock": Kind(("lag_ms",), _clock),
    "target": Kind(("scale",), _target),
    "drive": Kind((), _drive),
    "edge": Kind((), _edge),
    "constants": Kind(("values", "units"), _constants),
}
