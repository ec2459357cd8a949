"""The published filter, picture by picture: what it believed, and what the pictures still told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.report.figure import AFTER, svg
from bodyschema.report.page import render
from bodyschema.report.residuals import WIDTH
from bodyschema.units import significant

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Course:
    """A filter's beliefs, one for each picture that it learned from."""

    joints: tuple[str, ...]
    offsets: Array
    """(n, n_joints) rad"""
    std: Array
    """(n, n_joints) rad, of the particles."""
    sizes: Array
    """(n,) effective size over the number of particles."""
    numbers: Sequence[int]
    """Of the pictures."""


@dataclass(frozen=True)
class FilterCourse:
    """Offsets and effective size over the pictures."""

    course: Course
    title: str = "The filter, picture by picture"

    def render(self) -> str:
        """See `Section`."""
        chart = svg("course", self._says(), (WIDTH, 300), self._paint)
        return render("tracking/filter_course.html", chart=chart)

    def _says(self) -> str:
        course = self.course
        ends = ", ".join(
            f"{name} {significant(float(np.rad2deg(end)), 2)} deg"
            for name, end in zip(course.joints, course.offsets[-1], strict=True)
        )
        return (
            f"After the last picture: {ends}; effective size {100 * course.sizes[0]:.1f} % of the "
            f"particles in the first picture, {100 * course.sizes[-1]:.1f} % in the last."
        )

    def _paint(self, figure: Any) -> None:
        from matplotlib.ticker import MaxNLocator

        course, panels = self.course, figure.subplots(1, 2)
        for j, name in enumerate(course.joints):
            middle, wide = (np.rad2deg(v[:, j]) for v in (course.offsets, course.std))
            (line,) = panels[0].plot(course.numbers, middle, label=name)
            panels[0].fill_between(
                course.numbers, middle - wide, middle + wide, color=line.get_color(), alpha=0.12,
                linewidth=0,
            )  # fmt: skip
        panels[0].set(title="offsets, deg")
        panels[0].legend(frameon=False, fontsize=10, ncols=2)
        panels[1].plot(course.numbers, 100 * course.sizes, ".", color=AFTER)
        panels[1].set(title="effective size, % of the particles", ylim=(0, 103))
        for panel in panels:
            panel.set(xlabel="picture")
            panel.xaxis.set_major_locator(MaxNLocator(integer=True))
