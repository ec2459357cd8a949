"""What holds for every body, looked at before compiled loops follow its indices.

A body that a reader of ours made is right by construction; one that was read from a result folder
may say anything, and a loop that goes to frame 10^9 ends the process.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.kernels import AXIS, FIXED, GEAR, LINK, OFFSET, PART, PRISMATIC, TURN

if TYPE_CHECKING:
    from bodyschema.model.tree import Body, Visual
    from bodyschema.model.variables import Variables

LARGEST = 1e6
"""m or rad: what a robot has more of is a mistake, or a word for "without end"."""

ROUNDING = 1e-6
"""By which an axis may miss its length of 1, and a rotation its right angles."""

COMPONENTS = {OFFSET: 1, GEAR: 1, AXIS: 2, LINK: 3, TURN: 3}
"""How many components each kind of variable has, see `variables`."""

SIZES = {"mesh": 3, "box": 3, "cylinder": 2, "sphere": 1}
"""How many numbers each visible shape has."""


def span(limits: tuple[float, float]) -> tuple[float, float]:
    """Limits of a joint; those that nothing reaches stand for none."""
    low, high = limits
    return (low if low > -LARGEST else -np.inf, high if high < LARGEST else np.inf)


def refuse_large(name: str, placement: ArrayLike, mimics: Sequence[tuple[float, ...]]) -> None:
    """Refuse lengths whose squares would be no numbers any more. Raises InputError."""
    for what, values in (("the place of a joint", placement), ("a mimic", mimics)):
        if not (np.abs(np.asarray(values, dtype=np.float64)) < LARGEST).all():
            raise InputError(f"{what} of '{name}' has a number of {LARGEST:.0e} or more.")


def array_of(array: NDArray[Any], shape: tuple[int, ...], what: str, endless: bool = False) -> None:
    """Refuse an array of another shape, or with numbers that are none.

    Args:
        array: any.
        shape: that it must have.
        what: it is, for the message.
        endless: infinity is a number here.

    Raises:
        InputError: in one sentence.
    """
    if array.shape != shape:
        raise InputError(f"{what} has the shape {array.shape}, expected {shape}.")
    good = ~np.isnan(array) if endless else np.isfinite(array)
    if not good.all():
        raise InputError(f"{what} holds numbers that are not finite.")


def check_body(body: Body, where: str) -> None:
    """Refuse a body whose arrays do not fit each other.

    Args:
        body: as read.
        where: names it in messages.

    Raises:
        InputError: the first thing that does not fit.
    """
    n, count = len(body.frames), len(body.joints)
    for names, what in ((body.frames, "frames"), (body.joints, "joints")):
        if len({*names}) != len(names):
            raise InputError(f"{where} has two {what} of one name.")
    if not n or len(body.carriers) != n:
        raise InputError(f"{where} has {n} frames and {len(body.carriers)} names of carriers.")
    for what in ("parent", "kind", "driver", "rate", "shift"):
        array_of(getattr(body, what), (n,), f"{where}.{what}")
    for what in ("gear", "offset"):
        array_of(getattr(body, what), (count,), f"{where}.{what}")
    for what in ("lower", "upper"):
        array_of(getattr(body, what), (count,), f"{where}.{what}", endless=True)
    array_of(body.axis, (n, 3), f"{where}.axis")
    array_of(body.placement, (n, 4, 4), f"{where}.placement")
    _check_indices(body, where)
    _check_geometry(body, where)
    for visual in body.visuals:
        _check_visual(visual, body, where)


def _check_indices(body: Body, where: str) -> None:
    """What the compiled loops follow."""
    n, count = len(body.frames), len(body.joints)
    if (
        body.parent[0] != -1
        or not ((body.parent[1:] >= 0) & (body.parent[1:] < np.arange(1, n))).all()
    ):
        raise InputError(f"{where}.parent: parents come before children, the first has none (-1).")
    if not np.isin(body.kind, (FIXED, 1, PRISMATIC)).all():
        raise InputError(f"{where}.kind: every joint is fixed (0), revolute (1) or prismatic (2).")
    moves = body.kind != FIXED
    if not ((body.driver >= -1) & (body.driver < count)).all() or (body.driver[moves] < 0).any():
        raise InputError(f"{where}.driver: frames that move are driven by joint 0 to {count - 1}.")
    if not {*range(count)} <= {*body.driver.tolist()}:
        raise InputError(f"{where}.driver: every joint must move a frame.")


def _check_geometry(body: Body, where: str) -> None:
    """Axes of length 1 and rotations that are some."""
    refuse_large(where, body.placement[:, :3], list(zip(body.rate, body.shift, strict=True)))
    axes = body.axis[body.kind != FIXED]
    if not (np.abs(np.linalg.norm(axes, axis=1) - 1) < ROUNDING).all():
        raise InputError(f"{where}.axis: axes of joints must have length 1.")
    refuse_bent(body.placement, f"{where}.placement")


def refuse_bent(T: NDArray[np.float64], what: str) -> None:
    """Refuse transforms (n, 4, 4) that are not rigid. Raises InputError."""
    R = T[:, :3, :3]
    if not (np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)) < ROUNDING).all():
        raise InputError(f"{what}: rotations must be orthonormal.")
    if not (T[:, 3] == (0.0, 0.0, 0.0, 1.0)).all():
        raise InputError(f"{what}: the last row of a transform is 0 0 0 1.")


def _check_visual(visual: Visual, body: Body, where: str) -> None:
    if visual.frame not in body.frames or visual.shape not in SIZES:
        raise InputError(f"{where}.visuals: no {visual.shape!r:.40} on '{visual.frame:.40}'.")
    if len(visual.size) != SIZES[visual.shape] or not np.isfinite(visual.size).all():
        raise InputError(f"{where}.visuals: a {visual.shape} has {SIZES[visual.shape]} sizes.")
    array_of(visual.placement, (4, 4), f"{where}.visuals")
    refuse_bent(visual.placement[None], f"{where}.visuals")


def check_variables(variables: Variables, body: Body, where: str) -> None:
    """Refuse variables that name joints, frames or numbers that the body does not have.

    Args:
        variables: as read.
        body: that they are of; checked before.
        where: names them in messages.

    Raises:
        InputError: the first thing that does not fit.
    """
    n = len(variables.names)
    if len({*variables.names}) != n or not n == len(variables.groups) == len(variables.units):
        raise InputError(f"{where}: every variable has a name of its own, a group and a unit.")
    for what in ("code", "index", "component"):
        array_of(getattr(variables, what), (n,), f"{where}.{what}")
    for what in ("prior_std", "bound"):
        values = getattr(variables, what)
        array_of(values, (n,), f"{where}.{what}", endless=True)
        if not (values > 0).all():
            raise InputError(f"{where}.{what} must be above 0.")
    rows = zip(
        variables.names, variables.groups, variables.code, variables.index, variables.component,
        strict=True,
    )  # fmt: skip
    for name, group, code, index, component in rows:
        if not _fits(group, int(code), int(index), int(component), body):
            raise InputError(f"{where}: '{name:.60}' is of nothing that '{body.name:.60}' has.")


def _fits(group: str, code: int, index: int, component: int, body: Body) -> bool:
    """Whether a variable names something of the body."""
    if code == PART:
        part = group.partition(":")[2]
        return part in body.parts and 0 <= component < len(body.parts[part].names)
    if code not in COMPONENTS or not 0 <= component < COMPONENTS[code]:
        return False
    count = len(body.joints) if code in (OFFSET, GEAR) else len(body.frames)
    return 0 <= index < count
