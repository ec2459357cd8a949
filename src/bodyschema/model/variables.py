"""Variables: the named, ordered list of what may be wrong with any part of a body.

A vector x (n_parameters,) holds the deviations from a reference body, zero meaning "as modelled":

    offset  theta_j = (1 + g_j) q_j + o_j                      o_j = x            rad or m
    gear    the g_j above                                      g_j = x            1
    axis    a_k moved over the unit sphere by x in its tangent plane, see `chart`     rad
    link    translation of the placement P_k, in the parent's frame: l_k = l_k0 + x           m
    turn    rotation of the placement P_k: R_k = R_k0 exp(x)                                rad
    part    a number of a lens, a load, a sensor ...: value = value_0 + x, see `parts`

One fixed chart round the reference keeps x, its prior and its covariance plain vectors and
matrices: nothing has to be transported when the estimate moves. The chart is exact for tilts and
turns below pi; `Variables` built anew round a better body moves the chart.

An offset and a turn of the same joint's placement about its axis are one direction; therefore
joints have offsets, axes and links, and only fixed frames (cameras, tools, trackers) have turns.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import AXIS, FIXED, GEAR, LINK, OFFSET, PART, PRISMATIC, TURN

if TYPE_CHECKING:
    from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Group = Literal["offsets", "gears", "axes", "links"]

GROUPS: tuple[Group, ...] = ("offsets", "gears", "axes", "links")

PRIOR_STD = {"offset": 0.1, "shift": 0.02, "gear": 0.02, "axis": 0.02, "link": 0.01}
"""Default prior standard deviations (rad, m, 1, rad, m): how wrong robots are, generously."""

UNKNOWN_POSITION, UNKNOWN_TURN = 1.0, 1.0
"""m and rad: prior round the closed-form start of a frame that nobody measured."""

UNKNOWN_AXIS, UNKNOWN_LINK = 1.0, 0.1
"""rad and m: prior of a joint of which nothing but its place in the tree is known."""


@dataclass(frozen=True)
class Variables:
    """What may be wrong, a row each; see `free_joints`, `free_frame`, `free_part`, `join`."""

    names: tuple[str, ...]
    """Unique, such as "elbow.offset", "elbow.axis_1", "camera.turn_z", "camera.fx"."""
    groups: tuple[str, ...]
    """"offsets", "gears", "axes", "links", "frame:NAME", or "KIND:NAME" of a part."""
    units: tuple[str, ...]
    """"rad", "m", "1", or that of a part's number."""
    code: Ints
    """(n_parameters,) OFFSET, GEAR, AXIS, LINK, TURN or PART."""
    index: Ints
    """(n_parameters,) the joint (OFFSET, GEAR), frame (AXIS, LINK, TURN) or part that is meant."""
    component: Ints
    """(n_parameters,) which tangent or Cartesian component, which number of a part."""
    prior_std: Array
    """(n_parameters,) standard deviation of the prior round zero; inf for none."""
    bound: Array
    """(n_parameters,) largest deviation allowed either way."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def scale(self) -> Array:
        """(n_parameters,) prior standard deviations, 1 where there is no prior."""
        return np.where(np.isfinite(self.prior_std), self.prior_std, 1.0)

    def of_part(self, part: str) -> tuple[Ints, Ints]:
        """Columns of the variables of one part, (m,), and which of its numbers they are, (m,)."""
        return self._parts.get(part, _NO_PART)

    @cached_property
    def has_parts(self) -> bool:
        """Whether any number of a part is free."""
        return bool((self.code >= PART).any())

    @cached_property
    def _parts(self) -> dict[str, tuple[Ints, Ints]]:
        columns: dict[str, list[int]] = {}
        for i in np.flatnonzero(self.code == PART):
            columns.setdefault(self.groups[i].split(":", 1)[1], []).append(int(i))
        return {
            part: (np.array(rows, dtype=np.int64), self.component[rows])
            for part, rows in columns.items()
        }

    def where(self, groups: Iterable[str]) -> Variables:
        """The parameters of these groups only, in the same order."""
        wanted = set(groups)
        return self.take([i for i, group in enumerate(self.groups) if group in wanted])

    def take(self, rows: Sequence[int]) -> Variables:
        """The parameters of these rows only."""
        keep = np.asarray(rows, dtype=np.int64)
        return Variables(
            tuple(self.names[i] for i in keep),
            tuple(self.groups[i] for i in keep),
            tuple(self.units[i] for i in keep),
            self.code[keep],
            self.index[keep],
            self.component[keep],
            self.prior_std[keep],
            self.bound[keep],
        )

    def with_prior(self, prior_std: Array) -> Variables:
        """The same parameters under another prior, (n_parameters,)."""
        return replace(self, prior_std=np.asarray(prior_std, dtype=np.float64))


_NO_PART: tuple[Ints, Ints] = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


@dataclass(frozen=True)
class _Row:
    name: str
    group: str
    unit: str
    code: int
    index: int
    component: int
    prior_std: float
    bound: float


def _table(rows: Sequence[_Row]) -> Variables:
    def ints(values: Iterable[int]) -> Ints:
        return np.fromiter(values, dtype=np.int64, count=len(rows))

    def floats(values: Iterable[float]) -> Array:
        return np.fromiter(values, dtype=np.float64, count=len(rows))

    return Variables(
        tuple(row.name for row in rows),
        tuple(row.group for row in rows),
        tuple(row.unit for row in rows),
        ints(row.code for row in rows),
        ints(row.index for row in rows),
        ints(row.component for row in rows),
        floats(row.prior_std for row in rows),
        floats(row.bound for row in rows),
    )


def free_joints(
    body: Body, groups: Iterable[str] = GROUPS, joints: Iterable[str] | None = None
) -> Variables:
    """Free the given groups of the given joints (all joints when None), with default priors.

    Axes and links belong to the frame that a joint carries; a mimicking joint has its own.

    Raises:
        InputError: a group or a joint does not exist.
    """
    chosen = tuple(body.joints if joints is None else joints)
    wanted = tuple(groups)
    for group in wanted:
        if group not in GROUPS:
            raise InputError(f"no parameter group '{group}'{did_you_mean(group, GROUPS)}")
    rows: list[_Row] = []
    for name in chosen:
        joint = body.joint_index(name)
        nodes = [k for k in range(len(body.frames)) if body.driver[k] == joint]
        revolute = any(body.kind[k] != PRISMATIC for k in nodes)
        if "offsets" in wanted:
            unit, std = ("rad", PRIOR_STD["offset"]) if revolute else ("m", PRIOR_STD["shift"])
            bound = np.pi if revolute else np.inf
            rows.append(_Row(f"{name}.offset", "offsets", unit, OFFSET, joint, 0, std, bound))
        if "gears" in wanted:
            rows.append(_Row(f"{name}.gear", "gears", "1", GEAR, joint, 0, PRIOR_STD["gear"], 0.5))
        for k in nodes:
            rows += _geometry_rows(body, int(k), wanted)
    return _table(rows)


def _geometry_rows(body: Body, node: int, groups: Sequence[str]) -> list[_Row]:
    carrier = body.carriers[node]
    rows: list[_Row] = []
    if "axes" in groups:
        for c in range(2):
            name = f"{carrier}.axis_{c + 1}"
            rows.append(_Row(name, "axes", "rad", AXIS, node, c, PRIOR_STD["axis"], np.pi / 2))
    if "links" in groups:
        for c in range(3):
            name = f"{carrier}.link_{'xyz'[c]}"
            rows.append(_Row(name, "links", "m", LINK, node, c, PRIOR_STD["link"], np.inf))
    return rows


def free_frame(
    body: Body,
    frame: str,
    position_std: float = UNKNOWN_POSITION,
    turn_std: float | None = UNKNOWN_TURN,
    only: Iterable[str] | None = None,
) -> Variables:
    """Free the placement of a fixed frame: camera, tool, tracker, marker.

    Args:
        body: the body that has the frame.
        frame: its name; the frame must hang on its parent by a fixed joint.
        position_std: prior of each coordinate, m.
        turn_std: prior of each rotation component, rad; None frees the position only, as for a
            point whose orientation nobody can see.
        only: some of "link_x" .. "turn_z": a plane, the frame's x and y, moves by "link_z",
            "turn_x" and "turn_y" alone.

    Raises:
        InputError: no such frame, or it hangs on a moving joint.
    """
    node = body.frame_index(frame)
    if node == 0 or body.kind[node] != FIXED:
        raise InputError(
            f"frame '{frame}' cannot be freed as a whole: it "
            + ("is the root." if node == 0 else "hangs on a moving joint; free that joint instead.")
        )
    group = f"frame:{frame}"
    rows = [
        _Row(f"{frame}.link_{'xyz'[c]}", group, "m", LINK, node, c, position_std, np.inf)
        for c in range(3)
    ]
    if turn_std is not None:
        rows += [
            _Row(f"{frame}.turn_{'xyz'[c]}", group, "rad", TURN, node, c, turn_std, np.pi)
            for c in range(3)
        ]
    kept = None if only is None else {f"{frame}.{name}" for name in only}
    return _table([row for row in rows if kept is None or row.name in kept])


def free_part(
    body: Body,
    part: str,
    names: Iterable[str] | None = None,
    prior_std: Mapping[str, float] | None = None,
) -> Variables:
    """Free numbers of a part: a lens, a load, a sensor, a clock, a target, constants.

    Args:
        body: the body that has the part.
        part: its name.
        names: which of its numbers; all when None.
        prior_std: priors other than the part's own, by name.

    Raises:
        InputError: no such part, or no such number of it.
    """
    if part not in body.parts:
        raise InputError(f"no part '{part}' on {body.name}{did_you_mean(part, body.parts)}")
    made, index = body.parts[part], tuple(body.parts).index(part)
    chosen, priors = tuple(made.names if names is None else names), prior_std or {}
    for name in (*chosen, *priors):
        if name not in made.names:
            raise InputError(f"no '{name}' in {part}{did_you_mean(name, made.names)}")
    rows = []
    for c in (made.names.index(name) for name in chosen):
        std = priors.get(made.names[c], float(made.prior_std[c]))
        name, unit = f"{part}.{made.names[c]}", made.units[c]
        rows.append(_Row(name, f"{made.kind}:{part}", unit, PART, index, c, std, np.inf))
    return _table(rows)


def free_skeleton(
    body: Body, axis_std: float = UNKNOWN_AXIS, link_std: float = UNKNOWN_LINK
) -> Variables:
    """Free all that a skeleton is made of: the axis and link of every joint, the link of every
    fixed frame; with a prior as wide as for a body that nobody has measured.

    Args:
        body: the body, or a guess of it.
        axis_std: prior of each tangent component of an axis, rad.
        link_std: prior of each coordinate of a link, m.
    """
    fixed = [name for name, kind in zip(body.frames, body.kind, strict=True) if kind == FIXED]
    frames = [free_frame(body, name, link_std, None) for name in fixed if name != body.frames[0]]
    free = join(free_joints(body, ("axes", "links")), *frames)
    return free.with_prior(np.where(free.code == AXIS, axis_std, link_std))


def join(*parts: Variables) -> Variables:
    """One list of several, in order.

    Raises:
        InputError: the same parameter is freed twice.
    """
    names = [name for part in parts for name in part.names]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"parameter '{twice[0]}' is freed twice; free it once.")
    return Variables(
        tuple(names),
        tuple(group for part in parts for group in part.groups),
        tuple(unit for part in parts for unit in part.units),
        np.concatenate([part.code for part in parts]),
        np.concatenate([part.index for part in parts]),
        np.concatenate([part.component for part in parts]),
        np.concatenate([part.prior_std for part in parts]),
        np.concatenate([part.bound for part in parts]),
    )
