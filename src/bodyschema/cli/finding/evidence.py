"""What a search for the body saw, cell by cell, as files for other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.sources.tables import write_table
from bodyschema.vision.overlay import save_png

Flags = NDArray[np.bool_]


def write_evidence(folder: Path, found: BodyInView, moving: Flags) -> None:
    """Write mask.png, evidence.npz and the same as evidence.csv into a folder.

    Args:
        folder: that is there.
        found: after the last frame.
        moving: (n_frames, rows, cols) cells that moved with the joints in each frame.
    """
    white = np.where(found.pixels(), np.uint8(255), np.uint8(0))
    save_png(np.repeat(white[..., None], 3, axis=2), folder / "mask.png")
    np.savez_compressed(
        folder / "evidence.npz",
        joints=np.array(found.joints),
        cell_px=found.cell_px,
        mask=found.mask,
        probability=found.probability,
        joint=found.joint,
        evidence=found.evidence,
        moving=moving,
    )
    row, col = np.indices(found.mask.shape).reshape(2, -1)
    columns = {
        "u_px": (col + 0.5) * found.cell_px - 0.5,
        "v_px": (row + 0.5) * found.cell_px - 0.5,
        "probability": found.probability.ravel(),
        "me": found.mask.ravel(),
        "joint": found.joint.ravel(),
    }
    evidence = {
        f"evidence_{name}": e.ravel() for name, e in zip(found.joints, found.evidence, strict=True)
    }
    write_table(folder / "evidence.csv", columns | evidence)
