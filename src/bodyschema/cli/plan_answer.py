"""The answer of `plan`, as one JSON object for machines and as text for people."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bodyschema.acting.next_poses import Plan
from bodyschema.errors import shown
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

NAMED = 6
"""Variables that the terminal names; the JSON has all."""


def in_unit(q: Array, body: Body, unit: str) -> Array:
    """Readings (n, n_joints) with angles in rad or deg; sliding joints stay in m."""
    if unit == "rad":
        return q
    return np.asarray(np.where(_slides(body), q, np.rad2deg(q)))


def _slides(body: Body) -> NDArray[np.bool_]:
    """Which joints are read in m, (n_joints,)."""
    return np.isin(np.arange(len(body.joints)), body.driver[body.kind == PRISMATIC])


def plan_json(plan: Plan, body: Body, order: Ints, notes: Sequence[str]) -> dict[str, Any]:
    """Everything of the plan in plain types; joints in rad and m, errors in mm."""
    columns = [body.joint_index(joint) for joint in plan.joints]
    return {
        "joints": list(plan.joints),
        "poses": plan.q[:, columns].tolist(),
        "file_order": order.tolist(),
        "tool": [{"seen_from": a, "seen": b} for a, b in plan.pairs],
        "error_95_mm": (1e3 * plan.error).tolist(),
        "random_error_95_mm": (1e3 * plan.random_error).tolist(),
        "rank": list(plan.rank),
        "rank_within_reach": plan.most,
        "parameters": plan.n_parameters,
        "told": list(plan.told),
        "candidates": plan.n_candidates,
        "notes": list(notes),
    }


def print_plan(console: Console, plan: Plan, body: Body, order: Ints, notes: Sequence[str]) -> None:
    """What the plan buys, the poses, and what was not looked at."""
    before, after, chance = (
        1e3 * e for e in (plan.error[0], plan.error[-1], plan.random_error[-1])
    )
    console.print(
        f"\n[bold green]{len(plan.q)} poses[/]  95 % of the tool errors should then stay below "
        f"[bold]{after:.2f} mm[/], now {before:.2f}; poses at random would give {chance:.2f}. "
        "That is of noise alone, within the joint limits, in view or not.",
        highlight=False,
    )
    console.print(_directions(plan) + "\n", highlight=False)
    console.print(_table(plan, body, order, console.width))
    console.print(_columns(plan.joints), highlight=False)
    for note in notes:
        console.print(f"  - {escape(shown(note))}", highlight=False)


def _directions(plan: Plan) -> str:
    """Which open directions the plan closes."""
    first, last, n = plan.rank[0], plan.rank[-1], plan.n_parameters
    if first == n:
        return f"All {n} parameters were determined already."
    told = ", ".join(plan.told[:NAMED]) + (" ..." if len(plan.told) > NAMED else "")
    closed = f"the plan determines {last - first} more" + (f" ({told})" if told else "")
    if last == first:
        closed = "the plan determines no more"
    beyond = n - plan.most
    never = f"; {beyond} cannot be told by any pose in reach" if beyond else ""
    return f"{first} of {n} directions were determined, {closed}{never}."


def _table(plan: Plan, body: Body, order: Ints, width: int) -> Table:
    """Poses, the most telling first, with their rows in the file."""
    opens = plan.rank[-1] > plan.rank[0]
    names = _short(plan.joints)
    if sum(max(len(name), 4) + 3 for name in names) > width - 30:
        names = [str(i + 1) for i in range(len(names))]
    heads = ["", "row", *names, "error mm", *(["known"] if opens else [])]
    title = "The most telling first; row and columns of the file, angles in deg"
    table = Table(title=title, title_justify="left")
    for head in heads:
        table.add_column(escape(shown(head)), justify="right", overflow="fold")
    columns = [body.joint_index(joint) for joint in plan.joints]
    degrees = in_unit(plan.q, body, "deg")[:, columns]
    digits = np.where(_slides(body)[columns], 3, 0)
    row = np.argsort(order) + 1
    for i, (error, rank) in enumerate(zip(plan.error, plan.rank, strict=True)):
        pose = zip(degrees[i - 1], digits, strict=True)
        cells = [f"{value:.{n}f}" for value, n in pose] if i else [""] * len(columns)
        first = [str(i), str(row[i - 1])] if i else ["now", ""]
        table.add_row(*first, *cells, f"{1e3 * error:.2f}", *([str(rank)] if opens else []))
    return table


def _columns(joints: Sequence[str]) -> str:
    """The columns of the file by name and number: the table may have their numbers alone."""
    named = ", ".join(f"{i} {escape(shown(joint))}" for i, joint in enumerate(joints, start=1))
    return f"Columns: {named}."


def _short(names: Sequence[str]) -> list[str]:
    """Names without the beginning and the end that all of them share."""
    if len(names) < 2:
        return list(names)
    start = _shared(names)
    end = _shared([name[start:][::-1] for name in names])
    return [name[start : len(name) - end] or name for name in names]


def _shared(names: Sequence[str]) -> int:
    """Number of letters with which all names begin."""
    columns = zip(*names, strict=False)
    return sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, columns))
