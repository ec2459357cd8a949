"""Which cells of the image are me, from encoders and optical flow alone.

Nothing is known of the robot or the camera. Each frame's flow, against the background's motion
(`flow`), goes into the sums of the motion that is going on (`visual_jacobian`), once for each delay
that the camera may have. When the motion is over, it is weighed cell by cell (`contingency`), and
the belief about what each joint does to each cell takes it in. A frame costs the same at any time.

Joints that carry the camera move the whole view. Most of that is the background's motion; what is
near moves differently, and is given to those joints before anything is called me.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.confirming import Moved, next_motion, verdict, with_motion
from bodyschema.attention.contingency import Contingency, called_me, probability, weigh
from bodyschema.attention.frames import Frame, check_frame, check_settings, grid
from bodyschema.attention.lag import LagBelief, after_motion
from bodyschema.attention.motor import MotionCutter, Motor
from bodyschema.attention.visual_jacobian import (
    MotionSums,
    empty,
    faded,
    furthest,
    jacobians,
    joined,
    joint_evidence,
)
from bodyschema.errors import InputError
from bodyschema.vision.flow import cell_flow, in_company, prepare, reduction, repeats

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]
Ints = NDArray[np.int64]

LAG_STEP = 1 / 30
"""s between two candidate delays."""
NOISE = 0.03
"""pixels/frame of the reduced image: the least noise of a cell's flow."""
SLOPE = 100.0
"""pixels/rad of the reduced image: standard deviation of a visual Jacobian to begin with."""
FADING = 0.95
"""Of the belief about visual Jacobians, from motion to motion."""
REST_MEMORY, LATELY = 1.0, 5.0
"""s, over which motion at rest is remembered: for the evidence, and for what moves now."""
MOVES = 0.25
"""pixels/frame of the reduced image, from which a cell is said to move now."""
JUST_NOW = 0.1
"""s; joints that moved no longer ago than this, at the camera's lag, may be seen moving."""
RESTLESS = 1.0
"""Frames of motion while the joints rested from which a cell is not said to move as me."""
LONGEST_GAP = 0.12
"""s; a picture like the one before is passed over no longer than this."""


@dataclass(frozen=True)
class FinderState:
    """What the next frame needs."""

    size: tuple[int, int]
    """Width and height of the frames, pixels."""
    motor: Motor
    """Latest positions and the motion that is going on."""
    sums: MotionSums
    """Of the motion that is going on and the rest before it."""
    belief: MotionSums
    """Visual Jacobians from the motions before."""
    odds: Contingency
    """Evidence so far."""
    lag: LagBelief
    """Delay of the camera."""
    moved: Moved
    """How the joints have moved."""
    own_flow: Array
    """(N, 2) pixels/frame, of the last frame."""
    texture: Array
    """(N,) of the last frame."""
    restless: Array
    """(N,) frames in which each cell lately moved while the joints rested."""
    time: float = -np.inf
    """s, of the last frame."""
    taken: float = -np.inf
    """s, of the last frame that was no repetition."""
    since: float = np.nan
    """s, when the sums began."""
    image: Grey | None = None
    """The last frame, prepared."""
    positions: Array | None = None
    """(L, J) positions a lag before the last frame."""
    begun: Array | None = None
    """(J,) positions when the sums began."""


