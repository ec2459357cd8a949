"""One [[senses]] entry of a run file: the keys of all kinds, each used by some of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class SenseEntry:
    """What one sense is read from. Columns are in their units; all else is in SI, `std` apart."""

    kind: str
    """A key of `sense_kinds.KINDS`."""
    seen_from: str
    seen: str = ""
    columns: tuple[str, ...] = ()
    unit: str = ""
    """Of lengths, or of accelerations; m and m/s^2 when empty."""
    recording: tuple[str, ...] = ()
    """Files of its own; those of the run when empty."""
    where: str = ""
    """Rows of a long table that are meant, "marker == 3"; all when empty."""
    time: str | None = None
    """Column of times of its own recording; see the run file."""
    std: float | tuple[float, ...] | None = None
    """Noise of every number, or of each measure, in the units of the columns."""
    stated: bool = False
    """The noise is known: what exceeds it is error of the model."""
    clock: str = ""
    """Part "clock": how late the stream is."""
    speeds: str = ""
    """Columns of the speeds of the joints, such as "d_{joint}", in the joints' unit per second."""
    layout: str = "matrix3x4"
    """Of poses; see `layouts.LAYOUTS`."""
    angle_unit: str = ""
    """Of the angles of poses, and of their noise; rad when empty."""
    inverse: bool = False
    """The columns hold T_seen_seen_from."""
    touching: tuple[float, ...] = ()
    """m, the point of `seen` that touches each time."""
    lens: str = ""
    """Part "lens" of the camera `seen_from`."""
    target: tuple[tuple[float, ...], ...] | dict[str, Any] = ()
    """Of pixels: the points of `seen`, m, two columns each; of a board: keys of `Target`."""
    scale: str = ""
    """Part "target"."""
    masks: str = ""
    """Pictures that are not 0 on the robot, with {row} in their names."""
    images: str = ""
    """Pictures as they are, likewise."""
    links: tuple[str, ...] = ()
    """Links whose outline is used; all that have a shape when empty."""
    faces: int = 600
    """Of each link's mesh; 0 for all."""
    spacing: int = 4
    """Rows and columns between the points of an outline."""
    reach: float = 40.0
    """px to either side of the imagined outline that the real one is looked for at first."""
    darker: bool | None = None
    """In images: whether the body is darker than what is behind it."""
    edge: str = ""
    """Part "edge": how far out outlines lie all round."""
    distance: float | None = None
    """m, where no column holds it: two balls that touch."""
    anchor: tuple[float, ...] = ()
    """m, the point of `seen_from`."""
    end: tuple[float, ...] = ()
    """m, the point of `seen`."""
    height: float = 0.0
    """m above the plane, where no column holds it: a ball's radius."""
    point: tuple[float, ...] = ()
    """m, the point of `seen`."""
    sensor: str = ""
    """Part "sensor"."""
    loads: tuple[str, ...] | dict[str, str] = ()
    """Parts "load": those on the wrist, or of each link by its name."""
    sign: str = ""
    """"on_sensor", the load's pull; "on_object", the push on the load."""
    force_unit: str = "N"
    torque_unit: str = "Nm"
    per_ampere: tuple[float, ...] = ()
    """Nm that each motor exerts per ampere at its joint; the columns hold currents then."""
    drive: str = ""
    """Part "drive"."""
    motors: tuple[tuple[float, ...], ...] = ()
    """Joints that each motor turns, a row each; its own when empty."""
    gravity: float = 9.81
    """m/s^2"""
    moving: bool = False
    """Readings are of a motion, whose speeds and accelerations count."""
    accelerations: str = ""
    """Columns of the accelerations of the joints, as `speeds`."""
