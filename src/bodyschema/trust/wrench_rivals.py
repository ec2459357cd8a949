"""What else might explain a wrench that a load leaves over: families, each with its columns.

A rival adds Z gamma to the residuals, gamma of k numbers with one unknown size s, N(0, s^2 1). With
the load free beside it,

    K = Z^T (1 - A C A^T) Z = U diag(l) U^T,    b = U^T Z^T z,
    b_i^2 / l_i ~ v (1 + s^2 l_i) chi-square_1,  the rest of |z|^2 ~ v chi-square_nu

so s and the noise v are told by maximum likelihood (REML), and the gain against s = 0 weighs a
family by what it explains and by nothing else: columns that are not needed cost nothing (a score
test, Rao 1948; variance components, Patterson and Thompson 1971). Then gamma is as good as a
parameter with the prior s: what the load can hide of it is as large as what is seen of it, and
enters the error bars (`beside`).

    tilt       gravity points elsewhere: 2 slopes of the base (`wrench_gravity` for large ones)
    drift      the sensor's offset wanders: cosines over the recording, 1/j for the j-th
    jump       the offset is another one from a time on
    gains      each reading errs by shares of all six: 36
    loss       mass and first moments change evenly with time: a leak, a slow slip
    change     they are others from a time on
    lag        the wrench is late: its slope in time
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from bodyschema import lie
from bodyschema.learners.payload.recorded import LEVER
from bodyschema.senses.wrenches import load_regressor
from bodyschema.trust.wrench_rows import WrenchRows

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

WAVES = 6
"""Cosines of a drift: periods down to a third of the recording."""

USUAL = {
    "gains": 0.01, "tilt": 0.1, "drift": 1.0, "jump": 1.0, "loss": 0.1, "change": 0.3, "lag": 0.1,
}  # fmt: skip
"""Sizes s that are met: shares, rad, N, N, kg, kg and s. A family that must be ten times as large
to explain the wrench loses a hundred of its gain."""

GRAVITY = 9.81
"""m/s^2."""

TORQUE = 0.03
"""m: torque over force of a sensor's errors that are no share of the wrench."""

CUTS = 9
"""Times at which something may have changed."""

ROUNDS, FEWEST = 3, 4.0
"""Turns of noise and what is beside it, and the numbers that a component's noise is told from."""

SIZES = np.logspace(-2, 6, 49)
"""s^2 that are tried, over that which noise alone would show."""

UNSEEN = 1e-9
"""Share of a column below which the load takes up all of it."""

MASS = np.array([1.0, 0.05, 0.05, 0.05])
"""kg and kg m: mass and first moments that change together."""


@dataclass(frozen=True)
class WrenchRival:
    """A candidate of a family."""

    family: str
    Z: Array
    """(n, 6, k) effect on the residuals, N and Nm."""
    when: float = float("nan")
    """s, of what happens at a time."""

    def take(self, rows: Flags) -> WrenchRival:
        """The same on some of the means."""
        return replace(self, Z=self.Z[rows])


@dataclass(frozen=True)
class WeighedRival:
    """A rival beside the fit."""

    rival: WrenchRival
    gain: float
    """Twice the gain in log likelihood."""
    p_value: float
    """Chance of such a gain without it, for the best of its family."""
    share: float
    """Of the squared residuals that it explains."""
    size: float
    """s."""
    gamma: Array = field(repr=False)
    """(k,) expected."""
    spread: Array = field(repr=False)
    """(k, k) root of its covariance."""

    @property
    def family(self) -> str:
        """Of the rival."""
        return self.rival.family


def wrench_rivals(rows: WrenchRows, R_world: Array | None) -> list[WrenchRival]:
    """All candidates.

    Args:
        rows: of the fit, all means.
        R_world: (n, 3, 3) from the mount's axes to a world whose z points up; None if nobody
            knows: then gravity was measured, and cannot point elsewhere.
    """
    t, n = rows.smooth(), len(rows)
    own = np.tile(np.diag(np.repeat([1.0, TORQUE], 3)), (n, 1, 1))
    found = [WrenchRival("gains", _gains(rows))]
    loads = rows.Y[:, :, :4] * MASS
    if R_world is not None:
        found.append(WrenchRival("tilt", tilts(rows, R_world, np.zeros(2))))
    waves = [np.cos(j * np.pi * (t + 1) / 2)[:, None, None] * own / j for j in range(1, WAVES + 1)]
    found.append(WrenchRival("drift", np.concatenate(waves, axis=2)))
    found.append(WrenchRival("loss", t[:, None, None] * loads))
    lag = _slope(rows)
    if lag is not None:
        found.append(WrenchRival("lag", lag))
    for cut in np.linspace(0, n, CUTS + 2)[1:-1].astype(int):
        after = (rows.time >= rows.time[cut])[:, None, None]
        when = float(rows.time[cut])
        found.append(WrenchRival("jump", after * own, when))
        found.append(WrenchRival("change", after * loads, when))
    return found


