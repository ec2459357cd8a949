"""The parts of a body that may change on their own, and their parameters.

A part is the zero of a joint that moved in the recording, or a frame that hangs on a fixed joint: a
tracker, a camera, a tool.
"""

from __future__ import annotations

from collections.abc import Sequence

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import moved_joints
from bodyschema.model.kernels import FIXED
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.sense import Sense


def parts_of(estimate: Estimate, senses: Sequence[Sense]) -> tuple[Variables, dict[str, list[int]]]:
    """The estimate's parameters and those of every part; rows of each part."""
    body, known = estimate.reference, estimate.variables
    joints = moved_joints(body, senses)
    frames = sorted({frame for sense in senses for frame in (sense.seen_from, sense.seen)})
    extra = [free_joints(body, ("offsets",), joints)]
    for frame in frames:
        k = body.frame_index(frame)
        if k and body.kind[k] == FIXED:
            extra.append(free_frame(body, frame))
    more = join(*extra)
    new = [i for i, name in enumerate(more.names) if name not in known.names]
    variables = join(known, more.take(new))
    parts = {joint: [f"{joint}.offset"] for joint in joints}
    parts |= {frame: [n for n in more.names if n.startswith(f"{frame}.")] for frame in frames}
    rows = {
        part: [variables.names.index(name) for name in names]
        for part, names in parts.items()
        if names
    }
    return variables, rows
