"""What a study is: the settings of a published experiment, cut into independent tasks.

A study is a frozen dataclass. Its fields are its flags on the command line, their docstrings the
help. A runner gives it its tasks back one by one, in any order and from any process; the result of
a task depends on the task and the study's seed alone, so that the answer is the same on one core
and on many, in one go and resumed. Clocks are the exception: times that a task reports are what
they were.

    tasks   ->  work (anywhere, any order)  ->  summary  ->  rows, picture
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Result = dict[str, Any]
"""What a task found: text, finite numbers, None, and lists and dicts (keys text) of them."""


@dataclass(frozen=True)
class Task:
    """A part of a study that can be done alone, in one to ten seconds."""

    key: str
    """Unique in its study; names the task in the file of finished ones."""
    settings: Mapping[str, Any]
    """What the study's `work` needs to know, JSON types only."""


@dataclass(frozen=True)
class Rows:
    """The answer as a table, the paper's numbers beside ours."""

    headers: Sequence[str]
    rows: Sequence[Sequence[str]]
    """Text ready to be read, one cell a header."""
    notes: Sequence[str] = ()
    """Sentences on how to read it: settings, readings of the paper, misses."""


class Study(Protocol):
    """A published experiment; a frozen dataclass of settings.

    Figures that are drawn from the runs of another study of the paper name that in a class variable
    `source`, and have its settings: their tasks are kept in its folder and done once for all.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]
    paper: ClassVar[str]
    """First author and year, as in "hersch2008"."""
    figure: ClassVar[str]
    """"figure3"."""

    @property
    def runs(self) -> int:
        """Number of repetitions; 1 or 2 must work, for a quick look."""
        ...

    @property
    def seed(self) -> int:
        """The same seed gives the same results."""
        ...

    def tasks(self) -> Sequence[Task]:
        """The parts, in a fixed order."""
        ...

    def work(self, task: Task) -> Result:
        """Do one part; called in any process."""
        ...

    def summary(self, results: Mapping[str, Result]) -> Result:
        """The answer, from the results by key in the order of `tasks`."""
        ...

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """The answer for the terminal."""
        ...

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """The paper's figure, ours beside it."""
        ...


def source_of(study: Study) -> str:
    """The figure in whose folder the tasks of a study are kept; mostly its own."""
    return str(getattr(study, "source", study.figure))
