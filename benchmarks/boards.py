"""Boards in pictures: real sets against OpenCV's own chain, drawn ones against the truth.

    python benchmarks/boards.py [--pictures 10 20] [--seeds 3] [--data FOLDER] [--json]

Real sets: every fourth picture is held out. `rms_px` and `held_out_px` are of camera, board, lens
and joint zeros in one fit; `opencv_held_out_px` of calibrateCamera, a pose of each picture, and
hand-eye from these poses in closed form (OpenCV 5 has none of its own), which predict the corners
of the held-out pictures. Boards that look the same turned round are numbered for both by ours.
Corners more than 10 px off count for neither: rows 25 and 26 of ur3e have each other's joints.

Drawn sets (`board_folder`: OpenCV draws, zeros wrong by 2 deg, lens unknown): errors of the camera
in the board over the held-out postures of another seed, against `bound_mm`, what the Cramer-Rao
bound says of the same with the noise found; `coverage` is the share of zeros within 95 % bars.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import cv2
import numpy as np
from numpy.typing import NDArray

from board_folder import write_board_folder
from bodyschema import lie
from bodyschema.cli.loading import Loaded, load
from bodyschema.cli.run_file import run_from_table
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.parts import lens as lens_part
from bodyschema.seeds.closed_forms import solve_ky_xt
from bodyschema.senses.pixels import Pixels
from bodyschema.simulation.wrist_camera import WristCamera, simulate_wrist_camera, with_camera

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


def rms(residual: Array) -> float:
    """Of both coordinates, px, without gross ones."""
    near = np.linalg.norm(residual, axis=1) < GROSS
    return float(np.sqrt(np.mean(residual[near] ** 2)))


def opencv_chain(loaded: Loaded, train: Pixels, test: Pixels, size: tuple[int, int]) -> float:
    """Held-out error of calibrateCamera, poses, and hand-eye in closed form, px rms."""
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
    return rms(test.residual(body.with_part(train.lens, lens)))


def real_set(table: dict[str, Any], here: Path, joints: tuple[str, ...]) -> dict[str, Any]:
    """The figures of one real set."""
    run = run_from_table(table, here, "the benchmark")
    loaded = load(run)
    (sense,) = loaded.senses
    assert isinstance(sense, Pixels)
    rows = np.unique(sense.rows)
    held = rows[HELD - 1 :: HELD]
    train, test = of_rows(sense, np.setdiff1d(rows, held)), of_rows(sense, held)
    found = fitted(loaded, (train,), joints)
    size = run.parts[sense.lens].size
    return {
        "pictures": len(rows),
        "used": len(np.unique(train.rows)),
        "rms_px": round(rms(train.residual(found.body)), 3),
        "held_out_px": round(rms(test.residual(found.body)), 3),
        "opencv_held_out_px": round(opencv_chain(loaded, train, test, (size[0], size[1])), 3),
    }


def entry(target: dict[str, Any], images: Path, **more: Any) -> dict[str, Any]:
    """A sense of a board."""
    ends = {"kind": "board", "seen_from": "camera", "seen": "board", "lens": "lens"}
    return {**ends, "images": str(images), "target": target, **more}


def unknown(camera: str, board: str, size: list[int]) -> dict[str, Any]:
    """Frames and lens of which nothing is known."""
    return {
        "frames": {
            "camera": {"parent": camera, "known": "no"},
            "board": {"parent": board, "known": "no"},
        },
        "parts": {"lens": {"kind": "lens", "known": "no", "size": size}},
    }


def real_sets(data: Path, panda: Path) -> dict[str, Any]:
    """The sets that are there."""
    found = {}
    franka, ur = data / "franka_handeye_charuco", data / "ur3e_fixed_cameras"
    if franka.is_dir() and panda.is_file():
        target = {"kind": "charuco", "columns": 5, "rows": 7, "square_m": 0.034,
                  "marker_m": 0.028, "dictionary": "6X6_250"}  # fmt: skip
        table = unknown("panda_link8", "panda_link0", [1280, 720])
        table |= {"robot": str(panda), "recording": "recording.csv"}
        table["senses"] = [entry(target, franka / "images/{row:03}.jpg")]
        joints = tuple(f"panda_joint{k}" for k in range(2, 7))
        found[franka.name] = real_set(table, franka, joints)
    if ur.is_dir():
        names = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
        joints = tuple(f"{name}_joint" for name in names)
        target = {"kind": "chessboard", "columns": 9, "rows": 7, "square_m": 0.02}
        for camera in ("cam1", "cam2"):
            table = unknown("base", "flange", [1280, 720])
            table |= {"robot": "ur3e_dh.toml", "recording": "recording.csv"}
            table["joints"] = {"unit": "deg", "columns": {j: f"{j}_deg" for j in joints}}
            images = ur / f"images/{camera}_{{row:02}}.jpg"
            table["senses"] = [entry(target, images, columns=["row"])]
            found[f"{ur.name} {camera}"] = real_set(table, ur, joints[1:-1])
    return found


def drawn_set(pictures: int, seeds: int) -> dict[str, Any]:
    """Drawn boards of known truth."""
    off, bound, turned, inside = [], [], [], []
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            truth = write_board_folder(folder, pictures, seed)
            loaded = load(bs_run(folder))
        (sense,) = loaded.senses
        joints = loaded.nominal.joints[1:-1]
        found = fitted(loaded, (sense,), joints)
        fresh = simulate_wrist_camera(WristCamera(40, 100 + seed, 2.0, noise_mm=0, noise_deg=0))
        q = fresh.postures.q
        true = with_camera(fresh.believed.with_variables(zeros(fresh.believed), truth.offsets))
        true = true.with_placement("board", truth.T_link_board)
        seen = relative_pose(true, q, "board", "camera")
        error = lie.inverse(seen) @ relative_pose(found.body, q, "board", "camera")
        off.append(np.sqrt(np.mean(np.sum(error[:, :3, 3] ** 2, axis=1))))
        turned.append(np.sqrt(np.mean(np.sum(lie.log_so3(error[:, :3, :3]) ** 2, axis=1))))
        bound.append(stated(found, q))
        std = np.sqrt(np.diag(found.covariance))
        for k, name in enumerate(found.variables.names):
            if name.endswith(".offset"):
                wrong = found.x[k] - truth.offsets[loaded.body.joints.index(name[:-7])]
                inside.append(abs(wrong) < 1.96 * std[k])
    return {
        "camera_mm": round(1e3 * float(np.median(off)), 3),
        "camera_deg": round(float(np.degrees(np.median(turned))), 4),
        "bound_mm": round(1e3 * float(np.median(bound)), 3),
        "coverage": round(float(np.mean(inside)), 3),
    }


def bs_run(folder: Path) -> Any:
    """The run file of a folder."""
    from bodyschema.cli.run_file import read_run_file

    return read_run_file(folder / "run.toml")


def zeros(body: bs.Body) -> Any:
    """The zeros of all joints as variables."""
    return bs.free_joints(body, OFFSETS, body.joints)


def stated(found: Estimate, q: Array, draws: int = 60) -> float:
    """rms error of the camera in the board that the covariance states, m, by draws from it."""
    rng = np.random.default_rng(0)
    here = relative_pose(found.body, q, "board", "camera")[:, :3, 3]
    squares = []
    for x in rng.multivariate_normal(found.x, found.covariance, draws, check_valid="ignore"):
        body = found.reference.with_variables(found.variables, x)
        there = relative_pose(body, q, "board", "camera")[:, :3, 3]
        squares.append(np.mean(np.sum((there - here) ** 2, axis=1)))
    return float(np.sqrt(np.mean(squares)))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=int, nargs="*", default=[10, 20])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--panda", type=Path, default=Path("panda.urdf"))
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = real_sets(asked.data.resolve(), asked.panda.resolve())
    found |= {f"drawn {n}": drawn_set(n, asked.seeds) for n in asked.pictures}
    if asked.json:
        print(json.dumps(found))
        return
    for name, figures in found.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in figures.items()))


if __name__ == "__main__":
    main()
