"""Section 4.2 of Nabeshima and Kuniyoshi, with the truth: which cells are me, among movers?

The paper shows pictures of one robot (Fig. 3-5). Here two robots in MuJoCo move before cameras that
nobody has calibrated, and every cell's truth is known. The published detector and ours see the same
films: without a distractor, with things that move all the time, and with arms that repeat the
robot's motion half a second to a second later. Beside them: a head that moves while it looks, a
sleeve that is put on, and a rod that is taken and let go.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.report.figure import AFTER, BEFORE, GREY
from bodyschema.simulation.film import Film
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.studies.carried_things import carry
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_scenes import counts, shares, truth_of, used_joints, watch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROBOTS = ("arm", "humanoid")
DISTRACTORS = ("none", "always", "lagged")
EXTRAS = ("head", "sleeve", "rod")
"""What else happens: a head that moves, a sleeve that is put on, a rod that is taken and let go."""
NOTED = (1, 2, 3, 5, 8, 11, 15)
"""Numbers of motions after which the answer is scored."""
REPORTED = (1, 5, 15)
METHODS = ("faithful", "voted", "better")
SAYS = {"faithful": "Eq. 27", "voted": "Eq. 27, half of the motions", "better": "ours"}


@dataclass(frozen=True)
class FindBody:
    """Cells of the own body: precision and recall of the published detector and of ours."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "find-body"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 20
    """Scenes, each with another camera, posture, motion and delay; both robots by turns."""
    seed: int = 0
    """The same seed gives the same answer."""
    motions: int = 15
    """Motions in a film."""

    def tasks(self) -> Sequence[Task]:
        """One film each: every distractor, and one of the extras by turns."""
        found = []
        for run in range(self.runs):
            robot, extra = ROBOTS[run % 2], EXTRAS[run // 2 % len(EXTRAS)]
            for kind in (*DISTRACTORS, extra):
                settings = {"run": run, "robot": robot, "kind": kind}
                found.append(Task(f"run {run} {kind}", settings))
        return found

    def work(self, task: Task) -> Result:
        """Make the film, and show it to the detectors."""
        robot, kind = task.settings["robot"], task.settings["kind"]
        seed = self.seed * 100_003 + task.settings["run"]
        if kind in ("sleeve", "rod"):
            return carry(robot, kind, seed, self.motions)
        head = kind == "head"
        scene = MovingScene(robot, "always" if head else kind, seed, self.motions, head_moves=head)
        film = Studio(scene).film()
        joints = used_joints(film, head)
        camera = film.head if head else ()
        answer: Result = {
            "better": _seen(BodyFinder(joints, camera_joints=camera), film, len(joints))
        }
        if not head:
            answer |= _published(film, joints)
        truth = truth_of(film)
        answer["boundary_share"] = float(1 - (truth.body | truth.never).mean())
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares by method, distractor and number of motions; errors of the delay; times."""
        kinds: dict[str, list[Result]] = {}
        for key, result in results.items():
            kinds.setdefault(key.split()[-1], []).append(result)
        answer: Result = {method: self._of(method, kinds) for method in METHODS}
        for key in ("delay_error_ms", "ms_per_frame"):
            answer[key] = answer["better"][key]
        answer["moving_head"] = self._counted("better", kinds.get("head", []))
        answer["moving_head"]["delay_error_ms"] = _delay_error(kinds.get("head", []))
        for thing in ("sleeve", "rod"):
            answer[thing] = _carried(kinds.get(thing, []))
        films = [film for kind in DISTRACTORS for film in kinds[kind]]
        answer["boundary_share"] = float(np.mean([film["boundary_share"] for film in films]))
        return answer

    def _of(self, method: str, kinds: Mapping[str, Sequence[Result]]) -> Result:
        films = [film for kind in DISTRACTORS for film in kinds[kind]]
        clock = [film[method]["seconds_a_frame"] for film in films]
        found: Result = {kind: self._counted(method, kinds[kind]) for kind in DISTRACTORS}
        found["delay_error_ms"] = _delay_error(films) if method == "better" else None
        return found | {"ms_per_frame": 1e3 * float(np.median(clock))}

    def _counted(self, method: str, films: Sequence[Result]) -> Result:
        return {
            str(k): shares([film[method]["after"][str(k)] for film in films])
            for k in REPORTED
            if k <= self.motions
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Precision / recall / share of cells whose joint is named rightly."""
        headers = ("distractor, motions", *(SAYS[method] for method in METHODS))
        table = [
            [f"{kind}, {k}", *(_cell(summary[method][kind][k]) for method in METHODS)]
            for kind in DISTRACTORS
            for k in summary["better"][kind]
        ]
        head = {k: v for k, v in summary["moving_head"].items() if k != "delay_error_ms"}
        table += [[f"moving head, {k}", "-", "-", _cell(v)] for k, v in head.items()]
        return Rows(headers, table, self._notes(summary))

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        late, ms = summary["delay_error_ms"], [f"{summary[m]['ms_per_frame']:.1f}" for m in METHODS]
        sleeve, rod = summary["sleeve"], summary["rod"]
        return [
            "Precision / recall / share of the right joint, over all cells of "
            f"{self.runs} scenes; {100 * summary['boundary_share']:.0f} % of the "
            "cells are swept by the outline and count neither way.",
            f"Delay of the camera learned within {_number(late['median'])} ms (median), "
            f"{_number(late['p90'])} ms (90 %); true delays of 20 to 120 ms.",
            f"Worn sleeve: me after {_number(sleeve['me_after']['median'])} motions (median), in "
            f"{sleeve['became_me']} of {sleeve['films']}. Held rod: after "
            f"{_number(rod['me_after']['median'])}, in {rod['became_me']} of {rod['films']}; let "
            f"go: not me after {_number(rod['not_me_after']['median'])}, in "
            f"{rod['let_go']} of {rod['were_me']}.",
            f"ms a frame of 320 x 240, one core: {ms[0]} published, {ms[2]} ours.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Precision and recall against the number of motions."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11, 6), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True)
        colours = dict(zip(METHODS, (BEFORE, GREY, AFTER), strict=True))
        noted = [k for k in NOTED if k <= self.motions]
        for column, kind in enumerate(DISTRACTORS):
            films = [result for key, result in results.items() if key.endswith(f" {kind}")]
            for method in METHODS:
                found = [shares([film[method]["after"][str(k)] for film in films]) for k in noted]
                for row, what in enumerate(("precision", "recall")):
                    axes = panels[row, column]
                    values = [np.nan if f[what] is None else f[what] for f in found]
                    axes.plot(noted, values, "o-", color=colours[method], label=SAYS[method], ms=4)
                    axes.set(title=f"distractor: {kind}" if row == 0 else "", ylim=(0, 1.03))
                    axes.set_ylabel(what if column == 0 else "")
            panels[1, column].set_xlabel("motions")
        panels[0, 0].legend(frameon=False)
        return figure


