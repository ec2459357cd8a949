"""A simulated iCub with a wrong right arm and eye becomes right, from its recording alone.

    make demo        or        .venv/bin/python examples/demo.py

Everything goes into the folder demo/: the recording, the corrected URDF, and a picture.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import yaml

from bodyschema import Body, lie
from bodyschema.cli import run
from bodyschema.simulation.icub import nominal_icub
from bodyschema.simulation.picture import draw_before_after
from bodyschema.simulation.scoring import describe_errors, hand_error, load_truth

FOLDER = Path("demo")


def corrected_robot(result: Path) -> Body:
    """The robot that the result folder describes, read back as anyone would read it."""
    body = Body.from_urdf(result / "robot.urdf")
    for frame in yaml.safe_load((result / "transforms.yaml").read_text())["transforms"]:
        T = lie.transform(lie.rotation_from_rpy(frame["rpy"]), frame["xyz"])
        body = body.attach(frame["child"], frame["parent"], T)
    return body


def main() -> int:
    """Simulate, calibrate, compare with the truth, draw."""
    begin = time.perf_counter()
    simulated, result = FOLDER / "simulated", FOLDER / "calibrated"
    print("1. An iCub whose right arm and eye are not where its model says moves before its eyes.")
    code = run(["simulate", "--out", str(simulated), "--overwrite"])
    print("\n2. It is calibrated from that recording alone; truth.json stays closed.")
    code = code or run(
        ["calibrate", str(simulated / "run.toml"), "--out", str(result), "--overwrite"]
    )
    if code:
        return code
    print("\n3. The corrected URDF against the truth, on 200 postures that nobody has seen:")
    truth = load_truth(simulated)
    before, after = nominal_icub(), corrected_robot(result)
    print(describe_errors(hand_error(before, truth), hand_error(after, truth)))
    picture = draw_before_after(before, after, truth, FOLDER / "before_after.png")
    print(f"corrected URDF:    {result / 'robot.urdf'}")
    print(f"before and after:  {picture}")
    print(f"{time.perf_counter() - begin:.0f} s in all. Next: your own robot, see README.md.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
