"""Section of the report on touches: when, how strong, and all places where each may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bodyschema.report.page import render
from bodyschema.units import significant


@dataclass(frozen=True)
class Touches:
    """A table of all touches."""

    touches: Sequence[Mapping[str, Any]]
    """See `answers.touch.touch_entry`."""
    title: str = "Touches"

    def render(self) -> str:
        """See `Section`."""
        return render("touch/touches.html", rows=[_row(touch) for touch in self.touches])


def _row(touch: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "begins": f"{touch['begins']:.2f}",
        "ends": "" if touch["ends"] is None else f"{touch['ends']:.2f}",
        "force": significant(float(np.linalg.norm(touch["force"]))),
        "verdict": touch["verdict"],
        "places": [
            {
                "point": " ".join(f"{1e3 * value:.1f}" for value in place["point"]),
                "std": significant(1e3 * _worst(place["covariance"]), 2),
                "chance": f"{100 * place['chance']:.0f} %",
            }
            for place in touch["places"]
        ],
    }


def _worst(covariance: Sequence[Sequence[float]]) -> float:
    """m, standard deviation in the worst direction."""
    return float(np.sqrt(np.linalg.eigvalsh(np.array(covariance))[-1]))
