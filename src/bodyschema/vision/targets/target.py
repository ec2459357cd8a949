"""A calibration target: a flat pattern whose corners a picture tells to a fraction of a pixel.

    kind         columns x rows count      square_m is                     corner 0 is
    chessboard   inner corners             from one corner to the next     the origin
    charuco      squares                   the side of a square            one square in, both ways
    tags         tags (1 x 1: one tag)     from one tag to the next        of the first tag, origin
    circles      circles                   from one centre to the next     the origin

x runs along the columns, y along the rows, z away from who looks at the board: OpenCV's frames and
counts. Corners are numbered along the rows; a tag has four, clockwise from its own first. Of
`asymmetric` circles every other row is shifted by `square_m`, and those of a row are 2 `square_m`
apart. The square whose corner is corner 0 of a chessboard, inward, is black.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

KINDS = ("chessboard", "charuco", "tags", "circles")

MOST = 10_000
"""Corners of a target."""

LEAST_COUNT = {"chessboard": 3, "charuco": 2, "tags": 1, "circles": 2}
"""Columns and rows of each kind: OpenCV finds no chessboard of fewer corners."""


@dataclass(frozen=True)
class Target:
    """What a board is; see the table above."""

    kind: str
    """A word of `KINDS`."""
    columns: int
    rows: int
    square_m: float
    """m"""
    marker_m: float = 0.0
    """m, the side of a tag's black square."""
    dictionary: str = ""
    """Of the tags, as OpenCV calls it: "4X4_50", "APRILTAG_36h11"."""
    first_id: int = 0
    """Number of the first tag of a grid."""
    asymmetric: bool = False
    """Of circles: every other row is shifted."""
    legacy: bool = False
    """A ChArUco board of OpenCV before 4.6, whose first square is white where rows are even."""

    def check(self, where: str) -> None:
        """Refuse what is no target. Raises InputError, `where` names the place."""
        if self.kind not in KINDS:
            raise InputError(f"kind = '{self.kind}' in {where}{did_you_mean(self.kind, KINDS)}")
        least = LEAST_COUNT[self.kind]
        if min(self.columns, self.rows) < least or 4 * self.columns * self.rows > MOST:
            raise InputError(
                f"{where} has {self.columns} columns and {self.rows} rows; a target of kind "
                f"{self.kind} has {least} of each or more, and at most {MOST} corners."
            )
        if not 0 < self.square_m < 10:
            raise InputError(f"square_m = {self.square_m} in {where}; give the length in m.")
        if self.tagged:
            self._check_tags(where)
        elif self.marker_m or self.dictionary:
            raise InputError(f"{where} has marker_m or dictionary, and a {self.kind} has no tags.")

    def _check_tags(self, where: str) -> None:
        largest = self.square_m if self.columns * self.rows > 1 or self.kind == "charuco" else 10
        if not self.dictionary or not 0 < self.marker_m <= largest:
            raise InputError(
                f"{where} needs dictionary, such as '4X4_50', and marker_m, the side of a tag in "
                f"m, which is less than square_m; they are '{self.dictionary}' and {self.marker_m}."
            )

    @property
    def tagged(self) -> bool:
        """Whether tags tell one corner from the other."""
        return self.kind in ("charuco", "tags")

    @property
    def grid(self) -> tuple[int, int]:
        """Columns and rows of corners, or of tags."""
        inner = 1 if self.kind == "charuco" else 0
        return self.columns - inner, self.rows - inner

    @property
    def clear(self) -> float:
        """Share of the way from a corner to the next on which there is no edge but its own."""
        if self.kind == "charuco":
            return (self.square_m - self.marker_m) / 2 / self.square_m
        # A tag's black rim is a cell wide, of eight or ten.
        return 0.1 if self.kind == "tags" else 0.5

    @property
    def corners(self) -> Array:
        """Places of the corners in the target's frame, (n, 3) m."""
        columns, rows = self.grid
        j, i = (one.ravel() for one in np.meshgrid(np.arange(columns), np.arange(rows)))
        if self.asymmetric:
            j = 2 * j + i % 2
        at = self.square_m * np.stack([j, i, 0 * i], axis=1).astype(np.float64)
        if self.kind == "charuco":
            at[:, :2] += self.square_m
        if self.kind == "tags":
            round_it = self.marker_m * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
            at = (at[:, None] + round_it).reshape(-1, 3)
        return at

    @property
    def toml(self) -> str:
        """As an inline table of a run file."""
        said = [f'kind = "{self.kind}", columns = {self.columns}, rows = {self.rows}']
        said += [f"square_m = {self.square_m:g}"]
        if self.tagged:
            said += [f'marker_m = {self.marker_m:g}, dictionary = "{self.dictionary}"']
        said += [f"first_id = {self.first_id}"] if self.first_id else []
        said += [f"{key} = true" for key in ("asymmetric", "legacy") if getattr(self, key)]
        return "{ " + ", ".join(said) + " }"

    @property
    def turns(self) -> list[tuple[Ints, Array]]:
        """The ways in which the pattern looks the same, the first as it is.

        Each is a renumbering (n,) and the motion F (4, 4): corner p[i] = F corner i.
        """
        places, middle = self.corners, (self.corners.min(axis=0) + self.corners.max(axis=0)) / 2
        found = []
        for quarter in self._quarters():
            R = lie.exp_so3(np.array([0.0, 0.0, quarter * np.pi / 2]))
            F = lie.transform(R, middle - R @ middle)
            moved = places @ R.T + F[:3, 3]
            apart = np.linalg.norm(moved[:, None] - places, axis=2)
            found.append((np.argmin(apart, axis=1), F))
        return found

    def _quarters(self) -> tuple[int, ...]:
        """Quarter turns that leave the pattern as it is."""
        square = self.columns == self.rows
        if self.tagged:
            return (0,)
        if self.kind == "circles":
            if self.asymmetric:
                return (0, 2) if self.rows % 2 == 0 else (0,)
            return (0, 1, 2, 3) if square else (0, 2)
        if self.columns % 2 != self.rows % 2:
            return (0,)
        # Squares are one more than inner corners; a quarter turn keeps colours if they are odd.
        return (0, 1, 2, 3) if square and self.columns % 2 == 0 else (0, 2)
