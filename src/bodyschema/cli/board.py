"""`bodyschema board`: a board to print, true to size, and what to write in the run file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from bodyschema.errors import shown


@dataclass(frozen=True)
class Board:
    """Draw a calibration board as a PDF that prints true to size.

    Print it at 100 %, glue it on something flat, and measure it: printers scale all the same.
    """

    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("board.pdf")
    """The PDF; must not exist yet."""
    kind: Literal["charuco", "chessboard", "tags"] = "charuco"
    """ChArUco may be partly hidden or out of the picture; tags too; a chessboard may not."""
    columns: int = 7
    """Squares of a ChArUco board, inner corners of a chessboard, tags of a grid; 1 for one tag."""
    rows: int = 5
    """The same, downwards."""
    square_mm: float = 35.0
    """From one corner to the next, or from one tag to the next."""
    marker_mm: float | None = None
    """Side of a tag; three quarters of a square when absent."""
    dictionary: str = "5X5_100"
    """Of the tags, as OpenCV calls it; "APRILTAG_36h11" for AprilTags."""
    paper: Literal["a4", "a3", "a2", "a1", "a0", "letter"] = "a4"
    overwrite: bool = False
    """Replace the file."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Draw and write; returns 0."""
        from bodyschema.atomic import check_new_file, new_file
        from bodyschema.export.board_pdf import board_pdf, page_for
        from bodyschema.vision.targets.sheet import black_rectangles, pattern_size
        from bodyschema.vision.targets.target import Target

        check_new_file(self.out, self.overwrite)
        tagged = self.kind != "chessboard"
        marker = 0.75 * self.square_mm if self.marker_mm is None else self.marker_mm
        target = Target(
            self.kind,
            self.columns,
            self.rows,
            self.square_mm / 1e3,
            marker / 1e3 if tagged else 0.0,
            self.dictionary if tagged else "",
        )
        target.check("the board")
        size = pattern_size(target)
        page = page_for(*size, self.paper)
        entry = target.toml
        content = board_pdf(black_rectangles(target), size, page, f"bodyschema: {entry}")
        with new_file(self.out, self.overwrite) as temporary:
            temporary.write_bytes(content)
        if self.json:
            told = {"file": str(self.out), "target": entry, "width_mm": 1e3 * size[0],
                    "height_mm": 1e3 * size[1]}  # fmt: skip
            print(json.dumps(told))
            return 0
        print(
            shown(
                f"Drawn in {self.out}: {1e3 * size[0]:.1f} x {1e3 * size[1]:.1f} mm on "
                f"{self.paper}. Print it at 100 %, measure it, and write into [[senses]] of the "
                f'run file, with the lengths measured:\n\nkind = "board"\ntarget = {entry}'
            )
        )
        return 0
