"""The place of a contact: where lines of force meet, or where they enter the object.

A force f at the point r turns about the sensor's origin by tau = r x f, so for every wrench of the
touch (Eq. 37 of Nabeshima and Kuniyoshi has the same rows for the centre of mass)

    e = tau + [f]x r = 0,      cov(e) = B C B^T,   B = (-[r]x, 1),   C the wrench's covariance

and with W = cov(e)^-1 the squared error q(r) = sum e^T W e is a quadratic in r,

    H = sum [f]x^T W [f]x,     H r* = -sum [f]x^T W tau.

One force alone leaves the line r* + s u open, H u = 0: its line of action (f x tau / |f|^2 is its
nearest point to the origin). The surface of the object closes it: the point is where the line
enters through a face that the force presses on. If it enters several times each entry is a
hypothesis, with the chance exp(-q/2) among them and the first along the force among equals. Forces
of several directions make H regular, which tells the entries apart, or the point without a shape.

On a surface with the tangents T the point's covariance is T (T^T H T)^-1 T^T. If the surface
itself may be off by s in every direction, forces that meet tell where it is as well: with the
normal n at p, where the line enters, r is the place, C its covariance, and q' the misfit:

    C = (H + n n^T / s^2)^-1,    r = C (H r* + n n^T p / s^2),
    q'(p)  = q(r*) + (q(p) - q(r*)) d^T (H^-1 + s^2 1)^-1 d / d^T H d,      d = p - r*

The rows hold one number more than the two of a place on a surface: the couple along the force. No
force at one point makes it, so q, which is chi-square with 3 K - 2 degrees of freedom for K
wrenches, tells a point from a contact that twists, spreads or slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.touch.evidence import Principal
from bodyschema.model.solid import Solid

Array = NDArray[np.float64]

ROUNDS = 2
"""The weights depend on the place, which depends on the weights."""

ANYWHERE = 1.0
"""m, how far from the sensor a contact may be when no shape is known."""

SURE = 10.0
"""Times what noise in the forces pretends to know, above which knowledge along the line counts."""

EQUAL = 9.0
"""Of entries whose q differs by less the first one counts: things touch from outside."""


@dataclass(frozen=True)
class Place:
    """One place at which the contact may be."""

    point: Array
    """(3,) m, in the sensor's frame."""
    covariance: Array
    """(3, 3) m^2; flat along the normal where there is a surface."""
    normal: Array | None
    """(3,) unit, outward; None without a surface."""
    misfit: float
    """q."""
    chance: float
    """Among the places of one touch."""


class Located(NamedTuple):
    """The places of a touch, the one that is believed first."""

    places: tuple[Place, ...]
    inside: bool
    """False when the line misses the surface: the place is the nearest one."""
    freedom: int
    """Degrees of freedom of q."""
    misfit: float
    """Smallest q of any point, on the surface or not."""
    pitch: float
    """m, couple along the force over the force."""
    pitch_std: float
    """m."""


class Quadratic(NamedTuple):
    """q near a point."""

    H: Array
    """(3, 3)."""
    best: Array
    """(3,) r*, held within reach along what is open."""
    along: Array
    """(3,) u, the direction that is known least."""
    known: int
    """Directions that are known."""


def locate(found: Principal, push: Array, solid: Solid | None, doubt: float = 0.0) -> Located:
    """The places of a contact.

    Args:
        found: its wrenches, of which the strongest counts most.
        push: (3,) N, roughly: it orients the line.
        solid: the object's shape in the sensor's frame; None if unknown.
        doubt: m, s: one standard deviation that its surface may be off.
    """
    strongest = _strongest(found)
    f = found.wrenches[strongest, :3]
    F = f * (1.0 if f @ push >= 0 else -1.0)
    centre, reach = (np.zeros(3), ANYWHERE) if solid is None else (solid.centre, solid.radius)
    near = centre
    for _ in range(ROUNDS):
        q = quadratic(found, near, centre, reach)
        u = q.along if q.along @ F >= 0 else -q.along
        met = None if solid is None else solid.pressed(F, q.best, u)
        if met is None or not len(met.points):
            points, normals = q.best[None], [None]
        else:
            points, normals = met.points, list(met.normals)
        scores = np.array([_excused(found, q, point, doubt) for point in points])
        order = _believed(scores)
        near = points[order[0]]
    chances = np.exp(-(scores - scores.min()) / 2)
    chances /= chances.sum()
    places = tuple(
        Place(*_placed(q, points[i], normals[i], doubt), normals[i], scores[i], chances[i])
        for i in order
    )
    inside = solid is None or (met is not None and met.inside)
    known = q.known if solid is None else 2
    pitch = twist(found.wrenches[strongest], found.covariances[strongest], near)
    rest = min(misfit(found, q.best), float(scores.min()))
    return Located(places, inside, 3 * len(found.wrenches) - known, rest, *pitch)


