"""Arrangements: which joint hangs on which, and nothing of where they are.

For a robot that nobody has measured. A file in TOML:

    name = "arm"                        # optional; the file's name when absent
    root = "base"                       # optional: the link that the first joints hang on

    [joints]                            # joint = what it hangs on: a joint, or the root
    shoulder = "base"
    elbow = "shoulder"
    wrist = { parent = "elbow", kind = "revolute", limits = [-1.5, 1.5] }

    [markers]                           # points that are seen = the joint that moves them
    hand = "wrist"

    [camera]                            # optional: the frame that they are seen from
    name = "eye"                        # optional; "camera" when absent
    parent = "base"                     # a joint, or the root

The body has all links zero, all frames parallel and all axes along z: geometry that is still to be
learned. Joint `elbow` carries the link `elbow_link`; markers and camera are fixed frames. Joints
keep the file's order in q. Without a camera the root looks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from bodyschema.documents import toml_file
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

KEYS = ("name", "root", "joints", "markers", "camera")
KINDS = {"revolute": REVOLUTE, "prismatic": PRISMATIC}


@dataclass(frozen=True)
class JointEntry:
    """One joint of an arrangement."""

    parent: str
    kind: str = "revolute"
    limits: tuple[float, float] = (-np.inf, np.inf)
    """rad or m."""


@dataclass(frozen=True)
class Arrangement:
    """What hangs on what."""

    name: str
    root: str
    joints: Mapping[str, JointEntry]
    markers: Mapping[str, str]
    """Marker -> the joint that moves it, or the root."""
    camera: tuple[str, str] | None
    """Its name and what it hangs on; None where the root looks."""

    @property
    def looks(self) -> str:
        """The frame that markers are seen from."""
        return self.camera[0] if self.camera else self.root

    def body(self) -> Body:
        """The body with all geometry unknown: links zero, rotations identity, axes z."""
        order = self.from_the_root()
        fixed = {**self.markers, **(dict([self.camera]) if self.camera else {})}
        links = {self.root: 0, **{joint: i for i, joint in enumerate(order, start=1)}}
        parents = [self.joints[joint].parent for joint in order]
        n = 1 + len(order) + len(fixed)
        kinds = [KINDS[self.joints[joint].kind] for joint in order]
        return Body.build(
            name=self.name,
            frames=[self.root, *map(link_of, order), *fixed],
            carriers=["", *order, *(f"{frame}_joint" for frame in fixed)],
            parent=[-1, *(links[p] for p in parents), *(links[p] for p in fixed.values())],
            kind=[FIXED, *kinds, *[FIXED] * len(fixed)],
            axis=np.tile([0.0, 0.0, 1.0], (n, 1)),
            placement=np.tile(np.eye(4), (n, 1, 1)),
            limits={joint: entry.limits for joint, entry in self.joints.items()},
            joints=list(self.joints),
        )

    def from_the_root(self) -> list[str]:
        """Joints with parents before children. Raises InputError for a circle."""
        order, known = list[str](), {self.root}
        waiting = list(self.joints)
        while waiting:
            ready = [j for j in waiting if self.joints[j].parent in known]
            if not ready:
                raise InputError(
                    f"the joints {', '.join(waiting)} of {self.name} hang on each other in a "
                    f"circle; one of them must hang on the root '{self.root}'."
                )
            order += ready
            known |= {*ready}
            waiting = [joint for joint in waiting if joint not in known]
        return order


def link_of(joint: str) -> str:
    """Name of the link that a joint carries."""
    return f"{joint}_link"


def read_arrangement(path: Path) -> Arrangement:
    """Read an arrangement (see the module's text).

    Raises:
        InputError: the file is missing or malformed, a name is unknown or used twice, or joints
            hang on each other in a circle.
    """
    missing = f"no arrangement at '{path}'; give the path of a TOML file."
    # The parser names a key that is written twice, and the line.
    table = toml_file(path, missing, "not a readable arrangement")
    for key in table:
        if key not in KEYS:
            raise InputError(f"unknown key '{key}' in '{path.name}'{did_you_mean(key, KEYS)}")
    where = f"'{path.name}'"
    joints = {
        name: _joint(name, entry, where) for name, entry in _table(table, "joints", where).items()
    }
    if not joints:
        raise InputError(f'{where} names no joint; add [joints] with lines like: elbow = "base".')
    found = Arrangement(
        name=_text(table, "name", path.stem, where),
        root=_text(table, "root", "base", where),
        joints=joints,
        markers={
            name: _text({name: on}, name, "", f"[markers] of {where}")
            for name, on in _table(table, "markers", where).items()
        },
        camera=_camera(_table(table, "camera", where), where),
    )
    _check_names(found, where)
    found.from_the_root()
    return found


def _text(table: Mapping[str, Any], key: str, usual: str, where: str) -> str:
    value = table.get(key, usual)
    if not isinstance(value, str):
        raise InputError(f"{key} = {value!r:.60} in {where}; expected text.")
    return value


def _table(table: Mapping[str, Any], key: str, where: str) -> Mapping[str, Any]:
    entry = table.get(key, {})
    if not isinstance(entry, dict):
        raise InputError(f"{key} in {where} must be a table, [{key}]; it is {entry!r}.")
    return entry


def _joint(name: str, entry: Any, where: str) -> JointEntry:
    values = {"parent": entry} if isinstance(entry, str) else entry
    if not isinstance(values, dict) or "parent" not in values:
        raise InputError(
            f"joint '{name}' of {where} does not say what it hangs on; write "
            f'{name} = "PARENT" or {name} = {{ parent = "PARENT" }}.'
        )
    known = ("parent", "kind", "limits")
    for key in values:
        if key not in known:
            raise InputError(f"unknown key '{key}' of joint '{name}'{did_you_mean(key, known)}")
    kind = values.get("kind", "revolute")
    if not isinstance(kind, str) or kind not in KINDS:
        hint = did_you_mean(str(kind), KINDS)
        raise InputError(f"kind '{kind!s:.60}' of joint '{name}' in {where}{hint}")
    limits = values.get("limits", [-np.inf, np.inf])
    numbers = isinstance(limits, list) and all(
        isinstance(end, Real) and not isinstance(end, bool) for end in limits
    )
    if not numbers or len(limits) != 2 or not limits[0] < limits[1]:
        raise InputError(
            f"limits of joint '{name}' in {where} must be two numbers (rad or m), the lower first."
        )
    parent = _text(values, "parent", "", f"joint '{name}' of {where}")
    return JointEntry(parent, kind, (float(limits[0]), float(limits[1])))


def _camera(entry: Mapping[str, Any], where: str) -> tuple[str, str] | None:
    if not entry:
        return None
    known = ("name", "parent")
    for key in entry:
        if key not in known:
            raise InputError(
                f"unknown key '{key}' in [camera] of {where}{did_you_mean(key, known)}"
            )
    if "parent" not in entry:
        raise InputError(f'[camera] of {where} does not say what it hangs on; add: parent = "...".')
    where = f"[camera] of {where}"
    return _text(entry, "name", "camera", where), _text(entry, "parent", "", where)


def _check_names(found: Arrangement, where: str) -> None:
    """Every name is used once, and everything hangs on something that exists."""
    camera = [found.camera] if found.camera else []
    frames = [found.root, *map(link_of, found.joints), *found.markers, *(n for n, _ in camera)]
    for names, what in ((frames, "frames"), ([found.root, *found.joints], "links or joints")):
        twice = _twice(names)
        if twice:
            raise InputError(f"two {what} of {where} are called '{twice}'; rename one of them.")
    known = (found.root, *found.joints)
    hangs = [
        *((f"joint '{name}'", entry.parent) for name, entry in found.joints.items()),
        *((f"marker '{name}'", on) for name, on in found.markers.items()),
        *((f"camera '{name}'", on) for name, on in camera),
    ]
    for who, on in hangs:
        if on not in known:
            raise InputError(
                f"{who} of {where} hangs on '{on}', which is no joint and not the root"
                f"{did_you_mean(on, known)}"
            )


def _twice(names: Iterable[str]) -> str:
    """The first name that comes a second time; "" if none does."""
    return next((name for name, times in Counter(names).items() if times > 1), "")
