"""The robot before and after, as a drawing of its joints in one posture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kinematics import frame_poses
from bodyschema.report.evidence import Evidence
from bodyschema.report.figure import AFTER, BEFORE, GREY, INK, PAPER, plain, svg
from bodyschema.report.page import render
from bodyschema.report.residuals import WIDTH
from bodyschema.units import shown

Array = NDArray[np.float64]

FACTORS = (1, 2, 5, 10, 20, 50, 100, 200)
"""By which a correction may be exaggerated."""
VISIBLE = 0.1
"""Share of the robot's size that the exaggerated correction may take."""
VIEWS = (("front", 1, 2, "seen along -x"), ("side", 0, 2, "seen along y"))


def exaggeration(length: float, size: float) -> int:
    """The round number of times that a length is drawn too large to be seen beside a robot.

    Args:
        length: m.
        size: of the robot, m.
    """
    return max((f for f in FACTORS if f * length <= VISIBLE * size), default=1)


@dataclass(frozen=True)
class Pose:
    """The drawn frames of both bodies in one posture."""

    frames: tuple[int, ...]
    before: Array
    """(n, 3) m, in the root frame."""
    after: Array
    factor: int
    largest: float
    """m: true distance between the two at the frame that moves most."""
    at: str
    """That frame."""


@dataclass(frozen=True)
class Drawing:
    """Two views of the chain between the frames that look and are looked at."""

    evidence: Evidence
    title: str = "The robot before and after"

    def render(self) -> str:
        """See `Section`."""
        row, q = self._posture()
        pose = self._pose(q)
        picture = svg(
            "robot", _says(pose, row), (WIDTH, 440),
            lambda figure: self._draw(figure, pose),
        )  # fmt: skip
        return render(
            "drawing.html",
            picture=picture,
            row=row,
            factor=pose.factor,
            largest=shown(pose.largest, "m"),
            at=pose.at,
            root=self.evidence.calibration.body.frames[0],
            # A frame that was a guess to begin with has no "before" worth the name.
            open=bool(self.evidence.calibration.identifiability.directions),
        )

    def _posture(self) -> tuple[int, Array]:
        """The good sample whose error before is in the middle, and its readings."""
        sense, good = self.evidence.senses[0], self.evidence.good[0]
        name = sense.components[0][0]
        error = np.where(good, self.evidence.errors(name)[0][0], np.inf)
        middle = np.argsort(error, kind="stable")[(max(int(good.sum()), 1) - 1) // 2]
        return int(sense.rows[middle]), sense.q[middle]

    def _pose(self, q: Array) -> Pose:
        estimate = self.evidence.calibration.estimate
        frames = self._chain()
        before, after = (
            frame_poses(body, q)[list(frames), :3, 3]
            for body in (estimate.reference, estimate.body)
        )
        moved = np.linalg.norm(after - before, axis=1)
        size = float(np.ptp(before, axis=0).max())
        factor = exaggeration(float(moved.max()), size)
        name = estimate.body.frames[frames[int(np.argmax(moved))]]
        return Pose(frames, before, after, factor, float(moved.max()), name)

    def _chain(self) -> tuple[int, ...]:
        """The frames of the senses and all that lies between them and the root, root first."""
        body, found = self.evidence.calibration.body, set()
        for sense in self.evidence.senses:
            for name in (sense.seen_from, sense.seen):
                k = body.frame_index(name)
                while k >= 0:
                    found.add(k)
                    k = int(body.parent[k])
        return tuple(sorted(found))

    def _draw(self, figure: Any, pose: Pose) -> None:
        panes = figure.subplots(1, 2)
        shown_after = pose.before + pose.factor * (pose.after - pose.before)
        for axes, (name, across, up, words) in zip(panes, VIEWS, strict=True):
            for points, colour, word in (
                (pose.before, BEFORE, "before"),
                (shown_after, AFTER, "after"),
            ):
                self._draw_body(axes, pose.frames, points[:, [across, up]], colour, word)
            both = np.stack([pose.before, shown_after])[..., [across, up]]
            self._name_ends(axes, pose.frames, both)
            plain(axes)
            axes.set_aspect("equal", adjustable="datalim")
            axes.margins(0.12)
            axes.set_title(f"{name}, {words}")
            _draw_scale(axes, float(np.ptp(pose.before, axis=0).max()))
        handles, labels = panes[0].get_legend_handles_labels()
        if pose.factor > 1:
            labels[1] += f", correction {pose.factor} times as large"
        figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)

    def _draw_body(self, axes: Any, frames: tuple[int, ...], p: Array, c: str, word: str) -> None:
        body = self.evidence.calibration.body
        for i, k in enumerate(frames):
            if body.parent[k] in frames:
                above = frames.index(int(body.parent[k]))
                axes.plot(*p[[above, i]].T, color=c, lw=3.5, alpha=0.75, solid_capstyle="round")
        moving = [i for i, k in enumerate(frames) if body.driver[k] >= 0]
        axes.plot(*p[moving].T, "o", ms=7, mfc=PAPER, mec=c, mew=2)
        ends = [frames.index(body.frame_index(name)) for name in self._ends()]
        axes.plot(*p[ends].T, "s", ms=5.5, mfc=c, mec="none")
        axes.plot([], [], color=c, lw=3.5, label=word)

    def _name_ends(self, axes: Any, frames: tuple[int, ...], both: Array) -> None:
        """Names of the frames that look, are looked at, and the root; one where several meet.

        A name stands outside, beside the outer one of the two bodies (2, n, 2).
        """
        body = self.evidence.calibration.body
        size, middle = float(np.ptp(both[0], axis=0).max()), np.mean(both[..., 0])
        style: dict[str, Any] = {"textcoords": "offset points", "color": INK, "fontsize": 11}
        style["va"] = "center"
        style["bbox"] = {"fc": PAPER, "ec": "none", "alpha": 0.8, "pad": 1.5}
        written: list[Array] = []
        for name in (body.frames[0], *self._ends()):
            ends = both[:, frames.index(body.frame_index(name))]
            place = np.mean(ends, axis=0)
            if all(np.linalg.norm(place - other) > 0.13 * size for other in written):
                written.append(place)
                side = -1 if place[0] < middle else 1
                outer = ends[np.argmax(side * ends[:, 0])]
                align = "right" if side < 0 else "left"
                axes.annotate(name, outer, xytext=(9 * side, 0), ha=align, **style)

    def _ends(self) -> list[str]:
        senses = self.evidence.senses
        return list(dict.fromkeys(name for s in senses for name in (s.seen_from, s.seen)))


def _says(pose: Pose, row: int) -> str:
    """What the drawing tells, with its figures."""
    scale = f", drawn {pose.factor} times as large" if pose.factor > 1 else ", true to scale"
    return (
        f"In the posture of row {row}, {pose.at} was {shown(pose.largest, 'm')} from where it is "
        f"after the correction, more than any other frame of the chain{scale}; from the front and "
        "from the side."
    )


def _draw_scale(axes: Any, size: float) -> None:
    """A bar of a round length in the lower left corner."""
    length = 10.0 ** np.floor(np.log10(max(size, 1e-3) / 2))
    low, high = axes.get_xlim(), axes.get_ylim()
    axes.plot(
        [low[0], low[0] + length], [high[0], high[0]], color=GREY, lw=2, solid_capstyle="butt"
    )
    axes.annotate(f"{1e3 * length:g} mm", (low[0], high[0]), xytext=(0, 5), color=GREY, fontsize=11,
                  textcoords="offset points")  # fmt: skip
