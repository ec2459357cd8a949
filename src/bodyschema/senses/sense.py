"""Sense: what was observed of the body, and what a body model predicts of it.

A `Sense` is a frozen batch of samples of one kind; one sample is a batch of one. What a kind has to
bring is `measures`, the parts of one observation with their units, and

    predict(body) -> (n, ...)         what a body would show at the batch's joint readings

All else follows, and may be brought where it can be done better: `residual` (observed minus
predicted), `linearize` (by central differences until somebody writes the derivative), `imagined`,
and a closed-form `start` for frames that nobody knows. A whole sense of one's own:

    @dataclass(frozen=True)
    class WireLengths(Sense):
        measures = (("length", "m", 1),)

        def predict(self, body):
            T = relative_pose(body, self.readings(body), self.seen_from, self.seen)
            return np.linalg.norm(T[:, :3, 3], axis=1)
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import accumulate, pairwise
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Measure = tuple[str, str, int]
"""Name, unit and count of the numbers that share one noise level."""

PLACEMENT = ("link_x", "link_y", "link_z", "turn_x", "turn_y", "turn_z")
"""The variables of a frame that hangs on its parent by a fixed joint."""

DIFFERENCE = 1e-5
"""Step of differences, in units of a variable's prior: truncation and rounding balance there."""


@dataclass(frozen=True)
class Linearized:
    """A residual and its derivatives at one vector of variables."""

    residual: Array
    """(n, dimension) seen minus predicted."""
    by_parameter: Array
    """(n, dimension, n_parameters) derivative of the residual."""
    by_joint: Array
    """(n, dimension, n_joints) derivative of the residual with respect to the readings q."""


