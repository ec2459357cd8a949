"""Section 4.2 of Nabeshima and Kuniyoshi, with the truth: which cells are me, among movers?

The paper shows pictures of one robot (Fig. 3-5). Here two robots in MuJoCo move before cameras that
nobody has calibrated, and every cell's truth is known. The published detector and ours see the same
films: without a distractor, with things that move all the time, and with arms that repeat the
robot's motion half a second to a second later. As in the paper the robot makes each motion again,
the confirming motion; without it is the harder case, in films of their own. Beside them: a head
that moves while it looks, a sleeve that is put on, and a rod that is taken and let go.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.report.figure import AFTER, BEFORE, GREY
from bodyschema.simulation.film import Film
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.simulation.random_motions import CONFIRMED
from bodyschema.studies.carried_things import carry
from bodyschema.studies.confirmed_maps import Maps
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
METHODS = ("faithful", "faithful_share", "better_confirmed")
OUTSIDE = ("faithful_outside", "faithful_outside_share", "better")
"""In films without the confirming motion; ours needs none."""
SAYS = {
    "faithful": "any, conf.", "faithful_share": "share, conf.",
    "faithful_outside": "any", "faithful_outside_share": "share",
    "better_confirmed": "ours, conf.", "better": "ours",
}  # fmt: skip
SHOWN = {
    "faithful": (BEFORE, "--"), "faithful_share": (BEFORE, "-"),
    "faithful_outside": (GREY, "--"), "faithful_outside_share": (GREY, "-"),
    "better_confirmed": (AFTER, "--"), "better": (AFTER, "-"),
}  # fmt: skip
"""Colour and line of each in the picture."""


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
    share: float = 1 / 3
    """Of the motions that must find a cell, in the columns of the paper's blend (Fig. 5)."""

    def tasks(self) -> Sequence[Task]:
        """One film each: every distractor, with and without confirming, one of the extras."""
        found = []
        for run in range(self.runs):
            robot, extra = ROBOTS[run % 2], EXTRAS[run // 2 % len(EXTRAS)]
            confirmed = [f"confirmed {kind}" for kind in DISTRACTORS]
            for kind in (*confirmed, *DISTRACTORS, extra):
                settings = {"run": run, "robot": robot, "kind": kind}
                found.append(Task(f"run {run} {kind}", settings))
        return found

    def work(self, task: Task) -> Result:
        """Make the film, and show it to the detectors."""
        robot, kind = task.settings["robot"], task.settings["kind"]
        seed = self.seed * 100_003 + task.settings["run"]
        if kind in ("sleeve", "rod"):
            return carry(robot, kind, seed, self.motions)
        head, kind = kind == "head", kind.split()[-1]
        confirm = task.settings["kind"] != kind
        scene = MovingScene(
            robot, "always" if head else kind, seed, self.motions, confirm=confirm, head_moves=head
        )
        film = Studio(scene).film()
        joints = used_joints(film, head)
        finder = BodyFinder(joints, camera_joints=film.head if head else ())
        ours = "better_confirmed" if confirm else "better"
        answer: Result = {ours: _seen(finder, film, len(joints), confirm)}
        if not head:
            answer |= _published(film, joints, confirm, self.share)
        truth = truth_of(film)
        answer["boundary_share"] = float(1 - (truth.body | truth.never).mean())
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares by method, distractor and number of motions; errors of the delay; times."""
        kinds: dict[str, list[Result]] = {}
        for task in self.tasks():
            kinds.setdefault(task.settings["kind"], []).append(results[task.key])
        plain = [film for kind in DISTRACTORS for film in kinds[kind]]
        answer: Result = {"premises": {"confirming_motion": True, "share": self.share}}
        for method in METHODS:
            answer[method] = self._of(method, {k: kinds[f"confirmed {k}"] for k in DISTRACTORS})
        for method in OUTSIDE:
            answer[method] = self._of(method, kinds)
        for key in ("delay_error_ms", "ms_per_frame"):
            answer[key] = answer["better"][key]
        answer["moving_head"] = self._counted("better", kinds.get("head", []))
        answer["moving_head"]["delay_error_ms"] = _delay_error(kinds.get("head", []))
        for thing in ("sleeve", "rod"):
            answer[thing] = _carried(kinds.get(thing, []))
        answer["boundary_share"] = float(np.mean([film["boundary_share"] for film in plain]))
        return answer

    def _of(self, method: str, kinds: Mapping[str, Sequence[Result]]) -> Result:
        films = [film for kind in DISTRACTORS for film in kinds[kind]]
        clock = [film[method]["seconds_a_frame"] for film in films]
        found: Result = {kind: self._counted(method, kinds[kind]) for kind in DISTRACTORS}
        found["delay_error_ms"] = _delay_error(films) if method == "better" else None
        found["confirming_motion"] = method in METHODS
        return found | {"ms_per_frame": 1e3 * float(np.median(clock))}

    def _counted(self, method: str, films: Sequence[Result]) -> Result:
        return {
            str(k): shares([film[method]["after"][str(k)] for film in films])
            for k in REPORTED
            if k <= self.motions
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Precision / recall, by distractor and number of motions."""
        headers = ("distractor", *SAYS.values())
        table = [
            [f"{kind}, {k}", *(_cell(summary[method][kind][k]) for method in SAYS)]
            for kind in DISTRACTORS
            for k in summary["better"][kind]
        ]
        head = {k: v for k, v in summary["moving_head"].items() if k != "delay_error_ms"}
        nothing = ["-"] * (len(SAYS) - 1)
        table += [[f"moving head, {k}", *nothing, _cell(v)] for k, v in head.items()]
        return Rows(headers, table, self._notes(summary))

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        late, sleeve, rod = summary["delay_error_ms"], summary["sleeve"], summary["rod"]
        ms = [f"{summary[m]['ms_per_frame']:.1f}" for m in ("faithful", "better")]
        return [
            "Precision / recall over all cells of "
            f"{self.runs} scenes; {100 * summary['boundary_share']:.0f} % of the "
            "cells are swept by the outline and count neither way.",
            "Eq. 27 in four readings: cells that any of the motions found, or at least "
            f"{self.share:.2g} of them (the redder cells of Fig. 5); conf.: each motion is made "
            "back and once more, as in the paper, and both must find a cell (three motions for "
            "each that is counted).",
            f"Delay of the camera learned within {_number(late['median'])} ms (median), "
            f"{_number(late['p90'])} ms (90 %); true delays of 20 to 120 ms.",
            f"Worn sleeve: me after {_number(sleeve['me_after']['median'])} motions (median), in "
            f"{sleeve['became_me']} of {sleeve['films']}. Held rod: after "
            f"{_number(rod['me_after']['median'])}, in {rod['became_me']} of {rod['films']}; let "
            f"go: not me after {_number(rod['not_me_after']['median'])}, in "
            f"{rod['let_go']} of {rod['were_me']}.",
            f"ms a frame of 320 x 240, one core: {ms[0]} published, {ms[1]} ours.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Precision and recall against the number of motions."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11, 6), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True)
        noted = [k for k in NOTED if k <= self.motions]
        for column, kind in enumerate(DISTRACTORS):
            for method, (colour, line) in SHOWN.items():
                of = f"confirmed {kind}" if method in METHODS else kind
                tasks = [task for task in self.tasks() if task.settings["kind"] == of]
                films = [results[task.key][method]["after"] for task in tasks]
                found = [shares([film[str(k)] for film in films]) for k in noted]
                for row, what in enumerate(("precision", "recall")):
                    values = [np.nan if f[what] is None else f[what] for f in found]
                    style = {"color": colour, "linestyle": line, "label": SAYS[method]}
                    panels[row, column].plot(noted, values, marker="o", ms=4, **style)
        for column, kind in enumerate(DISTRACTORS):
            panels[0, column].set(title=f"distractor: {kind}", ylim=(0, 1.03))
            panels[1, column].set_xlabel("motions")
        panels[0, 0].set_ylabel("precision")
        panels[1, 0].set_ylabel("recall")
        panels[1, 2].legend(frameon=False, loc="lower right", fontsize=8)
        return figure


