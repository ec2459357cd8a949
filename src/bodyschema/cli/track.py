"""`bodyschema track`: pictures + encoders -> joint offsets and the pose of the hand; no markers."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import tyro

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from bodyschema.answers.answer import Answer
    from bodyschema.answers.track import Tracked
    from bodyschema.cli.tracking.album import Album

Item = TypeVar("Item")

ASKED = ("keys", "seeds", "seed", "method", "particles", "edges", "overlays")
"""Flags on which the result depends."""


@dataclass(frozen=True)
class Track:
    """Find joint offsets and hand pose from images, without markers (see docs/tracking.md).

    Exit code 1 if the body was not found in the pictures.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN.toml")]
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
    method: Literal["outlines", "particle-filter"] = "outlines"
    """Who learns: outlines of all key postures at once, or the filter that Vicente et al. published
    in 2016, as printed: every camera known exactly, joint offsets alone wrong, every picture in its
    order; see docs/vicente2016.md."""
    particles: int = 200
    """Of the filter."""
    edges: Literal["hand", "outline"] = "hand"
    """What the filter imagines where there are no masks: all edges of the model, or its outline."""
    overlays: int = 5
    """Pictures with the outline before (red) and after (green); 0 for none."""
    overwrite: bool = False
    """Replace an earlier result in the folder; nothing else is ever replaced."""
    force: bool = False
    """Write the result even when the data contradict it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Learn, look at every moment, write; returns 1 when the body was not found."""
        from rich.console import Console

        from bodyschema.answers.track import frame_entries
        from bodyschema.cli.result import finish, prepare
        from bodyschema.cli.run_file import read_run_file
        from bodyschema.cli.tracking.album import Album

        self._check()
        notes = Console(stderr=True)
        with notes.status("reading"):
            run = read_run_file(self.run_file, "track")
            asked = asdict(run) | {"inputs": run.inputs, "command": self.command()}
            album = Album.open(run)
            prepare(self.out, self.overwrite, self.run_file, asked, album.first_pictures)
        if self.method == "particle-filter":
            return self._filter(album, asked, notes)
        tracked = self._track(album, notes)
        with notes.status("writing"):
            answer = self._answer(album, tracked, asked)
            frames = frame_entries(tracked, album.numbers[:, 0].tolist())
            document = json.dumps({**answer.details, "frames": frames}, indent=1) + "\n"
            answer = replace(answer, files={**answer.files, "track.json": document.encode()})
            more = {"frames": frames, "frames_per_second": tracked.rate}
        # Overlays show why a body was not found; nothing is corrected then.
        force = self.force or bool(answer.details["lost"])
        return finish(answer, self.out, self.overwrite, self.json, more, _then(answer), force=force)

    def command(self) -> str:
        """The command line that asks for this result, wherever it goes and whatever is printed."""
        words = ["bodyschema", "track", str(self.run_file)]
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name in ASKED and value != entry.default:
                words += [f"--{entry.name}", str(value)]
        return shlex.join(words)

    def _check(self) -> None:
        """Refuse counts that nothing can be done with."""
        for name, least in (
            ("keys", 1),
            ("seeds", 0),
            ("seed", 0),
            ("overlays", 0),
            ("particles", 2),
        ):
            if getattr(self, name) < least:
                raise InputError(f"--{name} is {getattr(self, name)}; give {least} or more.")

    def _track(self, album: Album, notes: Console) -> Tracked:
        """The body from the key postures, and the hand at every moment."""
        from bodyschema.answers.track import track
        from bodyschema.cli.tracking.album import markerless

        learner = markerless(album, self.seeds, self.seed)
        notes.print(f"learning the offsets from {min(self.keys, len(album))} postures")
        return track(
            learner,
            album.body,
            album.variables,
            album,
            album.seen_by.hand,
            self.keys,
            partial(_watched, notes=notes),
            album.unplaced,
        )

    def _filter(self, album: Album, asked: Mapping[str, Any], notes: Console) -> int:
        """The same by the published filter."""
        from bodyschema.cli.result import finish
        from bodyschema.cli.tracking.published import published

        settings = (self.particles, self.edges, self.seed, self.overlays)
        watched = partial(_watched, notes=notes)
        answer, more = published(
            album, *settings, {**asked, "sha256": album.picture_hashes}, watched
        )
        force = self.force or bool(answer.details["lost"])
        return finish(answer, self.out, self.overwrite, self.json, more, _then(answer), force=force)

    def _answer(self, album: Album, tracked: Tracked, asked: Mapping[str, Any]) -> Answer:
        from bodyschema.answers.track import track_answer
        from bodyschema.cli.tracking.overlays import draw_overlays, overlay_files, report_pictures
        from bodyschema.seeds.image_seeds import spread_out

        shown = spread_out(album.q, self.overlays) if self.overlays else []
        fit, believed = tracked.fit, album.round(tracked.body)
        camera = fit.model.cameras(album.cameras, fit.z)[0]
        drawn = draw_overlays(believed, fit.model.surface, camera, fit.estimate.body, sorted(shown))
        answer = track_answer(
            tracked,
            album.nominal,
            album.seen_by.hand,
            album.q,
            album.numbers[:, 0].tolist(),
            album.cameras,
            {**asked, "sha256": album.picture_hashes},
            report_pictures(drawn, album.lenses[0].name),
        )
        return replace(answer, files=overlay_files(drawn))


def _then(answer: Answer) -> str:
    if answer.details["lost"]:
        return (
            "Nothing was corrected. Next: look at the overlays; check lens, camera and meshes, or "
            "free more."
        )
    return "Next: look at the overlays; green should lie on the robot. Then use robot.urdf."


def _watched(items: Iterable[Item], total: int, *, notes: Console) -> Iterable[Item]:
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
