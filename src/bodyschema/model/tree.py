"""Body: an immutable kinematic tree held as arrays, one row a frame, parents before children.

Frame k hangs on its parent by a joint frame P_k (the placement) and a motion M_k about or along
the axis a_k:  T_parent_k = P_k M_k(theta_k). Joint j is read by an encoder as q_j; its true value
is (1 + gear_j) q_j + offset_j, and theta_k = rate_k (that) + shift_k for the frames that it drives
(rate 1 and shift 0 unless the frame mimics another).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model import chart
from bodyschema.model.body_check import refuse_large, span
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.parts import Part
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Visual:
    """One visible shape of a link."""

    frame: str
    placement: Array
    """(4, 4) T_frame_shape."""
    shape: str
    """"mesh", "box", "cylinder" or "sphere"."""
    size: tuple[float, ...]
    """m: box x y z, cylinder radius length, sphere radius; for a mesh its scale, 1."""
    mesh: str = ""
    """Path of the mesh file; a package:// address that was not found stays as it is."""


@dataclass(frozen=True)
class Body:
    """The model that a robot has of itself, from a URDF, a DH table or a bare arrangement.

    It is everything that a prediction needs: frames and joints here, and in `parts` what else there
    is. One noun for both, since a body that bends needs its loads to know where its hand is.
    """

    name: str
    frames: tuple[str, ...]
    """Link names; the first is the root."""
    carriers: tuple[str, ...]
    """Name of the joint that carries each frame; "" for the root."""
    joints: tuple[str, ...]
    """Names of the independent joints: the columns of every q."""
    parent: Ints
    """(n_frames,) -1 for the root."""
    kind: Ints
    """(n_frames,) FIXED, REVOLUTE or PRISMATIC."""
    axis: Array
    """(n_frames, 3) unit, in the joint frame."""
    placement: Array
    """(n_frames, 4, 4) T_parent_joint."""
    driver: Ints
    """(n_frames,) the joint that moves the frame; -1 for none."""
    rate: Array
    """(n_frames,) 1, or the multiplier of a mimicking joint."""
    shift: Array
    """(n_frames,) 0, or the offset of a mimicking joint (rad or m)."""
    lower: Array
    """(n_joints,) limits of q (rad or m); -inf for none."""
    upper: Array
    gear: Array
    """(n_joints,) relative error of the encoder's scale."""
    offset: Array
    """(n_joints,) rad or m."""
    visuals: tuple[Visual, ...] = ()
    parts: Mapping[str, Part] = field(default_factory=dict)
    """Lenses, loads, sensors, clocks and targets by name; see `parts`."""
    source: str = ""
    """Path of the description that it was read from; "" if there is none."""
    arguments: Mapping[str, str] = field(default_factory=dict)
    """Of a xacro file, by name."""
    remarks: tuple[str, ...] = ()
    """What of the description was read otherwise than it says, a sentence each."""
    stated_zeros: Mapping[str, str] = field(default_factory=dict)
    """Joint -> how the description writes a zero that only some drivers honour; no part of q."""

    @classmethod
    def from_urdf(
        cls,
        path: str | Path,
        packages: Mapping[str, str | Path] | None = None,
        arguments: Mapping[str, Any] | None = None,
    ) -> Body:
        """Read a URDF or xacro file; see `bodyschema.model.urdf.read_urdf`.

        Args:
            path: the file, or the text of a URDF itself, as /robot_description holds it.
            packages: folder of each ROS package that it names.
            arguments: of a xacro file, by name.
        """
        from bodyschema.model.urdf import body_of_text, is_text, read_urdf

        if is_text(path):
            return body_of_text(str(path), packages or {})
        given = {name: str(value) for name, value in (arguments or {}).items()}
        body = read_urdf(Path(path), packages or {}, given)
        return replace(body, source=str(Path(path).resolve()), arguments=given)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        packages: Mapping[str, str | Path] | None = None,
        arguments: Mapping[str, Any] | None = None,
    ) -> Body:
        """Read a description of any form: URDF, xacro, MJCF, or a table.

        Tables are those of Denavit and Hartenberg, of screw axes, or of several robots; see
        `bodyschema.model.description`.
        """
        from bodyschema.model.description import read_description

        given = {name: str(value) for name, value in (arguments or {}).items()}
        return read_description(Path(path), packages, given)

    @classmethod
    def from_mjcf(cls, path: str | Path) -> Body:
        """Read an MJCF, MuJoCo's own XML; see `bodyschema.model.mjcf.read_mjcf`."""
        from bodyschema.model.mjcf import read_mjcf

        return replace(read_mjcf(Path(path)), source=str(Path(path).resolve()))

    @classmethod
    def from_screws(cls, path: str | Path) -> Body:
        """Read a table of screw axes; see `bodyschema.model.screws.read_screws`."""
        from bodyschema.model.screws import read_screws

        return replace(read_screws(Path(path)), source=str(Path(path).resolve()))

    @classmethod
    def from_dh(cls, path: str | Path) -> Body:
        """Read a DH table in TOML or JSON; see `bodyschema.model.dh.read_dh`."""
        from bodyschema.model.dh import read_dh

        return replace(read_dh(Path(path)), source=str(Path(path).resolve()))

    @classmethod
    def from_arrangement(cls, path: str | Path) -> Body:
        """A body of unknown geometry, from the order of its joints; see `model.arrangement`."""
        from bodyschema.model.arrangement import read_arrangement

        return read_arrangement(Path(path)).body()

    @classmethod
    def random_chain(cls, n_joints: int, rng: np.random.Generator) -> Body:
        """A serial arm of revolute joints with random axes and links, for studies.

        Axes are uniform on the sphere, link lengths uniform in 0.05..0.3 m; frames are "base",
        "link_1" .. "link_n" and a fixed "tip".
        """
        n = n_joints + 2
        axis = rng.normal(size=(n, 3))
        links = rng.normal(size=(n, 3))
        lengths = rng.uniform(0.05, 0.3, size=(n, 1))
        links *= lengths / np.linalg.norm(links, axis=1, keepdims=True)
        numbers = [str(i) for i in range(1, n_joints + 1)]
        placement = lie.transform(np.tile(np.eye(3), (n, 1, 1)), links)
        placement[0] = np.eye(4)
        return cls.build(
            name=f"random_{n_joints}",
            frames=["base", *("link_" + i for i in numbers), "tip"],
            carriers=["", *("joint_" + i for i in numbers), "tip_joint"],
            parent=range(-1, n - 1),
            kind=[FIXED, *[REVOLUTE] * n_joints, FIXED],
            axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
            placement=placement,
        )

    @classmethod
    def build(
        cls,
        name: str,
        frames: Sequence[str],
        carriers: Sequence[str],
        parent: Sequence[int] | range,
        kind: Sequence[int],
        axis: ArrayLike,
        placement: ArrayLike,
        limits: Mapping[str, tuple[float, float]] | None = None,
        mimics: Mapping[str, tuple[str, float, float]] | None = None,
        joints: Sequence[str] | None = None,
        visuals: Sequence[Visual] = (),
        remarks: Sequence[str] = (),
        stated_zeros: Mapping[str, str] | None = None,
    ) -> Body:
        """A body from plain lists; `mimics` maps a joint to (joint followed, rate, shift)."""
        follow = mimics or {}
        moving = [c for c, k in zip(carriers, kind, strict=True) if k != FIXED]
        order = tuple(joints or [c for c in moving if c not in follow])
        leader = {c: follow.get(c, (c, 1.0, 0.0)) for c in moving}
        driver = [order.index(leader[c][0]) if c in leader else -1 for c in carriers]
        spans = [span((limits or {}).get(j, (-np.inf, np.inf))) for j in order]
        refuse_large(name, placement, [follow[joint][1:] for joint in follow])
        return cls(
            name=name,
            frames=tuple(frames),
            carriers=tuple(carriers),
            joints=order,
            parent=np.array(parent, dtype=np.int64),
            kind=np.array(kind, dtype=np.int64),
            axis=np.array(axis, dtype=np.float64),
            placement=np.array(placement, dtype=np.float64),
            driver=np.array(driver, dtype=np.int64),
            rate=np.array([leader.get(c, ("", 1.0, 0.0))[1] for c in carriers]),
            shift=np.array([leader.get(c, ("", 1.0, 0.0))[2] for c in carriers]),
            lower=np.array([low for low, _ in spans], dtype=np.float64),
            upper=np.array([high for _, high in spans], dtype=np.float64),
            gear=np.zeros(len(order)),
            offset=np.zeros(len(order)),
            visuals=tuple(visuals),
            remarks=tuple(remarks),
            stated_zeros=stated_zeros or {},
        )

    def frame_index(self, frame: str) -> int:
        """Row of a frame. Raises InputError with close names."""
        if frame not in self.frames:
            raise InputError(f"no frame '{frame}' on {self.name}{did_you_mean(frame, self.frames)}")
        return self.frames.index(frame)

    def joint_index(self, joint: str) -> int:
        """Column of an independent joint in q. Raises InputError with close names."""
        if joint not in self.joints:
            raise InputError(f"no joint '{joint}' on {self.name}{did_you_mean(joint, self.joints)}")
        return self.joints.index(joint)

    def attach(self, frame: str, parent: str, T_parent_frame: ArrayLike | None = None) -> Body:
        """A body with one more fixed frame, such as a camera, a tool or the tracker's frame.

        Args:
            frame: new name.
            parent: the frame that it hangs on.
            T_parent_frame: (4, 4); identity when None.
        """
        if frame in self.frames or frame in self.parts:
            kind = "frame" if frame in self.frames else "part"
            raise InputError(f"{self.name} has a {kind} '{frame}' already; choose another name.")
        T = _rigid(np.eye(4) if T_parent_frame is None else T_parent_frame)
        return replace(
            self,
            frames=(*self.frames, frame),
            carriers=(*self.carriers, f"{frame}_joint"),
            parent=np.append(self.parent, self.frame_index(parent)),
            kind=np.append(self.kind, FIXED),
            axis=np.vstack([self.axis, [0.0, 0.0, 1.0]]),
            placement=np.concatenate([self.placement, T[None]]),
            driver=np.append(self.driver, -1),
            rate=np.append(self.rate, 1.0),
            shift=np.append(self.shift, 0.0),
        )

    def joined(
        self, other: Body, parent: str, T_parent_root: ArrayLike | None = None, prefix: str = ""
    ) -> Body:
        """One body of two: the other's root is fixed to a frame; see `bodyschema.model.assembly`.

        Args:
            other: the second robot.
            parent: frame of this one.
            T_parent_root: (4, 4) m, of the other's root; identity when None.
            prefix: before the names of the other's frames and joints.
        """
        from bodyschema.model.assembly import joined

        return joined(self, other, parent, T_parent_root, prefix)

    def with_placement(self, frame: str, T_parent_joint: ArrayLike) -> Body:
        """A body with another placement of one frame, (4, 4)."""
        placement = self.placement.copy()
        placement[self.frame_index(frame)] = _rigid(T_parent_joint)
        return replace(self, placement=placement)

    def with_part(self, name: str, part: Part) -> Body:
        """A body with one more part, or with another one of that name.

        Raises:
            InputError: a frame has that name; what is unknown is known by its name alone.
        """
        if name in self.frames:
            raise InputError(
                f"{self.name} has a frame '{name}'; give the {part.kind} another name."
            )
        return replace(self, parts={**self.parts, name: part})

    def part(self, name: str) -> Part:
        """A part. Raises InputError with close names."""
        if name not in self.parts:
            raise InputError(f"no part '{name}' on {self.name}{did_you_mean(name, self.parts)}")
        return self.parts[name]

    def with_variables(self, variables: Variables, x: ArrayLike) -> Body:
        """The body that deviates from this one by x, (n_parameters,); see `variables`."""
        return self.deviate(variables, x)[0]

    def deviate(self, variables: Variables, x: ArrayLike) -> tuple[Body, Array]:
        """The body at x and the slope of the chart there, (n_parameters, 3); see `chart`."""
        v = np.asarray(x, dtype=np.float64)
        if v.shape != (len(variables),):
            raise InputError(f"expected {len(variables)} parameters, got an array {v.shape}.")
        gear, offset = self.gear.copy(), self.offset.copy()
        axis, placement = self.axis.copy(), self.placement.copy()
        direction = np.zeros((len(variables), 3))
        chart.deviate(
            variables.code, variables.index, variables.component, v, self.tangents,
            axis, placement, gear, offset, direction,
        )  # fmt: skip
        parts = self.parts
        if variables.has_parts:
            free = ((name, variables.of_part(name)) for name in parts)
            parts = {name: parts[name].moved(at, v[columns]) for name, (columns, at) in free}
        changed = {"gear": gear, "offset": offset, "axis": axis, "placement": placement}
        # `dataclasses.replace` looks at all twenty fields, in every step of a filter.
        body = object.__new__(Body)
        vars(body).update(vars(self), **changed, parts=parts)
        vars(body).pop("tangents", None)
        return body, direction

    @cached_property
    def tangents(self) -> Array:
        """(n_frames, 3, 2) tangent basis of each axis."""
        return lie.tangent_basis(self.axis)


def _rigid(T_a_b: ArrayLike) -> Array:
    T = lie.matrices(T_a_b)
    if T.shape != (4, 4) or not np.isfinite(T).all():
        raise InputError(f"expected a 4x4 transform, got an array {T.shape}:\n{T}")
    return T
