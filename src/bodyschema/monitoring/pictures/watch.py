"""Hand and eye from stereo pictures: found, learned, certified, watched, learned again.

    find ──moves with the wrist──> learn ──certificate──> observe ──tool slipped, swapped──> observe
                                     ^                       │                      (and learn it)
                                     └────── turning <───────┘ camera moves

Corners are born on the hand and on the wall, followed by what they looked like at birth
(`vision.anchored_corners`), and fitted with the camera (`hand_eye.corner_fit`). That the camera has
moved is told by the wall (`background`), at any time, known or not; that what is held has slipped,
by corners that jumped as one; that it was swapped, by landmarks that are missed (`held_tool`). One
lost corner vetoes nothing.

After a turn the old camera and the new one are fitted together: corners of the hand and of the wall
that both have seen carry over what was known. When the new one is certified the old is given up.

A pure transition function: `step(state, frame)` gives the next state and what happened.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from bodyschema.errors import InputError
from bodyschema.monitoring.pictures import turning
from bodyschema.monitoring.pictures.finding import found
from bodyschema.monitoring.pictures.following import followed, noted
from bodyschema.monitoring.pictures.held_tool import gone, known_again, slipped
from bodyschema.monitoring.pictures.learning import born, good, learned
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import PictureInfo, PictureState


@dataclass(frozen=True)
class PictureWatch:
    """Finds, learns and watches hand and eye."""

    settings: PictureSettings

    def start(self) -> PictureState:
        """Nothing known."""
        return PictureState()

    def step(self, state: PictureState, frame: StereoFrame) -> tuple[PictureState, PictureInfo]:
        """The state after one frame, and what happened.

        Raises:
            InputError: the pictures are not two grey ones of one size.
        """
        _check(frame)
        if state.hand is None or state.wall is None:
            return found(state, frame, self.settings)
        state = followed(state, frame)
        assert state.wall is not None
        seen = state.wall.seen
        moved, stands = state.background.step(state.wall.name[seen], state.wall.place[seen])
        begins = moved.moving and not state.background.moving
        state = replace(state, background=moved)
        if begins:
            return turning.begun(state, self.settings), PictureInfo("turning")
        if stands:
            return turning.ended(state), PictureInfo("learn", "changed", "camera")
        if moved.moving:
            return state, PictureInfo("turning")
        return self._looked(noted(state, frame, self.settings), frame)

    def _looked(self, state: PictureState, frame: StereoFrame) -> tuple[PictureState, PictureInfo]:
        """Jumps every few frames; fits, landmarks and births now and then."""
        settings = self.settings
        if state.certified and state.frame % settings.every == 0:
            state, jump = slipped(state, settings)
            if jump is not None:
                return state, PictureInfo(state.mode, "changed", "tool", jump.length)
        if state.frame % settings.solve:
            return state, PictureInfo(state.mode)
        state = learned(state, settings)
        if state.certified:
            state, missed = gone(state, frame, settings)
            if missed:
                return state, PictureInfo(state.mode, "changed", "tool")
        state = born(state, frame, settings)
        if state.mode == "learn" and good(state, settings):
            return turning.certified(state), PictureInfo("observe", "certified", "camera")
        if known_again(state):
            return replace(state, changed_tool=None), PictureInfo(state.mode, "certified", "tool")
        return state, PictureInfo(state.mode)


def _check(frame: StereoFrame) -> None:
    for image in (frame.left, frame.right):
        if image.dtype != "uint8" or image.ndim != 2 or image.shape != frame.left.shape:
            raise InputError(
                "expected two grey 8-bit pictures of one size, (height, width); got "
                f"{frame.left.dtype} {frame.left.shape} and {image.dtype} {image.shape}."
            )
