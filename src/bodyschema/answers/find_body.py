"""Which part of a picture is the robot, as an answer: nothing of a model is corrected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from bodyschema.answers.answer import Answer
from bodyschema.attention.body_in_view import BodyInView
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration
from bodyschema.model.kernels import FIXED
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.report.cells import Cells

Flags = NDArray[np.bool_]

FEW = 3
"""Cells; smaller regions are summed up in one line."""


def found_answer(
    found: BodyInView,
    moving: Flags,
    frames: int,
    left_out: int,
    run: Mapping[str, Any] | None = None,
    seconds: float = 0.0,
) -> Answer:
    """The answer of a search for the body.

    Args:
        found: after the last frame.
        moving: (n_frames, rows, cols) cells that moved with the joints in each frame.
        frames: that were looked at.
        left_out: frames without readings.
        run: what was asked.
        seconds: that it took.
    """
    details = found_details(found, moving) | {"frames": frames, "frames_left_out": left_out}
    there = bool(found.mask.any() or moving.any())
    body = Body.build("view", ["picture"], [""], [-1], [FIXED], [[0.0, 0.0, 1.0]], np.eye(4)[None])
    none, known = Accuracy({}, {}), Identifiability(0, (), np.zeros(0))
    nothing = Estimate(body, free_joints(body, ()), np.zeros(0), np.zeros((0, 0)))
    answer = Calibration(
        verdict="found" if there else "not found",
        explanation=_head(details),
        fit=nothing,
        nominal=none,
        held_out=none,
        identifiability=known,
        outliers=(),
        n_rows=frames,
        seconds=seconds,
        findings=tuple(_findings(details)),
        notes=(_enough(details), _next(details)),
        corrects=False,
        details=details,
    )
    return Answer.of(answer, (), body, run, verb="find-body", sections=(Cells(found),))


def found_details(found: BodyInView, moving: Flags) -> dict[str, Any]:
    """Everything found in plain types, SI and pixels; see `found_answer`."""
    lit = moving.sum(axis=(1, 2))
    return {
        "motions": found.motions,
        "enough": bool(found.enough),
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


def _findings(details: Mapping[str, Any]) -> list[str]:
    """Regions, what moves them, and how late the pictures are, in words."""
    lines = []
    large = [region for region in details["regions"] if region["cells"] >= FEW]
    small = [region for region in details["regions"] if region["cells"] < FEW]
    for region in large:
        u0, v0, u1, v1 = region["box_px"]
        mover = f", moved furthest by {region['joint']}" if region["joint"] else ""
        lines.append(f"  {region['cells']:4d} cells in ({u0}, {v0}) to ({u1}, {v1}) px{mover}")
    if small:
        cells = sum(region["cells"] for region in small)
        lines.append(f"  {cells:4d} cells in {len(small)} smaller places")
    movers = {name: n for name, n in details["cells_of_joint"].items() if n}
    if movers:
        ranked = sorted(movers.items(), key=lambda item: -item[1])
        lines.append("Cells of a joint: " + ", ".join(f"{name} {n}" for name, n in ranked) + ".")
    return [*lines, _moving(details), _lag(details)]


def _head(details: Mapping[str, Any]) -> str:
    if not details["body_cells"]:
        return "No cell of the picture is surely me all the time."
    share = 100 * details["body_cells"] / details["cells"]
    return f"{details['body_cells']} of {details['cells']} cells are me ({share:.1f} %)."


def _moving(details: Mapping[str, Any]) -> str:
    frames = details["frames_with_moving_cells"]
    if not frames:
        return "In no frame does anything move together with the joints."
    return (
        f"In {frames} of {details['frames']} frames something moves together with the joints, "
        f"{details['moving_cells_median']:.0f} cells in the middle one."
    )


def _lag(details: Mapping[str, Any]) -> str:
    if details["lag_s"] is None or details["lag_sd_s"] is None:
        return "How far the pictures lag behind the encoders is not known yet."
    lag, sd = 1e3 * details["lag_s"], 1e3 * details["lag_sd_s"]
    return f"The pictures come {lag:.0f} ± {sd:.0f} ms after the encoders."


def _enough(details: Mapping[str, Any]) -> str:
    verdict = "Seen enough" if details["enough"] else "Not seen enough"
    return f"{verdict} after {details['motions']} motions: {details['reason']}"


def _next(details: Mapping[str, Any]) -> str:
    motion = details["next_motion"]
    if motion is None:
        return "Next: look at the pictures; coloured cells should lie on the robot."
    act = f"move {motion['joint']} alone" if motion["kind"] == "joint" else "repeat the last motion"
    return f"Next: {act}: {motion['why']}"
