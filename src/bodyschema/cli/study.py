"""`bodyschema study PAPER FIGURE`: a published experiment, its numbers beside the paper's."""

from __future__ import annotations

import inspect
import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import tyro

from bodyschema.cli.result import PLAIN
from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.studies.registry import PAPERS, STUDIES, study_class
from bodyschema.studies.study import Result, Study, source_of

if TYPE_CHECKING:
    from rich.console import Console

    from bodyschema.studies.ledger import Ledger

AnyStudy = TypeVar("AnyStudy", bound=Study)

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""


@dataclass(frozen=True)
class ListStudies:
    """Repeat a published experiment: bodyschema study PAPER FIGURE; alone, list them."""

    def run(self) -> int:
        """Print the papers and their figures; returns 0."""
        for paper, describes in PAPERS.items():
            figures = [figure for of, figure in STUDIES if of == paper]
            print(f"{paper}  {', '.join(figures)}\n    {describes}")
        print("\nbodyschema study PAPER FIGURE --help explains the settings of each.")
        return 0


@dataclass(frozen=True)
class RunStudy(Generic[AnyStudy]):
    """A study with the options that all studies share."""

    study: Annotated[AnyStudy, tyro.conf.OmitArgPrefixes, tyro.conf.arg(name="")]
    workers: int | None = None
    """Processes; one for each core when absent. The answer does not depend on it."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder, where finished tasks are not done again; studies/PAPER_FIGURE and what differs from
    the defaults when absent; with --json and no folder nothing is written. Figures of the same runs
    share one folder."""
    overwrite: bool = False
    """Begin anew in a folder that holds a study; what it found is dropped at once."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Run, write and print; returns 0, or 130 when interrupted."""
        from rich.console import Console

        self._check()
        messages = Console(stderr=True)
        ledger = self._ledger()
        damaged = ledger.read().damaged if ledger is not None else 0
        if damaged:
            messages.print(_damage(damaged), **PLAIN)
        try:
            results = self._work(ledger, messages)
        except KeyboardInterrupt:
            messages.print(_parting(ledger), **PLAIN)
            return INTERRUPTED
        summary = self.study.summary(results)
        text = json.dumps(summary, indent=None if self.json else 2, allow_nan=False)
        if ledger is not None:
            self._write(ledger, text, summary, results, messages)
        if self.json:
            print(text)
        else:
            self._show(summary, Console())
        return 0

    def _check(self) -> None:
        """Refuse settings that no study can work with."""
        if self.study.runs < 1 or (self.workers is not None and self.workers < 1):
            raise InputError("--runs and --workers count something; give numbers of 1 or more.")
        for entry in fields(self.study):
            value = getattr(self.study, entry.name)
            if isinstance(value, float) and not math.isfinite(value):
                flag = entry.name.replace("_", "-")
                raise InputError(f"--{flag} is {value}; give a finite number.")

    def _ledger(self) -> Ledger | None:
        from bodyschema.studies.ledger import Ledger
        from bodyschema.studies.runner import settings_of

        if self.json and self.out is None:
            return None
        return Ledger.open(self.folder(), settings_of(self.study), self.overwrite)

    def folder(self) -> Path:
        """Where the results go."""
        if self.out is not None:
            return self.out
        changed = [
            f"{entry.name}-{_word(getattr(self.study, entry.name))}"
            for entry in fields(self.study)
            if entry.default is MISSING or getattr(self.study, entry.name) != entry.default
        ]
        return Path("studies") / "_".join([self.study.paper, source_of(self.study), *changed])

    def _work(self, ledger: Ledger | None, messages: Console) -> dict[str, Result]:
        """All tasks, with a bar that says how far they are."""
        from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn

        from bodyschema.studies.runner import run_study

        columns = (*Progress.get_default_columns(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=messages) as bar:
            line = bar.add_task(f"{self.study.paper} {self.study.figure}", total=None)

            def tell(done: int, total: int) -> None:
                bar.update(line, completed=done, total=total)

            return run_study(self.study, self.workers or os.cpu_count() or 1, ledger, tell)

    def _write(
        self,
        ledger: Ledger,
        text: str,
        summary: Mapping[str, Any],
        results: Mapping[str, Result],
        messages: Console,
    ) -> None:
        """summary.json and the picture; under the figure's own name in another study's folder."""
        from bodyschema.studies.picture import picture_files

        files = {"summary.json": (text + "\n").encode()}
        name = f"{self.study.paper}_{self.study.figure}"
        try:
            files |= picture_files(name, lambda: self.study.draw(summary, results))
        except MissingExtraError as missing:
            messages.print(str(missing), **PLAIN)
        if source_of(self.study) != self.study.figure:
            own = self.study.figure
            files = {own + Path(name).suffix: content for name, content in files.items()}
        ledger.keep(files)

    def _show(self, summary: Mapping[str, Any], console: Console) -> None:
        from rich.table import Table

        answer = self.study.rows(summary)
        table = Table()
        for place, head in enumerate(answer.headers):
            table.add_column(head, justify="right" if place else "left")
        for row in answer.rows:
            table.add_row(*row)
        console.print(table)
        for note in answer.notes:
            console.print(f"- {note}", highlight=False, markup=False)
        console.print(f"\nAll of it: {self.folder()}", highlight=False, markup=False)


def study_verb(arguments: Sequence[str]) -> RunStudy[Any] | ListStudies:
    """The verb that `study ARGUMENTS` asks for; only the module of that study is loaded.

    Raises:
        InputError: no such paper or figure.
    """
    names = [word for word in arguments[:2] if not word.startswith("-")]
    if not names:
        return tyro.cli(ListStudies, prog="bodyschema study", args=list(arguments))
    paper = names[0]
    if paper not in PAPERS:
        raise InputError(f"no paper '{paper}' among the studies{did_you_mean(paper, PAPERS)}")
    figures = [figure for of, figure in STUDIES if of == paper]
    if len(names) == 1:
        raise InputError(f"name a figure of {paper}: {', '.join(figures)}.")
    figure = names[1]
    if figure not in figures:
        raise InputError(f"no study '{figure}' of {paper}{did_you_mean(figure, figures)}")
    kind = study_class(paper, figure)
    return tyro.cli(
        RunStudy[kind],  # type: ignore[valid-type]
        prog=f"bodyschema study {paper} {figure}",
        description=inspect.getdoc(kind),
        args=list(arguments[2:]),
        config=(tyro.conf.FlagCreatePairsOff,),
    )


def _word(value: object) -> str:
    """A setting as part of a folder's name."""
    return "-".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _damage(lines: int) -> str:
    """What is said of lines of tasks.jsonl that cannot be read."""
    some = "1 line of tasks.jsonl is damaged" if lines == 1 else f"{lines} lines are damaged"
    return f"{some} and left out; what stood there is done again."


def _parting(ledger: Ledger | None) -> str:
    if ledger is None:
        return "\nStopped; nothing was kept. With --out FOLDER the finished tasks would be."
    return (
        f"\nStopped; {len(ledger.finished())} finished tasks are kept in '{ledger.folder}'. "
        "The same command goes on from there."
    )
