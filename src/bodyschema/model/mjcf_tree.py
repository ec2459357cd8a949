"""The kinematic tree of a compiled MJCF: bodies, their joints, sites and cameras; see `mjcf`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE

Array = NDArray[np.float64]

OPTICAL = np.diag([1.0, -1.0, -1.0])
"""From MuJoCo's cameras, which look along -z with y up, to optical frames."""

HELD = ("free", "ball")
"""Joints of MJCF that no encoder reads, by their numbers."""


@dataclass
class MjcfTree:
    """The lists that a Body is built of, filled body by body."""

    mujoco: Any
    model: Any
    frames: list[str] = field(default_factory=lambda: ["world"])
    carriers: list[str] = field(default_factory=lambda: [""])
    parent: list[int] = field(default_factory=lambda: [-1])
    kind: list[int] = field(default_factory=lambda: [FIXED])
    axis: list[Any] = field(default_factory=lambda: [(0.0, 0.0, 1.0)])
    placement: list[Array] = field(default_factory=lambda: [np.eye(4)])
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    held: set[int] = field(default_factory=set)
    of_body: list[int] = field(default_factory=lambda: [0])
    """Row of the frame of each body."""

    def add_body(self, b: int) -> None:
        """A body and the joints that it hangs on."""
        m = self.model
        name, above = self._body_name(b), self.of_body[m.body_parentid[b]]
        after = lie.transform(rotation(m.body_quat[b]), m.body_pos[b])
        first, count = int(m.body_jntadr[b]), int(m.body_jntnum[b])
        moving = [j for j in range(first, first + count) if self._moves(j, name)]
        for j in moving:
            through = j == moving[-1] and not m.jnt_pos[j].any()
            above = self._add_joint(j, name if through else "", name, above, after)
            after = lie.transform(np.eye(3), -m.jnt_pos[j])
        if name not in self.frames:
            above = self._add(name, f"{name}_fixed", above, FIXED, (0.0, 0.0, 1.0), after)
        self.of_body.append(above)

    def _add_joint(self, j: int, frame: str, body: str, above: int, before: Array) -> int:
        """A joint, whose frame has a name of its own if it is not that of the body."""
        m, joint = self.model, self.joint_name(j)
        slides = bool(m.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_SLIDE)
        axis = m.jnt_axis[j] / np.linalg.norm(m.jnt_axis[j])
        at = lie.transform(np.eye(3), m.jnt_pos[j])
        back = _motion(axis, -float(m.qpos0[m.jnt_qposadr[j]]), slides)
        low, high = m.jnt_range[j] if m.jnt_limited[j] else (-np.inf, np.inf)
        self.limits[joint] = float(low), float(high)
        kind = PRISMATIC if slides else REVOLUTE
        frame = frame or self._free(f"{body}_{joint}")
        return self._add(frame, joint, above, kind, axis, before @ at @ back)

    def add_sites_and_cameras(self) -> None:
        """What has a name is a frame; a second one of a name says what it is."""
        m, kinds = self.model, self.mujoco.mjtObj
        for i, name in self._named(kinds.mjOBJ_SITE, m.nsite):
            T = lie.transform(rotation(m.site_quat[i]), m.site_pos[i])
            self._add_fixed(name, "site", int(m.site_bodyid[i]), T)
        for i, name in self._named(kinds.mjOBJ_CAMERA, m.ncam):
            T = lie.transform(rotation(m.cam_quat[i]) @ OPTICAL, m.cam_pos[i])
            self._add_fixed(name, "camera", int(m.cam_bodyid[i]), T)

    def joint_name(self, j: int) -> str:
        """Of a joint; by its number where it has none."""
        return self._name(self.mujoco.mjtObj.mjOBJ_JOINT, j) or f"joint_{j + 1}"

    def _body_name(self, b: int) -> str:
        return self._name(self.mujoco.mjtObj.mjOBJ_BODY, b) or f"body_{b}"

    def _named(self, kind: Any, count: int) -> Iterator[tuple[int, str]]:
        return ((i, name) for i in range(count) if (name := self._name(kind, i)))

    def _name(self, kind: Any, i: int) -> str:
        return self.mujoco.mj_id2name(self.model, kind, i) or ""

    def _moves(self, j: int, body: str) -> bool:
        """Whether an encoder may read a joint; others are held, and the body says so."""
        kind = int(self.model.jnt_type[j])
        if kind >= len(HELD):
            return True
        self.held.add(j)
        self.remarks.append(
            f"Joint '{self.joint_name(j)}' is {HELD[kind]} and has no encoder, so '{body}' was "
            "held where the file has it; if it moved during the recording, see it from a frame on "
            "the robot's side of that joint."
        )
        return False

    def _add_fixed(self, name: str, what: str, b: int, T: Array) -> None:
        frame = name if name not in self.frames else self._free(f"{name}_{what}")
        self._add(frame, f"{frame}_fixed", self.of_body[b], FIXED, (0.0, 0.0, 1.0), T)

    def _add(
        self, frame: str, carrier: str, above: int, kind: int, axis: Any, placement: Array
    ) -> int:
        if frame in self.frames or carrier in self.carriers:
            raise InputError(f"two things of the MJCF are called '{frame}'; rename one.")
        self.frames.append(frame)
        self.carriers.append(carrier)
        self.parent.append(above)
        self.kind.append(kind)
        self.axis.append(axis)
        self.placement.append(placement)
        return len(self.frames) - 1

    def _free(self, name: str) -> str:
        """A name that no body or frame has."""
        taken = {*self.frames, *(self._body_name(b) for b in range(1, self.model.nbody))}
        return next(n for n in (name, *(f"{name}_{i}" for i in range(2, 99))) if n not in taken)


def rotation(wxyz: Any) -> Array:
    """Rotation of a quaternion as MuJoCo has it, scalar first, (3, 3)."""
    return lie.rotation_from_xyzw(np.roll(np.asarray(wxyz, dtype=np.float64), -1))


def _motion(axis: Array, by: float, slides: bool) -> Array:
    """M(by) about or along an axis."""
    if slides:
        return lie.transform(np.eye(3), by * axis)
    return lie.transform(lie.exp_so3(by * axis), np.zeros(3))