def quadratic(found: Principal, near: Array, centre: Array, reach: float) -> Quadratic:
    """q about a point.

    Args:
        found: the wrenches.
        near: (3,) m, where the weights are taken.
        centre: (3,) m, of what is within reach.
        reach: m, where the point may be along what the wrenches leave open.
    """
    H, g, pretended = np.zeros((3, 3)), np.zeros(3), np.zeros((3, 3))
    B = to_moment(near)
    turns = lie.skew(np.eye(3))  # [f]x r = -sum r_i [e_i]x f
    for w, C in zip(found.wrenches, found.covariances, strict=True):
        A, W = lie.skew(w[:3]), np.linalg.inv(B @ C @ B.T)
        H += A.T @ W @ A
        g -= A.T @ W @ w[3:]
        pretended += np.einsum("iab,ac,jcd,bd->ij", turns, W, turns, C[:3, :3])
    values, axes = np.linalg.eigh(H)
    known = values > SURE * np.einsum("ij,ik,kj->j", axes, pretended, axes) + 1 / reach**2
    held = np.where(known, values, 1 / reach**2)
    pull = np.where(known, axes.T @ g, axes.T @ centre / reach**2)
    return Quadratic((axes * held) @ axes.T, axes @ (pull / held), axes[:, 0], int(known.sum()))


def misfit(found: Principal, point: Array) -> float:
    """q of a point, with the weights of that point."""
    total, B = 0.0, to_moment(point)
    for w, C in zip(found.wrenches, found.covariances, strict=True):
        e = B @ w
        total += float(e @ np.linalg.solve(B @ C @ B.T, e))
    return total


def to_moment(point: Array) -> Array:
    """B (3, 6) of the module's text: from a wrench about the origin to its torque about a point."""
    x, y, z = point
    return np.array([[0, z, -y, 1, 0, 0], [-z, 0, x, 0, 1, 0], [y, -x, 0, 0, 0, 1]])


def twist(wrench: Array, C: Array, point: Array) -> tuple[float, float]:
    """The couple along the force over the force, m, and its standard deviation."""
    size = float(np.linalg.norm(wrench[:3]))
    along = wrench[:3] / size
    B = to_moment(point)
    std = np.sqrt(along @ (B @ C @ B.T) @ along)
    return float(along @ wrench[3:]) / size, float(std) / size


def _strongest(found: Principal) -> int:
    """The wrench whose force is clearest."""
    clear = [
        w[:3] @ np.linalg.solve(C[:3, :3], w[:3])
        for w, C in zip(found.wrenches, found.covariances, strict=True)
    ]
    return int(np.argmax(clear))


def _believed(scores: Array) -> list[int]:
    """All places: the first along the force that is as good as the best, then by q."""
    first = int(np.flatnonzero(scores <= scores.min() + EQUAL)[0])
    return [first, *(int(i) for i in np.argsort(scores, kind="stable") if i != first)]


def _excused(found: Principal, q: Quadratic, point: Array, doubt: float) -> float:
    """q' of a point on a surface that may be off."""
    whole, d = misfit(found, point), point - q.best
    beside = float(d @ q.H @ d)
    if not doubt or beside <= 0:
        return whole
    share = float(d @ np.linalg.solve(np.linalg.inv(q.H) + doubt**2 * np.eye(3), d)) / beside
    least = misfit(found, q.best)
    return least + (whole - least) * share if whole > least else whole


def _placed(q: Quadratic, point: Array, normal: Array | None, doubt: float) -> tuple[Array, Array]:
    """r (3,) and its covariance (3, 3), from a point on the surface."""
    if normal is None:
        return point, np.asarray(np.linalg.inv(q.H))
    if doubt:
        held = np.outer(normal, normal) / doubt**2
        C = np.asarray(np.linalg.inv(q.H + held))
        return C @ (q.H @ q.best + held @ point), C
    T = lie.tangent_basis(normal)
    return point, np.asarray(T @ np.linalg.solve(T.T @ q.H @ T, T.T))
