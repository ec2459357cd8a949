"""What a run of `track` was asked and from what files: the content of run.json."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bodyschema.cli.tracking.album import Album, picture_path
from bodyschema.export import result_folder


def track_record(album: Album, command: str) -> dict[str, Any]:
    """run.json with the hashes of all inputs, and the command.

    Args:
        album: what was looked at.
        command: the command line that asks for the same.
    """
    run = album.run
    record = result_folder.run_record(Path(run.robot), {**asdict(run), "inputs": _videos(album)})
    hashes = {**record["sha256"], **dict(_picture_hashes(album))}
    return {**record, "sha256": hashes, "command": command}


def check_place(folder: Path, overwrite: bool, run_file: Path, album: Album) -> None:
    """Refuse a folder that would touch an input or something that is no answer of `track`.

    Raises:
        InputError: it does, or it cannot be written.
    """
    first = [picture_path(p, album.numbers[0, c]) for p, c in _patterns(album)]
    named = [Path(album.run.robot), Path(album.run.recording), *map(Path, _videos(album))]
    result_folder.refuse_inputs(folder, [run_file, *named, *first])
    result_folder.check_place(folder, overwrite, "track.json")


def _videos(album: Album) -> list[str]:
    return [video.source for video in album.videos if video is not None]


def _patterns(album: Album) -> Iterator[tuple[str, int]]:
    """Patterns of pictures and masks, with the number of their camera."""
    for c, entry in enumerate(album.run.cameras.values()):
        yield from ((pattern, c) for pattern in (entry.images, entry.masks) if pattern)


def _picture_hashes(album: Album) -> Iterator[tuple[str, str]]:
    """One hash for all pictures of a pattern, of theirs in order."""
    for pattern, c in _patterns(album):
        whole = hashlib.sha256()
        for number in album.numbers[:, c]:
            path = picture_path(pattern, number)
            whole.update(result_folder.sha256(path).encode() if path.is_file() else b"-")
        yield pattern, whole.hexdigest()
