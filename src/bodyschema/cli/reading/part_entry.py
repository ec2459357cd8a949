"""One [parts.NAME] section of a run file: the keys of all kinds, each used by some of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from bodyschema.cli.entry_types import one_of
from bodyschema.cli.reading.run_entries import KNOWLEDGE


@dataclass(frozen=True)
class PartEntry:
    """A part of the model: a lens, a load, a sensor, a clock, a target, a drive, or constants."""

    kind: str
    """A key of `part_kinds.KINDS`."""
    known: str = "roughly"
    """"exactly", "roughly" or "no"; see `part_kinds`."""
    free: tuple[str, ...] = ()
    """Its numbers that may be wrong, or what their names begin with; see `part_kinds.freed`."""
    std: dict[str, float] = field(default_factory=dict)
    """Priors other than the usual, in SI, by names as in `free`."""
    fx: float | None = None
    """px; fy is fx when absent, cx and cy are the centre of the picture."""
    fy: float | None = None
    cx: float | None = None
    cy: float | None = None
    fov_deg: float | None = None
    """Instead of fx: angle of view from the left to the right edge."""
    distortion: tuple[float, ...] = ()
    """k1 k2 p1 p2 k3, of a rational lens k4 k5 k6 after them, of a fisheye k1 k2 k3 k4."""
    model: str = ""
    """Of the distortion: "plumb_bob", "rational" or "fisheye"; by the count of `distortion` when
    empty, which is never a fisheye."""
    file: str = ""
    """Of a lens: camera_info.yaml, a file of OpenCV or Kalibr, instead of its numbers."""
    size: tuple[int, ...] = ()
    """Width and height of the pictures, px."""
    mass_kg: float | None = None
    com_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Centre of mass in the load's frame."""
    moments_kgm2: tuple[float, ...] = ()
    """About the centre: xx, yy, zz, or xx, xy, yy, xz, yz, zz; a ball's of 5 cm when absent."""
    channels: str = "force"
    """"force" (six), "acceleration" (three) or "distance" (one)."""
    offset: tuple[float, ...] = ()
    """Of each channel, in its unit; 0 when absent."""
    gain: tuple[float, ...] = ()
    """Of each channel beyond 1; 0 when absent."""
    lag_ms: float = 0.0
    scale: float = 1.0
    values: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def check(self, where: str) -> None:
        """Refuse a word that means nothing. Raises InputError."""
        one_of("known", self.known, KNOWLEDGE, where)
