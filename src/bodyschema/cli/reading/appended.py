"""Recordings one after the other, `append` in a run file, and frames that were moved between them.

Every sense is read from every recording; a frame that is `per_recording` becomes a frame of each,
board_mon and board_tue for mon.csv and tue.csv. With `join = "time"` each recording is a list of
files, or a bag, whose streams are joined to the joints in it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bodyschema.cli.reading.run_entries import FrameEntry
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError

Files = tuple[str, ...]


def with_appended(
    entries: Mapping[str, Any], appended: Sequence[Files], where: str
) -> dict[str, Any]:
    """The entries of a run file in which every recording has senses and frames of its own.

    Args:
        entries: with "recording", "frames", "senses" and other sections, as read.
        appended: the files of each recording that `append` names.
        where: names the run file in messages.

    Raises:
        InputError: nothing to read from them, an empty list of files, or frames that do not fit;
            see `_frames_of_each`.
    """
    frames, senses = entries["frames"], entries["senses"]
    if not appended:
        moved = next((name for name, entry in frames.items() if entry.per_recording), None)
        if moved is not None:
            raise InputError(
                f"[frames.{moved}] of {where} is per_recording, and no recordings are appended; "
                'add: append = ["monday.csv", "tuesday.csv"].'
            )
        return {"append": ()}
    if not senses or any(entries[other] for other in ("wrist", "pictures", "hand_eye")):
        raise InputError(
            f"append in {where} is for recordings of [[senses]], as calibrate reads them; describe "
            "what was seen there, or leave it out."
        )
    if not all(appended):
        raise InputError(
            f"append in {where} has a recording of no files; name them, or leave it out."
        )
    recordings = [files for files in (entries["recording"], *appended) if files]
    ends = _endings(recordings)
    moved = [name for name, entry in frames.items() if entry.per_recording]
    spread = [
        _in(entry, files, end, moved)
        for entry in senses
        if not entry.recording
        for files, end in zip(recordings, ends, strict=True)
    ]
    own = [entry for entry in senses if entry.recording]
    return {
        "append": (),
        "recording": (),
        "frames": _frames_of_each(frames, ends, where),
        "senses": (*spread, *own),
    }


def _frames_of_each(
    frames: Mapping[str, FrameEntry], ends: Sequence[str], where: str
) -> dict[str, FrameEntry]:
    """Frames of the run, those that were moved once for each recording.

    Raises:
        InputError: a name twice, or a frame on one that was moved which was not moved itself.
    """
    moved = [name for name, entry in frames.items() if entry.per_recording]
    made = {name: entry for name, entry in frames.items() if name not in moved}
    for name, entry in made.items():
        if entry.parent in moved:
            raise InputError(
                f"[frames.{name}] of {where} hangs on '{entry.parent}', which is per_recording; "
                "set per_recording = true there too."
            )
    for name in moved:
        for end in ends:
            own, parent = f"{name}_{end}", frames[name].parent
            if own in frames:
                raise InputError(f"{where} has a frame '{own}' already; rename it.")
            on = f"{parent}_{end}" if parent in moved else parent
            made[own] = replace(frames[name], parent=on, per_recording=False)
    return made


def _in(entry: SenseEntry, files: Files, end: str, moved: Sequence[str]) -> SenseEntry:
    """One sense in one recording."""
    looks, seen = (
        f"{name}_{end}" if name in moved else name for name in (entry.seen_from, entry.seen)
    )
    return replace(entry, recording=files, seen_from=looks, seen=seen)


def _endings(recordings: Sequence[Files]) -> list[str]:
    """A word for each recording: the name of its first file, or its number where names repeat."""
    words = [re.sub(r"\W+", "_", Path(files[0]).stem) for files in recordings]
    return words if len({*words}) == len(words) else [str(i + 1) for i in range(len(words))]
