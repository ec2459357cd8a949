"""A sleeve that is put on, a rod that is taken and let go: after how many motions does it count?

The cells of a thing are those that it covers, on average while it is carried, by at least
THING_SHARE. It has become me when ENOUGH of them are called me. Let go, it hangs where it was: of
the cells that were me then and that it still covers, it has stopped being me when no more than FEW
are called me.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.simulation.acting_robots import RobotName
from bodyschema.simulation.film import Film
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.studies.study import Result
from bodyschema.studies.watched_scenes import THING_SHARE, truth_of, used_joints, watch

Flags = NDArray[np.bool_]

ENOUGH, FEW = 0.75, 0.25
"""Shares of a thing's cells."""


def carry(robot: RobotName, thing: Literal["rod", "sleeve"], seed: int, motions: int) -> Result:
    """Motions until the thing is me, and until it no longer is; None for never.

    Args:
        robot: which one.
        thing: what it carries.
        seed: of the scene.
        motions: a third of them before, half with the thing, and a third after a rod's release.
    """
    taken = motions // 3
    released = max(taken + motions // 2, taken + 1)
    last = released + (max(motions // 3, 1) if thing == "rod" else 0)
    scene = MovingScene(
        robot, "always", seed, last, carried=thing, taken=taken,
        released=released if thing == "rod" else None,
    )  # fmt: skip
    film = Studio(scene).film()
    held, left = _cells(film, taken, released)
    joints = used_joints(film, head_moves=False)
    masks: dict[int, Flags] = {}

    def note(done: int, found: BodyInView) -> None:
        masks[done] = found.mask

    watch(BodyFinder(joints), film, len(joints), note)
    left &= masks[released]
    worn = {k - taken: masks[k][held] for k in range(taken + 1, released + 1)}
    after = {k - released: masks[k][left] for k in range(released + 1, last + 1)}
    return {
        "cells": int(held.sum()),
        "me_after": _first(worn, lambda share: share >= ENOUGH),
        "cells_left": int(left.sum()),
        "not_me_after": _first(after, lambda share: share <= FEW),
    }


def _cells(film: Film, taken: int, released: int) -> tuple[Flags, Flags]:
    """(rows, cols) each: cells of the thing while it is carried, and of what hangs there later."""
    truth, time = truth_of(film), film.time[film.labelled]
    begin = film.motion_end[taken - 1] + 0.4 if taken else 0.0
    end = film.motion_end[released - 1]
    held = truth.thing[(begin < time) & (time < end)].mean(axis=0) >= THING_SHARE
    later = time > end + 0.4
    hangs = truth.thing[later].mean(axis=0) >= THING_SHARE
    return held, hangs & (truth.links[later].max(axis=0) == 0)


def _first(called: Mapping[int, Flags], good: Callable[[float], bool]) -> int | None:
    """The first number of motions after which the share of cells that are called me is good."""
    for motions, cells in called.items():
        if len(cells) and good(float(cells.mean())):
            return motions
    return None


def carried(films: Sequence[Result]) -> Result:
    """Over the films in which the thing covers at least one cell."""
    seen = [film for film in films if film["cells"]]
    were = [film for film in seen if film["cells_left"]]
    worn = [film["me_after"] for film in seen if film["me_after"] is not None]
    let_go = [film["not_me_after"] for film in were if film["not_me_after"] is not None]
    return {
        "films": len(seen), "became_me": len(worn), "me_after": quantiles(worn),
        "were_me": len(were), "let_go": len(let_go), "not_me_after": quantiles(let_go),
    }  # fmt: skip


def quantiles(values: Sequence[float]) -> Result:
    """Median and 90 %; None of nothing."""
    if not values:
        return {"median": None, "p90": None}
    return {"median": float(np.median(values)), "p90": float(np.quantile(values, 0.9))}
