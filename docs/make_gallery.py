"""Make the pictures of the gallery: results of simulated robots, opened in headless Chromium.

    python docs/make_gallery.py [WORK]

WORK keeps the results (build/gallery by default). It takes half a minute of computing, needs the
extras `sim` and `mesh` and a Chromium, and gives the same pictures again but for the fonts of the
machine.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import icub_models
import numpy as np
from PIL import Image

from bodyschema import lie
from bodyschema.cli import run
from bodyschema.simulation.contacts import draw_contact
from bodyschema.studies.touch_runs import draw_wrist

PICTURES = Path(__file__).parent / "_static" / "gallery"
COLOURS = 192
"""Of a picture; the files stay below 150 kB."""
NIGHT = "--blink-settings=preferredColorScheme=0"
HAND_EYE = """
recording = "log.csv"
time = ""
[hand_eye]
eye_on = "base"
[[senses]]
kind = "poses"
seen_from = "base"
seen = "flange"
columns = ["A*"]
layout = "xyz_xyzw"
[[senses]]
kind = "poses"
seen_from = "camera"
seen = "board"
columns = ["T*"]
layout = "xyz_xyzw"
"""
TOUCH = """
recording = "log.csv"
[wrench]
columns = ["fx", "fy", "fz", "mx", "my", "mz"]
frame = "sensor"
sign = "on_object"
[pose]
columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
[surface]
box = [0.10, 0.12, 0.18]
xyz = [0.0161846, -0.0214352, 0.0923942]
[touch]
quiet = [0.0, 15.0]
"""


def main(work: Path) -> None:
    """Make results, pages and pictures."""
    shutil.rmtree(work, ignore_errors=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    robot = work / "robot"
    verb("simulate", "--out", robot, "--seed", "0")
    verb("calibrate", robot / "run.toml", "--out", work / "calibrated")
    page = work / "calibrated" / "report.html"
    shoot(page, "report_day", 1200, 900)
    shoot(page, "report_night", 1200, 900, NIGHT)
    shoot(page, "report_phone", 500, 900)
    meshes = Path(icub_models.get_models_path()).parent
    space(work / "calibrated", "view_day", "--package", f"iCub={meshes}")
    shoot(work / "view_day.html", "view_night", 1200, 800, NIGHT)
    verb("hand-eye", hand_eye_run(work / "hand_eye"), "--out", work / "placed")
    space(work / "placed", "view_hand_eye")
    verb("touch", touch_run(work / "touch"), "--out", work / "touched")
    space(work / "touched", "view_touch")


def hand_eye_run(folder: Path) -> Path:
    """A camera beside a robot that sees a board on its hand, with errors of 0.5 mm and 0.06 deg."""
    rng = np.random.default_rng(5)
    A = np.array([pose(rng, 0.4) for _ in range(25)])
    X, Y = pose(rng, 0.1), pose(rng, 1.0)
    noise = lie.exp_so3(1e-3 * rng.normal(size=(25, 3))), 5e-4 * rng.normal(size=(25, 3))
    T = lie.inverse(Y) @ A @ X @ lie.transform(*noise)
    both = [np.hstack([P[:, :3, 3], lie.quaternion_xyzw(P[:, :3, :3])]) for P in (A, T)]
    names = ",".join(f"{name}{k}" for name in "AT" for k in range(7))
    return recorded(folder, np.hstack(both), names, HAND_EYE)


def pose(rng: np.random.Generator, size: float) -> np.ndarray:
    """Turned anyhow, so far away in each direction; (4, 4)."""
    return lie.transform(lie.exp_so3(rng.normal(size=3)), size * rng.normal(size=3))


def touch_run(folder: Path) -> Path:
    """A box that is waved about and pushed with 2 N after 16 s."""
    rng = np.random.default_rng(1)
    wrist = draw_wrist("box", "identified", 0.5, rng)
    samples = wrist.move(18.0, rng, [draw_contact(wrist.held.solid, 2.0, "point", 16.0, rng)])
    turn = lie.quaternion_xyzw(samples.rotation)
    table = np.column_stack([samples.time, samples.wrench, samples.position, turn])
    return recorded(folder, table, "t,fx,fy,fz,mx,my,mz,x,y,z,qx,qy,qz,qw", TOUCH)


def recorded(folder: Path, table: np.ndarray, names: str, text: str) -> Path:
    """A recording and its run file."""
    folder.mkdir(parents=True)
    np.savetxt(folder / "log.csv", table, delimiter=",", header=names, comments="", fmt="%.12g")
    (folder / "run.toml").write_text(text)
    return folder / "run.toml"


def verb(*words: object) -> None:
    """Run a verb of the command line."""
    if run([str(word) for word in words]) != 0:
        raise SystemExit(f"bodyschema {' '.join(map(str, words))} failed")


def space(result: Path, name: str, *flags: object) -> None:
    """The page in space of a result, and its picture."""
    page = result.parent / f"{name}.html"
    verb("view", result, "--html", page, *flags)
    shoot(page, name, 1200, 800)


def shoot(page: Path, name: str, width: int, height: int, *flags: str) -> None:
    """A picture of a page in few colours."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome") or "chrome"
    picture = PICTURES / f"{name}.png"
    subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--hide-scrollbars", *flags,
         f"--window-size={width},{height}", "--virtual-time-budget=20000",
         f"--screenshot={picture}", page.resolve().as_uri()],
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    with Image.open(picture) as shot:
        shot.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)
    print(f"{picture.name}: {picture.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/gallery"))
