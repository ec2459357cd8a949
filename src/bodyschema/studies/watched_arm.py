"""An arm with a rod before a stereo camera, in MuJoCo: the rod slips, later the head turns.

The course of the paper's experiment: random motion at 30 samples a second, the rod moved at 75 s,
the head at 113 s, 130 s in all. MuJoCo's own kinematics say where the rod's tip really is, the
encoders' angles go through ours; pixels are the projection of the tip with noise, nothing is
rendered and tracking never fails. The published learner and ours read the same stream.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import triangulated_rows
from bodyschema.learners.published.linear_relation import PaperRelation
from bodyschema.model.kinematics import relative_pose
from bodyschema.monitoring.monitor import Monitor
from bodyschema.simulation.katana import (
    Scene,
    Stream,
    draw_motion,
    draw_scene,
    katana,
    perceive,
    project_points,
    stereo,
)
from bodyschema.simulation.real_robot import RealRobot

Array = NDArray[np.float64]

ROD, HEAD, SECONDS = 75.0, 113.0, 130.0
"""s: when the rod is moved, when the head, and when the experiment ends."""

CURVE = 15
"""Samples between two points of a curve."""


@dataclass(frozen=True)
class Course:
    """What happens in an experiment."""

    noise: float = 0.5
    """pixels"""
    rod: float = 0.042
    """m: length of the shift of the rod; 42 mm is what the paper's results show."""
    turn: float = np.radians(5.8)
    """rad: angle by which the head turns; its shift is 11.4 mm a degree, as in the paper."""
    ramp: float = 0.0
    """s that each change takes."""

    def __post_init__(self) -> None:
        if self.ramp < 0:
            raise InputError(f"a change takes no time or some; got {self.ramp:g} s.")

    def stream(self, rng: np.random.Generator, speed: float = 0.5) -> Stream:
        """All samples of one experiment, at a peak joint speed as a share of the limits."""
        scene = draw_scene(rng)
        time, q = draw_motion(SECONDS, rng, scene.T_world_cam, speed)
        T_real = _real_poses(q)
        rod = self.rod * _direction(rng)
        turn, shift = self.turn * _direction(rng), 0.0114 * np.degrees(self.turn) * _direction(rng)
        eyes = stereo(self.noise)
        pixels = perceive(scene, T_real, eyes, rng)
        for i in np.flatnonzero(time >= ROD):
            slipped, turned = self._share(time[i] - ROD), self._share(time[i] - HEAD)
            now = scene.rod_moved(slipped * rod).head_moved(turned * turn, turned * shift)
            place = T_real[i : i + 1]
            pixels[i] += _seen(now, place, self.noise) - _seen(scene, place, self.noise)
        return Stream(time, q, relative_pose(katana(), q, "base", "hand"), pixels)

    def _share(self, since: float) -> float:
        """Share of a change that is done some seconds after it began."""
        if since < 0:
            return 0.0
        return 1.0 if self.ramp == 0 else float(min(since / self.ramp, 1.0))


def _seen(scene: Scene, T: Array, noise: float) -> Array:
    return np.asarray(project_points(scene, T, stereo(noise))[0])


def _real_poses(q: Array) -> Array:
    """(n, 4, 4) of the hand, from MuJoCo."""
    body = katana()
    robot = RealRobot(write_urdf(body), {}, body.joints, {})
    return np.asarray(robot.poses(q, "base", ["hand"])[:, 0])


def _direction(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def watch_faithfully(seen: Stream, noise: float, ssd: float = 0.1) -> dict[str, Any]:
    """The published learner on a stream, stopping below an SSD: its events and curves."""
    learner = PaperRelation(16, closest=ssd)
    state, events, curves = learner.start(), [], []
    points = stereo(noise).triangulate(seen.pixels[:, 0])
    for i in range(len(seen)):
        state, (look,) = learner.step(state, (triangulated_rows(seen.T_world_hand[i], points[i]),))
        if look.event:
            kind = "identified" if look.event == "identified" else "alarm"
            events.append([float(seen.time[i]), kind, ""])
        if i % CURVE == 0:
            found = look.direction
            curves.append(
                {
                    "time": float(seen.time[i]),
                    "squares": None if found is None else [float(s) for s in found.squares[:4]],
                    "closeness": None if found is None else min(found.closeness, 3.5),
                    "error": None if found is not None else look.error,
                    "limit": None if state.x is None else state.limit,
                }
            )
    return {"events": events, "curves": curves}


def watch_better(seen: Stream, noise: float) -> dict[str, Any]:
    """The monitor round our learner on a stream: its events and curves."""
    learner = HandEyePoints(stereo(noise))
    monitor = Monitor(learner)
    state, events, curves = monitor.start(), [], []
    for i in range(len(seen)):
        state, report = monitor.step(state, (seen.sample(i),))
        if report.event:
            events.append([float(seen.time[i]), report.event, report.block])
        if i % CURVE == 0:
            bounds = learner.certificate(state.belief).bounds
            curves.append(
                {
                    "time": float(seen.time[i]),
                    "bounds": {part: float(min(b, 10.0)) for part, b in bounds.items()},
                    "sum": max(state.sums.core, state.sums.gross),
                    "observing": report.mode == "observe",
                }
            )
    return {"events": events, "curves": curves}


def score(events: Sequence[Sequence[Any]]) -> dict[str, Any]:
    """What became of both changes, and the false alarms."""
    changes = {"tool": (ROD, HEAD), "camera": (HEAD, SECONDS)}
    first = [t for t, kind, _ in events if kind == "identified"]
    answer: dict[str, Any] = {"first_identified": min(first, default=None)}
    for block, (begin, end) in changes.items():
        inside = [event for event in events if begin <= event[0] < end]
        alarms = [t for t, kind, _ in inside if kind == "alarm"]
        known = [t for t, kind, _ in inside if kind == "identified" and alarms and t > alarms[0]]
        settled = known[0] if known else end
        # A change that takes a second may be named twice: what counts is the name that stays.
        blamed = [name for t, kind, name in inside if kind == "changed" and t <= settled]
        answer[block] = {
            "delay": alarms[0] - begin if alarms and _observing(events, begin) else None,
            "blamed": blamed[-1] if blamed else None,
            "first_blamed": blamed[0] if blamed else None,
            "known_again": known[0] - alarms[0] if known else None,
        }
    answer["false_alarms"] = _false_alarms(events)
    answer["hours"] = _watched(events) / 3600
    return answer


def _observing(events: Sequence[Sequence[Any]], moment: float) -> bool:
    """Whether the monitor was watching at a moment."""
    before = [kind for t, kind, _ in events if t < moment and kind in ("identified", "alarm")]
    return bool(before) and before[-1] == "identified"


def _false_alarms(events: Sequence[Sequence[Any]]) -> int:
    """Alarms other than the first one after each change that found the monitor watching."""
    alarms = [t for t, kind, _ in events if kind == "alarm"]
    due = 0
    for begin, end in ((ROD, HEAD), (HEAD, SECONDS)):
        due += any(begin <= t < end for t in alarms) and _observing(events, begin)
    return len(alarms) - due


def _watched(events: Sequence[Sequence[Any]]) -> float:
    """Seconds spent observing."""
    total, since = 0.0, None
    for t, kind, _ in events:
        if kind in ("identified", "dismissed") and since is None:
            since = t
        elif kind == "alarm" and since is not None:
            total, since = total + t - since, None
    return total + (SECONDS - since if since is not None else 0.0)
