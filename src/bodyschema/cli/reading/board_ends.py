"""What a run of boards alone is about: the camera, seen from the board, as with poses.

Pictures of a board leave open where a flange or a base lies that camera and board hang on: turning
the last joint's zero turns the camera round the flange, and no picture tells. So the verdict speaks
of what was asked for, unless the run file names other frames that are wanted right.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bodyschema.cli.reading.run_entries import FrameEntry, WantedEntry
from bodyschema.cli.reading.sense_entry import SenseEntry


def with_board_ends(
    wanted: Sequence[WantedEntry], senses: Sequence[SenseEntry], frames: Mapping[str, FrameEntry]
) -> tuple[WantedEntry, ...]:
    """The frames that are wanted right, where boards are all that was seen.

    Args:
        wanted: as the run file says; nothing is added to it.
        senses: of the run file.
        frames: of it; a board or a camera whose place is known is nothing that was asked for.
    """
    asked = tuple(wanted)
    if asked or not all(entry.kind == "board" for entry in senses):
        return asked
    ends = {
        (entry.seen, entry.seen_from): None
        for entry in senses
        for end in (entry.seen, entry.seen_from)
        if end in frames and frames[end].known == "no"
    }
    return tuple(WantedEntry(camera, board) for board, camera in ends)
