"""Hand-eye calibration on the tracks of KinHEC, by its own protocol, beside its own solvers.

    pip install kinhec "opencv-python-headless<5"
    kinhec generate --tier small --out kinhec_small          (minutes)
    python benchmarks/kinhec_tracks.py kinhec_small --json

Without a folder the small tier is generated first, and not kept.

Per track: median and mean of the translation error of X in mm for ours and for the best of KinHEC's
solvers (the one with the smallest median there), the share of sequences that we flag as not
determined, false flags (flagged, but within 50 mm) and the worst error that was not flagged.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs

LARGE = 50.0
"""mm: an error that must not go without a warning."""


def ours(data: Any, _: np.random.Generator) -> dict[str, Any]:
    """Our solver in the form that KinHEC calls; the column of inliers carries our flag."""
    answer = bs.solve_hand_eye(data[0], data[1], eye_on="base")
    return {"X": answer.X, "Y": answer.Y, "n_inliers": int(not answer.determined)}


def main() -> None:
    """Run the benchmark and print it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="what 'kinhec generate' wrote")
    parser.add_argument("--tracks", nargs="*", help="all when absent")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    try:
        import kinhec  # noqa: F401
    except ImportError:
        sys.exit("this benchmark needs KinHEC: pip install kinhec")
    with tempfile.TemporaryDirectory() as out:
        folder = asked.folder or generated(Path(out))
        table = solved(folder, Path(out), asked.tracks, progress=not asked.json)
    answer = {track: summary(rows, str(track)) for track, rows in table.groupby("track")}
    if asked.json:
        print(json.dumps(answer))
        return
    for track, found in answer.items():
        print(f"{track}: {found}")


def solved(
    folder: Path,
    out: Path,
    tracks: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
    progress: bool = True,
) -> Any:
    """KinHEC's table of errors, a row a sequence and solver; all of both when None."""
    from kinhec import benchmark

    benchmark.SOLVERS["ours"] = ours
    benchmark.SOLVER_DOCS["ours"] = "bodyschema.solve_hand_eye"
    return benchmark.run_benchmark(
        folder, out_dir=out, tracks=tracks, solver_names=solvers, progress=progress
    )


def generated(place: Path, tier: str = "small", tracks: Sequence[str] = ()) -> Path:
    """A tier, written into a folder of its own; the small one takes minutes."""
    data = place / "data"
    words = ["generate", "--tier", tier, "--out", str(data), "--work-dir", str(place / "work")]
    words += ["--tracks", *tracks] if tracks else []
    subprocess.run([sys.executable, "-m", "kinhec", *words], check=True, stdout=sys.stderr)
    return data


def judged(rows: Any, track: str) -> Any:
    """The rows of a track that count: clocks estimated where the `mixed` track asks for it."""
    if track == "mixed":
        return rows[(rows["eval_sync"] == "estimated") | (rows["time_offset_s"] == 0)]
    return rows[rows["eval_sync"] == "oracle"]


def summary(rows: Any, track: str) -> dict[str, Any]:
    """One track's figures, ours beside the best peer's."""
    rows = judged(rows, track)
    error = rows.pivot_table(index="sequence_id", columns="solver", values="X_trans_err_mm")
    peers = error.drop(columns="ours").median().sort_values()
    return own(rows) | {
        "best_peer": str(peers.index[0]),
        "best_peer_median_mm": float(peers.iloc[0]),
        "best_peer_mean_mm": float(error[peers.index[0]].mean()),
    }


def own(rows: Any) -> dict[str, Any]:
    """Our errors, and what we flag."""
    ours = rows[rows["solver"] == "ours"].set_index("sequence_id")
    wrong, flagged = ours["X_trans_err_mm"] > LARGE, ours["n_inliers"] > 0
    unflagged = ours["X_trans_err_mm"][~flagged]
    return {
        "sequences": len(ours),
        "median_mm": float(ours["X_trans_err_mm"].median()),
        "mean_mm": float(ours["X_trans_err_mm"].mean()),
        "flagged": float(flagged.mean()),
        "false_flags": float((flagged & ~wrong).mean()),
        "worst_unflagged_mm": float(unflagged.max()) if len(unflagged) else None,
    }


if __name__ == "__main__":
    main()
