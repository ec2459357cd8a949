"""Sections of the report on a wrist's load: what it explains, and what controllers are told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.recorded import PayloadFit
from bodyschema.report.figure import AFTER, BEFORE, GREY, MOST_DOTS, log_scale, svg
from bodyschema.report.page import render
from bodyschema.units import significant

Array = NDArray[np.float64]

WIDTH = 860.0


@dataclass(frozen=True)
class Explained:
    """The wrench before, and what is left of it."""

    fit: PayloadFit
    answer: Mapping[str, Any]
    title: str = "The wrench before and after"

    def render(self) -> str:
        """See `Section`."""
        return render(
            "payload/explained.html",
            picture=svg(
                "wrench", self._says(), (WIDTH, 460), self._paint,
            ),
            share=f"{100 * self.answer['unexplained']:.2g}",
            samples=self.answer["samples"],
            left_out=self.answer["left_out"],
            events=list(self.answer["events"]),
            noise=_noise(self.answer["sensor"]),
        )  # fmt: skip

    def _says(self) -> str:
        """What the picture tells, with its figures."""
        _, read, left = self._series()
        (F, f), (T, t) = (
            [float(np.median(np.linalg.norm(w[:, part], axis=1))) for w in (read, left)]
            for part in (slice(0, 3), slice(3, 6))
        )
        return (
            f"The median force was {significant(F)} N as read, offset removed, and "
            f"{significant(f)} N with the load taken off; the median torque {significant(T)} and "
            f"{significant(t)} Nm."
        )

    def _paint(self, figure: Any) -> None:
        time, read, left = self._series()
        axes = figure.subplots(2, 1, sharex=True)
        for panel, part, unit in zip(axes, (slice(0, 3), slice(3, 6)), ("N", "Nm"), strict=True):
            before = np.linalg.norm(read[:, part], axis=1)
            after = np.linalg.norm(left[:, part], axis=1)
            panel.plot(time, before, ".", ms=3, color=BEFORE, label="as read, offset removed")
            panel.plot(time, after, ".", ms=3, color=AFTER, label="not explained by the load")
            for event in self.answer["events"]:
                panel.axvline(event["time"], color=GREY, lw=0.8, ls=":")
            log_scale(panel, unit)
        axes[0].legend(loc="center right", fontsize=11)
        axes[1].set_xlabel("s")

    def _series(self) -> tuple[Array, Array, Array]:
        """Times, wrenches without bias and residuals, thinned to what a page can carry."""
        fit, bias = self.fit, self.fit.solution.guess.bias
        time = np.concatenate([part.means.time for part in fit.parts])
        y = np.concatenate([part.means.y for part in fit.parts])
        read = np.hstack([y[:, :3] @ fit.R.T, y[:, 3:] @ fit.R.T]) - bias
        left = np.concatenate([fit.residuals(k) for k in range(len(fit.parts))])
        step = max(1, len(time) // (2 * MOST_DOTS))
        return time[::step], read[::step], left[::step]


@dataclass(frozen=True)
class Controllers:
    """What to type into a controller."""

    answer: Mapping[str, Any]
    title: str = "For the robot's controller"

    def render(self) -> str:
        """See `Section`."""
        return render(
            "payload/controllers.html",
            loads=[
                (load["name"], load["controllers"], _missing(load)) for load in self.answer["loads"]
            ],
        )


def _missing(load: Mapping[str, Any]) -> str:
    """What no controller is told, and why."""
    what = {one["what"] for one in load["not_told"]}
    if what & {"mass", "com"}:
        return "Mass and centre of mass are not told: there is nothing to enter."
    return "The moments of inertia are not told and left out." if what else ""


def _noise(sensor: Mapping[str, Any]) -> str:
    force = ", ".join(f"{value:.2g}" for value in sensor["noise"][:3])
    torque = ", ".join(f"{1e3 * value:.2g}" for value in sensor["noise"][3:])
    return f"{force} N and {torque} mNm"
