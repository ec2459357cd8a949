"""A robot's life from pictures alone: found, learned, certified, changed, noticed, learned again.

The paper's robot does in turn what this one does without a pause (Nabeshima and Kuniyoshi, sections
3.3, 4.2 and 4.3): a five-joint arm with a tool waggles its wrist before a stereo camera and finds
its hand as what moves; it swings, and learns where the camera is from corners of the hand; it
certifies itself and watches. Then, at times that it is not told,

    40 %   the tool slips through the gripper by 42 mm
    60 %   the head turns by 5.8 degrees and shifts by 66 mm
    80 %   the tool is swapped for another one

of the film. All it gets are the pictures of two cameras, 640x480, 30 a second, and its encoders.
What it says is held against where MuJoCo has camera and tool. A certificate is false when the
camera is further off than what was certified, 0.2 degrees and 5 mm. With `--hard` there are plain
metal, shadows, things that move by themselves, shake and motion blur.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.learners.hand_eye.corner_fit import twist_between
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import PictureState
from bodyschema.monitoring.pictures.watch import PictureWatch
from bodyschema.simulation.living_film import Happening, Kind, LivingFilm
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

CHANGES: tuple[tuple[Kind, float], ...] = (("slip", 0.4), ("head", 0.6), ("swap", 0.8))
"""What happens, and the share of the film after which it does."""
PART = {"slip": "tool", "head": "camera", "swap": "tool"}
"""What is to be blamed."""
PATIENCE = 15.0
"""s after a change in which an alarm may still be about it."""
PAPER = {"head": "1 s to notice, 26 s to know again", "slip": "10 s to know again", "swap": ""}
"""What the paper reports of its robot."""
EVERY = 15
"""Frames between two figures of the course."""


@dataclass(frozen=True)
class Life:
    """Find, learn, certify, notice, blame and learn again, from rendered pictures alone."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "life"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 5
    """Arms, cameras, rooms and motions."""
    seed: int = 0
    """The same seed gives the same answer."""
    seconds: float = 120.0
    """s of film in each."""
    still: bool = False
    """Let nothing happen: what is counted are false alarms."""
    hard: bool = False
    """Plain metal, shadows, things that move by themselves, shake and blur."""

    def __post_init__(self) -> None:
        if not self.seconds >= 5:
            raise InputError(f"a life of {self.seconds:g} s is too short; give at least 5.")

    def tasks(self) -> Sequence[Task]:
        """One life each."""
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """One life: events with the truth beside them, and the course of the errors."""
        changes = () if self.still else CHANGES
        happenings = [Happening(kind, share * self.seconds) for kind, share in changes]
        film = LivingFilm(
            [self.seed, int(task.settings["run"])], self.seconds, happenings, self.hard
        )
        watch = PictureWatch(PictureSettings(film.joints, film.stereo))
        state, events, course, used = watch.start(), [], [], 0.0
        for i, moment in enumerate(film.moments()):
            frame = StereoFrame(
                moment.time, moment.q, moment.T_world_hand, moment.left, moment.right
            )
            begin = clock.process_time()
            state, info = watch.step(state, frame)
            used += clock.process_time() - begin
            off = _off(state, film.camera(moment.time))
            if info.event:
                events.append([moment.time, info.event, info.part, *off])
            if i % EVERY == 0:
                course.append([moment.time, *off, *_on_me(state, film)])
        return {
            "events": events,
            "course": course,
            "happenings": [[one.kind, one.time] for one in happenings],
            "frames": len(film.time),
            "cpu_seconds": used,
        }

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares and times over all lives."""
        runs = list(results.values())
        hours = len(runs) * self.seconds / 3600
        first = [_first(run, "certified", "camera") for run in runs]
        certificates = [e for run in runs for e in run["events"] if e[1:3] == CAMERA]
        wrong = [e for e in certificates if e[3] > 0.2 or e[4] > 5.0]
        alarms = sum(len(_unfounded(run)) for run in runs)
        course = np.array([row for run in runs for row in run["course"]], dtype=float)
        known = course[np.isfinite(course[:, 3])] if len(course) else np.zeros((0, 7))
        return {
            "runs": len(runs),
            "certified_s": _times(first, len(runs)),
            "certificates": len(certificates),
            "false_certificates": len(wrong),
            "false_alarms": alarms,
            "hours": hours,
            "false_alarms_per_hour": alarms / hours,
            "inside_bound": float(np.mean(
                (known[:, 1] < known[:, 3]) & (known[:, 2] < known[:, 4])
            )) if len(known) else None,
            "rotation_deg": _middle(known[:, 1]),
            "camera_mm": _middle(known[:, 2]),
            "on_me": _middle(course[:, 5]) if len(course) else None,
            "changes": {
                kind: _change(kind, runs) for kind, _ in ([] if self.still else CHANGES)
            },
            "touch_mm": None,
            "load_pct": None,
            "fps": float(np.median([run["frames"] / run["cpu_seconds"] for run in runs])),
        }  # fmt: skip

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """What was noticed, how soon, and beside it the paper's robot."""
        first = summary["certified_s"]
        table = [
            ["certified after, s", _text(first["median"]), _text(first["p90"]), "59 s"],
            ["share certified", _text(first["share"]), "", ""],
        ]
        for kind, change in summary["changes"].items():
            noticed, again = change["noticed_s"], change["certified_again_s"]
            table += [
                [f"{kind}: noticed, s", _text(noticed["median"]), _text(noticed["p90"]),
                 PAPER[kind]],
                [f"{kind}: share noticed, blamed", _text(change["noticed"]),
                 _text(change["blamed"]), ""],
                [f"{kind}: known again, s", _text(again["median"]), _text(again["p90"]), ""],
            ]  # fmt: skip
        notes = [
            f"{summary['certificates']} certificates, {summary['false_certificates']} of them "
            f"false; {summary['false_alarms']} false alarms in {summary['hours']:.2f} hours; "
            f"{summary['fps']:.0f} frames a second of processor time.",
            "640x480 stereo pictures drawn by MuJoCo" + (", the hard film." if self.hard else "."),
        ]
        return Rows(("", "median", "90 %", "paper"), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """The camera's error over time, dotted the stated bound; what was said, and when."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 5), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        for n, (axes, label) in enumerate(zip(panels, ("rotation, deg", "place, mm"), strict=True)):
            for k, run in enumerate(results.values()):
                course = np.array(run["course"], dtype=float)
                axes.semilogy(course[:, 0], course[:, 1 + n], color=f"C{k}", lw=1.0)
                axes.semilogy(course[:, 0], course[:, 3 + n], color=f"C{k}", lw=0.7, ls=":")
            for kind, share in [] if self.still else CHANGES:
                axes.axvline(share * self.seconds, color="0.6", lw=0.8)
                axes.annotate(kind, (share * self.seconds, 1.0), xytext=(3, -3),
                              xycoords=("data", "axes fraction"), textcoords="offset points",
                              va="top", fontsize=9)  # fmt: skip
            axes.set_ylabel(label)
        panels[-1].set_xlabel("time, s (dotted: stated bound, 99 %)")
        figure.suptitle("How far the camera is from where it is believed to be")
        return figure


CAMERA = ["certified", "camera"]


def _off(state: PictureState, truth: Array) -> list[float]:
    """deg and mm by which the camera is off, and the stated bounds; inf where there is none."""
    camera, (turn, away) = state.T_world_cam, state.bounds
    if camera is None:
        return [1e9] * 4
    twist = twist_between(camera, truth)
    off = np.rad2deg(np.linalg.norm(twist[3:])), 1e3 * np.linalg.norm(twist[:3])
    stated = (float(np.rad2deg(turn)), 1e3 * away)
    return [float(x) if np.isfinite(x) else 1e9 for x in (*off, *stated)]


def _on_me(state: PictureState, film: LivingFilm) -> list[float | None]:
    """Share of the hand's corners that are on hand or tool, and how many are on the tool."""
    if state.hand is None or not len(state.hand.name):
        return [None, None]
    hand, tool = film.shown()
    v, u = np.rint(state.hand.place).astype(int).T[::-1]
    return [float((hand | tool)[v, u].mean()), float(tool[v, u].sum())]


def _first(run: Result, event: str, part: str, after: float = 0.0) -> float | None:
    """s of the first such event after a time."""
    times = [e[0] for e in run["events"] if e[1] == event and e[2] == part and e[0] >= after]
    return min(times, default=None)


def _unfounded(run: Result) -> list[list[Any]]:
    """Changes that were announced and are none of those that happened."""
    return [
        e for e in run["events"] if e[1] == "changed"
        and not any(0 <= e[0] - when < PATIENCE for _, when in run["happenings"])
    ]  # fmt: skip


def _change(kind: str, runs: Sequence[Result]) -> Result:
    """How often and how soon one kind of change was noticed, blamed rightly and made good."""
    noticed, blamed, again = [], 0, []
    for run in runs:
        when = next(t for name, t in run["happenings"] if name == kind)
        told = [e for e in run["events"] if e[1] == "changed" and 0 <= e[0] - when < PATIENCE]
        if not told:
            continue
        noticed.append(told[0][0] - when)
        blamed += told[0][2] == PART[kind]
        known = _first(run, "certified", PART[kind], told[0][0])
        again.append(None if known is None else known - when)
    n = len(runs)
    return {
        "n": n,
        "noticed": len(noticed) / n,
        "blamed": blamed / n,
        "noticed_s": _times(noticed, n),
        "certified_again_s": _times(again, n),
    }


def _times(values: Sequence[float | None], count: int) -> Result:
    """Median and 90 % of what came to pass, and the share that did."""
    there = [value for value in values if value is not None]
    if not there:
        return {"median": None, "p90": None, "share": 0.0}
    late = np.sort(there + [np.inf] * (count - len(there)))
    middle, most = np.quantile(late, (0.5, 0.9), method="higher")
    return {
        "median": float(middle) if np.isfinite(middle) else None,
        "p90": float(most) if np.isfinite(most) else None,
        "share": len(there) / count,
    }


def _middle(values: Array) -> float | None:
    values = values[np.isfinite(values) & (values < 1e8)]
    return float(np.median(values)) if len(values) else None


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
