"""What the motions of one method at one speed come to; a time that is never reached is None."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bodyschema.studies.study import Result


def shares(runs: Sequence[Result]) -> dict[str, Any]:
    """Medians of times and errors, and how much of what was stated held."""
    inside = [r["inside"] for r in runs]
    stated = inside[0] is not None
    hits = np.array(inside, dtype=float) if stated else np.full((1, 10), np.nan)
    return {
        "seconds_to_1pct_1mm": _times(runs),
        "reached": float(np.mean([r["seconds"] is not None for r in runs])),
        "mass_pct": float(np.median([r["mass_pct"] for r in runs])),
        "com_mm": float(np.median([r["com_mm"] for r in runs])),
        "inertia_pct": float(np.median([r["inertia_pct"] for r in runs])) if stated else None,
        "coverage": float(hits.mean()) if stated else None,
        "coverage_of": {
            "mass": float(hits[:, 0].mean()),
            "first_moments": float(hits[:, 1:4].mean()),
            "moments": float(hits[:, 4:].mean()),
        }
        if stated
        else None,
        "physical_share": float(np.mean([r["physical"] for r in runs])),
        "certified_s": late([r["certified"] for r in runs], 0.5),
        "readings": _readings([r["readings"] for r in runs if "readings" in r]),
    }


def late(times: Sequence[float | None], share: float) -> float | None:
    """A quantile of times of which some are never; None if it falls among these."""
    ordered = sorted(np.inf if time is None else time for time in times)
    found = ordered[min(len(ordered) - 1, max(0, int(np.ceil(share * len(ordered))) - 1))]
    return found if np.isfinite(found) else None


def seconds_text(time: float | None) -> str:
    """A time for a table."""
    return "never" if time is None else f"{time:.1f}"


def times_text(times: Mapping[str, float | None]) -> str:
    """Median and 90 % for a table."""
    if times["median"] is None:
        return seconds_text(None)
    return f"{seconds_text(times['median'])}/{seconds_text(times['p90'])}"


def shown(value: float | None, factor: float = 1.0) -> str:
    """A number for a table."""
    return "-" if value is None else f"{factor * value:.3g}"


def _times(runs: Sequence[Result]) -> dict[str, float | None]:
    seconds = [r["seconds"] for r in runs]
    return {"median": late(seconds, 0.5), "p90": late(seconds, 0.9)}


def _readings(runs: Sequence[Result]) -> Result:
    """Medians of each reading of the published form; nothing of ours, which has only one."""
    return {
        reading: {
            "seconds_to_1pct_1mm": _times([r[reading] for r in runs]),
            "mass_pct": float(np.median([r[reading]["mass_pct"] for r in runs])),
            "com_mm": float(np.median([r[reading]["com_mm"] for r in runs])),
        }
        for reading in (runs[0] if runs else ())
    }
