"""The answer of `track`: one JSON object for machines, text for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bodyschema.export.calibration_yaml import OPEN
from bodyschema.units import read_as, with_error

if TYPE_CHECKING:
    from pathlib import Path

    from bodyschema.export.tracked_files import Settled
    from bodyschema.learners.images.hand_track import HandPose


def track_json(
    settled: Settled, poses: Sequence[HandPose], numbers: Sequence[int]
) -> dict[str, Any]:
    """The answer in plain types, SI.

    Args:
        settled: what was learned from the key postures.
        poses: the hand at every moment.
        numbers: of the first camera's pictures at these moments.
    """
    fit = settled.fit
    estimate = fit.estimate
    rows = zip(
        estimate.variables.names,
        estimate.x.tolist(),
        estimate.std.tolist(),
        estimate.variables.units,
        fit.identifiability.open_share.tolist(),
        strict=True,
    )
    return {
        "lost": fit.lost,
        "matched": fit.matched,
        "residual_px": fit.residual if np.isfinite(fit.residual) else None,
        "iou": fit.iou if np.isfinite(fit.iou) else None,
        "bias_px": fit.bias.tolist(),
        "parameters": {
            name: {"value": value, "std": std, "unit": unit, "identifiable": share <= OPEN}
            for name, value, std, unit, share in rows
        },
        "not_identifiable": list(fit.identifiability.sentences),
        "corrections": {} if fit.lost else settled.corrections,
        "frames": [
            {
                "frame": int(number),
                "time": pose.time,
                "T_camera_hand": pose.pose.tolist(),
                "covariance": pose.covariance.tolist(),
                "matched": pose.matched,
                "lost": pose.lost,
            }
            for number, pose in zip(numbers, poses, strict=True)
        ],
    }


def describe(answer: Mapping[str, Any], out: Path, reported: bool) -> str:
    """The answer in words.

    Args:
        answer: see `track_json`, and "frames_per_second" at which moments were looked at.
        out: the folder that holds it.
        reported: whether there is a report.html.
    """
    head = "The body was not found in the pictures." if answer["lost"] else "Found:"
    lines = [head]
    for name, found in answer["parameters"].items():
        scale, unit = read_as(found["unit"])
        value, std = with_error(scale * found["value"], scale * found["std"])
        said = f"{value:>9} ± {std} {unit}" if found["identifiable"] else "not told"
        lines.append(f"  {name:<28}{said:>9}")
    lines += [f"Not told: {sentence}" for sentence in answer["not_identifiable"]]
    frames = answer["frames"]
    gone = sum(frame["lost"] for frame in frames)
    lines.append(
        f"{100 * answer['matched']:.0f} % of the contour fits; the hand is lost in {gone} of "
        f"{len(frames)} rows; {answer['frames_per_second']:.1f} rows a second."
    )
    if gone == len(frames) and not answer["lost"]:
        lines.append("What carries the hand shows in no picture as modelled; is something on it?")
    if reported:
        lines.append(f"Report:          {out / 'report.html'}")
    if answer["lost"]:
        lines.append("Nothing was corrected. Next: look at the overlays; check lens, camera and")
        lines.append("meshes, or free more.")
    else:
        lines.append(f"Corrected robot: {out / 'robot.urdf'}   all numbers: {out / 'track.json'}")
        lines.append("Next: look at the overlays; green should lie on the robot.")
    return "\n".join(lines)
