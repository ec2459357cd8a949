"""The run file to start from: what a recording may mean, written down for a person to correct.

Names, units and frames are guessed from names of columns and sizes of numbers. What nobody can
guess, where the camera sits and which way a pose is written, stands in comments.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bodyschema.model.tree import Body
from bodyschema.sources.bags import MARK
from bodyschema.sources.contents import Contents, Stream
from bodyschema.sources.guesses import TICKS, Group, angle_unit, groups_of, joints_of, plain

SENSES = ("poses", "points")
"""Kinds of senses that need no more than their columns."""

ROOT, TIP = "base_link", "tool0"
"""Frames of a robot that nobody has named."""


@dataclass(frozen=True)
class Seen:
    """Columns of a stream that may be a sense."""

    stream: Stream
    group: Group


@dataclass(frozen=True)
class Suggestion:
    """What a recording may mean."""

    joints: Mapping[str, str]
    """Joint -> column."""
    unit: str
    """Of the joints."""
    states: Stream | None
    """That has the joints."""
    seen: tuple[Seen, ...]
    streams: tuple[Stream, ...] = ()
    """All of the recording."""
    body: Body | None = None
    robot: str = ""
    calibration: str = ""
    """LeRobot's file, if one lies in the data set or beside it."""

    @classmethod
    def of(cls, found: Contents, body: Body | None = None, robot: str = "") -> Suggestion:
        """Guess what the streams are.

        Args:
            found: the contents of a recording.
            body: the robot, if it is known.
            robot: its file, as the run file is to name it.
        """
        named = () if body is None else body.joints
        matched = [(joints_of(stream, named), stream) for stream in found.streams]
        joints, states = max(matched, key=lambda pair: len(pair[0]), default=({}, None))
        states = states if joints else None
        columns = states.recording.columns if states and states.recording else {}
        unit = angle_unit(columns, list(joints.values()))
        seen = tuple(Seen(stream, g) for stream in found.streams for g in groups_of(stream))
        near = found.more.get("calibration", [])
        return cls(joints, unit, states, seen, found.streams, body, robot, near[0] if near else "")

    def text(self, here: Path) -> str:
        """The run file; paths are relative to the folder `here`.

        A recording without joints, but with poses twice, is one for `hand-eye`.
        """
        poses = [one for one in self.seen if one.group.kind == "poses"]
        if self.states is None and len(poses) > 1:
            return "\n".join(self._hand_eye(poses[:2], here)) + "\n"
        return "\n".join(self._calibrate(here)) + "\n"

    def _calibrate(self, here: Path) -> Iterator[str]:
        used = self._used()
        yield "# Guessed from names and sizes of numbers: correct what is not so."
        absent = "" if self.robot else "      # name the description of the robot"
        yield f"robot = {json.dumps(self.robot or 'robot.urdf')}{absent}"
        yield from self._sources(used, here)
        yield from self._columns(here)
        root, tip = self._ends()
        for i, one in enumerate(used):
            yield from _sense(one, _named(i), root, tip, i)
        if not used:
            yield "\n# Nothing in it sees the robot: no poses, no points. Add a [[senses]] entry."
        for one in self.seen:
            if one.group.kind not in SENSES:
                yield f"# also there: {one.group.kind}, columns {list(one.group.columns)}"

    def _used(self) -> list[Seen]:
        """Poses, or else points, that can be read beside the joints without a clash of names."""
        kinds = {one.group.kind for one in self.seen}
        kind = next((k for k in SENSES if k in kinds), "")
        used: list[Seen] = []
        for one in self.seen:
            taken = {c for other in used for c in other.group.columns}
            fits = self.states is None or one.stream is self.states or self._beside(one.stream)
            if one.group.kind == kind and fits and not taken & {*one.group.columns}:
                used.append(one)
        return used[:1] if kind == "poses" else used

    def _beside(self, stream: Stream) -> bool:
        """Whether a stream can be joined to the joints, by time or by rows."""
        if self.states is None or stream.time is None or self.states.time is None:
            return self.states is not None and stream.samples == self.states.samples
        return bool(self.states.time[0] < stream.time[-1] or stream.time[0] < self.states.time[-1])

    def _sources(self, used: Sequence[Seen], here: Path) -> Iterator[str]:
        streams = dict.fromkeys([self.states] if self.states else [])
        streams |= dict.fromkeys(one.stream for one in used)
        streams = streams or dict.fromkeys(self.streams[:1])
        names = [_place(stream.name, here) for stream in streams]
        yield f"recording = {json.dumps(names[0] if len(names) == 1 else names)}"
        clocked = [s for s in streams if s.time is not None]
        if len(names) > 1 and len(clocked) == len(names):
            yield 'join = "time"      # each with a clock of its own'
        clock = next((s.clock for s in clocked), "")
        if clock and clock not in ("time", "t", "timestamp"):
            yield f"time = {json.dumps(clock)}"
        back = [s for s in clocked if s.time is not None and (np.diff(s.time) <= 0).any()]
        if back and len(names) == 1:
            yield 'time = ""          # times repeat or go back: rows are single postures'

    def _columns(self, here: Path) -> Iterator[str]:
        if not self.joints:
            yield "# No columns of joints were found: say under [joints] which is which."
            return
        others = {joint: column for joint, column in self.joints.items() if joint != column}
        if self.unit == "rad" and not others:
            return
        told = bool(self.calibration) and self.unit != "rad"
        unit = "deg" if self.unit == "ticks" and not told else self.unit
        yield f'\n[joints]\nunit = "{unit}"         # guessed by the largest reading'
        if told:
            yield f"calibration = {json.dumps(os.path.relpath(self.calibration, here))}"
        if self.unit == "ticks" and not told:
            for joint, column in self.joints.items():
                yield f"{_key(joint)} = {{ column = {json.dumps(column)}, {_TICKS} }}"
        elif others:
            cells = ", ".join(f"{_key(j)} = {json.dumps(c)}" for j, c in others.items())
            yield f"columns = {{ {cells} }}"
        if self.body is not None and not all(plain(j) == plain(c) for j, c in others.items()):
            yield "# in the order of the columns: no names are alike"

    def _ends(self) -> tuple[str, str]:
        """The root of the robot, and the frame that most of the recorded joints carry."""
        if self.body is None:
            return ROOT, TIP
        moving = {
            self.body.joint_index(joint) for joint in self.joints if joint in self.body.joints
        }
        carried: list[int] = []
        for frame, parent in enumerate(self.body.parent):
            before = carried[parent] if parent >= 0 else 0
            carried.append(before + (int(self.body.driver[frame]) in moving))
        most = max(range(len(carried)), key=lambda frame: (carried[frame], frame))
        return self.body.frames[int(np.argmin(self.body.parent))], self.body.frames[most]

    def _hand_eye(self, poses: Sequence[Seen], here: Path) -> Iterator[str]:
        yield "# Poses without joints, for: bodyschema hand-eye. The robot's come first: is it so?"
        files = [_place(one.stream.name, here) for one in poses]
        together = poses[0].stream is poses[1].stream
        if together:
            yield f"recording = {json.dumps(files[0])}"
        timed = all(one.stream.time is not None for one in poses) and not together
        yield '\n[hand_eye]\neye_on = "hand"          # or "base"'
        yield f'join = "{"time" if timed else "rows"}"'
        for one, file, ends in zip(
            poses, files, (("base", "flange"), ("camera", "marker")), strict=True
        ):
            yield f'\n[[senses]]\nkind = "poses"\nseen_from = "{ends[0]}"\nseen = "{ends[1]}"'
            if not together:
                yield f"recording = {json.dumps(file)}"
            if timed:
                yield f"time = {json.dumps(one.stream.clock)}"
            yield from _measures(one.group)


