"""Figures 3 to 5 of Nabeshima and Kuniyoshi: motion coincidence, moment by moment and blended.

Fig. 3 shows the first 300 ms of one motion: cells in which there is flow, and cells that have been
discovered. Fig. 4 shows the joints' speeds beside the evidence for each joint, Fig. 5 the blend of
the evidence of 15 motions. The paper shows one run of a real arm while a person moves in view; here
an arm moves in MuJoCo before a textured room in which other things move all the time. As in the
paper, each motion is made again (`confirmed_maps`), unless `--no-confirm` asks for the harder case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.simulation.film import Film
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.simulation.random_motions import RATE
from bodyschema.studies.coincidence_pictures import blended, outline, packed, show
from bodyschema.studies.confirmed_maps import Maps, moments
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_scenes import counts, shares, truth_of, used_joints, watch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOMENTS = (0, 2, 4, 6, 8, 10)
"""Frames after the motion's onset, of the panels of Fig. 3."""
SHOWN_S = (-0.2, 0.7)
"""s about the onset that Fig. 4 shows."""
HEADS = ("precision", "recall", "right joint")
SAYS = {
    "faithful": "Eq. 27, any of the motions",
    "faithful_share": "Eq. 27, {:.2g} of the motions",
    "better": "ours, same film",
}
NOTES = (
    "Boundary cells, which the body's outline sweeps, count neither way.",
    "The paper gives no numbers: its pictures show the discovered cells on the arm.",
)


