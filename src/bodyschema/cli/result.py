"""What every verb does with its answer: look at the place, write the folder, say what was found."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
) -> int:
    """Write the folder and print the answer; returns the exit code, 1 for bad news.

    Args:
        answer: of a verb.
        out: folder for it.
        overwrite: replace an earlier result.
        as_object: print one JSON object instead of text.
        more: keys of the object that are not stored.
        then: what to do next, for people.
    """
    answer.save(out, overwrite)
    return say(answer, out, as_object, more, then)


def say(
    answer: Answer,
    out: Path,
    as_object: bool,
    more: Mapping[str, Any] | None = None,
    then: str = "",
) -> int:
    """Print an answer whose folder is written; see `finish`."""
    from rich.console import Console

    from bodyschema.judging.calibration import TONES
    from bodyschema.report.summary import as_json, finite, print_answer

    if as_object:
        object_ = {**as_json(answer), "folder": str(out), **(more or {})}
        print(json.dumps(finite(object_)))
    else:
        console = Console()
        print_answer(console, answer.document)
        page = out / "report.html"
        shown = f"Report: {page}" if page.is_file() else NO_PAGE
        console.print(f"\n{shown}   all numbers: {out / 'answer.json'}", **PLAIN)
        if then:
            console.print(then, **PLAIN)
    return 1 if TONES.get(answer.verdict) == "bad" else 0


NO_PAGE = "There is no report.html; install the extra: pip install 'bodyschema[report]'"
PLAIN: dict[str, Any] = {"highlight": False, "markup": False, "soft_wrap": True}