_TICKS = f"scale = {360 / TICKS}, zero = {TICKS / 2}"


def _sense(one: Seen, ends: tuple[str, str], root: str, tip: str, number: int) -> Iterator[str]:
    """A sense between two frames that nobody has measured."""
    first, second = ends
    if not number:
        yield f"\n[frames.{first}]          # the camera or the board beside the robot"
        yield f'parent = "{root}"\nknown = "no"'
    yield f"\n[frames.{second}]          # what the robot carries of the two"
    yield f'parent = "{tip}"\nknown = "no"'
    yield f'\n[[senses]]\nkind = "{one.group.kind}"\nseen_from = "{first}"\nseen = "{second}"'
    yield from _measures(one.group)
    if one.group.kind == "poses":
        yield "# inverse = true         # where the columns hold what is fixed, seen from the robot"


def _measures(group: Group) -> Iterator[str]:
    yield f"columns = {json.dumps(list(group.columns))}"
    yield f'unit = "{group.unit}"             # guessed by the largest number'
    if group.layout:
        turned = "; or xyz_rpy" if group.layout == "xyz_rotvec" else ""
        yield f'layout = "{group.layout}"{"      # a guess" + turned if turned else ""}'
    if group.angle_unit:
        yield f'angle_unit = "{group.angle_unit}"'


def _named(number: int) -> tuple[str, str]:
    return "fixed", "carried" + (f"_{number + 1}" if number else "")


def _place(name: str, here: Path) -> str:
    """The name of a stream from a folder on."""
    file, mark, topic = name.partition(MARK)
    return os.path.relpath(file, here) + mark + topic


def _key(name: str) -> str:
    """A key of a TOML table."""
    bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if bare else json.dumps(name)
