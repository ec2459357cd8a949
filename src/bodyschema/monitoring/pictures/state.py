"""What a watch of hand and eye in pictures knows from one frame to the next, and what it says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.finder import FinderState
from bodyschema.estimation.certificate import bound
from bodyschema.learners.hand_eye.corner_fit import CameraPrior, CornerFit
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.monitoring.pictures.background import Background
from bodyschema.monitoring.pictures.hand_map import HandMap
from bodyschema.monitoring.pictures.landmarks import Landmarks
from bodyschema.vision.anchored_corners import Corners

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Mode = Literal["find", "learn", "observe", "turning"]
Event = Literal["", "found", "certified", "changed"]
Part = Literal["", "camera", "tool"]


@dataclass(frozen=True)
class Finding:
    """The search for the hand."""

    began: float
    """s, of the first frame."""
    finder: FinderState
    moving: Array
    """(rows, cols) how often each cell moved with the joints."""
    frames: int = 0


@dataclass(frozen=True)
class ChangedTool:
    """A tool that has changed and is not known yet."""

    since: int
    """Names of corners from here on are younger than the change."""
    hand: Array
    """(n, 3) m, places of the hand that did not change."""


@dataclass(frozen=True)
class PictureState:
    """What the next frame needs."""

    mode: Mode = "find"
    frame: int = 0
    """Frames so far."""
    finding: Finding | None = None
    """While the hand is looked for."""
    hand: Corners | None = None
    """Corners on the hand and on what it holds; None while it is looked for."""
    wall: Corners | None = None
    """Corners of the background."""
    background: Background = field(default_factory=Background)
    """Whether the camera moves."""
    passed: tuple[Ints, Array] | None = None
    """Names and places (K, 2) of the hand's corners when it was last asked which of them stay."""
    rows: CornerRows = field(default_factory=CornerRows.none)
    """Of the hand, named from 1, and of the wall, from -1; by camera 0 and, after a turn, 1."""
    readings: tuple[Ints, Array] | None = None
    """(m,) moments of rows, and (m, J) what the encoders read then."""
    camera: int = 0
    """The camera pose in force."""
    prior: CameraPrior | None = None
    """What rows that are kept no longer have told."""
    fit: CornerFit | None = None
    hand_map: HandMap = field(default_factory=HandMap)
    """Where on the hand corners have been."""
    landmarks: Landmarks = field(default_factory=Landmarks)
    """How sure corners of the hand looked."""
    strays: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Corners that turned out not to be on the hand."""
    certified: bool = False
    """Whether the camera has been certified since it last moved."""
    changed_tool: ChangedTool | None = None
    refused: int = 0
    """Fits in a row, since the certificate, that did not settle or explain what was seen: the last
    good one stays, and nothing is certain meanwhile."""

    @property
    def T_world_cam(self) -> Array | None:
        """(4, 4) of the left camera as believed; None before there is an answer."""
        return None if self.fit is None else np.asarray(self.fit.cameras[-1])

    @property
    def bounds(self) -> tuple[float, float]:
        """rad, m: how far off the camera is at most, at 99 %."""
        if self.fit is None or self.refused or not np.isfinite(self.fit.covariance).all():
            return np.inf, np.inf
        P = self.fit.covariance[-6:, -6:]
        return bound(P[3:, 3:]), bound(P[:3, :3])


@dataclass(frozen=True)
class PictureInfo:
    """What one frame led to."""

    mode: Mode
    event: Event = ""
    part: Part = ""
    """What was certified, or changed."""
    shift: float = np.nan
    """m by which a tool slipped, if it did."""
