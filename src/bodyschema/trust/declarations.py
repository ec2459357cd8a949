"""Declarations: ways in which a recording may be other than it is said to be.

Each says what the readings of the joints and what was seen would have been, had the recording been
declared so; what to write in the run file; and in words what is meant. A transform still tells in
which columns it was read: a quaternion that was read in the wrong order has its four numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.free_hand import hand_readings
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Seen = tuple[Array, Array | None]
"""Positions (n, 3) m and rotations (n, 3, 3), None for points."""

LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
"""Units in which lengths are recorded, in m."""

SAME_UNIT = 0.2
"""Relative distance to a unit below which a scale is that unit: zeros of joints that are off spoil
it by so much, and units are further apart."""

ROWS = 5
"""Rows by which joints and what is seen may be apart."""

GEARS = (0.5, 0.667, 0.8, 0.9, 0.95, 1.05, 1.1, 1.25, 1.5, 2.0)
"""Factors of one joint's readings to begin with."""


@dataclass(frozen=True)
class Recorded:
    """How a list of poses or points is declared; "" where nobody said."""

    layout: str = ""
    """A key of `senses.layouts.LAYOUTS`."""
    unit: str = ""
    """Of lengths."""
    angle_unit: str = ""
    """Of rpy and rotvec."""


@dataclass(frozen=True)
class Declaration:
    """One way in which a recording may have been meant."""

    words: str
    """As they follow "with": "inverse = true"."""
    key: str
    """What is declared; of declarations with the same key one at most is meant."""
    entry: str = ""
    """To write in the run file; "" where it has no word for it."""
    sense: str = ""
    """Label of the sense that it is about; "" for all."""
    readings: Callable[[Array], Array] | None = None
    """(n, n_joints) readings as they would be."""
    seen: Callable[[Array, Array | None], Seen] | None = None
    """Positions and rotations as they would be."""
    swapped: bool = False
    """The two frames hang on each other's parents, which is T_seen_seen_from for poses."""
    shift: int = 0
    """What is seen belongs to the joints so many rows before."""
    size: float = 1.0
    """Factor of the lengths seen."""
    scaled: bool = False
    """Lengths seen have a factor that is to be found."""
    joint: int = -1
    """The joint whose readings have a factor; -1 for none."""
    factor: float = 1.0
    """Of that joint."""

    def of(self, sense: Sense) -> Sense:
        """A sense as it would be, if it is about that."""
        if self.sense not in ("", sense.label):
            return sense
        q = sense.q if self.readings is None else self.readings(sense.q)
        if self.shift:
            kept = np.arange(len(sense))[max(self.shift, 0) : len(sense) + min(self.shift, 0)]
            q, sense = q[kept - self.shift], sense.take(kept)
        sense = replace(sense, q=q)
        if self.swapped and isinstance(sense, Poses):
            return replace(sense, observed=lie.inverse(sense.pose))
        if self.swapped:
            return replace(sense, seen_from=sense.seen, seen=sense.seen_from)
        if self.seen is None:
            return _resized_sense(sense, self.size)
        if isinstance(sense, Poses):
            p, Q = self.seen(sense.pose[:, :3, 3], sense.pose[:, :3, :3])
            return replace(
                sense, observed=lie.transform(sense.pose[:, :3, :3] if Q is None else Q, p)
            )
        return replace(sense, observed=self.seen(sense.observed, None)[0])


def _resized_sense(sense: Sense, size: float) -> Sense:
    """Points and poses further away, boards larger."""
    if size == 1.0:
        return sense
    if isinstance(sense, Pixels):
        return replace(sense, target=size * sense.target)
    if isinstance(sense, Poses):
        pose = lie.transform(sense.pose[:, :3, :3], size * sense.pose[:, :3, 3])
        return replace(sense, observed=pose)
    return replace(sense, observed=size * sense.observed)


AS_DECLARED = Declaration("as declared", "")


def seen_otherwise(
    label: str, posed: bool, turns: bool, recorded: Recorded, whose: str
) -> Iterator[Declaration]:
    """Ways in which what one sense saw may have been meant.

    Args:
        label: of the sense.
        posed: whether it has rotations.
        turns: whether these were read from columns.
        recorded: how it is declared.
        whose: in words, such as "of the board seen from the camera".
    """
    yield other_mount(label, posed)
    yield from by_rows(label)
    if turns:
        for words, key, entry, turned in rotations(recorded):
            yield Declaration(f"{words} {whose}", key, entry, label, seen=_turned(turned))


def other_mount(label: str, posed: bool) -> Declaration:
    """Frames on each other's parents, or poses the other way round: the data cannot tell."""
    if not posed:
        words = "the two frames on each other's parents (the eye on the other end)"
        return Declaration(words, "mount", "", label, swapped=True)
    words = "inverse = true (or the eye on the other end, which is the same to the data)"
    return Declaration(words, "mount", "inverse = true", label, swapped=True)


