"""`bodyschema track`: pictures + encoders -> joint offsets and the pose of the hand; no markers."""

from __future__ import annotations

import json
import shlex
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
import tyro

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from bodyschema.cli.tracking.album import Album
    from bodyschema.learners.images.hand_track import HandPose, HandTracker

Item = TypeVar("Item")


@dataclass(frozen=True)
class Track:
    """Find joint offsets and hand pose from images, without markers (see docs/tracking.md).

    Exit code 1 if the body was not found in the pictures.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="TRACK.toml")]
    """Robot, encoders, cameras and pictures or videos."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("tracked")
    """Folder for the corrected robot, track.json, report.html and overlays; must not hold anything
    yet. The robot's own description is not touched."""
    keys: int = 20
    """Postures that the offsets are learned from, far from each other; all others are looked at."""
    seeds: int = 512
    """First guesses; 0 trusts the robot as it is."""
    seed: int = 0
    """The same seed gives the same answer."""
    overlays: int = 5
    """Pictures with the outline before (red) and after (green); 0 for none."""
    overwrite: bool = False
    """Replace the output folder."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Learn, look at every moment, write; returns 1 when the body was not found."""
        from rich.console import Console

        from bodyschema.cli.tracking.album import Album
        from bodyschema.cli.tracking.track_answer import describe, track_json
        from bodyschema.cli.tracking.track_file import read_track_file
        from bodyschema.cli.tracking.track_folder import TrackFolder
        from bodyschema.cli.tracking.track_record import check_place, track_record
        from bodyschema.export.tracked_files import Settled
        from bodyschema.seeds.image_seeds import spread_out

        self._check()
        notes = Console(stderr=True)
        with notes.status("reading"):
            album = Album.open(read_track_file(self.run_file))
            check_place(self.out, self.overwrite, self.run_file, album)
        keys = sorted(spread_out(album.q, self.keys))
        tracker, poses, rate = self._track(album, keys, notes)
        seen = np.flatnonzero([not pose.lost for pose in poses])
        if 0 < len(seen) < len(poses) and not np.isin(keys, seen).all():
            # Pictures that do not show the hand have been learned from: once more without them.
            keys = sorted(seen[spread_out(album.q[seen], self.keys)].tolist())
            tracker, poses, rate = self._track(album, keys, notes)
        settled = Settled.of(tracker.fit)
        found = track_json(settled, poses, album.numbers[:, 0].tolist())
        with notes.status("writing"):
            record = track_record(album, self.command())
            folder = TrackFolder(album, settled, poses, keys, record)
            shown = spread_out(album.q, self.overlays) if self.overlays else []
            reported = folder.write(self.out, self.overwrite, found, sorted(shown), notes)
        # Not in the file: the same run writes the same bytes.
        answer = found | {"frames_per_second": rate}
        print(json.dumps(answer) if self.json else describe(answer, self.out, reported))
        return 1 if tracker.fit.lost else 0

    def command(self) -> str:
        """The command line that asks for this result, wherever it goes and whatever is printed."""
        words = ["bodyschema", "track", str(self.run_file)]
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name in ("keys", "seeds", "seed", "overlays") and value != entry.default:
                words += [f"--{entry.name}", str(value)]
        return shlex.join(words)

    def _check(self) -> None:
        """Refuse counts that nothing can be done with."""
        for name, least in (("keys", 1), ("seeds", 0), ("overlays", 0)):
            if getattr(self, name) < least:
                raise InputError(f"--{name} is {getattr(self, name)}; give {least} or more.")

    def _track(
        self, album: Album, keys: Sequence[int], notes: Console
    ) -> tuple[HandTracker, list[HandPose], float]:
        """The body from the key postures, the hand at every moment, and moments a second."""
        from bodyschema.learners.images.hand_track import HandTracker
        from bodyschema.learners.images.markerless import Markerless
        from bodyschema.vision.surface import Surface

        with notes.status(f"learning the offsets from {len(keys)} postures"):
            surface = Surface.of(album.body, album.run.links or None, album.run.faces)
            frames = list(album.seen(keys))
            doubts = album.run.doubts.doubts
            learner = Markerless(surface, seeds=self.seeds, seed=self.seed, doubts=doubts)
            fit = learner.fit(album.body, album.variables, frames)
            tracker = HandTracker.of(fit, frames, album.run.hand)
        begin = time.perf_counter()
        seen = _watched(album.seen(range(len(album))), len(album), notes)
        poses = [tracker.look(images) for images in seen]
        return tracker, poses, len(poses) / (time.perf_counter() - begin)


def _watched(items: Iterable[Item], total: int, notes: Console) -> Iterable[Item]:
    """The items, with a bar that tells how many a second."""
    from rich.progress import MofNCompleteColumn, Progress, ProgressColumn
    from rich.text import Text

    class Rate(ProgressColumn):
        """Moments a second."""

        def render(self, task: Any) -> Text:
            return Text(f"{task.finished_speed or task.speed or 0.0:.1f} frames/s")

    columns = (*Progress.get_default_columns(), MofNCompleteColumn(), Rate())
    with Progress(*columns, console=notes) as bar:
        yield from bar.track(items, total=total, description="looking at every moment")