@dataclass(frozen=True)
class Figure3:
    """A motion, the confirming one: where there is flow, and what is discovered, every 67 ms."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure3"

    runs: int = 1
    """Scenes, each with another camera, posture, motion and delay; the first one is drawn."""
    seed: int = 0
    """The same seed gives the same answer."""
    confirm: bool = True
    """Whether the robot makes each motion again, as in the paper: the confirming motion."""

    def tasks(self) -> Sequence[Task]:
        """One film each."""
        return _films(self.runs)

    def work(self, task: Task) -> Result:
        """Panels, and how many cells are right and wrong in each."""
        film = _film(self.seed, task, 1, self.confirm)
        truth, joints = truth_of(film), used_joints(film, head_moves=False)
        panels: list[Result] = []
        for moment in moments(film, joints, self.confirm):
            since = moment.since_onset
            if since is None or round(RATE * since) not in MOMENTS:
                continue
            panels.append(
                {
                    "ms": round(1e3 * since),
                    "picture": packed(moment.picture),
                    "moving": moment.moving.tolist(),
                    "found": moment.found.mask.tolist(),
                    "cells": counts(moment.found, truth),
                }
            )
        return {"panels": panels}

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Precision and recall of what is discovered, by ms after the onset."""
        films = [result["panels"] for result in results.values()]
        return {
            str(panel["ms"]): shares([panels[i]["cells"] for panels in films])
            for i, panel in enumerate(films[0])
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a moment."""
        table = [[f"{ms} ms", *_words(found)] for ms, found in summary.items()]
        return Rows(("after the onset", *HEADS), table, (_made(self.confirm), *NOTES))

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """The pictures, flow in blue and what is discovered in red."""
        from matplotlib.figure import Figure

        panels = results[self.tasks()[0].key]["panels"]
        figure = Figure(figsize=(12, 6.4), layout="constrained")
        for axes, panel in zip(figure.subplots(2, 3).flat, panels, strict=False):
            show(axes, panel["picture"], f"{panel['ms']} ms")
            outline(axes, panel["moving"], "tab:blue")
            outline(axes, panel["found"], "tab:red")
        return figure


@dataclass(frozen=True)
class Figure4:
    """One motion: speeds of the joints, and the cells that each joint is found to move."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure4"

    runs: int = 1
    """Scenes, each with another camera, posture, motion and delay; the first one is drawn."""
    seed: int = 0
    """The same seed gives the same answer."""
    confirm: bool = True
    """Whether the robot makes each motion again, as in the paper: the confirming motion."""

    def tasks(self) -> Sequence[Task]:
        """One film each."""
        return _films(self.runs)

    def work(self, task: Task) -> Result:
        """Speeds about the onset, and the evidence when the motion is over."""
        film = _film(self.seed, task, 1, self.confirm)
        joints = used_joints(film, head_moves=False)
        *_, last = moments(film, joints, self.confirm)
        return {
            "joints": list(joints),
            "onset": None if last.since_onset is None else last.found.time - last.since_onset,
            "time": film.time[1:].tolist(),
            "speed": (RATE * np.diff(film.q[:, : len(joints)], axis=0)).T.tolist(),
            "evidence": last.likelihood.astype(int).tolist(),
            "picture": packed(last.picture),
            "cells": counts(last.found, truth_of(film)),
        }

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Precision and recall of what is discovered, and whether the joint is right."""
        return shares([result["cells"] for result in results.values()])

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row."""
        notes = (_made(self.confirm), *NOTES)
        return Rows(("after", *HEADS), [["1 motion", *_words(summary)]], notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Speeds above, one map a joint below."""
        from matplotlib.figure import Figure

        first = results[self.tasks()[0].key]
        figure = Figure(figsize=(13, 6), layout="constrained")
        above = figure.add_subfigure(figure.add_gridspec(2, 1)[0])
        below = figure.add_subfigure(figure.add_gridspec(2, 1)[1])
        axes, time = above.subplots(), np.array(first["time"]) - (first["onset"] or 0.0)
        near = (time > SHOWN_S[0]) & (time < SHOWN_S[1])
        panels = below.subplots(1, len(first["joints"]))
        for i, (name, panel) in enumerate(zip(first["joints"], panels, strict=True)):
            axes.plot(1e3 * time[near], np.array(first["speed"][i])[near], label=name)
            show(panel, first["picture"], name)
            outline(panel, first["evidence"][i], "tab:red")
        axes.set(xlabel="ms after the first onset", ylabel="rad/s")
        axes.legend(frameon=False, ncols=3)
        return figure


@dataclass(frozen=True)
class Figure5:
    """Fifteen motions: the blend of what each of them discovers; beside it our probability."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure5"

    runs: int = 1
    """Scenes, each with another camera, posture, motion and delay; the first one is drawn."""
    seed: int = 0
    """The same seed gives the same answer."""
    confirm: bool = True
    """Whether the robot makes each motion again, as in the paper: the confirming motion."""
    motions: int = 15
    """Motions in a film, each with its confirmation."""
    share: float = 1 / 3
    """Of the motions that must find a cell, where the blend is turned into an answer."""

    def tasks(self) -> Sequence[Task]:
        """One film each."""
        return _films(self.runs)

    def work(self, task: Task) -> Result:
        """Share of the motions that coincided, and our probability, cell by cell."""
        film = _film(self.seed, task, self.motions, self.confirm)
        truth, joints = truth_of(film), used_joints(film, head_moves=False)
        answer: Result = {"picture": packed(film.pictures[-1]), "body": truth.body.tolist()}
        maps = Maps(self.confirm)

        def note(_: int, found: BodyInView) -> None:
            maps.add(found.evidence)

        last = watch(OnsetCoincidence(joints), film, len(joints), note)
        ours = watch(BodyFinder(joints), film, len(joints))
        seen = {"faithful": maps.body(last, 0.0), "faithful_share": maps.body(last, self.share)}
        for name, found in (seen | {"better": ours}).items():
            blend = found.probability.round(3).tolist()
            answer[name] = {"blend": blend, "cells": counts(found, truth)}
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Precision and recall of all."""
        return {name: shares([r[name]["cells"] for r in results.values()]) for name in SAYS}

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a detector."""
        table = [[SAYS[name].format(self.share), *_words(found)] for name, found in summary.items()]
        notes = (_made(self.confirm), *NOTES)
        return Rows((f"after {self.motions} motions", *HEADS), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Both blends over the last picture; the body's cells in blue."""
        from matplotlib.figure import Figure

        first = results[self.tasks()[0].key]
        figure = Figure(figsize=(12, 4.8), layout="constrained")
        titles = {
            "faithful": "Eq. 27: share of the motions (blue: the body)",
            "better": "ours: probability",
        }
        for axes, (name, title) in zip(figure.subplots(1, 2), titles.items(), strict=True):
            show(axes, first["picture"], title)
            blended(axes, first[name]["blend"])
            outline(axes, first["body"], "tab:blue")
        return figure


def _films(runs: int) -> list[Task]:
    return [Task(f"run {run}", {"run": run}) for run in range(runs)]


def _film(seed: int, task: Task, motions: int, confirm: bool) -> Film:
    """The arm before things that move all the time."""
    own = seed * 100_003 + task.settings["run"]
    scene = MovingScene("arm", "always", own, motions, confirm=confirm)
    return Studio(scene).film()


def _made(confirm: bool) -> str:
    """What the robot did."""
    if confirm:
        return "Each motion was made again: found is what began to move with it both times."
    return "Without the confirming motion, which the paper presumes."


def _words(found: Mapping[str, float | None]) -> list[str]:
    return ["-" if value is None else f"{value:.2f}" for value in found.values()]
