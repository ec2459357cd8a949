"""What writers of results are killed at, for `kills.py`: each writes over an earlier result.

A scene works in a folder that holds its result and things that are none of its business, and tells
afterwards what of the result is there.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import cache, partial
from io import StringIO
from pathlib import Path
from typing import Any, ClassVar, NamedTuple
from unittest.mock import patch

import numpy as np

import bodyschema as bs
from bodyschema.answers.answer import Answer, load
from bodyschema.atomic.manifest import file_hash
from bodyschema.cli.export import Export
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.simulation.folder import write_simulation
from bodyschema.simulation.world import SimulatedRecording, Simulation, simulate
from bodyschema.studies.ledger import Ledger
from bodyschema.studies.runner import run_study, settings_of
from bodyschema.studies.study import Result, Rows, Task

OLD, NEW, PART = "old", "new", "part"
"""What can be there; part of a study with the lines that it has, all of them right."""

Write = Callable[[Path, str], None]
"""Writes the old or the new result at a place."""


class Scene(NamedTuple):
    """A writer and how its result is read."""

    name: str
    write: Write
    read: Callable[[Path], str]
    """What is there: "old", "new", "part", or what is wrong with it in a sentence."""


def contents(place: Path) -> dict[str, str]:
    """Hashes of the files of a result by name; of a single file under no name."""
    if place.is_file():
        return {"": file_hash(place)}
    return {one.name: file_hash(one) for one in place.iterdir()} if place.is_dir() else {}


@cache
def whole(write: Write) -> Mapping[str, Mapping[str, str]]:
    """Contents of the old and the new result, written undisturbed."""
    with tempfile.TemporaryDirectory() as name:
        for which in (OLD, NEW):
            write(Path(name) / which, which)
        return {which: contents(Path(name) / which) for which in (OLD, NEW)}


def which_whole(write: Write, place: Path) -> str:
    """Which of the two is at a place, whole."""
    there = contents(place)
    for which, files in whole(write).items():
        if there == files:
            return which
    return f"neither: {sorted(there)}"


# ---- answers and descriptions ----------------------------------------------------------------


@cache
def answer(which: str) -> Answer:
    """A small arm that was calibrated; old and new differ in a sentence and in a file."""
    rng = np.random.default_rng(0)
    body = bs.Body.random_chain(3, rng).attach("camera", "base")
    truth = replace(body, offset=np.array([0.0, 0.05, -0.04]))
    q = rng.uniform(-2, 2, (20, 3))
    seen = bs.Points.make(q, np.zeros((20, 3)), "camera", "tip").imagined(truth, q)
    seen = replace(seen, observed=seen.position + rng.normal(0, 1e-4, (20, 3)))
    found = bs.calibrate(body, [seen], {"camera": "roughly"}, ["offsets"], folds=2)
    files = {"report.html": 20_000 * which.encode(), f"{which}.txt": which.encode()}
    return replace(found, explanation=which, files=files, senses=(), sections=())


def save(place: Path, which: str) -> None:
    answer(which).save(place, overwrite=True)


def save_in_two_steps(place: Path, which: str) -> None:
    with patch("bodyschema.atomic.folder.swapped", lambda *_: False):
        save(place, which)


def loaded(write: Write, place: Path) -> str:
    """Which answer is there, as `load` finds it, and whether all of it is."""
    said, found = load(place).explanation, which_whole(write, place)
    return found if found == said else f"load finds {said}, there is {found}"


@cache
def inputs() -> tuple[Path, Path]:
    """Result folders and a description, to export from."""
    folder = tempfile.TemporaryDirectory()
    inputs.folder = folder  # type: ignore[attr-defined]  # goes away with this process
    place = Path(folder.name)
    (place / "robot.urdf").write_bytes(
        write_urdf(bs.Body.random_chain(3, np.random.default_rng(0)))
    )
    save(place / NEW, NEW)
    return place / NEW, place / "robot.urdf"


def export(place: Path, which: str) -> None:
    result, robot = inputs()
    if which == OLD:
        place.write_bytes(robot.read_bytes())
    else:
        with redirect_stdout(StringIO()):
            Export(result, robot=robot, out=place, overwrite=True).run()


# ---- simulations -----------------------------------------------------------------------------


@cache
def recorded(which: str) -> SimulatedRecording:
    return simulate(Simulation(n_samples=4, seed=len(which) if which == OLD else 0))


def record(place: Path, which: str) -> None:
    write_simulation(recorded(which), place, overwrite=True)


# ---- studies ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Counting:
    """Squares of the first numbers; its tasks take no time."""

    paper: ClassVar[str] = "nobody1900"
    figure: ClassVar[str] = "figure1"

    runs: int = 6
    """Number of tasks."""
    seed: int = 0
    """Of nothing."""
    name: str = NEW
    """Tells studies apart."""

    def tasks(self) -> Sequence[Task]:
        return [Task(f"run {n}", {"number": n}) for n in range(self.runs)]

    def work(self, task: Task) -> Result:
        return {"square": task.settings["number"] ** 2, "text": 200 * self.name}

    def summary(self, results: Mapping[str, Result]) -> Result:
        return {"squares": [result["square"] for result in results.values()]}

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        raise NotImplementedError

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Any:
        raise NotImplementedError


def study(place: Path, which: str, begun: int = 3) -> None:
    """Half of a study as the old one; all of it as the new, going on."""
    job = Counting()
    ledger = Ledger.open(place, settings_of(job))
    if which == OLD:
        for task in job.tasks()[:begun]:
            ledger.add(task.key, job.work(task))
        return
    results = run_study(job, 1, ledger)
    summary = json.dumps(job.summary(results)).encode()
    ledger.keep({"summary.json": summary, "figure.png": b"drawn"})


def study_anew(place: Path, which: str) -> None:
    """One study over another."""
    job = Counting(name=which)
    ledger = Ledger.open(place, settings_of(job), overwrite=True)
    ledger.keep({"summary.json": json.dumps(job.summary(run_study(job, 1, ledger))).encode()})


def counted(place: Path) -> str:
    """Whether all results that are there are those of the study that is there."""
    ledger = Ledger(place)
    job = Counting(name=json.loads((place / "study.json").read_text())["name"])
    right = {task.key: job.work(task) for task in job.tasks()}
    there = ledger.read()
    if there.damaged:
        return f"{there.damaged} damaged lines"
    if not there.results.items() <= right.items():
        return "results of another study"
    summary = place / "summary.json"
    if summary.is_file() and json.loads(summary.read_bytes()) != job.summary(right):
        return "a summary of another study"
    if job.name == NEW and len(there.results) < len(right):
        return PART
    return job.name


def went_on(place: Path) -> str:
    """As `counted`, with what was there before."""
    before = {f"run {n}" for n in range(3)}
    lost = before - {*Ledger(place).finished()}
    return f"lost: {sorted(lost)}" if lost else counted(place)


SCENES = (
    Scene("calibrate", save, partial(loaded, save)),
    Scene("two steps", save_in_two_steps, partial(loaded, save)),
    Scene("simulate", record, partial(which_whole, record)),
    Scene("export", export, partial(which_whole, export)),
    Scene("study", study, went_on),
    Scene("anew", study_anew, counted),
)