def by_rows(label: str) -> Iterator[Declaration]:
    """Joints and what is seen some rows apart."""
    for k in range(1, ROWS + 1):
        rows = "one row" if k == 1 else f"{k} rows"
        yield Declaration(f"what is seen moved up by {rows}, as it comes {rows} late",
                          "rows", "", label, shift=k)  # fmt: skip
        yield Declaration(f"what is seen moved down by {rows}, as it comes {rows} early",
                          "rows", "", label, shift=-k)  # fmt: skip


Turning = Callable[[Array], Array]


def rotations(recorded: Recorded) -> Iterator[tuple[str, str, str, Turning]]:
    """Words, key, entry and what makes rotations (n, 3, 3) of those that were read."""
    layout = recorded.layout
    yield "the rotations transposed,", "transposed", "", lambda R: np.swapaxes(R, 1, 2)
    if layout in ("", "xyz_xyzw"):
        words = "the quaternions in the order w, x, y, z"
        entry = 'layout = "xyz_wxyz"'
        yield f"{entry}, {words}," if layout else f"{words},", "layout", entry, _rolled(-1)
    if layout in ("", "xyz_wxyz"):
        words = "the quaternions in the order x, y, z, w"
        entry = 'layout = "xyz_xyzw"'
        yield f"{entry}, {words}," if layout else f"{words},", "layout", entry, _rolled(1)
    for name, read, made in (("rpy", lie.rpy_from_rotation, lie.rotation_from_rpy),
                             ("rotvec", lie.log_so3, lie.exp_so3)):  # fmt: skip
        if layout not in ("", f"xyz_{name}"):
            continue
        units = (
            ("deg", "rad") if not layout else ("rad",) if recorded.angle_unit == "deg" else ("deg",)
        )
        for unit in units:
            size = np.pi / 180 if unit == "deg" else 180 / np.pi
            yield (f'angle_unit = "{unit}" for the angles', "angle_unit", f'angle_unit = "{unit}"',
                   _resized(read, made, size))  # fmt: skip
        if layout == "xyz_rpy":
            yield from _orders()
        if layout == "xyz_rotvec":
            yield ('layout = "xyz_rpy" for the angles', "layout", 'layout = "xyz_rpy"',
                   lambda R: lie.rotation_from_rpy(lie.log_so3(R)))  # fmt: skip


def _orders() -> Iterator[tuple[str, str, str, Turning]]:
    """What three columns that were read as roll, pitch, yaw may be instead."""
    for order in permutations("xyz"):
        product = " ".join(f"R{axis}" for axis in order)
        if order != ("z", "y", "x"):
            words = f"angles about x, y, z that turn as {product}"
            yield words, "layout", "", _euler(order, (0, 1, 2))
        if order == ("z", "y", "x"):
            words, entry = "the three columns of angles in the reverse order", "columns"
        else:
            words, entry = f"angles about z, y, x that turn as {product}", ""
        yield words, "layout", entry, _euler(order, (2, 1, 0))
    yield 'layout = "xyz_rotvec" for the angles', "layout", 'layout = "xyz_rotvec"', _rotvec


def _euler(order: Sequence[str], columns: tuple[int, int, int]) -> Turning:
    """Rotations of angles that were read as roll, pitch, yaw.

    Args:
        order: axes of the product.
        columns: in which of the three the angles about x, y and z stand.
    """
    middle = columns["xyz".index(order[1])]

    def made(R: Array) -> Array:
        angles = _nearer(lie.rpy_from_rotation(R), lambda a: np.abs(a[:, middle]))
        T = np.tile(np.eye(3), (len(R), 1, 1))
        for axis in order:
            index = "xyz".index(axis)
            T = T @ lie.exp_so3(angles[:, columns[index], None] * np.eye(3)[index])
        return T

    return made


def _rotvec(R: Array) -> Array:
    return lie.exp_so3(_nearer(lie.rpy_from_rotation(R), lambda a: np.linalg.norm(a, axis=1)))


def _nearer(rpy: Array, size: Callable[[Array], Array]) -> Array:
    """Of the two triples of angles that make one rotation the one of the smaller size, (n, 3)."""
    twin = np.array([np.pi, np.pi, np.pi]) + rpy * np.array([1.0, -1.0, 1.0])
    twin = (twin + np.pi) % (2 * np.pi) - np.pi
    return np.where((size(twin) < size(rpy))[:, None], twin, rpy)


def _rolled(by: int) -> Turning:
    return lambda R: lie.rotation_from_xyzw(np.roll(lie.quaternion_xyzw(R), by, axis=1))


def _resized(read: Turning, made: Turning, size: float) -> Turning:
    return lambda R: made(size * read(R))


def _turned(turned: Turning) -> Callable[[Array, Array | None], Seen]:
    return lambda p, Q: (p, None if Q is None else turned(Q))


