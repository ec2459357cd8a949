"""Boards that are not as large as declared: printers scale, and rulers are read wrongly."""

from __future__ import annotations

import numpy as np

from bodyschema.judging.calibration import Calibration

TOLD, LEAST = 4.0, 0.01
"""Standard deviations, and share of the declared size, that a board has to differ by to be named:
a per cent is what paper does on its own and what the fit takes care of."""


def wrong_sizes(found: Calibration) -> tuple[str, ...]:
    """A sentence for every target whose size was found to be wrong."""
    fit = found.fit
    std = np.sqrt(np.diag(fit.covariance))
    names = list(fit.variables.names)
    said = []
    for name, part in fit.body.parts.items():
        if part.kind != "target" or f"{name}.scale" not in names:
            continue
        scale, error = part["scale"], float(std[names.index(f"{name}.scale")])
        declared = fit.reference.part(name)["scale"]
        off = scale / declared - 1
        if abs(off) > max(LEAST, TOLD * error):
            which = "larger" if off > 0 else "smaller"
            said.append(
                f"The target of '{name}' is {100 * abs(off):.1f} % {which} than declared (± "
                f"{100 * error:.1f}), as the robot's own lengths tell: measure it, and multiply "
                f"its declared lengths (square_m, marker_m) by {scale / declared:.4f}."
            )
    return tuple(said)