def noise_beside(rivals: Sequence[WrenchRival], rows: WrenchRows) -> Array:
    """(6,) N and Nm: noise of each component beside all that might be wrong at once.

    Under an error that is no noise the levels of a fit are those of the error, in the components
    that it enters. Where there are too few rows to tell, they stay.
    """
    wide = [r.Z * USUAL[r.family] for r in rivals if np.isnan(r.when)]
    Z, sigma = np.concatenate(wide, axis=2), rows.sigma
    n, p, k = len(rows), rows.A.shape[2], Z.shape[2]
    for _ in range(ROUNDS):
        told = rows.told_in(sigma)
        A = np.concatenate([told.A, Z / sigma[:, None]], axis=2).reshape(6 * n, p + k)
        A = np.vstack([A, np.diag(np.sqrt(np.append(rows.precision, np.ones(k))))])
        Q = np.linalg.qr(A / np.linalg.norm(A, axis=0))[0][: 6 * n]
        left = told.z - (Q @ (Q.T @ told.z.ravel())).reshape(n, 6)
        freedom = n - np.sum(Q.reshape(n, 6, -1) ** 2, axis=(0, 2))
        if freedom.min() < FEWEST:
            return rows.sigma
        sigma = sigma * np.sqrt(np.sum(left**2, axis=0) / freedom)
    return np.asarray(sigma)


def weighed(rivals: Sequence[WrenchRival], rows: WrenchRows) -> list[WeighedRival]:
    """All that can be seen beside the fit, the best of each family, most likely first."""
    best = dict[str, WeighedRival]()
    counts = {r.family: sum(o.family == r.family for o in rivals) for r in rivals}
    for rival in rivals:
        one = _weigh(rival, rows, counts[rival.family])
        if one is not None and one.gain > best.get(rival.family, one).gain - 1e-12:
            best[rival.family] = one
    return sorted(best.values(), key=lambda one: -one.gain)


def _weigh(rival: WrenchRival, rows: WrenchRows, candidates: int) -> WeighedRival | None:
    Z = rows.left_of(rival.Z / rows.sigma[:, None])
    values, U = np.linalg.eigh(Z.T @ Z)
    b = U.T @ (Z.T @ rows.left_of(rows.z[:, :, None])[:, 0])
    return _most_likely(rival, rows, candidates, values, U, b, None)


def weighed_anew(
    rival: WrenchRival, gamma: Array, there: WrenchRows, rows: WrenchRows
) -> WeighedRival | None:
    """A rival whose effect is not linear in gamma, by what is left where it takes gamma.

    Args:
        rival: its effect there.
        gamma: (k,) its best value.
        there: the rows under it, in the same noise.
        rows: without it.
    """
    Z = there.left_of(rival.Z / there.sigma[:, None])
    values, U = np.linalg.eigh(Z.T @ Z)
    return _most_likely(rival, rows, 1, values, U, values * (U.T @ gamma), there.squared)


def _most_likely(
    rival: WrenchRival,
    rows: WrenchRows,
    candidates: int,
    values: Array,
    U: Array,
    b: Array,
    rest: float | None,
) -> WeighedRival | None:
    """The size s and the noise v of the module's text; rest is |z|^2 less all that it explains."""
    seen = values > UNSEEN * max(float(np.sum((rival.Z / rows.sigma[:, None]) ** 2)), 1e-300)
    k, left = int(seen.sum()), rows.freedom
    if not k or left <= k + 1:
        return None
    b, told = b[seen], values[seen]
    squares = b**2 / told
    rest = rows.squared - float(squares.sum()) if rest is None else rest
    rest = max(rest, 1e-12 * rows.squared)
    tried = SIZES / float(told.max())
    grown = 1 + tried[:, None] * told
    v = (np.sum(squares / grown, axis=1) + rest) / left
    gains = -(left * np.log(v / (rows.squared / left)) + np.log(grown).sum(axis=1))
    gains -= tried * v / USUAL[rival.family] ** 2
    at = int(np.argmax(gains))
    gain, s2 = max(float(gains[at]), 0.0), float(tried[at])
    gamma = U[:, seen] @ (s2 * b / grown[at])
    # What nothing is seen of is as large as the rest may be.
    open_ = np.where(seen, s2 * v[at] / (1 + s2 * np.maximum(values, 0.0)), s2 * v[at])
    share = 1 - float(v[at]) * left / rows.squared
    p = 0.5 * float(erfc(np.sqrt(gain / 2))) * candidates
    size = float(np.sqrt(s2 * v[at]))
    return WeighedRival(rival, gain, min(p, 1.0), share, size, gamma, U * np.sqrt(open_))


