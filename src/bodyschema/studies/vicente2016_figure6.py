"""Vicente et al. 2016, Fig. 6 to 8: the errors of Table 1's movements, frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from bodyschema.studies.hand_summary import curves, mean_and_sd
from bodyschema.studies.study import Result
from bodyschema.studies.vicente2016_table1 import Table1

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Figure6(Table1):
    """Estimation error during the open loop, with and without adaptation; runs of Table 1."""

    figure: ClassVar[str] = "figure6"
    source: ClassVar[str] = "table1"

    def summary(self, results: Mapping[str, Result]) -> Result:
        """That of Table 1, and the estimation error after each quarter of the open loop."""
        at = {f"{k}_quarters": max(k * self.frames // 4, 1) - 1 for k in range(1, 5)}
        return super().summary(results) | {"course": _course(results, "estimation", at)}

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Position and orientation."""
        return _alone(self.estimation, results)


@dataclass(frozen=True)
class Figure7(Table1):
    """Real reaching error during the whole movement; runs of Table 1."""

    figure: ClassVar[str] = "figure7"
    source: ClassVar[str] = "table1"

    def summary(self, results: Mapping[str, Result]) -> Result:
        """That of Table 1, and the real reaching error in the course of the closed loop."""
        return super().summary(results) | {"course": _course(results, "reaching", _closing(self))}

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Position and orientation."""
        return _alone(self.reaching, results)


@dataclass(frozen=True)
class Figure8(Table1):
    """Real and estimated reaching error during the closed loop; runs of Table 1."""

    figure: ClassVar[str] = "figure8"
    source: ClassVar[str] = "table1"

    def summary(self, results: Mapping[str, Result]) -> Result:
        """That of Table 1, and the estimated reaching error in the course of the closed loop."""
        course = _course(results, "believed_reaching", _closing(self))
        return super().summary(results) | {"course": course}

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Position and orientation."""
        return _alone(self.closed, results)


def _closing(study: Table1) -> dict[str, int]:
    """Frames of the closed loop: its first, that after a fifth, its last."""
    fifth = study.frames + study.closed_frames // 5 - 1
    return {
        "first": study.frames,
        "fifth": max(fifth, study.frames),
        "last": study.frames + study.closed_frames - 1,
    }


def _course(results: Mapping[str, Result], name: str, at: Mapping[str, int]) -> Result:
    """One error of all movements in some frames, with the model without a mismatch."""
    found = curves([r["identical"] for r in results.values()], name)
    last = found.shape[1] - 1
    return {says: mean_and_sd(found[:, min(frame, last)]) for says, frame in at.items()}


def _alone(paint: Any, results: Mapping[str, Result]) -> Figure:
    """One published figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    paint(figure.subplots(1, 2), results)
    return figure