def resized(s: float, recorded: Recorded, label: str, whose: str) -> Declaration:
    """Lengths that are s times as long: in another unit, if one is near, or of another scale."""
    unit = _unit(s, recorded)
    if unit:
        size = LENGTHS[unit] / LENGTHS.get(recorded.unit, 1.0)
        entry = f'unit = "{unit}"'
        return Declaration(f"{entry} for the lengths {whose}", "unit", entry, label, size=size)
    words = (
        f"lengths {whose} {s:.3g} times as long (a board or tag of another size, or a description "
        f"of the robot that is {1 / s:.3g} times too large)"
    )
    return Declaration(words, "scale", "", label, size=s)


def _unit(s: float, recorded: Recorded) -> str:
    """The unit of lengths that were read s times too short; "" if there is none."""
    said = recorded.unit or "m"
    size = s * LENGTHS.get(said, 1.0)
    near = (unit for unit, m in LENGTHS.items() if abs(size / m - 1) < SAME_UNIT)
    return next((unit for unit in near if unit != said), "")


def other_axes(P: Array, label: str, posed: bool, whose: str) -> Declaration:
    """Positions whose axes are swapped or mirrored, P a signed permutation (3, 3)."""

    def seen(p: Array, Q: Array | None) -> Seen:
        return p @ P.T, Q

    order = [f"{'-' if row.min() < 0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in P]
    if not posed:
        words = (
            f"positions {whose} mirrored (two columns swapped, or one of the other sign: which, "
        )
        words += "points cannot tell)"
    else:
        words = f"positions {whose} in the order {', '.join(order)}"
    return Declaration(words, "axes", "", label, seen=seen)


def joints_otherwise(body: Body, joints: Sequence[int], unit: str = "") -> Iterator[Declaration]:
    """Ways in which the readings of the joints may have been meant.

    Args:
        body: whose joints.
        joints: columns of those that count.
        unit: of the readings, as declared.
    """
    turning = [j for j in joints if not (body.kind[body.driver == j] == PRISMATIC).any()]
    for other, size in (("deg", np.pi / 180), ("rad", 180 / np.pi)):
        if other != (unit or "rad") or not unit:
            entry = f'[joints] unit = "{other}"'
            yield Declaration(entry, "joint unit", entry, readings=_scaled(turning, size))
    for a, b in combinations(joints, 2):
        first, second = body.joints[a], body.joints[b]
        words = f"the columns of joints '{first}' and '{second}' swapped"
        yield Declaration(words, f"swap {a} {b}", f"columns of {first} and {second}",
                          readings=_swap(a, b))  # fmt: skip
    for j in joints:
        for factor in (-1.0, *GEARS):
            yield geared(body, j, factor)


def geared(body: Body, joint: int, factor: float) -> Declaration:
    """A joint that moves by so many times what it reads."""
    name = body.joints[joint]
    words = f"the readings of joint '{name}' times {factor:.3g} (its gear)"
    if factor == -1:
        words = f"joint '{name}' counted the other way round"
    readings = _scaled([joint], factor)
    return Declaration(words, f"joint {joint}", readings=readings, joint=joint, factor=factor)


def hand_otherwise(recorded: Recorded) -> Iterator[Declaration]:
    """Ways in which the poses of a free hand may have been meant; see `model.free_hand`."""
    for words, key, entry, turned in rotations(recorded):
        readings = _of_hand(turned, 1.0)
        yield Declaration(f"{words} of the robot's poses", f"robot {key}", entry, readings=readings)


def hand_resized(s: float, recorded: Recorded) -> Declaration | None:
    """The robot's lengths in another unit, s times as long; None if none is near."""
    unit = _unit(s, recorded)
    if not unit:
        return None
    readings = _of_hand(lambda R: R, LENGTHS[unit] / LENGTHS.get(recorded.unit, 1.0))
    words = f'unit = "{unit}" for the robot\'s poses'
    return Declaration(words, "robot unit", f'unit = "{unit}"', readings=readings)


def _of_hand(turned: Turning, size: float) -> Callable[[Array], Array]:
    """Readings of a free hand whose poses have other rotations and lengths."""

    def readings(q: Array) -> Array:
        R = turned(lie.rotation_from_rpy(q[:, [5, 4, 3]]))
        return hand_readings(lie.transform(R, size * q[:, :3]))

    return readings


def _scaled(joints: Sequence[int], factor: float) -> Callable[[Array], Array]:
    def readings(q: Array) -> Array:
        changed = q.copy()
        changed[..., list(joints)] *= factor
        return changed

    return readings


def _swap(a: int, b: int) -> Callable[[Array], Array]:
    def readings(q: Array) -> Array:
        changed = q.copy()
        changed[..., [a, b]] = q[..., [b, a]]
        return changed

    return readings
