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
        from kinhec import benchmark
    except ImportError:
        sys.exit("this benchmark needs KinHEC: pip install kinhec")
    benchmark.SOLVERS["ours"] = ours
    benchmark.SOLVER_DOCS["ours"] = "bodyschema.solve_hand_eye"
    with tempfile.TemporaryDirectory() as out:
        folder = asked.folder or generated(Path(out))
        table = benchmark.run_benchmark(
            folder, out_dir=Path(out), tracks=asked.tracks, progress=not asked.json
        )
    answer = {track: summary(rows, str(track)) for track, rows in table.groupby("track")}
    if asked.json:
        print(json.dumps(answer))
        return
    for track, found in answer.items():
        print(f"{track}: {found}")


def generated(place: Path) -> Path:
    """The small tier, written into a folder of its own; takes minutes."""
    data = place / "small"
    words = ["generate", "--tier", "small", "--out", str(data), "--work-dir", str(place / "work")]
    subprocess.run([sys.executable, "-m", "kinhec", *words], check=True, stdout=sys.stderr)
    return data


def summary(rows: Any, track: str) -> dict[str, Any]:
    """One track's figures; clocks estimated where KinHEC's `mixed` track asks for it."""
    if track == "mixed":
        estimated = (rows["eval_sync"] == "estimated") | (rows["time_offset_s"] == 0)
        rows = rows[estimated]
    else:
        rows = rows[rows["eval_sync"] == "oracle"]
    error = rows.pivot_table(index="sequence_id", columns="solver", values="X_trans_err_mm")
    ours = rows[rows["solver"] == "ours"].set_index("sequence_id")
    wrong, flagged = ours["X_trans_err_mm"] > LARGE, ours["n_inliers"] > 0
    unflagged = ours["X_trans_err_mm"][~flagged]
    peers = error.drop(columns="ours").median().sort_values()
    return {
        "sequences": len(ours),
        "median_mm": float(ours["X_trans_err_mm"].median()),
        "mean_mm": float(ours["X_trans_err_mm"].mean()),
        "best_peer": str(peers.index[0]),
        "best_peer_median_mm": float(peers.iloc[0]),
        "best_peer_mean_mm": float(error[peers.index[0]].mean()),
        "flagged": float(flagged.mean()),
        "false_flags": float((flagged & ~wrong).mean()),
        "worst_unflagged_mm": float(unflagged.max()) if len(unflagged) else None,
    }


if __name__ == "__main__":
    main()