def freed(rows: WrenchRows, one: WeighedRival) -> WrenchRows:
    """The rows with a rival's k numbers free beside the p of theta, in the same units."""
    Z = one.rival.Z / rows.sigma[:, None]
    prior = np.concatenate([rows.precision, np.full(Z.shape[2], one.size**-2.0)])
    return replace(rows, A=np.concatenate([rows.A, Z], axis=2), precision=prior)


def beside(rows: WrenchRows, one: WeighedRival) -> WrenchRows:
    """The same, where the rival has taken its share of the residuals."""
    Z = one.rival.Z / rows.sigma[:, None]
    return replace(freed(rows, one), z=rows.z - Z @ one.gamma - rows.A @ step_of(rows, one))


def as_free(one: WeighedRival, rows: WrenchRows) -> WeighedRival:
    """The same with the spread that numbers of its size have beside the load on these rows."""
    Z = rows.left_of(one.rival.Z / rows.sigma[:, None])
    values, U = np.linalg.eigh(Z.T @ Z)
    told = np.maximum(values, 0.0) * rows.freedom / rows.squared
    return replace(one, spread=U / np.sqrt(told + one.size**-2.0))


def step_of(rows: WrenchRows, one: WeighedRival) -> Array:
    """(p,) by how much theta moves when a rival takes its share of the residuals."""
    effect = rows.z - one.rival.Z @ one.gamma / rows.sigma
    return np.asarray(rows.root @ np.einsum("nip,ni->p", rows.B, effect))


def moved(rows: WrenchRows, one: WeighedRival) -> tuple[Array, Array]:
    """By how much a rival, if true, has moved theta: the step (p,), and its spread (p, k)."""
    M = -rows.root @ np.einsum("nip,nik->pk", rows.B, one.rival.Z / rows.sigma[:, None])
    return M @ one.gamma, M @ one.spread


def _gains(rows: WrenchRows) -> Array:
    """(n, 6, 36) each reading's share in each other, of sizes that belong together.

    Of the wrench that the load makes: shares of what was read would explain the noise in it too,
    and, at one each, all of it.
    """
    y = np.einsum("nij,nj->ni", rows.Y, rows.carried)
    force = float(np.sqrt(np.mean(y[:, :3] ** 2)))
    torque = max(float(np.sqrt(np.mean(y[:, 3:] ** 2))), LEVER * force)
    size = np.repeat([force, torque], 3)
    Z = np.zeros((len(y), 6, 36))
    for i in range(6):
        Z[:, i, 6 * i : 6 * i + 6] = y * size[i] / size
    return Z


def way_down(gamma: Array) -> Array:
    """(3,) the unit vector down, where a base leans by slopes gamma (2,) towards x and y."""
    way = np.array([gamma[0], gamma[1], -1.0])
    return np.asarray(way / np.linalg.norm(way))


def tilts(rows: WrenchRows, R_world: Array, gamma: Array) -> Array:
    """(n, 6, 2) what a change of each slope of the base does where they are gamma (2,)."""
    still, columns, down = np.zeros((len(rows), 3)), [], way_down(gamma)
    for axis in np.eye(3)[:2]:
        # d (w / |w|) = (1 - d d^T) dw / |w| with w = (gamma, -1), d = w / |w|.
        change = (axis - down * (down @ axis)) * -down[2]
        g = GRAVITY * np.einsum("nji,j->ni", R_world, change)
        Y = load_regressor(-g, still, still)
        columns.append(np.einsum("nij,nj->ni", Y, rows.carried))
    return np.stack(columns, axis=2)


def _slope(rows: WrenchRows) -> Array | None:
    """(n, 6, 1) the wrench's change a second; None where nothing moves between neighbours."""
    out = np.zeros((len(rows), 6))
    for k in np.unique(rows.part):
        at = np.flatnonzero(rows.part == k)
        t = rows.time[at]
        if len(at) < 3 or np.any(np.diff(t) <= 0):
            return None
        out[at] = np.gradient(rows.wrench[at], t, axis=0)
    return out[:, :, None]


def upright(down: Array) -> Array:
    """(3, 3) to axes whose z points up, from those in which gravity (3,) is `down`."""
    up = -np.asarray(down, dtype=np.float64) / np.linalg.norm(down)
    return np.vstack([lie.tangent_basis(up).T, up])
