"""`bodyschema track`: pictures + encoders -> joint offsets and the pose of the hand; no markers."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from bodyschema.atomic import check_new_folder, new_folder

if TYPE_CHECKING:
    from bodyschema.cli.track_file import Album
    from bodyschema.learning.images.hand_track import HandPose
    from bodyschema.learning.images.markerless import MarkerlessFit
    from bodyschema.learning.images.rim_fit import RimModel


@dataclass(frozen=True)
class Track:
    """Find joint offsets and hand pose from images, without markers (see cli/track_file).

    Exit code 1 if the body was not found in the pictures.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="TRACK.toml")]
    """Robot, encoders, cameras and pictures."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("tracked")
    """Folder for track.json and overlays; must not hold anything yet."""
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
        """Learn, look at every row, write; returns 1 when the body was not found."""
        from rich.console import Console
        from rich.progress import track

        from bodyschema.cli.track_file import Album, read_track_file
        from bodyschema.imagination.surface import Surface
        from bodyschema.learning.images.hand_track import HandTracker
        from bodyschema.learning.images.image_seeds import spread_out
        from bodyschema.learning.images.markerless import Markerless
        from bodyschema.learning.images.rim_fit import RimModel

        check_new_folder(self.out, self.overwrite)
        album = Album.open(read_track_file(self.run_file))
        surface = Surface.of(album.body, album.run.links or None, album.run.faces)
        begin = time.perf_counter()
        notes, free = Console(stderr=True), album.parameters
        with notes.status("learning the offsets"):
            key_frames = [album.seen(row) for row in spread_out(album.q, self.keys)]
            learner = Markerless(surface, seeds=self.seeds, seed=self.seed)
            fit = learner.fit(album.body, free, key_frames)
        model = RimModel(surface, album.body, free)
        tracker = HandTracker.of(model, fit, key_frames, album.run.hand)
        rows = track(range(len(album)), "looking at every row", console=notes)
        poses = [tracker.look(album.seen(row)) for row in rows]
        seconds = time.perf_counter() - begin
        answer = track_json(fit, poses, len(album) / seconds)
        with new_folder(self.out, self.overwrite) as folder:
            (folder / "track.json").write_text(json.dumps(answer, indent=1))
            _draw(folder, album, model, fit, spread_out(album.q, self.overlays))
        print(json.dumps(answer) if self.json else describe(answer, self.out))
        return 1 if fit.lost else 0


def track_json(
    fit: MarkerlessFit, poses: Sequence[HandPose], frames_per_second: float
) -> dict[str, Any]:
    """The answer in plain types, SI."""
    estimate = fit.estimate
    return {
        "lost": fit.lost,
        "matched": fit.matched,
        "residual_px": fit.residual if np.isfinite(fit.residual) else None,
        "iou": fit.iou if np.isfinite(fit.iou) else None,
        "bias_px": fit.bias.tolist(),
        "parameters": {
            name: {"value": float(value), "std": float(std), "unit": unit}
            for name, value, std, unit in zip(
                estimate.parameters.names,
                estimate.x,
                estimate.std,
                estimate.parameters.units,
                strict=True,
            )
        },
        "not_identifiable": list(fit.identifiability.sentences),
        "frames_per_second": frames_per_second,
        "frames": [
            {
                "time": pose.time,
                "T_camera_hand": pose.pose.tolist(),
                "covariance": pose.covariance.tolist(),
                "matched": pose.matched,
                "lost": pose.lost,
            }
            for pose in poses
        ],
    }


def describe(answer: dict[str, Any], out: Path) -> str:
    """The answer in words."""
    scale = {"rad": (180 / np.pi, "deg"), "m": (1e3, "mm"), "1": (100.0, "%")}
    lines = []
    for name, found in answer["parameters"].items():
        factor, unit = scale[found["unit"]]
        value, std = factor * found["value"], factor * found["std"]
        lines.append(f"  {name:<28}{value:+9.3f} ± {std:.3f} {unit}")
    lines += [f"Not told: {sentence}" for sentence in answer["not_identifiable"]]
    frames = answer["frames"]
    gone = sum(frame["lost"] for frame in frames)
    head = "The body was not found in the pictures." if answer["lost"] else "Found:"
    lines.append(
        f"{100 * answer['matched']:.0f} % of the contour fits; the hand is lost in {gone} of "
        f"{len(frames)} rows; {answer['frames_per_second']:.1f} rows a second."
    )
    lines.append(f"All numbers and overlays: {out}")
    if answer["lost"]:
        lines.append("Next: look at the overlays; check lens, camera and meshes, or free more.")
    else:
        lines.append("Next: look at the overlays; green should lie on the robot.")
    return "\n".join([head, *lines])


def _draw(
    folder: Path, album: Album, model: RimModel, fit: MarkerlessFit, rows: Sequence[int]
) -> None:
    """Outlines before and after over the first camera's pictures."""
    from bodyschema.imagination.overlay import overlay, save_png
    from bodyschema.imagination.poses import piece_poses

    camera = album.cameras[0]
    for row in rows:
        poses = [
            piece_poses(body, album.q[row], [camera], model.surface.frames)[0, 0]
            for body in (album.body, fit.estimate.body)
        ]
        picture = overlay(album.images(row)[0], camera, model.surface, poses)
        save_png(picture, folder / f"overlay_{row:04}.png")
