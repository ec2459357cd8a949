"""Boards in pictures: real sets against OpenCV's own chain, rendered ones against the truth.

    python benchmarks/boards.py [--pictures 10 20 40] [--seeds 8] [--data FOLDER] [--json]

Real sets: every fourth picture is held out. `rms_px` and `held_out_px` are of camera, board, lens
and joint zeros in one fit; `opencv_held_out_px` of calibrateCamera, a pose of each picture, and
hand-eye from these poses in closed form (OpenCV 5 has none of its own), which predict the corners
of the held-out pictures. Boards that look the same turned round are numbered for both by ours.
Corners more than 10 px off count for neither: rows 25 and 26 of ur3e have each other's joints.
`held_out_mm` is how far the camera of a held-out picture, by its corners alone and the chain's own
lens, is from where the chain predicts it. `camera_mm`, `board_mm` are places in the frames that
carry them by all pictures, with 95 % bars, `board_size_percent` is how much larger the board is
than declared. The lens is told only where it says "lens stated"; of "spoiled" a tenth is smeared
and another tenth of another camera, none of those held out.

Rendered sets (`rendered_board`: MuJoCo draws; zeros wrong by 1 to 2 deg, lens unknown): errors of
the camera in the board over fresh postures and of the zeros, against `bound_mm`, what the
Cramer-Rao bound says of the same with corners as noisy as detected (`corner_px`); `coverage` is the
share of zeros and places within their 95 % bars.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import cv2
import numpy as np
from numpy.typing import NDArray

from board_sets import real_sets
from board_truth import figures
from bodyschema import lie
from bodyschema.cli.loading import Loaded, load
from bodyschema.cli.run_file import run_from_table
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import straight_rays
from bodyschema.model.parts import lens as lens_part
from bodyschema.seeds.closed_forms import solve_ky_xt
from bodyschema.seeds.pixel_poses import pose_of_points
from bodyschema.senses.pixels import Pixels

Array = NDArray[np.float64]

GROSS = 10.0
"""px: farther off is another row's picture, for either chain."""

HELD = 4
"""Every how many-th picture is held out."""

OFFSETS = ("offsets",)


def fitted(loaded: Loaded, senses: tuple[Any, ...], joints: tuple[str, ...]) -> Estimate:
    """Everything in one fit."""
    problem = Problem(loaded.body, senses, loaded.frames, joints, parts=loaded.parts)
    return problem.fit(problem.variables(OFFSETS), senses)


def of_rows(sense: Pixels, rows: Array) -> Pixels:
    """The corners of some pictures."""
    return sense.take(np.flatnonzero(np.isin(sense.rows, rows)))


def rms(residual: Array) -> float | None:
    """Of both coordinates, px, without gross ones; None where there are no others."""
    near = np.linalg.norm(residual, axis=1) < GROSS
    return round(float(np.sqrt(np.mean(residual[near] ** 2))), 3) if near.any() else None


def apart_mm(body: bs.Body, test: Pixels) -> float:
    """Median distance of a picture's camera, by its corners alone, from where it is predicted."""
    off = []
    for row in np.unique(test.rows):
        mine = test.take(np.flatnonzero(test.rows == row))
        T = pose_of_points(mine.points(body), straight_rays(mine.lens_of(body), mine.observed))
        if T is not None:
            told = relative_pose(body, mine.q[:1], mine.seen, mine.seen_from)[0, :3, 3]
            off.append(np.linalg.norm(lie.inverse(T)[:3, 3] - told))
    return round(1e3 * float(np.median(off)), 2)


def place_mm(found: Estimate, frame: str) -> dict[str, list[float]]:
    """A frame in the one that carries it, and its 95 % bars, mm."""
    body = found.body
    at = body.placement[body.frame_index(frame)][:3, 3]
    std = np.sqrt(np.diag(found.covariance))
    names = list(found.variables.names)
    bars = [1.96 * std[names.index(f"{frame}.link_{axis}")] for axis in "xyz"]
    return {
        f"{frame}_mm": np.round(1e3 * at, 1).tolist(),
        f"{frame}_95_mm": np.round(1e3 * np.array(bars), 1).tolist(),
    }


def size_percent(found: Estimate) -> dict[str, float]:
    """How much larger the board is than declared, and its 95 % bar."""
    name = "size_of_board.scale"
    k = list(found.variables.names).index(name)
    return {
        "board_size_percent": round(100 * float(found.x[k]), 2),
        "board_size_95_percent": round(196 * float(np.sqrt(found.covariance[k, k])), 2),
    }


def opencv_chain(loaded: Loaded, train: Pixels, size: tuple[int, int]) -> bs.Body:
    """The body as calibrateCamera, poses, and hand-eye in closed form have it."""
    rows = np.unique(train.rows)
    places: Any = [train.target[train.rows == r].astype(np.float32)[:, None] for r in rows]
    seen: Any = [train.observed[train.rows == r].astype(np.float32)[:, None] for r in rows]
    empty: Any = None
    _, matrix, bent, turns, moves = cv2.calibrateCamera(places, seen, size, empty, empty)
    T = np.array(
        [
            lie.transform(lie.exp_so3(np.ravel(w)), np.ravel(t))
            for w, t in zip(turns, moves, strict=True)
        ]
    )
    q = np.array([train.q[train.rows == r][0] for r in rows])
    body = loaded.body
    ends = [body.frames[body.parent[body.frame_index(f)]] for f in (train.seen_from, train.seen)]
    X, Y = solve_ky_xt(relative_pose(body, q, *ends), T, np.ones(len(q)))
    body = body.with_placement(train.seen_from, X).with_placement(train.seen, Y)
    camera = Camera("lens", "lens", *size, matrix, np.ravel(bent)[:5])
    lens = replace(body.part(train.lens), values=lens_part(camera).values)
    return body.with_part(train.lens, lens)


def real_set(table: dict[str, Any], here: Path, joints: tuple[str, ...]) -> dict[str, Any]:
    """The figures of one real set."""
    run = run_from_table(table, here, "the benchmark")
    loaded = load(run)
    (sense,) = loaded.senses
    assert isinstance(sense, Pixels)
    rows = np.unique(sense.rows)
    held = rows[rows % HELD == HELD - 1]
    train, test = of_rows(sense, np.setdiff1d(rows, held)), of_rows(sense, held)
    found = fitted(loaded, (train,), joints)
    size = run.parts[sense.lens].size
    whole = fitted(loaded, (sense,), joints)
    theirs = opencv_chain(loaded, train, (size[0], size[1]))
    return {
        "pictures": len(rows),
        "used": len(np.unique(train.rows)),
        "rms_px": rms(train.residual(found.body)),
        "held_out_px": rms(test.residual(found.body)),
        "opencv_held_out_px": rms(test.residual(theirs)),
        "held_out_mm": apart_mm(found.body, test),
        "opencv_held_out_mm": apart_mm(theirs, test),
        **place_mm(whole, "camera"),
        **place_mm(whole, "board"),
        **size_percent(whole),
    }


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=int, nargs="*", default=[10, 20, 40])
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--panda", type=Path, default=Path("panda.urdf"))
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = {}
    for name, table, here, joints in real_sets(asked.data.resolve(), asked.panda.resolve()):
        found[name] = real_set(table, here, joints)
    for which in ("hand", "fixed", "both") if asked.pictures else ():
        for n in asked.pictures if which != "both" else asked.pictures[:1]:
            found[f"rendered {which} {n}"] = figures(which, n, asked.seeds)
    if asked.json:
        print(json.dumps(found))
        return
    for name, row in found.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in row.items()))


if __name__ == "__main__":
    main()
