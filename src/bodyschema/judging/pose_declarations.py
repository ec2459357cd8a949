"""Whether poses of a hand and of what an eye saw were recorded as they are said to be.

Pairs that hardly agree are solved again as they would be if one list were inverted, had its
quaternions in the other order, or were in mm instead of m. A way that explains them far better is
named; if there is none, and no place of hand and eye explains them, that is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.full_poses import HandEye, solve_hand_eye

Array = NDArray[np.float64]
Whose = Literal["robot", "eye"]
Rival = tuple[str, Whose, Callable[[Array], Array]]
"""How poses may have been recorded: in words, whose poses, and what then has to be done to them."""

QUATERNIONS = {"xyz_xyzw": "xyz_wxyz", "xyz_wxyz": "xyz_xyzw"}
"""Layouts that are taken for each other."""

PLAUSIBLE = (0.02, 0.05)
"""Noise of good pairs that needs no other explanation: share of the hand's travel, and rad."""

USELESS = (0.2, 0.35)
"""The same beyond which no place of hand and eye explains the poses."""

BETTER = 1 / 3
"""A rival explains the poses when its noise is at most this share of theirs."""

TRUE_SIZES = (0.8, 1.25)
"""A scale of the eye's lengths beyond these is no matter of a board's printer."""


def agrees(limits: tuple[float, float], found: HandEye, A: Array) -> bool:
    """Whether good pairs agree so far, in lengths that are about true."""
    position, turn = _noise(found)
    low, high = TRUE_SIZES
    return position <= limits[0] * _travel(A) and turn <= limits[1] and low < found.scale < high


def _travel(A: Array) -> float:
    return max(float(np.linalg.norm(np.ptp(A[:, :3, 3], axis=0))), 1e-12)


def _noise(found: HandEye) -> tuple[float, float]:
    """Size of a good pair's residual in true lengths, m and rad."""
    position = float(np.sqrt(np.trace(found.noise[:3, :3]))) / found.scale
    return position, float(np.sqrt(np.trace(found.noise[3:, 3:])))


def reason(
    A: Array, T: Array, found: HandEye, seed: int, layouts: Mapping[Whose, str]
) -> str | None:
    """Why poses that hardly agree are not to be trusted, in a sentence; None where they are.

    Raises nothing: what cannot be solved is no explanation.
    """
    position, turn = _noise(found)
    said = f"As declared, the poses agree to {1e3 * position:.3g} mm and {np.rad2deg(turn):.2g} deg"
    for words, whose, undone in rivals(layouts):
        hand, eye = (undone(A), T) if whose == "robot" else (A, undone(T))
        try:
            other = solve_hand_eye(hand, eye, found.eye_on, False, found.accepted_std, seed)
        except (InputError, np.linalg.LinAlgError):
            continue
        there, turned = _noise(other)
        share = there / _travel(hand) / max(position / _travel(A), 1e-12)
        places = share < BETTER and turned < max(BETTER * turn, PLAUSIBLE[1])
        turns = share < 1 / TRUE_SIZES[0] and turn > PLAUSIBLE[1] and turned < BETTER * turn
        if (places or turns) and other.determined:
            return (
                f"{said} only; {words} they agree to {1e3 * there:.3g} mm and "
                f"{np.rad2deg(turned):.2g} deg."
            )
    if agrees(USELESS, found, A):
        return None
    return (
        f"{said}: no place of hand and eye explains them; perhaps rows of the two lists do not "
        "belong together, or one of them is not what it is declared to be."
    )


def rivals(layouts: Mapping[Whose, str]) -> list[Rival]:
    """Ways in which poses are recorded other than they are said to be.

    Args:
        layouts: as they are said to be, where that is known.
    """
    # Inverting both lists swaps X and Y, so nobody can tell from poses which one is inverse.
    inverse = (
        "with inverse = true for the seen poses (or for the robot's, or the eye on the other end)"
    )
    found: list[Rival] = [(inverse, "eye", lie.inverse)]
    owners: tuple[tuple[Whose, str], ...] = (("eye", "seen"), ("robot", "robot"))
    for whose, said in owners:
        layout = layouts.get(whose, "")
        if layout in QUATERNIONS:
            shift = 1 if layout == "xyz_xyzw" else -1
            words = f'with layout = "{QUATERNIONS[layout]}" for the {said} poses'
            found.append((words, whose, partial(_reordered, shift=shift)))
        for unit, size in (("mm", 1e-3), ("m", 1e3)):
            words = f"with lengths a thousand times {'smaller' if size < 1 else 'larger'}"
            words += f' (unit = "{unit}") for the {said} poses'
            found.append((words, whose, partial(_sized, size=size)))
    return found


def _reordered(T: Array, shift: int) -> Array:
    """Poses whose quaternion was read in the wrong order; 1 if its first number is w."""
    q = lie.quaternion_xyzw(T[:, :3, :3])
    return lie.transform(lie.rotation_from_xyzw(np.roll(q, -shift, axis=1)), T[:, :3, 3])


def _sized(T: Array, size: float) -> Array:
    return lie.transform(T[:, :3, :3], size * T[:, :3, 3])
