"""Pixels: points fixed to a frame, such as the corners of a board, in the pictures of a camera.

    residual  r = (u, v) - lens(p),   p = t_a_b(q, x) + R_a_b(q, x) s c    a = camera, b = target

with c the point in the target's own coordinates and s the target's scale. The lens is a part of the
body and may be wrong, distortion included (`model.lens`); so may the scale of a board that was
printed too large. The corners of one picture are samples that share time and row.

    dr = -d lens/dp (d + w x (R s c) + R c ds) - d lens/d lens       for a twist (d, w) of T_a_b
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.lens import pixel_derivatives, pixels
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.carried import carried, carried_position, each, shown
from bodyschema.senses.sense import PLACEMENT, Linearized, Sense, check_samples

Array = NDArray[np.float64]

DEFAULT_STD = 0.3
"""px in each direction, where the user states no noise: corners found to a fraction of a pixel."""

PICTURED = 12
"""Corners of a picture that is only imagined: more say the same again, and cost memory."""


@dataclass(frozen=True)
class Pixels(Sense):
    """Pixels (n, 2) of points of frame `seen`, in the optical frame `seen_from` of a camera."""

    target: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the points in frame `seen`, in the target's own coordinates."""
    lens: str = field(default="", kw_only=True)
    """The body's part of kind "lens"."""
    scale: str = field(default="", kw_only=True)
    """The body's part that scales the target; "" where its coordinates are right."""
    size: tuple[int, int] = field(default=(0, 0), kw_only=True)
    """Width and height of the pictures, px; zeros where nobody said."""

    measures = (("image", "px", 2),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (2,))
        check_samples(self, self.target, (3,))
        if not self.lens:
            raise InputError(f'{self.label}: name the camera\'s lens, lens="NAME" of a part.')

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        image: ArrayLike,
        seen_from: str,
        seen: str,
        lens: str,
        target: ArrayLike | None = None,
        scale: str = "",
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings, repeated for the points of one picture.
            image: (n, 2) px; (0, 0) is the centre of the top-left pixel.
            seen_from: the camera's optical frame, z forward, x right.
            seen: frame that the points are fixed to.
            lens: name of the body's part that is the lens.
            target: (n, 3) m, the points in `seen`, or (3,) for one point; its origin when None.
            scale: name of the body's part that scales `target`; "" for none.
            std: noise of each coordinate, px.
            time: (n,) s, the same for the points of one picture; 0, 1, 2, ... when None.
            rows: (n,) row numbers, likewise; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`, `size`.
        """
        found = np.atleast_2d(np.asarray(image, dtype=np.float64))
        points = each(target, len(found))
        more = {**more, "target": points, "lens": lens, "scale": scale}
        return super().make(q, found, seen_from, seen, std, time, rows, **more)

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"pixels of {self.seen} in {self.seen_from}"

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The target's orientation plays a part unless its one point is the origin."""
        return PLACEMENT, shown(self.target)

    def points(self, body: Body) -> Array:
        """The target's points at its true size, (n, 3) m in `seen`."""
        return self.target * body.part(self.scale)["scale"] if self.scale else self.target

    def lens_of(self, body: Body) -> Array:
        """(4 + k,) numbers of the lens. Raises InputError for a part of another kind."""
        part = body.part(self.lens)
        if part.kind != "lens":
            raise InputError(f"{self.label}: part '{self.lens}' is a {part.kind}, not a lens.")
        return part.values

    def predict(self, body: Body) -> Array:
        """Where the points would be seen, (n, 2) px; `model.lens.UNSEEN` out of the view."""
        return pixels(self.lens_of(body), carried_position(body, self, self.points(body)))

    def pictured(self, body: Body, q: ArrayLike) -> Self:
        """See `Sense.pictured`: all corners of a board, or PICTURED of them that lie far apart."""
        corners = _apart(np.unique(self.target, axis=0))
        if len(corners) < 2:
            return self.imagined(body, q)
        postures = np.asarray(q, dtype=np.float64)
        each = np.repeat(np.arange(len(postures)), len(corners))
        there = replace(self.imagined(body, postures[each]), rows=each, time=each.astype(float))
        there = replace(there, target=np.tile(corners, (len(postures), 1)))
        return replace(there, observed=there.predict(body))

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        body = reference.with_variables(variables, x)
        place = carried(reference, variables, x, self, self.points(body))
        image, by_point, by_lens = pixel_derivatives(self.lens_of(body), place.position)
        by_parameter = -by_point @ place.by_parameter
        columns, numbers = variables.of_part(self.lens)
        by_parameter[:, :, columns] -= by_lens[:, :, numbers]
        columns, _ = variables.of_part(self.scale)
        if len(columns):
            by_scale = place.arm / body.part(self.scale)["scale"]
            by_parameter[:, :, columns] -= by_point @ by_scale[:, :, None]
        linear = Linearized(self.observed - image, by_parameter, -by_point @ place.by_joint)
        return self.late(linear, variables)


def _apart(corners: Array) -> Array:
    """PICTURED corners of many, each the one that is farthest from those before it."""
    if len(corners) <= PICTURED:
        return corners
    chosen = [0]
    distance = np.linalg.norm(corners - corners[0], axis=1)
    while len(chosen) < PICTURED:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(corners - corners[chosen[-1]], axis=1))
    return np.asarray(corners[chosen])
