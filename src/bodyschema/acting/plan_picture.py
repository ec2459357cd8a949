"""The plan as a picture: what it buys, and how the robot will stand.

Left, the predicted tool error against the number of poses, as planned and at random; right, the
poses as stick figures from the side and from above, numbered from the most telling on.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.next_poses import Plan
from bodyschema.errors import MissingExtraError
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

SIGNED, HEAD = "bodyschema plan", 512
"""What a picture says it was drawn by, and in how many of its first bytes."""

PLANNED, RANDOM = "#0a8f86", "#d9600f"
INK, GREY, RULE, PAPER, SCENE = "#22272e", "#767676", "#e4e1da", "#ffffff", "#f7f5f1"


def draw_plan(plan: Plan, body: Body, senses: Sequence[Sense], path: str | Path) -> Path:
    """Draw the picture into a .png, .svg or .pdf file and return its path.

    Args:
        plan: the plan.
        body: the corrected body.
        senses: what was seen, for the places of the tool so far.
        path: file to write.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "sim", "the picture of the plan") from None
    figure = Figure(figsize=(14.4, 6.2), facecolor=PAPER)
    FigureCanvasAgg(figure)
    n, before, after = len(plan.q), plan.error[0], plan.error[-1]
    poses = "One more pose" if n == 1 else f"{n} more poses"
    figure.text(0.035, 0.93, f"{poses} to know the robot better", fontsize=20, weight="bold", c=INK)
    figure.text(
        0.035, 0.877,
        f"95 % of tool errors below {_length(after)}, now {_length(before)}; "
        f"{_length(plan.random_error[-1])} with as many poses at random",
        fontsize=12.5, color=GREY,
    )  # fmt: skip
    _draw_errors(figure.add_axes((0.075, 0.115, 0.325, 0.66)), plan)
    side = figure.add_axes((0.43, 0.115, 0.265, 0.66))
    above = figure.add_axes((0.72, 0.115, 0.265, 0.66))
    _draw_views(side, above, plan, body, senses)
    target = Path(path)
    signature = {"Software": SIGNED} if target.suffix == ".png" else None
    figure.savefig(target, dpi=130, facecolor=PAPER, metadata=signature)
    return target