def _seen(detector: BodyFinder | OnsetCoincidence, film: Film, joints: int) -> Result:
    """Cells right and wrong after some motions, the delay, and the time that it took."""
    truth, after = truth_of(film), {}

    def note(done: int, found: BodyInView) -> None:
        if done in NOTED:
            after[str(done)] = counts(found, truth)

    begin = time.process_time()
    found = watch(detector, film, joints, note)
    seconds = (time.process_time() - begin) / len(film.time)
    lag = None if np.isnan(found.lag_s) else found.lag_s - film.delay_s
    return {"after": after, "lag_error": lag, "seconds_a_frame": seconds}


def _published(film: Film, joints: tuple[str, ...]) -> dict[str, Result]:
    """Eq. 27 as it stands, and with a vote of half of the motions, from one pass."""
    truth, after, voted = truth_of(film), {}, {}

    def note(done: int, found: BodyInView) -> None:
        if done in NOTED:
            after[str(done)] = counts(found, truth)
            half = found.evidence.max(axis=0) >= max(done / 2, 1)
            voted[str(done)] = counts(replace(found, mask=found.mask & half), truth)

    begin = time.process_time()
    watch(OnsetCoincidence(joints), film, len(joints), note)
    seconds = (time.process_time() - begin) / len(film.time)
    return {
        "faithful": {"after": after, "seconds_a_frame": seconds},
        "voted": {"after": voted, "seconds_a_frame": seconds},
    }


def _delay_error(films: Sequence[Result]) -> Result:
    """ms; median and 90 % of the size of the error at the end."""
    errors = [film["better"]["lag_error"] for film in films]
    known = [1e3 * abs(error) for error in errors if error is not None]
    return _spread(known) | {"unknown": len(errors) - len(known)}


def _carried(films: Sequence[Result]) -> Result:
    """Over the films in which the thing covers at least one cell."""
    seen = [film for film in films if film["cells"]]
    were = [film for film in seen if film["cells_left"]]
    worn = [film["me_after"] for film in seen if film["me_after"] is not None]
    let_go = [film["not_me_after"] for film in were if film["not_me_after"] is not None]
    return {
        "films": len(seen), "became_me": len(worn), "me_after": _spread(worn),
        "were_me": len(were), "let_go": len(let_go), "not_me_after": _spread(let_go),
    }  # fmt: skip


def _spread(values: Sequence[float]) -> Result:
    if not values:
        return {"median": None, "p90": None}
    return {"median": float(np.median(values)), "p90": float(np.quantile(values, 0.9))}


def _cell(found: Mapping[str, float | None]) -> str:
    return " / ".join(_number(value) for value in found.values())


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
