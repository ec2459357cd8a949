"""What `bodyschema find-body` says: the same answer as plain types and in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.sources.tables import write_table
from bodyschema.vision.overlay import save_png

Flags = NDArray[np.bool_]

FEW = 3
"""Cells; smaller regions are summed up in one line."""


def found_json(found: BodyInView, moving: Flags) -> dict[str, Any]:
    """The answer in plain types, SI and pixels.

    Args:
        found: after the last frame.
        moving: (n_frames, rows, cols) cells that moved with the joints in each frame.
    """
    lit = moving.sum(axis=(1, 2))
    return {
        "motions": found.motions,
        "enough": found.enough,
        "reason": found.reason,
        "next_motion": None if found.next_motion is None else asdict(found.next_motion),
        "lag_s": found.lag_s if np.isfinite(found.lag_s) else None,
        "lag_sd_s": found.lag_sd_s if np.isfinite(found.lag_sd_s) else None,
        "size": list(found.size),
        "cell_px": found.cell_px,
        "cells": int(found.mask.size),
        "body_cells": int(found.mask.sum()),
        "cells_of_joint": {
            name: int(np.sum(found.mask & (found.joint == j)))
            for j, name in enumerate(found.joints)
        },
        "regions": _regions(found),
        "frames_with_moving_cells": int(np.sum(lit > 0)),
        "moving_cells_median": float(np.median(lit[lit > 0])) if lit.any() else 0.0,
    }


def _regions(found: BodyInView) -> list[dict[str, Any]]:
    """Connected cells that are me, the largest first."""
    label, count = ndimage.label(found.mask)
    regions = []
    for k in range(1, count + 1):
        inside = label == k
        rows, cols = np.nonzero(inside)
        owners = found.joint[inside]
        owners = owners[owners >= 0]
        joint = found.joints[int(np.bincount(owners).argmax())] if len(owners) else None
        box = [cols.min(), rows.min(), cols.max() + 1, rows.max() + 1]
        regions.append(
            {
                "cells": int(inside.sum()),
                "joint": joint,
                "box_px": [int(edge) * found.cell_px for edge in box],
                "probability": float(found.probability[inside].mean()),
            }
        )
    return sorted(regions, key=lambda region: (-region["cells"], region["box_px"]))


def write_found(folder: Path, found: BodyInView, moving: Flags, answer: Mapping[str, Any]) -> None:
    """Write found.json, mask.png, evidence.npz and the same as evidence.csv into a folder."""
    (folder / "found.json").write_text(json.dumps(answer, indent=1))
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


def describe_found(answer: Mapping[str, Any], out: Path) -> str:
    """The answer in words."""
    lines = [_head(answer)]
    large = [region for region in answer["regions"] if region["cells"] >= FEW]
    small = [region for region in answer["regions"] if region["cells"] < FEW]
    for region in large:
        u0, v0, u1, v1 = region["box_px"]
        mover = f", moved furthest by {region['joint']}" if region["joint"] else ""
        lines.append(f"  {region['cells']:4d} cells in ({u0}, {v0}) to ({u1}, {v1}) px{mover}")
    if small:
        cells = sum(region["cells"] for region in small)
        lines.append(f"  {cells:4d} cells in {len(small)} smaller places")
    movers = {name: n for name, n in answer["cells_of_joint"].items() if n}
    if movers:
        ranked = sorted(movers.items(), key=lambda item: -item[1])
        lines.append("Cells of a joint: " + ", ".join(f"{name} {n}" for name, n in ranked) + ".")
    lines += [_moving(answer), _lag(answer)]
    verdict = "Seen enough" if answer["enough"] else "Not seen enough"
    lines.append(f"{verdict} after {answer['motions']} motions: {answer['reason']}")
    lines.append(
        f"{answer['frames']} frames, {answer['frames_per_second']:.1f} a second "
        f"({answer['ms_per_frame']:.1f} ms of them looking for the body)."
    )
    lines.append(f"Evidence, mask, pictures and video: {out}")
    lines.append(_next(answer))
    return "\n".join(lines)


def _head(answer: Mapping[str, Any]) -> str:
    if not answer["body_cells"]:
        return "No cell of the picture is surely me all the time."
    share = 100 * answer["body_cells"] / answer["cells"]
    return f"Found: {answer['body_cells']} of {answer['cells']} cells are me ({share:.1f} %):"


def _moving(answer: Mapping[str, Any]) -> str:
    frames = answer["frames_with_moving_cells"]
    if not frames:
        return "In no frame does anything move together with the joints."
    return (
        f"In {frames} of {answer['frames']} frames something moves together with the joints, "
        f"{answer['moving_cells_median']:.0f} cells in the middle one."
    )


def _lag(answer: Mapping[str, Any]) -> str:
    if answer["lag_s"] is None or answer["lag_sd_s"] is None:
        return "How far the pictures lag behind the encoders is not known yet."
    lag, sd = 1e3 * answer["lag_s"], 1e3 * answer["lag_sd_s"]
    return f"The pictures come {lag:.0f} ± {sd:.0f} ms after the encoders."


def _next(answer: Mapping[str, Any]) -> str:
    motion = answer["next_motion"]
    if motion is None:
        return "Next: look at the pictures; coloured cells should lie on the robot."
    act = f"move {motion['joint']} alone" if motion["kind"] == "joint" else "repeat the last motion"
    return f"Next: {act}: {motion['why']}"
