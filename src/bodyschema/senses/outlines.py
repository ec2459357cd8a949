"""Outlines: where a camera sees the edge of the body against what is behind it.

A rim point X of the surface (`vision.correspondences`), imagined at pi(T X) with the outward normal
n, was found at the picture's own outline s = pi(T X) + d n (`vision.normal_search`). Pixels along a
contour err together: over the steps of a mask's staircase, or where an edge is blurred. So the
points of one short arc of contour are one sample, their mean by length c_k,

    residual  r = sum_k c_k [n_k . (s_k - pi(T_a_b(q, x) X_k)) - g_k h_k] - e     px

with a the camera and b the piece. As the outline moves along n as its material points do, this is
exact to first order in the body, and exact as such in its derivatives; `associate` chooses points,
normals and places anew round a better body, and looks for them less far away each time. What may be
wrong besides the body:

    lens   f and c of the camera, a part "lens" (its distortion was taken out of the pictures)
    edge   e, px, that masks or edges lie outward all round: a part with one number
    skin   h, m, that the body is thicker than its mesh, for each patch of it: a part with as many
           numbers as there are patches; g = |n^T P| px/m, see `outward_gain`

The samples of one picture share time and row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.images import Picture
from bodyschema.senses.sense import Linearized, Sense, check_samples, counted
from bodyschema.senses.views import View, moved, ready
from bodyschema.vision.arcs import ARC, MATCHED, arcs
from bodyschema.vision.correspondences import Rim, find_rim, normal_slope, outward_gain
from bodyschema.vision.normal_search import Gradient
from bodyschema.vision.patches import Patches
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

DEFAULT_STD = 0.3
"""px, where the user states no noise: how well a mask's or an edge's place is found."""

REACH, LEAST_REACH, NEARER = 40.0, 4.0, 0.6
"""px to either side that an outline is looked for at first and at last, and the factor between."""

LOOKS = 3
"""Searches at the least reach, after which correspondences are kept: some points at the ends of
arcs come and go for ever."""

SPACING = 2
"""Rows and columns from one point of the contour to the next."""


@dataclass(frozen=True)
class Outlines(Sense):
    """How far outward, px, the seen outline lies of the imagined one; one sample an arc."""

    camera: Camera = field(kw_only=True)
    """Whose frame is `seen_from`; without distortion."""
    surface: Surface = field(kw_only=True)
    """What shows of the body."""
    patches: Patches = field(kw_only=True)
    """Of the surface, that err on their own."""
    views: tuple[View, ...] = field(default=(), kw_only=True)
    """All pictures; those of which no sample is left any more are not looked at again."""
    unseen: tuple[int, ...] = field(default=(), kw_only=True)
    """Pictures in which nothing was found yet."""
    view: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64), kw_only=True)
    """(n,) which picture a sample is of."""
    piece: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64), kw_only=True)
    """(n,) which piece of the surface."""
    patch: Ints = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64), kw_only=True)
    """(n, k) which patches of it, for each point of the arc."""
    point: Array = field(default_factory=lambda: np.empty((0, 0, 3)), kw_only=True)
    """(n, k, 3) m, X in the frame of the piece."""
    normal: Array = field(default_factory=lambda: np.empty((0, 0, 2)), kw_only=True)
    """(n, k, 2) n, unit, outward."""
    share: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    """(n, k) c, of sum 1; 0 where an arc has fewer points."""
    gain: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    """(n, k) g, px per m."""
    lens: str = field(default="", kw_only=True)
    """Part "lens"; "" takes the camera's own numbers."""
    edge: str = field(default="", kw_only=True)
    """Part with one number e; "" for none."""
    skin: str = field(default="", kw_only=True)
    """Part with the number h of every patch; "" for none."""
    reach: float = field(default=REACH, kw_only=True)
    """px, of the next search."""
    looks: int = field(default=0, kw_only=True)
    """Searches at the least reach so far."""
    arc: float = field(default=ARC, kw_only=True)
    """px of contour that are one sample."""
    spacing: int = field(default=SPACING, kw_only=True)
    """Rows and columns between points."""
    polarity: float = field(default=0.0, kw_only=True)
    """In images: +1 where the body is darker than what is behind it, -1 brighter, 0 unknown."""

    measures = (("outline", "px", 1),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, ())
        for part in (self.point, self.normal, self.share, self.gain):
            check_samples(self, part)

    @classmethod
    def make(  # type: ignore[override]
        cls,
        body: Body,
        q: ArrayLike,
        pictures: Sequence[Picture | Gradient],
        camera: Camera,
        surface: Surface,
        std: float = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        rate: ArrayLike | None = None,
        patches: int = 0,
        **more: Any,
    ) -> Self:
        """Build from pictures of one camera, outlines found round a first body.

        Args:
            body: the first guess.
            q: (n_pictures, n_joints) encoder readings.
            pictures: of each, a mask of the body (bool), an 8-bit image or its slopes; taken with
                the camera's own distortion.
            camera: its frame is a frame of the body.
            surface: what shows of the body.
            std: noise of a found place across the outline, px.
            time: (n_pictures,) s; 0, 1, 2, ... when None.
            rows: (n_pictures,) numbers for messages; 0, 1, 2, ... when None.
            rate: (n_pictures, n_joints) dq/dt; needed with a clock.
            patches: of each piece that err on their own.
            more: `lens`, `edge`, `skin`, `reach`, `arc`, `spacing`, `polarity`, `stated`, `clock`.

        Raises:
            InputError: not one picture for each posture.
        """
        readings, times, numbers = counted(q, time, rows)
        if len(pictures) != len(readings):
            raise InputError(f"{len(pictures)} pictures and {len(readings)} postures; give pairs.")
        rates = [None] * len(readings) if rate is None else list(np.asarray(rate, dtype=float))
        views = tuple(
            View(ready(picture, camera), float(t), int(row), reading, speed)
            for picture, t, row, reading, speed in zip(
                pictures, times, numbers, readings, rates, strict=True
            )
        )
        if rate is not None:
            more["rate"] = np.zeros((0, readings.shape[1]))
        blank = cls.blank(camera, surface, readings.shape[1], std, patches, **more)
        return replace(blank, views=views, unseen=tuple(range(len(views))))._looked(
            body, blank.reach
        )

    @classmethod
    def blank(
        cls,
        camera: Camera,
        surface: Surface,
        n_joints: int,
        std: float = DEFAULT_STD,
        patches: int = 0,
        **more: Any,
    ) -> Self:
        """No picture yet: what `imagined` views are made of; see `make`."""
        straight = replace(camera, distortion=np.zeros(0))
        return cls(
            time=np.zeros(0),
            q=np.zeros((0, n_joints)),
            seen_from=camera.frame,
            seen=surface.frames[-1],
            covariance=np.array([[std**2]]),
            rows=np.zeros(0, dtype=np.int64),
            camera=straight,
            surface=surface,
            patches=Patches.of(surface, patches),
            **more,
        )

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"outline seen from {self.seen_from}"

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """The camera and each piece."""
        return tuple((self.seen_from, frame) for frame in self.surface.frames)

    def predict(self, body: Body) -> Array:
        """n . pi(T X) + g h + e, (n,) px."""
        q, group = _runs(self.readings(body))
        out = self._outward(body)
        K = self._camera(body).intrinsics
        for b in np.unique(self.piece):
            mine = self.piece == b
            T = relative_pose(body, q, self.seen_from, self.surface.frames[b])[group[mine]]
            seen = self.point[mine] @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3]
            pixel = K[:2] * seen[..., :2] / seen[..., 2:] + K[2:]
            out[mine] += self._mean(np.sum(self.normal[mine] * pixel, axis=2), mine)
        return out

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        body = reference.with_variables(variables, x)
        q, group = _runs(self.readings(body))
        K, n = self._camera(body).intrinsics, len(self)
        plane = np.zeros((*self.share.shape, 2))
        by_parameter, by_joint = np.zeros((n, len(x))), np.zeros((n, q.shape[1]))
        for b in np.unique(self.piece):
            frame = self.surface.frames[b]
            D = relative_pose_derivatives(reference, variables, x, q, self.seen_from, frame)
            for k in np.unique(group[self.piece == b]):
                mine = np.flatnonzero((self.piece == b) & (group == k))
                arm = self.point[mine] @ D.pose[k, :3, :3].T
                seen = arm + D.pose[k, :3, 3]
                slope = normal_slope(self.normal[mine], seen, K[:2])
                by_twist = np.concatenate([slope, np.cross(arm, slope)], axis=2)
                by_twist = np.einsum("nk,nki->ni", self.share[mine], by_twist)
                by_parameter[mine] = by_twist @ D.by_parameter[k]
                by_joint[mine] = by_twist @ D.by_joint[k]
                plane[mine] = seen[..., :2] / seen[..., 2:]
        pixel = np.sum(self.normal * (K[:2] * plane + K[2:]), axis=2)
        residual = self.observed - self._mean(pixel) - self._outward(body)
        self._by_parts(variables, plane, by_parameter)
        return self.late(
            Linearized(residual[:, None], -by_parameter[:, None], -by_joint[:, None]), variables
        )

    def imagined(self, body: Body, q: ArrayLike) -> Self:
        """Whole outlines at postures q (n, n_joints): many samples each, of row 0, 1, 2 ..."""
        postures = np.atleast_2d(np.asarray(q, dtype=np.float64))
        still = None if self.rate is None else np.zeros(postures.shape[1])
        views = tuple(View(None, float(k), k, row, still) for k, row in enumerate(postures))
        blank = replace(self.take([]), views=views, unseen=tuple(range(len(views))))
        return blank._looked(body, 0.0)

    def associate(self, body: Body) -> Self:
        """The samples with rim points and their places chosen anew round a body, nearer by."""
        if self.looks >= LOOKS:
            return self
        reach = max(LEAST_REACH, NEARER * self.reach)
        return replace(self, looks=self.looks + (reach == LEAST_REACH))._looked(body, reach)

    def kept(self, body: Body) -> Self:
        """The samples as a body shows them nearby; `associate` leaves them."""
        return replace(self._looked(body, LEAST_REACH), looks=LOOKS)

    def matched(self, body: Body) -> float:
        """Share of the imagined outline that the pictures show within `MATCHED`; 0 for none."""
        near, whole = 0.0, 0.0
        for i in self._open:
            rim, _ = self._rim(body, self.views[i])
            seen = self.views[i].search(rim, LEAST_REACH, self.polarity)
            near += float(rim.length[seen.found & (np.abs(seen.distance) < MATCHED)].sum())
            whole += float(rim.length.sum())
        return near / max(whole, 1.0)

    @property
    def _open(self) -> list[int]:
        """Pictures that are looked at."""
        return sorted({*self.view.tolist(), *self.unseen})

    def _looked(self, body: Body, reach: float) -> Self:
        """The samples as `reach` pixels round a body show them; as imagined where no picture is.

        A piece that stands before the camera as in an earlier picture has the same outline and the
        same errors again: it counts once.
        """
        T, found = {i: self._poses(body, self.views[i]) for i in self._open}, []
        if not T:
            return self
        for i, pose in T.items():
            view = self.views[i]
            # A posture that is imagined twice was asked for twice.
            before = [
                T[k]
                for k in T
                if k < i and (view.picture is not None or (view.q != self.views[k].q).any())
            ]
            found.append(self._look(body, i, view, reach, moved(pose, before)))
        columns: dict[str, Any] = {
            name: np.concatenate([one[name] for one in found]) for name in found[0]
        }
        unseen = tuple(sorted(set(T) - set(columns["view"].tolist())))
        blank = replace(self, reach=reach, unseen=unseen, **columns)
        imagined = np.array([view.picture is None for view in self.views])[blank.view]
        thick = np.where(imagined, blank._outward(body), 0.0)
        return replace(blank, observed=blank.observed + thick)

    def _look(
        self, body: Body, i: int, view: View, reach: float, fresh: NDArray[np.bool_]
    ) -> dict[str, Array | Ints]:
        """The samples of one picture, of those pieces that have moved, by field."""
        rim, gain = self._rim(body, view)
        seen = view.search(rim, reach, self.polarity)
        most = int(np.ceil(self.arc / self.spacing)) + 1
        rows = arcs(rim, seen.found & fresh[rim.piece], seen.distance, self.arc, most)
        share = np.where(rows >= 0, rim.length[rows], 0.0)
        share = share / share.sum(axis=1, keepdims=True)
        patch = self.patches.of_rim(rim) if len(self.patches) else np.zeros(len(rim), np.int64)
        place = np.sum(rim.normal * rim.pixel, axis=1) + seen.distance
        count = len(rows)
        columns = {
            "time": np.full(count, view.time),
            "rows": np.full(count, view.row, dtype=np.int64),
            "q": np.tile(view.q, (count, 1)),
            "view": np.full(count, i, dtype=np.int64),
            "piece": rim.piece[rows[:, 0]],
            "patch": patch[rows],
            "point": rim.point[rows],
            "normal": rim.normal[rows],
            "share": share,
            "gain": gain[rows],
            "observed": np.sum(share * place[rows], axis=1),
        }
        if view.rate is not None:
            columns["rate"] = np.tile(view.rate, (count, 1))
        return columns

    def _rim(self, body: Body, view: View) -> tuple[Rim, Array]:
        """The outline as drawn, and its gain."""
        camera, T = self._camera(body), self._poses(body, view)
        rim = find_rim(self.surface, T[None], [camera], self.spacing)
        return rim, outward_gain(rim, T[None], [camera])

    def _poses(self, body: Body, view: View) -> Array:
        """T_cam_piece, (n_pieces, 4, 4)."""
        lag = body.part(self.clock)["lag"] if self.clock else 0.0
        q = view.q if view.rate is None else view.q - lag * view.rate
        return np.asarray(piece_poses(body, q, [self.camera], self.surface.frames)[0, 0])

    def _camera(self, body: Body) -> Camera:
        """The camera by what is believed of its lens."""
        if not self.lens:
            return self.camera
        f_x, f_y, c_x, c_y = body.part(self.lens).values[:4]
        return replace(self.camera, matrix=np.array([[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]]))

    def _mean(self, values: Array, rows: Any = slice(None)) -> Array:
        """Over the points of each arc: (n, k) -> (n,)."""
        return np.asarray(np.sum(self.share[rows] * values, axis=1))

    def _outward(self, body: Body) -> Array:
        """sum c g h + e, (n,) px."""
        out = np.full(len(self), body.part(self.edge).values[0] if self.edge else 0.0)
        return (
            out + self._mean(self.gain * body.part(self.skin).values[self.patch])
            if self.skin
            else out
        )

    def _by_parts(self, variables: Variables, plane: Array, by_parameter: Array) -> None:
        """Fill in the derivatives of the prediction by lens, edge and skin."""
        own = np.concatenate([self.normal * plane, self.normal], axis=2)
        columns, numbers = variables.of_part(self.lens)
        pinhole = numbers < 4
        by_parameter[:, columns[pinhole]] = np.einsum(
            "nk,nki->ni", self.share, own[..., numbers[pinhole]]
        )
        columns, _ = variables.of_part(self.edge)
        by_parameter[:, columns] = 1.0
        columns, numbers = variables.of_part(self.skin)
        for column, number in zip(columns, numbers, strict=True):
            by_parameter[:, column] = self._mean(self.gain * (self.patch == number))


def _runs(q: Array) -> tuple[Array, Ints]:
    """Rows of q that differ from the one before, (m, n_joints), and which of them each is, (n,)."""
    if not len(q):
        return q, np.zeros(0, dtype=np.int64)
    new = np.concatenate([[True], (q[1:] != q[:-1]).any(axis=1)])
    return q[new], np.cumsum(new) - 1
