"""A load in plain values: for answers, documents and the forms of robot controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.loads import (
    SIX,
    com_covariance,
    free_loads,
    load_of,
    moments_covariance,
)
from bodyschema.learners.payload.untold import Untold, untold
from bodyschema.model.inertia import PHI, Inertia

Array = NDArray[np.float64]


def load_entry(
    name: str, load: Inertia, P: Array, open_: Sequence[Untold] | None = None
) -> dict[str, Any]:
    """A load with its standard deviations: kg, m, kg m^2 about its centre, in its own frame.

    Args:
        name: of the load.
        load: what is believed.
        P: (10, 10) covariance of its parameters phi.
        open_: what is not told of it; by P alone when None.
    """
    left = untold(load, P) if open_ is None else open_
    moments = np.sqrt(np.diag(moments_covariance(load, P)))
    return {
        "name": name,
        "mass": load.mass,
        "mass_std": float(np.sqrt(P[0, 0])),
        "com": load.com.tolist(),
        "com_std": np.sqrt(np.diag(com_covariance(load, P))).tolist(),
        "inertia": load.moments.tolist(),
        "inertia_std": {
            f"I_{'xyz'[i]}{'xyz'[j]}": float(moments[k]) for k, (i, j) in enumerate(SIX)
        },
        "phi": dict(zip(PHI, load.phi.tolist(), strict=True)),
        "phi_covariance": P.tolist(),
        "physical": load.physical,
        "not_told": [{"what": one.what, "sentence": one.sentence} for one in left],
    }


def load_entries(estimate: Estimate) -> list[dict[str, Any]]:
    """The loads that an estimate holds."""
    return [load_entry(name, *load_of(estimate, name)) for name in free_loads(estimate)]


def load_lines(loads: Sequence[dict[str, Any]]) -> list[str]:
    """Loads in words, with what is not told of them."""
    return [line for load in loads for line in _lines(load)]


def _lines(load: dict[str, Any]) -> list[str]:
    com, com_std = np.array(load["com"]), np.array(load["com_std"])
    untold_things = {one["what"] for one in load["not_told"]}
    doubt = " (not told)" if "mass" in untold_things else ""
    lines = [f"{load['name']}: {load['mass']:.4f} ± {load['mass_std']:.4f} kg{doubt}"]
    if "mass" in untold_things:
        lines.append("  centre of mass  not told")
    else:
        doubt = ", not told in every direction" if "com" in untold_things else ""
        lines.append(f"  centre of mass  {vector(com, com_std, 1e3, 'mm')} (its frame{doubt})")
    moments = np.array(load["inertia"])
    for name, std in load["inertia_std"].items():
        i, j = ("xyz".index(c) for c in name[2:])
        told = f"{1e3 * moments[i, j]:+.3f} ± {1e3 * std:.3f} g m2"
        lines.append(f"  {name:<15} {'not told' if name in untold_things else told}")
    return lines


def vector(values: Array, std: Array, factor: float, unit: str) -> str:
    """ "(1.00 ± 0.02, ...) mm"."""
    shown = ", ".join(
        f"{factor * v:.2f} ± {factor * s:.2g}" for v, s in zip(values, std, strict=True)
    )
    return f"({shown}) {unit}"
