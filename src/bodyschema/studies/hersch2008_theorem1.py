"""Hersch et al. 2008, Theorem 1: when is the true axis of one joint the only minimum?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from bodyschema.studies.one_joint import Swing, bowl, settle
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

REACHES_DEG = (180.0, 135.0, 90.0, 45.0, 22.5)
STARTS = 16
"""Random axes from which each problem is descended."""
APART = 1e-3
"""rad: nearer to the true axis is the true axis."""
CURVED = 1e-4
"""Least curvature of a strict minimum, in units of s."""


@dataclass(frozen=True)
class Theorem1:
    """Random problems of one joint: how many have a false minimum, for each range of the joint.

    With one fixed end point, and with an end point that varies.
    """

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "theorem1"

    runs: int = 1000
    """Random problems (true axis and end point) for each range."""
    seed: int = 0
    """The same seed gives the same results."""

    def tasks(self) -> Sequence[Task]:
        """One for each range of the joint."""
        return [Task(f"+-{reach:g} deg", {"reach_deg": reach}) for reach in REACHES_DEG]

    def work(self, task: Task) -> Result:
        """Problems with a false strict minimum, and random starts that ended in one."""
        swing = Swing.uniform(float(np.deg2rad(task.settings["reach_deg"])))
        rng = np.random.default_rng([self.seed, REACHES_DEG.index(task.settings["reach_deg"])])
        false = caught = 0
        for _ in range(self.runs):
            ends, true, v = _descended(rng, swing)
            away = [a for a in ends if np.linalg.norm(a - true) > APART]
            strict = [a for a in away if bowl(a, true, v, swing) > CURVED * swing.s]
            caught += len(strict)
            false += bool(strict)
        return {"false": false, "caught": caught}

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares by range, and the widest range with one minimum for a varied end point."""
        return {
            "runs": self.runs,
            "widest_deg": round(float(np.rad2deg(widest())), 2),
            "ranges": {str(reach): self._found(reach, results) for reach in REACHES_DEG},
        }

    def _found(self, reach: float, results: Mapping[str, Result]) -> Result:
        swing, of = Swing.uniform(float(np.deg2rad(reach))), results[f"+-{reach:g} deg"]
        return {
            "condition_as_printed": bool(swing.as_printed),
            "fixed_false_minimum": of["false"] / self.runs,
            "fixed_starts_caught": of["caught"] / (STARTS * self.runs),
            "varied_condition": bool(swing.single),
            "varied_starts_caught": round(swing.caught, 4),
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a range."""
        rows = [
            [
                f"+-{float(reach):g} deg", "holds" if of["condition_as_printed"] else "fails",
                f"{of['fixed_false_minimum']:.0%}", f"{of['fixed_starts_caught']:.0%}",
                "holds" if of["varied_condition"] else "fails", f"{of['varied_starts_caught']:.0%}",
            ]
            for reach, of in summary["ranges"].items()
        ]  # fmt: skip
        head = ["joint", "var cos <= 2 var sin", "fixed v: false minimum", "starts caught",
                "k <= s", "varied v: starts caught"]  # fmt: skip
        notes = [
            "The paper: no false minimum where var cos <= 2 var sin. With one fixed end point v "
            "that is not so: the table counts random problems that have a strict one, and random "
            f"starts that end there ({STARTS} a problem).",
            "With v varied on a sphere the true axis is the only minimum if and only if "
            "<(1 - cos)^2> = k <= s = <sin^2>: for uniform joints up to "
            f"+-{summary['widest_deg']:.0f} deg. Beyond, the opposite axis is a minimum too.",
        ]
        return Rows(head, rows, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Starts caught against the range of the joint."""
        from matplotlib.figure import Figure

        from bodyschema.report.figure import AFTER, BEFORE

        figure = Figure(figsize=(7, 4), layout="constrained")
        panel = figure.subplots()
        reaches = np.array(REACHES_DEG)
        found = list(summary["ranges"].values())
        fixed = [100 * of["fixed_starts_caught"] for of in found]
        wide = np.linspace(5, 180, 300)
        varied = [100 * Swing.uniform(float(reach)).caught for reach in np.deg2rad(wide)]
        panel.plot(reaches, fixed, "o-", color=BEFORE, label="one fixed v (counted)")
        panel.plot(wide, varied, color=AFTER, label="v varied (derived)")
        panel.set(xlabel="joint uniform in +- deg", ylim=(0, None))
        panel.set_title("random starts that end in a false minimum, %")
        panel.legend()
        return figure


def widest() -> float:
    """The range +-q (rad) of a uniform joint at which k = s."""

    def excess(reach: float) -> float:
        swing = Swing.uniform(reach)
        return swing.k - swing.s

    return float(brentq(excess, 1.0, np.pi))


def _descended(rng: np.random.Generator, swing: Swing) -> tuple[list[Array], Array, Array]:
    """Where `STARTS` random axes come to rest, the true axis, and v, all random unit vectors."""
    drawn = rng.normal(size=(STARTS + 2, 3))
    drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
    true, v, starts = drawn[0], drawn[1], drawn[2:]
    return [a for a in starts if settle(true, v, swing.s, swing.c, a)], true, v
