"""The output folder of `track`, which appears whole or not at all.

track.json          all numbers, for programs
robot.urdf          and its companions, see `export.tracked_files`; not if the body was not found
overlay_*.png       the first camera's pictures with the outline before and after
run.json            what was asked, with versions and hashes of the inputs
report.html         all of it for people, where the extra `report` is installed
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.telling_posture import telling_posture
from bodyschema.atomic import new_folder
from bodyschema.cli.tracking.album import Album
from bodyschema.errors import MissingExtraError
from bodyschema.export.tracked_files import Settled
from bodyschema.learners.images.hand_track import HandPose
from bodyschema.report.tracking.evidence import OverlayPicture, TrackEvidence
from bodyschema.vision.overlay import overlay, save_png
from bodyschema.vision.poses import piece_poses

if TYPE_CHECKING:
    from rich.console import Console

Pixels = NDArray[np.uint8]

WIDEST = 1280
"""pixels of a picture inside the report."""
JPEG_QUALITY = 85


@dataclass(frozen=True)
class TrackFolder:
    """What goes into the folder."""

    album: Album
    settled: Settled
    poses: Sequence[HandPose]
    """Of the hand at every moment."""
    keys: Sequence[int]
    """Moments that were learned from."""
    record: Mapping[str, Any]
    """See `track_record`."""

    def write(
        self,
        out: Path,
        overwrite: bool,
        answer: Mapping[str, Any],
        shown: Sequence[int],
        notes: Console,
    ) -> bool:
        """Write all of it.

        Args:
            out: the folder.
            overwrite: replace an earlier answer.
            answer: see `track_json`.
            shown: moments to draw, in order.
            notes: told when there can be no report.

        Returns:
            Whether there is a report.
        """
        drawn = self._drawn(shown)
        files = {"track.json": _text(answer), "run.json": _text(self.record)}
        if not self.settled.fit.lost:
            files |= self.settled.files(Path(self.album.run.robot), self.album.nominal)
        try:
            files["report.html"] = self._report(drawn).encode()
        except MissingExtraError as missing:
            notes.print(str(missing), highlight=False, markup=False, soft_wrap=True)
        with new_folder(out, overwrite) as folder:
            for name, content in files.items():
                (folder / name).write_bytes(content)
            for number, picture in drawn.items():
                save_png(picture, folder / f"overlay_{number:04}.png")
        return "report.html" in files

    def _drawn(self, shown: Sequence[int]) -> dict[int, Pixels]:
        """Outlines before and after over the first camera's pictures, by their numbers."""
        album, fit = self.album, self.settled.fit
        surface, camera = fit.model.surface, fit.model.cameras(album.cameras, fit.z)[0]
        drawn = {}
        for moment, pictures in zip(shown, album.pictures(shown), strict=True):
            poses = [
                piece_poses(body, album.q[moment], [camera], surface.frames)[0, 0]
                for body in (album.body, fit.estimate.body)
            ]
            number = int(album.numbers[moment, 0])
            drawn[number] = overlay(pictures[0], camera, surface, poses)
        return drawn

    def _report(self, drawn: Mapping[int, Pixels]) -> str:
        """report.html."""
        from bodyschema.report.tracking.page import tracking_html

        album, fit = self.album, self.settled.fit
        cameras = tuple(camera.name for camera in album.lenses)
        return tracking_html(
            TrackEvidence(
                self.settled,
                album.nominal,
                album.body,
                cameras,
                album.run.hand,
                album.q,
                album.numbers[:, 0].tolist(),
                self.keys,
                self.poses,
                None if fit.lost else telling_posture(fit, album.cameras, album.q),
                [
                    OverlayPicture(f"Camera '{cameras[0]}', picture {number}", _jpeg(picture))
                    for number, picture in drawn.items()
                ],
                self.record,
            )
        )


def _text(document: Mapping[str, Any]) -> bytes:
    return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode()


def _jpeg(picture: Pixels) -> bytes:
    """A picture small enough for a page."""
    import cv2

    height, width = picture.shape[:2]
    if width > WIDEST:
        size = WIDEST, round(height * WIDEST / width)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    _, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), options)
    return bytes(data)