@dataclass(frozen=True)
class Sense:
    """Samples of one kind: frame `seen`, looked at (touched, felt) from frame `seen_from`."""

    time: Array
    """(n,) s; rows of one moment share it."""
    q: Array
    """(n, n_joints) encoder readings in the order of `body.joints`."""
    seen_from: str
    seen: str
    covariance: Array
    """(dimension, dimension) believed noise; only its shape counts unless it is `stated`."""
    rows: Ints
    """(n,) row of each sample in its recording, for messages."""
    observed: Array = field(default_factory=lambda: np.empty(0))
    """(n, ...) what was seen, in the form that `predict` returns."""
    stated: bool = field(default=False, kw_only=True)
    """Whether the noise is known: then what exceeds it is error of the model, never noise."""
    clock: str = field(default="", kw_only=True)
    """The body's part that says how late the time stamps are; "" if they are right."""
    rate: Array | None = field(default=None, kw_only=True)
    """(n, n_joints) dq/dt at each sample; needed with a clock."""

    measures: ClassVar[tuple[Measure, ...]] = ()
    shared: ClassVar[tuple[str, ...]] = ()
    """Names of further fields that hold one array for all samples."""

    def __post_init__(self) -> None:
        check_samples(self, self.observed)

    @classmethod
    def make(
        cls,
        q: ArrayLike,
        observed: ArrayLike,
        seen_from: str,
        seen: str,
        std: float | Sequence[float],
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            observed: (n, ...) what was seen.
            seen_from: frame that looks.
            seen: frame that is looked at.
            std: noise of every number, or one for each measure, in its unit.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: fields of the kind.
        """
        readings, times, numbers = counted(q, time, rows)
        counts = [count for _, _, count in cls.measures]
        sizes = np.repeat(np.broadcast_to(np.asarray(std, dtype=np.float64), len(counts)), counts)
        return cls(
            time=times,
            q=readings,
            seen_from=seen_from,
            seen=seen,
            covariance=np.diag(sizes**2),
            rows=numbers,
            observed=np.asarray(observed, dtype=np.float64),
            **more,
        )

    def __len__(self) -> int:
        return len(self.time)

    @property
    def label(self) -> str:
        """Name for messages and reports; no two senses of a problem share one."""
        names = " and ".join(name for name, _, _ in self.measures)
        return f"{names} of {self.seen} from {self.seen_from}"

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        """(name, unit, rows of the residual) of each part that has a noise level of its own."""
        ends = accumulate((count for _, _, count in self.measures), initial=0)
        spans = zip(self.measures, pairwise(ends), strict=True)
        return tuple((name, unit, slice(a, b)) for (name, unit, _), (a, b) in spans)

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Frames whose relative poses the prediction depends on, (looks, is looked at)."""
        return ((self.seen_from, self.seen),)

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Components of the placements of `seen_from` and of `seen` that can be seen at all."""
        return PLACEMENT, PLACEMENT

    def readings(self, body: Body) -> Array:
        """(n, n_joints) encoder readings at the moments when the samples were really taken.

        To first order in the lag of the clock: q - lag dq/dt.
        """
        if not self.clock or self.rate is None:
            return self.q
        return np.asarray(self.q - body.part(self.clock)["lag"] * self.rate)

    def predict(self, body: Body) -> Array:
        """What a body would show, in the form of `observed`."""
        raise NotImplementedError

    def residual(self, body: Body) -> Array:
        """Seen minus predicted, (n, dimension)."""
        n = len(self)
        return np.asarray((self.observed - self.predict(body)).reshape(n, len(self.covariance)))

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """Residual and derivatives for the body that deviates from the reference by x.

        By central differences; a kind that knows its derivatives overrides this.
        """
        body = reference.with_variables(variables, x)
        steps = DIFFERENCE * variables.scale
        columns = []
        for i, step in enumerate(steps):
            moved = [x + sign * step * (np.arange(len(x)) == i) for sign in (1, -1)]
            there = [self.residual(reference.with_variables(variables, y)) for y in moved]
            columns.append((there[0] - there[1]) / (2 * step))
        by_joint = []
        for j in range(self.q.shape[1]):
            step = DIFFERENCE * (np.arange(self.q.shape[1]) == j)
            there = [replace(self, q=self.q + sign * step).residual(body) for sign in (1, -1)]
            by_joint.append((there[0] - there[1]) / (2 * DIFFERENCE))
        shape = (len(self), len(self.covariance))
        empty = np.empty((*shape, 0))
        return Linearized(
            self.residual(body),
            np.stack(columns, axis=2) if columns else empty,
            np.stack(by_joint, axis=2) if by_joint else empty,
        )

    def late(self, linear: Linearized, variables: Variables) -> Linearized:
        """The derivatives with that by the clock's lag filled in, -dr/dq dq/dt."""
        columns, _ = variables.of_part(self.clock)
        if len(columns) and self.rate is not None:
            slope = -np.einsum("ndj,nj->nd", linear.by_joint, self.rate)
            linear.by_parameter[:, :, columns] = slope[:, :, None]
        return linear

    def imagined(self, body: Body, q: ArrayLike) -> Self:
        """What this sense would see of a body without noise at postures q, (n, n_joints).

        What else belongs to a sample (a point that is touched, a corner of a board) is taken from
        this batch's samples in turn.
        """
        postures = np.asarray(q, dtype=np.float64)
        count = np.arange(len(postures))
        blank = self.take(count % len(self)) if len(self) else self._nothing(len(count))
        still = None if self.rate is None else np.zeros_like(postures)
        there = replace(blank, time=count.astype(np.float64), q=postures, rows=count, rate=still)
        return replace(there, observed=there.predict(body))

    def pictured(self, body: Body, q: ArrayLike) -> Self:
        """The same with all that one posture shows: of a board every corner, not one in turn.

        Rows count the postures from 0; kinds that see one thing a posture have nothing to add.
        """
        return self.imagined(body, q)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """The body with those of the unknown frames placed that this sense ends in.

        None where the kind has no closed form of its own; see `seeds.starts`.
        """
        return None

    def associate(self, body: Body) -> Self:
        """The samples with their correspondences chosen anew round a body.

        Only outlines and corners have any to choose; called between solves until nothing changes.
        """
        return self

    def kept(self, body: Body) -> Self:
        """The samples with the correspondences that a body shows, not to be chosen again.

        So that the same samples can be predicted by several fits and compared.
        """
        return self

    def sections(self, evidence: Any) -> Sequence[Any]:
        """Sections of its own for the report; none where a kind has nothing to add.

        Args:
            evidence: what all sections are drawn from, see `report.evidence`.

        Returns:
            Anything with a `title` and `render()`, its HTML; see `report.section`.
        """
        return ()

    def take(self, rows: Sequence[int] | NDArray[Any]) -> Self:
        """Some of the samples, by index or mask."""
        chosen: dict[str, Any] = {name: getattr(self, name)[rows] for name in self.arrays}
        return replace(self, **chosen)

    @property
    def arrays(self) -> tuple[str, ...]:
        """Names of the fields that have one row a sample."""
        shared = ("covariance", *self.shared)
        named = (entry.name for entry in fields(self) if entry.name not in shared)
        return tuple(name for name in named if isinstance(getattr(self, name), np.ndarray))

    def _nothing(self, n: int) -> Self:
        """n samples of a batch that has none to take from."""
        return replace(self, **self._zeros(n))

    def _zeros(self, n: int) -> dict[str, Any]:
        return {name: np.zeros((n, *getattr(self, name).shape[1:])) for name in self.arrays}


def concatenate(parts: Sequence[Sense]) -> Sense:
    """One batch of several batches of the same sense, seen from and of the same frames.

    Raises:
        InputError: they differ in sense or frames.
    """
    first = parts[0]
    for part in parts[1:]:
        if (type(part), part.label) != (type(first), first.label):
            raise InputError(
                f"{type(part).__name__} of {part.label} and {type(first).__name__} of "
                f"{first.label} are not one batch; keep them apart."
            )
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in first.arrays
    }
    return replace(first, **joined)


