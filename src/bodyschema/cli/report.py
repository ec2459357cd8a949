"""`bodyschema report`: look at a result in the terminal; the page for a browser lies beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Report:
    """Show what a verb found: the frames asked for, whether to believe it, what to change."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that any verb wrote."""
    all: bool = False
    """Also errors before and after, all parameters, and what the data cannot tell."""
    json: bool = False
    """Print everything that was found as one JSON object instead of text."""

    def run(self) -> int:
        """Print; returns 0."""
        from rich.console import Console

        from bodyschema.answers.answer import load
        from bodyschema.cli.result import NO_PAGE, PLAIN, how_to_see_all
        from bodyschema.documents import is_folder
        from bodyschema.export.documents import plain
        from bodyschema.report.summary import print_answer

        document = load(self.result).document
        if self.json:
            print(json.dumps(plain(document), ensure_ascii=False, allow_nan=False))
            return 0
        console = Console()
        print_answer(console, document, self.all, how_to_see_all(self.result))
        page = (self.result if is_folder(self.result) else self.result.parent) / "report.html"
        shown = f"Report: {page.resolve()} (open it in a browser)" if page.is_file() else NO_PAGE
        console.print(f"\n{shown}", **PLAIN)
        return 0