@dataclass(frozen=True)
class BodyFinder:
    """Finds the body in the image while it moves."""

    joints: tuple[str, ...]
    """Names of the joints whose positions come with each frame."""
    cell_px: int = 16
    """Side of a cell, pixels."""
    camera_joints: tuple[str, ...] = ()
    """Those of `joints` that carry the camera, such as a neck: they move the whole view."""
    false_share: float = 0.02
    """Expected share of wrong cells among those that are called me."""
    longest_lag_s: float = 0.3
    """s; the camera is at most this late. A person who imitates the robot is later."""

    def __post_init__(self) -> None:
        check_settings(self.joints, self.cell_px, self.camera_joints)
        if not 0 < self.false_share < 1:
            raise InputError(f"false_share is a share; give 0 to 1, not {self.false_share:g}.")
        if not 0 < self.longest_lag_s <= 1:
            raise InputError(
                f"longest_lag_s is in seconds, above 0 and up to 1; got {self.longest_lag_s:g}."
            )

    def start(self, size: tuple[int, int]) -> FinderState:
        """Before the first frame; size is (width, height) in pixels.

        Raises:
            InputError: an image smaller than three cells either way.
        """
        rows, cols = grid(size, self.cell_px)
        L, J, N = len(self._lags), len(self.joints), rows * cols
        return FinderState(
            size=size, motor=MotionCutter().start(J), sums=empty(L, J, N), belief=empty(L, J, N),
            odds=Contingency(np.zeros((L, N))), lag=LagBelief(np.zeros(L)),
            moved=Moved(np.zeros(J, dtype=np.int64), np.zeros(J), np.zeros(J)),
            own_flow=np.zeros((N, 2)), texture=np.zeros(N),
            restless=np.zeros(N),
        )  # fmt: skip

    def step(
        self, state: FinderState, moment: tuple[Frame, ...]
    ) -> tuple[FinderState, tuple[bool, ...]]:
        """The state after one frame, and whether it ended a motion: then `found` says more.

        Raises:
            InputError: not the announced image, not one finite number a joint, or not later than
                the frame before.
            MissingExtraError: OpenCV is not installed.
        """
        ended = []
        for frame in moment:
            state = self._looked(state, frame)
            ended.append(state.motor.ended)
        return state, tuple(ended)

    def _looked(self, state: FinderState, frame: Frame) -> FinderState:
        here = check_frame(state.size, self.joints, state.time, frame)
        time_s = frame.time
        motor = MotionCutter().step(state.motor, time_s, here)
        prepared = prepare(frame.image, self.cell_px)
        moved_on = replace(state, motor=motor, time=time_s)
        if state.image is None:
            seen = replace(
                moved_on, since=time_s, taken=time_s, image=prepared, begun=here,
                positions=motor.at(time_s - self._lags),
            )  # fmt: skip
        elif time_s - state.taken < LONGEST_GAP and repeats(
            state.image, prepared, self.cell_px, reduction(state.size[0], self.cell_px)
        ):
            # Many cameras repeat pictures: the next true one is then compared with the last.
            seen = moved_on
        else:
            seen = self._seen(moved_on, prepared)
        return self._weighed(seen, here) if motor.ended else seen

    def _seen(self, state: FinderState, prepared: Grey) -> FinderState:
        """With the motion since the last picture that was no repetition."""
        assert state.image is not None
        assert state.positions is not None
        motor, factor = state.motor, reduction(state.size[0], self.cell_px)
        flow = cell_flow(state.image, prepared, self.cell_px, factor, bool(self.camera_joints))
        least, own = NOISE * factor, flow.own.reshape(-1, 2)
        positions, since = motor.at(state.time - self._lags), state.since
        passed, keep = state.time - state.taken, 1.0
        if np.isnan(motor.began):
            keep = float(np.exp(-passed / REST_MEMORY))
            since = max(since, state.time - REST_MEMORY)
        rests = state.time - motor.last_moved > self.longest_lag_s
        moves = np.hypot(own[:, 0], own[:, 1]) > MOVES * factor
        return replace(
            state, taken=state.time, since=since, image=prepared, positions=positions,
            own_flow=own, texture=flow.texture.ravel(),
            sums=state.sums.add((positions - state.positions) / least, own / least, keep),
            restless=float(np.exp(-passed / LATELY)) * state.restless + (moves & rests),
        )  # fmt: skip

    def _weighed(self, state: FinderState, here: Array) -> FinderState:
        """After the last frame of a motion."""
        before = faded(state.belief, FADING)
        odds, score = weigh(
            state.odds, before, state.sums, state.time - state.since, *self._columns,
            self._precision(state),
        )  # fmt: skip
        assert state.begun is not None
        return replace(
            state, odds=odds, lag=after_motion(state.lag, score), belief=joined(before, state.sums),
            sums=empty(len(self._lags), len(self.joints), len(state.texture)),
            since=state.time, begun=here,
            moved=with_motion(state.moved, here - state.begun, MotionCutter().turn),
        )  # fmt: skip

    def found(self, state: FinderState) -> BodyInView:
        """What is known by now."""
        shape, best, own = grid(state.size, self.cell_px), state.lag.best, self._columns[0]
        P = probability(state.odds.log_odds[best])
        mask = called_me(P, self.false_share)
        K, V = jacobians(state.belief, best, self._precision(state))
        evidence = joint_evidence(state.belief, best, K, V)
        lag_sd = LAG_STEP * state.lag.sd()
        enough, reason = verdict(P, mask, state.texture, state.moved, lag_sd, self.joints, own)
        least = NOISE * reduction(state.size[0], self.cell_px)
        scaled = (K / least, V / least**2)
        more = next_motion(P, state.texture, *scaled, state.moved, self.joints, own)
        return BodyInView(
            time=state.time, joints=self.joints, size=state.size, cell_px=self.cell_px,
            probability=P.reshape(shape), mask=mask.reshape(shape),
            now=in_company(self._moving(state).reshape(shape)),
            joint=np.where(mask, own[furthest(K[..., own], evidence[own])], -1).reshape(shape),
            evidence=evidence.reshape(len(self.joints), *shape),
            lag_s=LAG_STEP * state.lag.lag(), lag_sd_s=lag_sd, motions=state.odds.motions,
            enough=enough, reason=reason, next_motion=None if enough else more,
        )  # fmt: skip

    def _moving(self, state: FinderState) -> Flags:
        """(N,) cells that move now, as the joints did, and do not while the joints rest."""
        late = state.time - state.lag.best * LAG_STEP - state.motor.last_moved
        least = MOVES * reduction(state.size[0], self.cell_px)
        moves = np.hypot(state.own_flow[:, 0], state.own_flow[:, 1]) > least
        return np.asarray(moves & (late < JUST_NOW) & (state.restless < RESTLESS))

    def _precision(self, state: FinderState) -> float:
        """1 / s^2, (rad/pixel)^2."""
        return 1 / (SLOPE * reduction(state.size[0], self.cell_px)) ** 2

    @cached_property
    def _lags(self) -> Array:
        """(L,) s."""
        return LAG_STEP * np.arange(0.0, int(self.longest_lag_s / LAG_STEP + 1e-9) + 1)

    @cached_property
    def _columns(self) -> tuple[Ints, Ints]:
        """Numbers of the joints that move the body in view, and of those that carry the camera."""
        carries = np.isin(self.joints, self.camera_joints)
        return np.flatnonzero(~carries), np.flatnonzero(carries)
