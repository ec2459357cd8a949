"""Section 4.2 of Nabeshima and Kuniyoshi, with the truth: which cells are me, among movers?

The paper shows pictures of one robot (Fig. 3-5). Here two robots in MuJoCo move before cameras that
nobody has calibrated, and every cell's truth is known. The published detector and ours see the same
films: with things that move all the time in every scene, and in some without any, or with arms
that repeat the robot's motion half a second to a second later. As in the paper the robot makes each
motion again, the confirming motion; the harder case is the same motion before it is confirmed.
Ours needs none; by turns it also sees a film without, a head that moves while it looks, a sleeve
that is put on, or a rod that is taken and let go.
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
from bodyschema.report.figure import AFTER, BEFORE, GREY
from bodyschema.simulation.film import Film
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.simulation.random_motions import CONFIRMED
from bodyschema.studies.carried_things import carried, carry, quantiles
from bodyschema.studies.confirmed_maps import published
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_scenes import counts, shares, truth_of, used_joints, watch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROBOTS = ("arm", "humanoid")
ALWAYS = "always"
"""What moves by itself in every scene."""
DISTRACTORS = ("none", ALWAYS, "lagged")
TURNS = ("", "lagged", "", "none", "")
"""What else is filmed, confirmed, pair of scenes by pair."""
ALONE = (ALWAYS, "head", "sleeve", "rod")
"""And without confirming motions: the same scene, one whose head moves, things that are carried."""
NOTED = (1, 2, 3, 5, 8, 11, 15)
"""Numbers of motions after which the answer is scored."""
REPORTED = (1, 5, 15)
METHODS = ("faithful", "faithful_share", "faithful_outside", "faithful_outside_share")
OURS = ("better_confirmed", "better")
"""In films with and without the confirming motion."""
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
        """A film each: confirmed, one without by turns, in some scenes another confirmed."""
        found = []
        for run in range(self.runs):
            pair = run // 2
            others = (ALWAYS, TURNS[pair % len(TURNS)])
            kinds = [f"confirmed {kind}" for kind in others if kind]
            for kind in (*kinds, ALONE[pair % len(ALONE)]):
                settings = {"run": run, "robot": ROBOTS[run % 2], "kind": kind}
                found.append(Task(f"run {run} {kind}", settings))
        return found

    def work(self, task: Task) -> Result:
        """Make the film, and show it to the detectors."""
        robot, kind = task.settings["robot"], task.settings["kind"]
        seed = self.seed * 100_003 + task.settings["run"]
        if kind in ("sleeve", "rod"):
            return carry(robot, kind, seed, self.motions)
        head = kind == "head"
        mover: Any = ALWAYS if head else kind.split()[-1]
        confirm = kind.startswith("confirmed")
        scene = MovingScene(robot, mover, seed, self.motions, confirm=confirm, head_moves=head)
        film = Studio(scene).film()
        joints = used_joints(film, head)
        finder = BodyFinder(joints, camera_joints=film.head if head else ())
        ours = "better_confirmed" if confirm else "better"
        answer: Result = {ours: _seen(finder, film, len(joints), confirm)}
        if confirm:
            answer |= published(film, joints, self.share, NOTED)
        truth = truth_of(film)
        answer["boundary_share"] = float(1 - (truth.body | truth.never).mean())
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares by method, distractor and number of motions; errors of the delay; times."""
        kinds = self._films(results)
        plain = [*kinds[ALWAYS], *kinds[f"confirmed {ALWAYS}"]]
        answer: Result = {"premises": {"confirming_motion": True, "share": self.share}}
        for method in (*METHODS, *OURS):
            answer[method] = self._of(method, kinds)
        answer["delay_error_ms"] = _delay_error([film["better"] for film in kinds[ALWAYS]])
        answer["ms_per_frame"] = answer["better"]["ms_per_frame"]
        heads = kinds.get("head", [])
        answer["moving_head"] = self._counted("better", heads)
        answer["moving_head"]["delay_error_ms"] = _delay_error([film["better"] for film in heads])
        for thing in ("sleeve", "rod"):
            answer[thing] = carried(kinds.get(thing, []))
        answer["boundary_share"] = float(np.mean([film["boundary_share"] for film in plain]))
        return answer

    def _films(self, results: Mapping[str, Result]) -> dict[str, list[Result]]:
        """Results by what was filmed."""
        kinds: dict[str, list[Result]] = {}
        for task in self.tasks():
            kinds.setdefault(task.settings["kind"], []).append(results[task.key])
        return kinds

    def _of(self, method: str, kinds: Mapping[str, Sequence[Result]]) -> Result:
        found: Result = {"confirming_motion": method not in ("better", *METHODS[2:])}
        clock = []
        for kind in DISTRACTORS:
            films = kinds.get(kind if method == "better" else f"confirmed {kind}", [])
            clock += [film[method]["seconds_a_frame"] for film in films]
            if films:
                found[kind] = self._counted(method, films) | {"films": len(films)}
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
            [f"{kind}, {k}", *(_cell(summary[method].get(kind, {}).get(k)) for method in SAYS)]
            for kind in DISTRACTORS
            if kind in summary["faithful"]
            for k in summary["faithful"][kind]
            if k != "films"
        ]
        head = {k: v for k, v in summary["moving_head"].items() if k != "delay_error_ms"}
        nothing = ["-"] * (len(SAYS) - 1)
        table += [[f"moving head, {k}", *nothing, _cell(v)] for k, v in head.items()]
        return Rows(headers, table, self._notes(summary))

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        late, sleeve, rod = summary["delay_error_ms"], summary["sleeve"], summary["rod"]
        filmed = [kind for kind in DISTRACTORS if kind in summary["faithful"]]
        ms = [f"{summary[m]['ms_per_frame']:.1f}" for m in ("faithful", "better")]
        return [
            "Precision / recall over all cells of "
            + ", ".join(f"{summary['faithful'][kind]['films']} films ({kind})" for kind in filmed)
            + f"; {100 * summary['boundary_share']:.0f} % of the cells are swept by the outline "
            "and count neither way.",
            "Eq. 27 in four readings: cells that any of the motions found, or at least "
            f"{self.share:.2g} of them (the redder cells of Fig. 5); conf.: each motion is made "
            "back and once more, as in the paper, and both must find a cell (three motions for "
            "each that is counted); without, the first of the three alone.",
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

        films = self._films(results)
        filmed = [kind for kind in DISTRACTORS if f"confirmed {kind}" in films]
        figure = Figure(figsize=(2 + 3 * len(filmed), 6.4), layout="constrained")
        panels = figure.subplots(2, len(filmed), sharex=True, sharey="row", squeeze=False)
        for column, kind in enumerate(filmed):
            for method in SHOWN:
                of = films.get(kind if method == "better" else f"confirmed {kind}", [])
                if of:
                    self._draw_method(panels[:, column], method, of)
            panels[0, column].set_title(f"distractor: {kind} ({len(films[f'confirmed {kind}'])})")
            panels[1, column].set_xlabel("motions")
        panels[0, 0].set(ylabel="precision", ylim=(0, 1.03))
        panels[1, 0].set(ylabel="recall", ylim=(0, 1.03))
        handles, labels = panels[0, filmed.index(ALWAYS)].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
        return figure

    def _draw_method(self, panels: Any, method: str, films: Sequence[Result]) -> None:
        """Precision and recall of one method, one above the other."""
        noted = [k for k in NOTED if k <= self.motions]
        found = [shares([film[method]["after"][str(k)] for film in films]) for k in noted]
        colour, line = SHOWN[method]
        for axes, what in zip(panels, ("precision", "recall"), strict=True):
            values = [np.nan if f[what] is None else f[what] for f in found]
            style = {"color": colour, "linestyle": line, "label": SAYS[method]}
            axes.plot(noted, values, marker="o", ms=4, **style)


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


def _delay_error(films: Sequence[Result]) -> Result:
    """ms; median and 90 % of the size of the error at the end."""
    known = [1e3 * abs(film["lag_error"]) for film in films if film["lag_error"] is not None]
    return quantiles(known) | {"unknown": len(films) - len(known)}


def _cell(found: Mapping[str, float | None] | None) -> str:
    both = [found[what] for what in ("precision", "recall")] if found else [None]
    return "/".join("-" if value is None else f"{value:.2f}" for value in both)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
