"""Scene: everything that a page draws of a result, in plain arrays and words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.static_transforms import estimated_frames
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.places import FramePlace, places
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Visual
from bodyschema.report.drawing import VISIBLE, exaggeration
from bodyschema.senses.sense import Sense
from bodyschema.units import significant
from bodyschema.view.ellipsoids import Ellipsoid, carried, looked_at, touched, uncertain_frames
from bodyschema.view.marks import Marks, marks_of
from bodyschema.view.postures import Moving, Recorded
from bodyschema.view.shapes import Shape, shapes_of

Array = NDArray[np.float64]

UNMOVED = 1e-7
"""m: a correction that moves nothing by more is none, and has no ghost."""
CERTAIN = 1e-9
"""m: a place that is surer than that was not free, and has no ellipsoid."""
GONE = (
    "What was recorded is not at hand, so one posture in the middle of the joints is shown, and "
    "nothing that was seen."
)


@dataclass(frozen=True)
class Placed:
    """A frame that was asked for, in words."""

    name: str
    parent: str
    place: str
    """mm, in the parent."""
    turn: str
    """deg, roll pitch yaw; "as given" where it was not estimated."""
    error: str
    """mm that its place is off by at most, with 95 %; as the report says it."""


@dataclass(frozen=True)
class Force:
    """A touch as an arrow."""

    name: str
    start: Array
    """(n, 3) m, in the root frame."""
    vector: Array
    """(n, 3) N."""


@dataclass(frozen=True)
class Scene:
    """One result in space."""

    title: str
    tone: str
    verdict: str
    explanation: str
    trust: tuple[str, ...]
    notes: tuple[str, ...]
    recorded: Recorded
    moving: Moving
    ghost: bool
    """Whether there is a "before" to draw."""
    shapes: tuple[Shape, ...]
    marks: tuple[Marks, ...]
    ellipsoids: tuple[Ellipsoid, ...]
    forces: tuple[Force, ...]
    placed: tuple[Placed, ...]
    words: tuple[str, str]
    """What "before" and "after" are."""
    named: tuple[str, ...]
    """Frames whose names and axes are drawn."""

    @property
    def size(self) -> float:
        """m: the largest side of what is drawn true to scale."""
        bare = [np.ptp(self._corners(e), axis=0).max() for e in self.ellipsoids if e.kind == "load"]
        return max(self.moving.size, *(float(size) for size in bare), 0.0)

    def is_wide(self, ellipsoid: Ellipsoid) -> bool:
        """Whether a place is so unsure that it shows by itself, and is drawn true to scale."""
        return ellipsoid.widest > VISIBLE * self.size

    @property
    def unsure(self) -> tuple[str, ...]:
        """Sentences on places that are hardly told."""
        return tuple(
            f"{e.name}: known to no better than ± {significant(1e3 * e.widest, 2)} mm in its worst "
            f"direction; {'drawn true to scale' if e.widest < self.size else 'too much to draw'}."
            for e in self.ellipsoids
            if e.kind == "uncertainty" and self.is_wide(e)
        )

    def _corners(self, ellipsoid: Ellipsoid) -> Array:
        """(8, 3) m: the ends of its axes in the first posture, its centre, and the root."""
        ends = ellipsoid.axes[0].T
        centre = ellipsoid.centre[0]
        return np.vstack([centre + ends, centre - ends, centre, np.zeros(3)])

    @property
    def factors(self) -> dict[str, int]:
        """How many times too large each kind of thing is drawn to begin with."""
        size = self.size
        arrows = [np.linalg.norm(m.arrows[1][~m.bad], axis=1) for m in self.marks if m.arrows]
        told = [
            e.widest for e in self.ellipsoids if e.kind == "uncertainty" and not self.is_wide(e)
        ]
        return {
            "correction": exaggeration(self.moving.shift[0], size),
            # There are hundreds of them: shorter than what stands alone.
            "arrows": exaggeration(
                float(np.median(np.concatenate(arrows))) if arrows else 0.0, size / 4
            ),
            "ellipsoids": exaggeration(max(told, default=size), size),
        }


def scene_of(
    calibration: Calibration,
    title: str,
    senses: Sequence[Sense] = (),
    visuals: Sequence[Visual] = (),
    notes: Sequence[str] = (),
    recorded: Recorded | None = None,
) -> Scene:
    """What there is to draw of an answer.

    Args:
        calibration: the answer of any verb.
        title: of the page.
        senses: what was seen; empty where the recording is gone.
        visuals: shapes of the robot description.
        notes: sentences on what is not at hand.
        recorded: postures; those of the senses when None.
    """
    c, body = calibration, calibration.body
    recorded = recorded or Recorded.by(senses, body, c.outliers)
    placed = estimated_frames(c.estimate.variables)
    asked, seen = places(c), looked_at(senses, body.frames)
    pairs = list(dict.fromkeys([*((place.parent, place.frame) for place in asked), *seen]))
    shapes, missing = shapes_of([v for v in visuals if v.frame in body.frames])
    named = list(dict.fromkeys(name for pair in pairs for name in reversed(pair)))
    wanted = {*named, *(shape.frame for shape in shapes), *_carriers(c)}
    moving = Moving.of(c.estimate, recorded.q, wanted, placed)
    uncertain = uncertain_frames(c.widened, recorded.q, pairs)
    loads, forces = _felt(c, recorded.q)
    return Scene(
        title,
        c.tone,
        c.verdict,
        c.explanation,
        c.trust.reasons,
        (
            *_untold(asked),
            *notes,
            *missing,
            *((GONE,) if recorded.rows[0] < 0 and body.joints else ()),
        ),
        recorded,
        moving,
        not c.from_nothing and c.corrects and moving.shift[0] > UNMOVED,
        shapes,
        marks_of(c, senses),
        (*(e for e in uncertain if e.widest > CERTAIN), *loads),
        forces,
        tuple(_placed(one) for place in asked for one in (place, place.told) if one),
        (c.before, c.after),
        tuple(named),
    )


def _untold(asked: Sequence[FramePlace]) -> list[str]:
    return [f"{p.frame} in {p.parent} is not determined: {p.untold}." for p in asked if p.untold]


def _placed(place: FramePlace) -> Placed:
    turn = ", ".join(f"{v:.3f}" for v in np.rad2deg(lie.rpy_from_rotation(place.T[:3, :3])))
    free = [math.isfinite(bound) for bound in (place.position_95, place.rotation_95)]
    return Placed(
        place.frame,
        place.parent,
        ", ".join(f"{1e3 * v:.2f}" for v in place.T[:3, 3]),
        turn if free[1] else "as given",
        significant(1e3 * place.position_95, 2) if free[0] else "as given",
    )


def _carriers(calibration: Calibration) -> list[str]:
    """Link and sensor that a load hangs on, of an answer on a wrist."""
    if "loads" not in calibration.details or "sensor" not in calibration.details:
        return []
    frames = calibration.body.frames
    link = calibration.details["sensor"]["link"]
    # The sensor is the frame that was attached last; a bare wrist is a flange of no robot.
    return [link if link in frames else frames[0], frames[-1]]


def _felt(calibration: Calibration, q: Array) -> tuple[list[Ellipsoid], tuple[Force, ...]]:
    """Loads and touches of an answer on a wrist."""
    carriers, body = _carriers(calibration), calibration.body
    if not carriers:
        return [], ()
    T_link, T_sensor = (relative_pose(body, q, body.frames[0], name) for name in carriers)
    details = calibration.details
    touches = details.get("touches") or []
    found = [e for load in details["loads"] for e in carried(load, T_link)]
    found += [e for touch in touches for e in touched(touch, T_sensor)]
    forces = []
    for touch in touches:
        point, force = np.array(touch["places"][0]["point"]), np.array(touch["force"])
        start = T_sensor[:, :3, :3] @ point + T_sensor[:, :3, 3]
        name = f"{np.linalg.norm(force):.2g} N at {touch['begins']:.2f} s"
        forces.append(Force(name, start, T_sensor[:, :3, :3] @ force))
    return found, tuple(forces)
