"""The hand moment by moment: how far from where it was believed, how sure, and whether seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bodyschema.report.figure import AFTER, BEFORE, GREY, MOST_DOTS, log_scale, svg
from bodyschema.report.page import render
from bodyschema.report.residuals import WIDTH
from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.units import ABSENT, significant

MOST_ROWS = 40


@dataclass(frozen=True)
class Moments:
    """Charts over all moments, and a table of those in which the hand is lost."""

    evidence: TrackEvidence
    title: str = "The hand, moment by moment"

    def render(self) -> str:
        """See `Section`."""
        evidence = self.evidence
        gone = np.flatnonzero(evidence.lost)
        return render(
            "tracking/moments.html",
            hand=evidence.hand,
            camera=evidence.cameras[0],
            chart=svg("hand", self._hand_says(), (WIDTH, 300), self._hand),
            seen=svg("seen", self._seen_says(), (WIDTH, 300), self._seen),
            lost=[self._row(int(i)) for i in gone[:MOST_ROWS]],
            left_out=max(len(gone) - MOST_ROWS, 0),
            held_out=self._held_out(),
        )

    def _row(self, i: int) -> tuple[str, str, str, str]:
        evidence, pose = self.evidence, self.evidence.poses[i]
        residual = pose.residual if np.isfinite(pose.residual) else None
        return (
            str(evidence.numbers[i]),
            f"{pose.time:.3f}",
            f"{100 * pose.matched:.0f} %",
            ABSENT if residual is None else significant(residual, 2),
        )

    def _held_out(self) -> str:
        """Residuals where the offsets were learned, and elsewhere."""
        evidence = self.evidence
        good = ~evidence.lost & np.isfinite(evidence.residual)
        inside, outside = good & evidence.learned, good & ~evidence.learned
        if not inside.any() or not outside.any():
            return ""
        pixels = [float(np.median(evidence.residual[part])) for part in (inside, outside)]
        return (
            f"Median residual in the {int(inside.sum())} moments that were learned from: "
            f"{pixels[0]:.2f} pixels; in the {int(outside.sum())} others: {pixels[1]:.2f}."
        )

    def _hand_says(self) -> str:
        """What the picture of the hand tells, with its figures."""
        evidence, good = self.evidence, ~self.evidence.lost
        if not good.any():
            return f"The hand is lost in all {len(good)} moments."
        shift, std = (np.median(v[good], axis=0) for v in (evidence.shift, evidence.std))
        return (
            f"In {int(good.sum())} of {len(good)} moments the hand was found; in the middle one "
            f"{significant(1e3 * shift[0])} mm and {significant(np.rad2deg(shift[1]))} deg from "
            f"where it was believed, with a standard deviation of {significant(1e3 * std[0], 2)} "
            f"mm and {significant(np.rad2deg(std[1]), 2)} deg."
        )

    def _seen_says(self) -> str:
        evidence = self.evidence
        residual = evidence.residual[np.isfinite(evidence.residual)]
        off = f", {significant(float(np.median(residual)), 2)} pixels off" if len(residual) else ""
        found = 100 * float(np.median(evidence.matched))
        return f"In the middle moment {found:.0f} % of the imagined contour was found{off}."

    def _shown(self) -> Any:
        """Evenly spaced moments, and all lost ones."""
        count = len(self.evidence.poses)
        some = np.linspace(0, count - 1, min(count, MOST_DOTS)).astype(int)
        return np.union1d(some, np.flatnonzero(self.evidence.lost)[:MOST_DOTS])

    def _hand(self, figure: Any) -> None:
        evidence, shown = self.evidence, self._shown()
        at, scales = np.array(evidence.numbers)[shown], ((1e3, "mm"), (180 / np.pi, "deg"))
        for k, (panel, (scale, unit)) in enumerate(zip(figure.subplots(1, 2), scales, strict=True)):
            good = ~evidence.lost[shown]
            for values, colour, label in (
                (evidence.shift[:, k], BEFORE, "from where it was believed"),
                (evidence.std[:, k], AFTER, "one standard deviation"),
            ):
                panel.plot(at[good], scale * values[shown][good], ".", color=colour, label=label)
                panel.plot(at[~good], scale * values[shown][~good], "x", color=GREY)
            _whole_numbers(panel)
            panel.set(xlabel="picture", title="position" if k == 0 else "orientation")
            log_scale(panel, unit)
            panel.legend(frameon=False, fontsize=11)

    def _seen(self, figure: Any) -> None:
        evidence, shown = self.evidence, self._shown()
        at = np.array(evidence.numbers)[shown]
        left, right = figure.subplots(1, 2)
        good = ~evidence.lost[shown]
        left.plot(at[good], 100 * evidence.matched[shown][good], ".", color=AFTER)
        left.plot(at[~good], 100 * evidence.matched[shown][~good], "x", color=GREY)
        left.set(xlabel="picture", title="contour found, %", ylim=(0, 103))
        for panel in (left, right):
            _whole_numbers(panel)
        right.plot(at, evidence.residual[shown], ".", color=AFTER)
        right.set(xlabel="picture", title="median residual, pixels", ylim=(0, None))


def _whole_numbers(panel: Any) -> None:
    """Marks of the pictures' axis: there is no half a picture."""
    from matplotlib.ticker import MaxNLocator

    panel.xaxis.set_major_locator(MaxNLocator(integer=True))