def counted(
    q: ArrayLike, time: ArrayLike | None, rows: ArrayLike | None
) -> tuple[Array, Array, Ints]:
    """Readings (n, n_joints), times and row numbers (n,); the latter count from 0 when None."""
    readings = np.atleast_2d(np.asarray(q, dtype=np.float64))
    count = np.arange(len(readings))
    return (
        readings,
        np.asarray(count if time is None else time, dtype=np.float64),
        np.asarray(count if rows is None else rows, dtype=np.int64),
    )


def check_samples(sense: Sense, seen: Array, shape: tuple[int, ...] | None = None) -> None:
    """Refuse arrays that do not belong together or are not finite.

    Args:
        sense: whose arrays.
        seen: (n, *shape).
        shape: of one sample; any when None.

    Raises:
        InputError: wrong shape, a value that is not finite, with the row, or a clock without rate.
    """
    n = len(sense.time)
    expected_seen = (n, *(seen.shape[1:] if shape is None else shape))
    parts = {"time": (sense.time, (n,)), "q": (sense.q, (n, -1)), "seen": (seen, expected_seen)}
    if sense.rate is not None:
        parts["rate"] = (sense.rate, sense.q.shape)
    elif sense.clock:
        raise InputError(
            f"{sense.label}: its clock '{sense.clock}' may be late, so its samples need the speeds "
            "of the joints too: give rate (n, n_joints), dq/dt."
        )
    for name, (array, expected) in parts.items():
        fits = array.ndim == len(expected) and all(
            want in (-1, have) for want, have in zip(expected, array.shape, strict=True)
        )
        if not fits:
            raise InputError(
                f"{sense.label}: {name} should have shape {expected}, it has {array.shape}."
            )
        bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
        if bad.any():
            row = sense.rows[np.flatnonzero(bad)[0]]
            raise InputError(
                f"{sense.label}: {name} is not a finite number in row {row}; "
                f"drop the {int(bad.sum())} bad rows or repair them."
            )
