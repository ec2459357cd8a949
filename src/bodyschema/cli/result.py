"""What every verb does with its answer: look at the place, write the folder, say what was found."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema.errors import shown

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer


def prepare(
    out: Path,
    overwrite: bool,
    run_file: Path | None,
    run: Mapping[str, Any],
    more: Sequence[Path] = (),
) -> None:
    """Refuse a folder that could not be written, or that holds an input.

    Args:
        out: for the result.
        overwrite: whether an earlier result may be replaced.
        run_file: that was read.
        run: what it says.
        more: further inputs.

    Raises:
        InputError: in one sentence.
    """
    from bodyschema.export.result_folder import check_place, inputs_of, refuse_inputs

    refuse_inputs(out, [*([run_file] if run_file else []), *inputs_of(None, run), *more])
    check_place(out, overwrite)


def finish(
    answer: Answer,
    out: Path,
    overwrite: bool,
    as_object: bool,
    more: Mapping[str, Any] | None = None,
    then: str = "",
    force: bool = False,
) -> int:
    """Write the folder and print the answer; returns the exit code, 1 for bad news.

    Args:
        answer: of a verb.
        out: folder for it.
        overwrite: replace an earlier result.
        as_object: print one JSON object instead of text.
        more: keys of the object that are not stored.
        then: what to do next, for people.
        force: write even what the data contradict.
    """
    if answer.trust.level == "contradicted" and not force:
        return say(answer, None, as_object, more)
    answer.save(out, overwrite)
    return say(answer, out, as_object, more, then)


def say(
    answer: Answer,
    out: Path | None,
    as_object: bool,
    more: Mapping[str, Any] | None = None,
    then: str = "",
) -> int:
    """Print an answer whose folder is written, or not (None); see `finish`."""
    from rich.console import Console

    from bodyschema.report.summary import as_json, finite, print_answer

    if as_object:
        place = {} if out is None else {"folder": str(out)}
        object_ = {**as_json(answer), **place, **(more or {})}
        print(json.dumps(finite(object_)))
    else:
        console = Console()
        print_answer(console, answer.document, hint="" if out is None else how_to_see_all(out))
        console.print(f"\n{NOTHING if out is None else shown(_written(out))}", **PLAIN)
        if then:
            console.print(shown(then), **PLAIN)
    return 1 if answer.tone == "bad" else 0


def how_to_see_all(out: Path) -> str:
    """The command that prints what an answer in short leaves out, quoted for a shell."""
    return f"`bodyschema report {shown(shlex.quote(str(out)))} --all`"


def _written(out: Path) -> str:
    page = out / "report.html"
    report = f"Report: {page}" if page.is_file() else NO_PAGE
    return f"{report}   all numbers: {out / 'answer.json'}"


NOTHING = "Nothing was written. Mend what is said above, or insist with --force."
NO_PAGE = "There is no report.html; install the extra: pip install 'bodyschema[report]'"
PLAIN: dict[str, Any] = {"highlight": False, "markup": False, "soft_wrap": True}
