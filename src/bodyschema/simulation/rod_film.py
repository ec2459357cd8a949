"""The five-joint arm holds a rod before the pair of cameras; the rod slips, later the head turns.

The course of the paper's experiment (Nabeshima and Kuniyoshi, section 4.3), in pictures: the
gripper is plain, so that corners are found on the rod, which has a pattern. Who watches may stop
the robot for a while; rod and head move when their time has come, whatever the robot does. Cameras
and encoders share one clock; ten pictures a second.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import katana
from bodyschema.simulation.stereo_film import StereoFilm, StereoMoment

Array = NDArray[np.float64]

RATE = 10.0
"""Pictures a second."""
ROLL, WAGGLE = 4, 0.12
"""The last joint, and the rad by which it waggles alone, either way, so that the rod is found."""
PIECE, PIECES, BEGINS = (0.025, 0.02, 0.03), 5, (0.17, 0.0, 0.01)
"""m: half sides of a piece of the rod; how many; and the first one's middle in the last link."""
PLAIN = (0.25, 0.25, 0.25, 1.0)
"""Colour of the gripper."""
SLIDES = {"rod": "xyz", "head": "xyz"}
"""What may be shifted, along three axes each."""
RAMP = 1.0
"""s that a change takes."""


class RodFilm(StereoFilm):
    """An arm with a rod, a room and two cameras on a head, ready to be filmed."""

    def __init__(
        self, seed: int | Sequence[int], seconds: float, rod: tuple[float, float],
        head: tuple[float, float],
    ) -> None:  # fmt: skip
        """Build the scene.

        Args:
            seed: of everything.
            seconds: length of the film after the rod has been found.
            rod: s, when the rod is shifted, and by how much, m.
            head: s, when the head is turned, and by how much, rad; it shifts by 11.4 mm a degree.
        """
        super().__init__(seed)
        self.seconds, self._rod_at, self._head_at = seconds, rod[0], head[0]
        self._rod_shift = rod[1] * _direction(self._rng)
        self._head_shift = 0.0114 * np.degrees(head[1]) * _direction(self._rng)
        tilt = _direction(self._rng)[:2]
        self._head_turn = head[1] * tilt / np.linalg.norm(tilt)
        self._motion = self._swings(np.arange(round(seconds * RATE)) / RATE)
        self._address = {name: self._model.joint(name).qposadr[0] for name in _JOINTS}
        held = self._model.body("held").id
        self._hand = np.flatnonzero(self._model.geom_bodyid == held)

    def _furnish(self, spec: Any, patterns: Sequence[str]) -> None:
        """A rod in the gripper and a head that may be pushed, both on slides."""
        mujoco, gripper = self._mujoco, spec.body("roll")
        for geom in gripper.geoms:
            geom.material, geom.rgba = "", PLAIN
        passive = {"contype": 0, "conaffinity": 0, "mass": 0.1}
        held = gripper.add_body(name="held", pos=BEGINS)
        for k in range(PIECES):  # a pattern is stretched over its whole shape
            held.add_geom(
                type=mujoco.mjtGeom.mjGEOM_BOX, size=PIECE, pos=[0, 0, 2 * k * PIECE[2]],
                material=patterns[k % 3], **passive,
            )  # fmt: skip
        for name, body in (("rod", held), ("head", spec.body("head"))):
            for axis, letter in enumerate(SLIDES[name]):
                body.add_joint(
                    name=f"{name}_{letter}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=np.eye(3)[axis]
                )

    def waggles(self, seconds: float) -> Iterator[StereoMoment]:
        """Only the last joint moves, to and fro twice a second: what moves is the rod."""
        for t in np.arange(-round(seconds * 30), 0) / 30:
            q = self._motion[0].copy()
            q[ROLL] += WAGGLE * np.sin(4 * np.pi * t)
            yield self._at(float(t), q)

    def watched(self, stops: list[float]) -> Iterator[StereoMoment]:
        """All moments; whoever watches appends to `stops` how many s the robot is to rest."""
        place, rest = 0, 0
        for k in range(round(self.seconds * RATE)):
            yield self._at(k / RATE, self._motion[min(place, len(self._motion) - 1)])
            rest += round(RATE * sum(stops))
            stops.clear()
            if rest > 0:
                rest -= 1
            else:
                place += 1

    def _at(self, time: float, q: Array) -> StereoMoment:
        """One moment, with what has been done to rod and head by then."""
        slipped, turned = (
            float(np.clip((time - at) / RAMP, 0.0, 1.0)) for at in (self._rod_at, self._head_at)
        )
        values = (*slipped * self._rod_shift, *turned * self._head_shift, *turned * self._head_turn)
        for name, value in zip(_JOINTS, values, strict=True):
            self._data.qpos[self._address[name]] = value
        return self._moment(time, q, relative_pose(katana.katana(), q, "base", "hand"))


_JOINTS = (*(f"{name}_{a}" for name in SLIDES for a in SLIDES[name]), "head_pan", "head_tilt")
"""Joints of the changes, in the order of `_at`."""


def _direction(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))
