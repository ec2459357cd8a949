"""`bodyschema report`: look at a result in the terminal; the page for a browser lies beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Report:
    """Show what a calibration found: verdict, errors, parameters, and what stays open."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that `calibrate` wrote."""
    json: bool = False
    """Print calibration.yaml as one JSON object instead of text."""

    def run(self) -> int:
        """Print; returns 0."""
        from rich.console import Console

        from bodyschema.errors import InputError
        from bodyschema.export.calibration_yaml import read_document
        from bodyschema.export.documents import plain
        from bodyschema.report.summary import print_answer

        document = read_document(self.result)
        if self.json:
            print(json.dumps(plain(document), ensure_ascii=False, allow_nan=False))
            return 0
        console = Console()
        try:
            print_answer(console, document)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"'{self.result}' is no whole calibration ({type(error).__name__}: {error}); "
                "calibrate again."
            ) from None
        for note in document.get("notes", []):
            console.print(note, highlight=False, markup=False)
        console.print(self._where(), highlight=False, markup=False, soft_wrap=True)
        return 0

    def _where(self) -> str:
        folder = self.result if self.result.is_dir() else self.result.parent
        page = folder / "report.html"
        if page.is_file():
            return f"\nReport: {page.resolve()} (open it in a browser)"
        return (
            "\nThere is no report.html; install the extra and calibrate again: "
            "pip install 'bodyschema[report]'"
        )
