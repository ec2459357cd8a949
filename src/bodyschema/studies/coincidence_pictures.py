"""Pictures of Fig. 3 to 5 of Nabeshima and Kuniyoshi: frames with cells drawn over them."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.studies.watched_scenes import CELL
from bodyschema.vision.flow import opencv

Grey = NDArray[np.uint8]


def packed(picture: Grey) -> str:
    """A grey picture as text: PNG in base64."""
    _, data = opencv().imencode(".png", picture)
    return base64.b64encode(data.tobytes()).decode("ascii")


def show(axes: Any, picture: str, title: str) -> None:
    """A packed picture."""
    data = np.frombuffer(base64.b64decode(picture), dtype=np.uint8)
    axes.imshow(opencv().imdecode(data, 0), cmap="gray", vmin=0, vmax=255)
    axes.set(title=title, xticks=[], yticks=[])
    axes.grid(False)


def outline(axes: Any, cells: Any, colour: str) -> None:
    """Rectangles about the cells that are not zero, (rows, cols)."""
    from matplotlib.patches import Rectangle

    for row, col in zip(*np.nonzero(np.asarray(cells)), strict=True):
        corner = (CELL * col + 0.5, CELL * row + 0.5)
        size = CELL - 3.0
        axes.add_patch(Rectangle(corner, size, size, fill=False, edgecolor=colour, linewidth=1.2))


def blended(axes: Any, share: Any) -> None:
    """Cells the redder the larger their share, (rows, cols) from 0 to 1."""
    values = np.asarray(share, dtype=np.float64)
    rows, cols = values.shape
    axes.imshow(
        values, cmap="Reds", vmin=0, vmax=1, alpha=0.75 * np.minimum(2 * values, 1),
        extent=(-0.5, CELL * cols - 0.5, CELL * rows - 0.5, -0.5),
    )  # fmt: skip
