"""Joint space: where in the range of each joint the error is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import PRISMATIC
from bodyschema.report.evidence import Evidence, spread
from bodyschema.report.figure import AFTER, BEFORE, log_scale, svg
from bodyschema.report.page import render
from bodyschema.report.residuals import SMALLEST, SMALLEST_OTHER, WIDTH
from bodyschema.units import read_as, significant

Array = NDArray[np.float64]
Samples = tuple[Array, Array, Array]
"""Readings (n, n_joints), and errors before and after (n,) as they are shown."""

ACROSS = 4
"""Panels beside each other."""
MOST_DOTS = 150
BINS = 7
FEWEST_A_BIN = 4


@dataclass(frozen=True)
class JointSpace:
    """Position errors against the reading of every joint that moved."""

    evidence: Evidence
    title: str = "Error over joint space"

    def render(self) -> str:
        """See `Section`."""
        joints = self.evidence.joints
        samples = self._samples()
        rows = [joints[first : first + ACROSS] for first in range(0, len(joints), ACROSS)]
        return render(
            "joint_space.html", charts=[self._chart(k, row, samples) for k, row in enumerate(rows)]
        )

    def _chart(self, k: int, joints: Sequence[str], samples: Samples) -> str:
        """The panels that stand beside each other."""
        q, _, after = samples
        body, unit = self.evidence.calibration.body, self._unit
        told = []
        for joint in joints:
            x = q[:, body.joint_index(joint)]
            _, medians = _medians(x, after)
            low, high = significant(min(medians)), significant(max(medians))
            told.append(f"{joint} {low} to {high} {unit}")
        says = f"Running median of the error after, over the readings of {'; '.join(told)}."
        return svg(
            f"joint-space-{k}",
            says,
            (WIDTH, 200),
            lambda figure: self._draw(figure, joints, samples),
        )

    def _draw(self, figure: Any, joints: Sequence[str], samples: Samples) -> None:
        q, before, after = samples
        body = self.evidence.calibration.body
        panes = figure.subplots(1, ACROSS, squeeze=False, sharey=True).ravel()
        for axes, joint in zip(panes, joints, strict=False):
            scale, unit = joint_unit(self.evidence, joint)
            x = scale * q[:, body.joint_index(joint)]
            for values, colour in ((before, BEFORE), (after, AFTER)):
                dots = spread(np.stack([x, values], axis=1), MOST_DOTS)
                axes.plot(*dots.T, "o", ms=3, mfc=colour, mec="none", alpha=0.4)
                axes.plot(*_medians(x, values), color=colour, lw=2.2)
            axes.set_title(f"{joint}, {unit}", fontsize=11)
            axes.margins(x=0.03)
            axes.locator_params(axis="x", nbins=4)
        log_scale(panes[0], self._unit)
        for axes in panes[len(joints) :]:
            axes.set_visible(False)

    @property
    def _unit(self) -> str:
        """Of the errors, as people read it."""
        return read_as(self.evidence.calibration.held_out.main[1])[1]

    def _samples(self) -> Samples:
        """Readings, and errors as shown, of all good samples of what the answer speaks of."""
        name, unit, _ = self.evidence.calibration.held_out.main
        pairs = self.evidence.errors(name)
        kept = [
            (sense.q[good], before[good], after[good])
            for sense, good, (before, after) in zip(
                self.evidence.senses, self.evidence.good, pairs, strict=True
            )
            if len(before)
        ]
        q, before, after = (np.concatenate(side) for side in zip(*kept, strict=True))
        floor, scale = SMALLEST.get(unit, SMALLEST_OTHER), read_as(unit)[0]
        return q, scale * np.maximum(before, floor), scale * np.maximum(after, floor)


def joint_unit(evidence: Evidence, joint: str) -> tuple[float, str]:
    """Scale and name of the unit that a joint's readings are shown in."""
    body = evidence.calibration.body
    slides = bool((body.kind[body.driver == body.joint_index(joint)] == PRISMATIC).any())
    return read_as("m" if slides else "rad")


def _medians(x: Array, values: Array) -> tuple[list[float], list[float]]:
    """Median error in parts of the range that hold equally many samples."""
    order = np.argsort(x, kind="stable")
    parts = np.array_split(order, max(min(BINS, len(x) // FEWEST_A_BIN), 1))
    full = [part for part in parts if len(part)]
    return (
        [float(np.median(x[part])) for part in full],
        [float(np.median(values[part])) for part in full],
    )
