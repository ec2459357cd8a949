"""`bodyschema track --method particle-filter`: the published filter on a user's own recording."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from bodyschema.answers.answer import Answer
from bodyschema.answers.filtered import filtered_answer, filtered_frames
from bodyschema.cli.tracking.album import Album
from bodyschema.cli.tracking.overlays import draw_overlays, overlay_files, report_pictures
from bodyschema.errors import InputError
from bodyschema.learners.images.recorded_filter import filtered
from bodyschema.learners.published.image_likelihood import EdgeLikelihood, SilhouetteLikelihood
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.seeds.image_seeds import spread_out
from bodyschema.senses.images import Images
from bodyschema.vision.surface import Surface

Progress = Callable[[Iterable[Images], int], Iterable[Images]]


def published(
    album: Album,
    particles: int,
    edges: Literal["hand", "outline"],
    seed: int,
    overlays: int,
    asked: Mapping[str, Any],
    progress: Progress,
) -> tuple[Answer, dict[str, Any]]:
    """The answer, and what is printed of it besides.

    Args:
        album: pictures and readings.
        particles: of the filter.
        edges: that are imagined where there are no masks.
        seed: the same seed gives the same answer.
        overlays: pictures to draw.
        asked: for the record.
        progress: shows how far the work is.

    Raises:
        InputError: a camera is not known exactly, or the recording does not fit the filter.
    """
    _require_known(album)
    learner = _learner(album, particles, edges, seed)
    moments, count = range(len(album)), len(album)
    seen = progress(album.seen(moments), count)
    found = filtered(learner, album.body, album.variables, seen, count)
    shown = sorted(spread_out(album.q, overlays)) if overlays else []
    after = found.estimate(-1).body
    drawn = draw_overlays(album, learner.surface, album.cameras[0], after, shown)
    hand, numbers = album.seen_by.hand, album.numbers[:, 0].tolist()
    pictures = report_pictures(drawn, album.lenses[0].name)
    answer = filtered_answer(found, album.nominal, hand, album.q, numbers, asked, pictures)
    frames = filtered_frames(found, album.q, numbers, album.cameras[0].frame, hand)
    document = json.dumps({**answer.details, "frames": frames}, indent=1) + "\n"
    files = {**overlay_files(drawn), "track.json": document.encode()}
    more = {"frames": frames, "frames_per_second": count / found.seconds}
    return replace(answer, files=files), more


def _require_known(album: Album) -> None:
    for name, entry in album.seen_by.cameras.items():
        if entry.known != "exactly":
            raise InputError(
                f"the published filter takes cameras at their word, and camera '{name}' has "
                f'known = "{entry.known}"; measure its place and say known = "exactly", or leave '
                "--method out, which looks for it."
            )


def _learner(
    album: Album, particles: int, edges: Literal["hand", "outline"], seed: int
) -> ParticleFilter:
    """With the paper's settings; the prior is what the run file says of the offsets, if it does."""
    seen = album.seen_by
    surface = Surface.of(album.body, seen.links or None, seen.faces)
    masked = all(entry.masks for entry in seen.cameras.values())
    likelihood = SilhouetteLikelihood() if masked else EdgeLikelihood(edges=edges)
    learner = ParticleFilter(surface, particles=particles, likelihood=likelihood, seed=seed)
    deg = album.run.free.offset_deg
    return learner if deg is None else replace(learner, prior=float(np.deg2rad(deg)))
