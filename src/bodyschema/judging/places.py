"""Places: where the frames are that were asked for, and how well that is known.

Asked for are the frames that nobody knew, or only roughly, and what is wanted. The pose of frame b
in frame a is uncertain by

    Sigma = J C J^T          (6, 6): position and rotation in a's axes,

with C the whole covariance of the answer, priors of joints and all, as wide as its own samples make
it. What a camera shares with the zero of the joint that carries it is thus as uncertain as that
zero. Let N span the directions that the data leave open. Where N carries more than half of Sigma
the place is not told in a; then the nearest frame on the way to what was seen is looked for in
which it is, with the joints between at zero (or as near to it as their limits allow).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.identifiability import SAYS_LITTLE
from bodyschema.estimation.prediction import length_quantile
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.settled import settled
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import GROUPS
from bodyschema.units import listed

Array = NDArray[np.float64]

OPEN = 0.5
"""Share of a variance in open directions above which it is not determined."""

NAMED = 3
"""Names that a sentence spells out."""

PREFIX = "frame:"
"""Of the parameter group of a frame that was freed."""


@dataclass(frozen=True)
class FramePlace:
    """Where a frame is."""

    parent: str
    """The frame that the coordinates are in."""
    frame: str
    T: Array
    """(4, 4) T_parent_frame, as it goes with the robot that is written; m."""
    sd: Array
    """(6,) standard deviations of position (m) and rotation (rad) in the parent's axes, priors of
    the joints and all; nan where nothing was asked, as of the turn of a point."""
    position_95: float
    """m: the position is wrong by less with 95 %; nan where it was not free."""
    rotation_95: float
    """rad: the same of the rotation."""
    untold: str = ""
    """Why it is not determined, in words; "" if it is."""
    at: Mapping[str, float] = field(default_factory=dict)
    """Readings of the joints between both, rad or m; none where nothing moves."""
    told: FramePlace | None = None
    """Where this place is not determined: the same frame in another, in which it is."""


def places(calibration: Calibration) -> tuple[FramePlace, ...]:
    """The frames that were asked for, those that were free first, each once."""
    estimate = calibration.estimate
    if not len(estimate.variables):
        return ()
    body = settled(calibration).body
    belief = _Belief(calibration, body, _open(calibration))
    groups = dict.fromkeys(estimate.variables.groups)
    frames = [g.removeprefix(PREFIX) for g in groups if g.startswith(PREFIX)]
    pairs = [(body.frames[body.parent[body.frame_index(f)]], f) for f in frames]
    return tuple(belief.place(*pair) for pair in dict.fromkeys((*pairs, *calibration.wanted)))


def _open(calibration: Calibration) -> Array:
    """N, (k, n_parameters): open directions in the units of the parameters."""
    estimate = calibration.estimate
    D = estimate.variables.scale
    values, vectors = np.linalg.eigh(D[:, None] * estimate.data_information * D)
    return np.asarray(vectors[:, values < SAYS_LITTLE].T * D)


@dataclass(frozen=True)
class _Belief:
    """What is known, for one place after the other."""

    calibration: Calibration
    body: Body
    """As it is written."""
    open: Array

    def place(self, parent: str, frame: str) -> FramePlace:
        """The place of a frame, and where it is told if it is not told there."""
        found = self._at(parent, frame)
        if not found.untold:
            return found
        for other in self._beyond(parent, frame):
            there = self._at(other, frame)
            if not there.untold:
                return replace(found, told=there)
        return found

    def _at(self, parent: str, frame: str) -> FramePlace:
        estimate, body = self.calibration.estimate, self.body
        between = _joints_between(body, parent, frame)
        q = np.clip(np.zeros(len(body.joints)), body.lower, body.upper)
        J = relative_pose_derivatives(
            estimate.reference, estimate.variables, estimate.x, q, parent, frame
        ).by_parameter
        Sigma = J @ self.calibration.widened.covariance @ J.T
        spread = self.open @ J.T
        free = [bool(np.abs(part).max(initial=0.0) > 0) for part in (J[:3], J[3:])]
        bounds, told = [], []
        for part, asked in zip((slice(0, 3), slice(3, 6)), free, strict=True):
            size = np.trace(Sigma[part, part])
            told.append(not asked or float(np.sum(spread[:, part] ** 2)) <= OPEN * size)
            bounds.append(length_quantile([Sigma[part, part]], np.inf, 0.95) if asked else np.nan)
        sd = np.where(np.repeat(free, 3), np.sqrt(np.maximum(np.diag(Sigma), 0.0)), np.nan)
        return FramePlace(
            parent, frame, relative_pose(body, q, parent, frame), sd, bounds[0], bounds[1],
            untold="" if all(told) else self._why(frame, between),
            at={j: float(q[body.joint_index(j)]) for j in between},
        )  # fmt: skip

    def _why(self, frame: str, between: Sequence[str]) -> str:
        """What the place goes along with: the joints between that are open, or its partners."""
        variables, known = self.calibration.estimate.variables, self.calibration.identifiability
        group = dict(zip(variables.names, variables.groups, strict=True))
        mine = [name for name, of in group.items() if of == f"{PREFIX}{frame}"]
        with_ = dict.fromkeys(p for name in mine for p in known.partners(name) if p not in mine)
        shares = zip(variables.names, known.open_share, strict=True)
        hidden = [n for n, share in shares if share > OPEN and n.rpartition(".")[0] in between]
        of_joints = hidden or [name for name in with_ if group[name] in GROUPS]
        if of_joints:
            names = list(dict.fromkeys(name.rpartition(".")[0] for name in of_joints))
            what = "the zero" if all(n.endswith(".offset") for n in of_joints) else "the geometry"
            return f"moves along with {what} of {listed(names, NAMED)}"
        if with_:
            names = list(dict.fromkeys(name.rpartition(".")[0] for name in with_))
            return f"moves along with {listed(names, NAMED)}"
        return "the data say less of it than was believed before"

    def _beyond(self, parent: str, frame: str) -> Iterator[str]:
        """Frames from the parent's far side to what was seen of the frame, or saw it."""
        body = self.body
        for error in self.calibration.predicted:
            for one, other in ((error.seen_from, error.seen), (error.seen, error.seen_from)):
                way = _way(body, one, other)
                if frame in way:
                    later = way[way.index(frame) + 1 :]
                    yield from (name for name in later if name != parent)


def _way(body: Body, a: str, b: str) -> list[str]:
    """Frames from a to b through the tree, both included."""
    up, down = _chain(body, a), _chain(body, b)
    common = next(name for name in up if name in down)
    return [*up[: up.index(common) + 1], *reversed(down[: down.index(common)])]


def _chain(body: Body, frame: str) -> list[str]:
    """A frame and all that carry it, up to the root."""
    found, k = [frame], body.frame_index(frame)
    while k:
        k = int(body.parent[k])
        found.append(body.frames[k])
    return found


def _joints_between(body: Body, a: str, b: str) -> list[str]:
    """Names of the joints whose readings move b in a."""
    way = _way(body, a, b)
    top = min(way, key=body.frame_index)
    rows = [body.frame_index(name) for name in way if name != top]
    return list(dict.fromkeys(body.joints[body.driver[k]] for k in rows if body.driver[k] >= 0))
