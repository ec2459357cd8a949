"""Numbers and pictures of watched hands, shared by the studies of Vicente et al. 2016."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri

from bodyschema.studies.study import Result
from bodyschema.studies.watched_hand import Trace

Array = NDArray[np.float64]

CURVES = ("estimation", "without", "reaching", "believed_reaching")
"""The errors of a trace, each (n_frames, 2) in mm and degrees."""


def stored(trace: Trace) -> Result:
    """A trace in JSON types."""
    curves: Result = {name: np.round(getattr(trace, name), 6).tolist() for name in CURVES}
    return curves | {"sizes": trace.sizes, "nees": trace.nees, "seconds": trace.seconds}


def curves(traces: Iterable[Mapping[str, Any]], name: str) -> Array:
    """One error of many movements, (n_movements, n_frames, 2)."""
    return np.array([trace[name] for trace in traces])


def mean_and_sd(values: ArrayLike) -> Result:
    """Of position and orientation over movements; values (n_movements, 2) mm and degrees."""
    v = np.asarray(values, dtype=np.float64)
    return {
        name: {"mean": float(v[:, i].mean()), "sd": float(v[:, i].std())}
        for i, name in enumerate(("position_mm", "orientation_deg"))
    }


def within_band(nees: ArrayLike) -> float:
    """Share of normalised squared errors of poses that lie in the central 95 % of chi-square."""
    low, high = chdtri(6, [0.975, 0.025])
    values = np.asarray(nees, dtype=np.float64)
    return float(np.mean((values > low) & (values < high)))


def text(found: Mapping[str, Any], unit: str) -> str:
    """Mean and standard deviation as a cell of a table; unit "mm" or "deg"."""
    value = found["position_mm" if unit == "mm" else "orientation_deg"]
    return f"{value['mean']:.2f} ± {value['sd']:.2f}"


def band(axes: Any, frames: ArrayLike, values: Array, label: str, colour: str, style: str) -> None:
    """Mean over movements and one standard deviation either way; values (n_movements, n_frames)."""
    mean, sd = values.mean(axis=0), values.std(axis=0)
    axes.plot(frames, mean, style, color=colour, label=label)
    axes.fill_between(frames, mean - sd, mean + sd, color=colour, alpha=0.15, linewidth=0)
