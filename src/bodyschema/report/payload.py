"""The report of a payload: what hangs on the wrist, what it explains, and what is still open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.recorded import PayloadFit
from bodyschema.report.figure import AFTER, BEFORE, MOST_DOTS, log_scale, svg
from bodyschema.report.page import render
from bodyschema.report.report import page_html
from bodyschema.report.section import Section

Array = NDArray[np.float64]

WIDTH = 860.0


class Event(Protocol):
    """Something that happened to the load."""

    @property
    def time(self) -> float:
        """s."""
        ...

    @property
    def event(self) -> str:
        """What."""
        ...


def payload_html(fit: PayloadFit, answer: Mapping[str, Any], events: Sequence[Event]) -> str:
    """The whole page.

    Args:
        fit: of the recording.
        answer: the same in plain values, see `cli.payload_answer`.
        events: changes of the load that were noticed.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    sections: list[Section] = [
        Loads(answer),
        Explained(fit, answer, tuple(events)),
        Open(answer),
        Controllers(answer),
    ]
    return page_html("What the wrist carries", sections)


@dataclass(frozen=True)
class Loads:
    """Every parameter with its doubt."""

    answer: Mapping[str, Any]
    title: str = "What hangs on the wrist"

    def render(self) -> str:
        """See `Section`."""
        loads = [_rows(load) for load in self.answer["loads"]]
        untold = {one["what"] for load in self.answer["loads"] for one in load["not_told"]}
        known = not {"mass", "com"} & untold
        return render(
            "payload/loads.html",
            known=known,
            lead=_lead(self.answer["loads"]), loads=loads, sensor=_sensor(self.answer["sensor"]),
            notes=self.answer["notes"],
        )  # fmt: skip


@dataclass(frozen=True)
class Explained:
    """The wrench before, and what is left of it."""

    fit: PayloadFit
    answer: Mapping[str, Any]
    events: tuple[Event, ...]
    title: str = "The wrench before and after"

    def render(self) -> str:
        """See `Section`."""
        return render(
            "payload/explained.html",
            picture=svg(
                "wrench", "Force and torque as read and as left unexplained", (WIDTH, 460),
                self._paint,
            ),
            share=f"{100 * self.answer['unexplained']:.2g}",
            samples=self.answer["samples"],
            left_out=self.answer["left_out"],
            events=list(self.answer["events"]),
            noise=_noise(self.answer["sensor"]),
        )  # fmt: skip

    def _paint(self, figure: Any) -> None:
        time, read, left = self._series()
        axes = figure.subplots(2, 1, sharex=True)
        for panel, part, unit in zip(axes, (slice(0, 3), slice(3, 6)), ("N", "Nm"), strict=True):
            before = np.linalg.norm(read[:, part], axis=1)
            after = np.linalg.norm(left[:, part], axis=1)
            panel.plot(time, before, ".", ms=3, color=BEFORE, label="as read, offset removed")
            panel.plot(time, after, ".", ms=3, color=AFTER, label="not explained by the load")
            for event in self.events:
                panel.axvline(event.time, color="0.4", lw=0.8, ls=":")
            log_scale(panel, unit)
        axes[0].legend(loc="center right", fontsize=10)
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
class Open:
    """Which motion is missing."""

    answer: Mapping[str, Any]
    title: str = "What the motion did not tell"

    def render(self) -> str:
        """See `Section`."""
        lines = dict.fromkeys(
            f"{load['name']}: {one['sentence']}"
            for load in self.answer["loads"]
            for one in load["not_told"]
        )
        return render("payload/open.html", lines=list(lines))


@dataclass(frozen=True)
class Controllers:
    """What to type into a controller."""

    answer: Mapping[str, Any]
    title: str = "For the robot's controller"

    def render(self) -> str:
        """See `Section`."""
        return render(
            "payload/controllers.html",
            loads=[(load["name"], load["controllers"]) for load in self.answer["loads"]],
        )


def _lead(loads: Sequence[Mapping[str, Any]]) -> str:
    """The masses in a line."""
    return "; ".join(
        f"{load['name']}: {' ± '.join(_digits(load['mass'], load['mass_std']))} kg"
        for load in loads
    )


def _rows(load: Mapping[str, Any]) -> dict[str, Any]:
    """A load's table: name, value, one standard deviation, unit, and whether it is told."""
    untold = {one["what"] for one in load["not_told"]}
    rows = [("mass", load["mass"], load["mass_std"], 1.0, "kg", "mass" not in untold)]
    for k, axis in enumerate("xyz"):
        told = "com" not in untold or load["com_std"][k] < 0.02
        rows.append((f"centre {axis}", load["com"][k], load["com_std"][k], 1e3, "mm", told))
    for name, std in load["inertia_std"].items():
        i, j = ("xyz".index(c) for c in name[2:])
        rows.append((name, load["inertia"][i][j], std, 1e3, "g m²", name not in untold))
    return {
        "name": load["name"],
        "rows": [
            (what, *_digits(factor * value, factor * std), unit, told)
            for what, value, std, factor, unit, told in rows
        ],
    }


def _sensor(sensor: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Offset and turn of the sensor, with their doubt."""
    rows = []
    for k, name in enumerate(("F x", "F y", "F z", "T x", "T y", "T z")):
        factor, unit = (1.0, "N") if k < 3 else (1e3, "mNm")
        value, std = factor * sensor["bias"][k], factor * sensor["bias_std"][k]
        rows.append((f"offset {name}", *_digits(value, std), unit))
    for k, axis in enumerate("xyz"):
        value, std = sensor["turn_deg"][k], sensor["turn_std_deg"][k]
        rows.append((f"turned about {axis}", *_digits(value, std), "deg"))
    return rows


def _digits(value: float, std: float) -> tuple[str, str]:
    """Value and doubt, the value to as many decimals as the doubt leaves it."""
    decimals = int(np.clip(1 - np.floor(np.log10(max(std, 1e-12))), 0, 6))
    return f"{value:.{decimals}f}", f"{std:.2g}" if std < 1000 else "huge"


def _noise(sensor: Mapping[str, Any]) -> str:
    force = ", ".join(f"{value:.2g}" for value in sensor["noise"][:3])
    torque = ", ".join(f"{1e3 * value:.2g}" for value in sensor["noise"][3:])
    return f"{force} N and {torque} mNm"