def _draw_errors(axes: Any, plan: Plan) -> None:
    """Predicted error before and after each pose."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    poses = np.arange(len(plan.error))
    curves = [("at random", plan.random_error, RANDOM), ("planned", plan.error, PLANNED)]
    wide = plan.error[0] > 8 * plan.error[-1]
    if wide:
        axes.set_yscale("log")
    for word, error, colour in curves:
        axes.plot(poses, 1e3 * error, "o-", color=colour, lw=2.6, ms=6, mec=PAPER, mew=1.2)
        text = f"{_length(error[-1])}\n{word}"
        axes.annotate(text, (poses[-1], 1e3 * error[-1]), xytext=(9, 0), va="center", color=colour,
                      textcoords="offset points", fontsize=12, weight="bold")  # fmt: skip
    if not wide:
        axes.set_ylim(0, 1.1e3 * plan.error[0])
    axes.set_xlim(-0.2, 1.36 * poses[-1])
    axes.set_xticks(poses[:: 1 + len(poses) // 12])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} mm"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("poses taken, the most telling first", color=INK, fontsize=10.5)
    _title(axes, "predicted tool error (95 %)")
    _plain(axes)
    axes.grid(color=RULE, linewidth=0.8)


def _draw_views(side: Any, above: Any, plan: Plan, body: Body, senses: Sequence[Sense]) -> None:
    """The robot in all poses, projected on x-z and on x-y."""
    lines, ends, still = _skeleton(body, plan)
    places = frame_poses(body, plan.q)[..., :3, 3]
    recorded = [sense.q for sense in senses if len(sense)]
    before = frame_poses(body, np.concatenate(recorded))[..., :3, 3] if recorded else places[:0]
    for axes, plane, names in ((side, [0, 2], "xz"), (above, [0, 1], "xy")):
        axes.plot(*before[:, ends[0]][:, plane].T, ".", ms=5, color="#b3ada0", zorder=1)
        _draw_poses(axes, places[..., plane], lines, ends[0])
        axes.plot(*places[0, 0, plane], "s", ms=11, color=INK, zorder=3)
        _frame_view(axes, names)
        for frame in still:
            _mark(axes, places[0, frame, plane], body.frames[frame])
    _title(side, "from the side")
    _title(above, "from above")
    if recorded:
        side.text(0.015, 0.015, "grey: where it was recorded", transform=side.transAxes,
                  fontsize=10, color=GREY)  # fmt: skip


def _draw_poses(axes: Any, places: Array, lines: Sequence[Sequence[int]], end: int) -> None:
    """Stick figures (n, n_frames, 2), the most telling on top, numbered at the tool."""
    from matplotlib import colormaps

    colours = colormaps["viridis"](np.linspace(0.1, 0.85, len(places)))
    for i in reversed(range(len(places))):
        for line in lines:
            axes.plot(*places[i, line].T, "o-", color=colours[i], lw=2.4, ms=4, alpha=0.8, zorder=2,
                      mfc=PAPER, mew=1.1, solid_joinstyle="round")  # fmt: skip
    for i in reversed(range(len(places))):
        axes.plot(*places[i, end], "o", ms=14, color=colours[i], mec=PAPER, mew=1.3, zorder=4)
        axes.text(*places[i, end], str(i + 1), color=PAPER, fontsize=8.5, weight="bold",
                  ha="center", va="center_baseline", zorder=5)  # fmt: skip


def _mark(axes: Any, place: Array, name: str) -> None:
    """A frame that stands still, with its name towards the middle."""
    right = place[0] > np.mean(axes.get_xlim())
    axes.plot(*place, "s", ms=8, mfc=PAPER, mec=INK, mew=1.6, zorder=6)
    axes.annotate(name, place, xytext=(8 if not right else -8, 7), textcoords="offset points",
                  ha="right" if right else "left", fontsize=10, color=INK, zorder=6)  # fmt: skip


def _frame_view(axes: Any, names: str) -> None:
    from matplotlib.ticker import MaxNLocator

    axes.set_facecolor(SCENE)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.1)
    _plain(axes)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    axes.grid(color=RULE, linewidth=0.8)
    axes.set_xlabel(f"{names[0]}, m", color=INK, fontsize=10.5)
    axes.text(0.015, 0.98, f"{names[1]}, m", transform=axes.transAxes, fontsize=10.5, color=INK,
              va="top")  # fmt: skip


def is_plan_picture(path: Path) -> bool:
    """Whether `draw_plan` drew a picture."""
    with path.open("rb") as file:
        return SIGNED.encode() in file.read(HEAD)


def _skeleton(body: Body, plan: Plan) -> tuple[list[list[int]], list[int], list[int]]:
    """Frames from the root to each moving end, those ends, and ends that stand still."""
    frames = dict.fromkeys(frame for a, b in plan.pairs for frame in (b, a))
    moving = {body.joint_index(joint) for joint in plan.joints}
    lines, ends, still = [], [], []
    for k in map(body.frame_index, frames):
        line = [k]
        while body.parent[line[-1]] >= 0:
            line.append(int(body.parent[line[-1]]))
        if any(int(body.driver[node]) in moving for node in line):
            lines.append(line[::-1])
            ends.append(k)
        else:
            still.append(k)
    return lines, ends, still


def _title(axes: Any, text: str) -> None:
    axes.set_title(text, color=INK, fontsize=13.5, weight="bold", loc="left", pad=9)


def _plain(axes: Any) -> None:
    axes.tick_params(which="both", colors=INK, labelsize=10, length=0)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _length(metres: float) -> str:
    """Millimetres with two significant digits or so."""
    mm = 1e3 * float(metres)
    return f"{mm:.0f} mm" if mm >= 10 else f"{mm:.1f} mm" if mm >= 1 else f"{mm:.2f} mm"