def _seen(detector: BodyFinder, film: Film, joints: int, confirm: bool) -> Result:
    """Cells right and wrong after some motions, the delay, and the time that it took."""
    truth, after, made = truth_of(film), {}, CONFIRMED if confirm else 1

    def note(done: int, found: BodyInView) -> None:
        if done % made == 0 and done // made in NOTED:
            after[str(done // made)] = counts(found, truth)

    begin = time.process_time()
    found = watch(detector, film, joints, note)
    seconds = (time.process_time() - begin) / len(film.time)
    lag = None if np.isnan(found.lag_s) else found.lag_s - film.delay_s
    return {"after": after, "lag_error": lag, "seconds_a_frame": seconds}


def _published(
    film: Film, joints: tuple[str, ...], confirm: bool, share: float
) -> dict[str, Result]:
    """Eq. 27, any of the motions or a share of them, from one pass."""
    truth, maps = truth_of(film), Maps(confirm)
    after: dict[str, dict[str, Any]] = {"": {}, "_share": {}}

    def note(_: int, found: BodyInView) -> None:
        if maps.add(found.evidence) and maps.count in NOTED:
            for ending, least in (("", 0.0), ("_share", share)):
                body = maps.body(found, least)
                after[ending][str(maps.count)] = counts(body, truth)

    begin = time.process_time()
    watch(OnsetCoincidence(joints), film, len(joints), note)
    seconds = (time.process_time() - begin) / len(film.time)
    name = "faithful" if confirm else "faithful_outside"
    return {
        f"{name}{ending}": {"after": found, "seconds_a_frame": seconds}
        for ending, found in after.items()
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
    both = (found[what] for what in ("precision", "recall"))
    return "/".join("-" if value is None else f"{value:.2f}" for value in both)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
