"""`bodyschema find-body`: video + encoders -> which cells of the picture are me, what moves them.

No model, no calibration and no markers are needed. Each frame is looked at once, so that the same
steps run live, see `examples/09_find_the_body.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from bodyschema.atomic import new_folder
from bodyschema.documents import is_file, is_folder
from bodyschema.errors import InputError, did_you_mean
from bodyschema.export.documents import plain

if TYPE_CHECKING:
    from bodyschema.sources.clip import Clip

STILL = 2e-3
"""rad (or m, or the joint's own unit) of travel below which a joint has not moved."""


@dataclass(frozen=True)
class FindBody:
    """Find the robot's body in a video from its joint positions alone.

    Exit code 1 if no cell is surely the robot and none moves together with the joints.
    """

    source: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="VIDEO|FOLDER|LEROBOT")]
    """Video file, folder of pictures, pattern with {row}, or LeRobot data set."""
    encoders: Path | None = None
    """CSV or Parquet table of joint positions; a LeRobot data set brings its own."""
    joints: tuple[str, ...] = ()
    """Columns or patterns such as 'q_*'; all columns of numbers if none are named."""
    unit: tuple[str, ...] = ("rad",)
    """Unit of the positions, then those that differ: rad '*gripper*=1'."""
    camera_joints: tuple[str, ...] = ()
    """Joints that carry the camera, such as a neck."""
    time_column: str | None = None
    """Time of the table in s; time, t or timestamp if not named."""
    start: float = 0.0
    """When the first frame was taken, on the encoders' clock, s."""
    fps: float | None = None
    """Frames a second; for pictures, and for videos without a clock."""
    episode: int = 0
    """Of a LeRobot data set."""
    camera: str | None = None
    """Of a LeRobot data set with several."""
    cell: int = 16
    """Side of a cell, pixels."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("found")
    """Folder for the results; must not hold anything yet."""
    pictures: int = 5
    """Pictures with the cells drawn in, evenly over the clip."""
    overwrite: bool = False
    """Replace an earlier result in the folder; nothing else is ever replaced."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Look at every frame, write; returns 1 when nothing was found."""
        from bodyschema.answers.find_body import found_answer
        from bodyschema.attention.finder import BodyFinder
        from bodyschema.cli.finding.body_search import search
        from bodyschema.cli.finding.evidence import write_evidence
        from bodyschema.cli.result import say
        from bodyschema.export.result_folder import is_earlier

        self._check()
        clip = self._clip()
        _refuse_stillness(clip)
        finder = BodyFinder(clip.joints, self.cell, named(self.camera_joints, clip.joints))
        with new_folder(self.out, self.overwrite, is_earlier) as folder:
            result = search(finder, clip, folder, self.pictures)
            answer = found_answer(
                result.found, result.moving, len(clip), clip.left_out, self._asked(), result.seconds
            )
            answer.save_into(folder)
            write_evidence(folder, result.found, result.moving)
        speed = {
            "source": str(self.source),
            "frames_per_second": len(clip) / result.seconds,
            "ms_per_frame": 1e3 * result.looking / len(clip),
        }
        return say(answer, self.out, self.json, speed)

    def _asked(self) -> dict[str, Any]:
        """What was asked, with the names of what was read."""
        kept = {k: v for k, v in asdict(self).items() if k not in ("out", "overwrite", "json")}
        files = [path for path in (self.source, self.encoders) if path and is_file(path)]
        return {**plain(kept), "inputs": [str(path) for path in files]}

    def _check(self) -> None:
        """Refuse flags that cannot be used, or would be left unheard."""
        from bodyschema.sources.lerobot import is_lerobot

        if self.pictures < 0:
            raise InputError(f"--pictures is {self.pictures}; give 0 or more.")
        if not np.isfinite(self.start):
            raise InputError(f"--start is {self.start}; give a time in s.")
        timed, listed = self.start != 0 or self.fps is not None, self.episode != 0 or self.camera
        if self.encoders is None and timed and is_lerobot(self.source):
            raise InputError("a LeRobot data set has a clock of its own; leave --start and --fps.")
        if self.encoders is not None and listed:
            raise InputError("--episode and --camera choose from a LeRobot data set; leave them.")
        self._check_place()

    def _check_place(self) -> None:
        """Refuse a folder that holds an input or something that is no answer of `find-body`."""
        from bodyschema.export.result_folder import check_place, refuse_inputs

        source = self.source / "*" if is_folder(self.source) else self.source
        refuse_inputs(self.out, [source, *([self.encoders] if self.encoders else [])])
        check_place(self.out, self.overwrite)

    def _clip(self) -> Clip:
        """The video with its readings."""
        from bodyschema.sources.clip import episode_clip, join_clip
        from bodyschema.sources.joint_track import joint_track
        from bodyschema.sources.lerobot import is_lerobot, open_episode
        from bodyschema.sources.tables import open_recording
        from bodyschema.sources.video import Video

        if self.encoders is not None:
            table = open_recording(self.encoders)
            track = joint_track(table, self.joints, self.unit, self.time_column)
            return join_clip(Video.open(self.source), track, self.start, self.fps)
        if not is_lerobot(self.source):
            raise InputError(
                f"'{self.source}' is no LeRobot data set (it has no meta/info.json); give the "
                "joint positions of a video with --encoders joints.csv."
            )
        episode = open_episode(self.source, self.episode, self.camera)
        track = joint_track(episode.recording, self.joints, self.unit, "timestamp")
        return episode_clip(Video.open(episode.video), track, episode)


def named(patterns: Sequence[str], joints: Sequence[str]) -> tuple[str, ...]:
    """The joints that fit any of the patterns.

    Raises:
        InputError: a pattern fits none.
    """
    for pattern in patterns:
        if not any(fnmatchcase(joint, pattern) for joint in joints):
            raise InputError(
                f"no joint '{pattern}' carries the camera{did_you_mean(pattern, joints)}"
            )
    return tuple(j for j in joints if any(fnmatchcase(j, pattern) for pattern in patterns))


def _refuse_stillness(clip: Clip) -> None:
    """There is nothing to learn from a robot that stands still."""
    travel = np.ptp(clip.positions, axis=0)
    furthest = int(np.argmax(travel))
    if travel[furthest] < STILL:
        raise InputError(
            f"no joint moves while '{clip.video.source}' is recorded; '{clip.joints[furthest]}' "
            f"travels furthest, {travel[furthest]:.1g}. Record the robot while it moves."
        )
