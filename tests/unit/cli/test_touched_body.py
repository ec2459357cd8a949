"""A recording of touches teaches two arms, in the dark: by the published gradient, and by the fit.

The arms of Fig. 7 of Hersch et al. 2008 (`studies.touching_arms`): both limbs feel where they are
touched within 10 cm of the hands' origins, to 1 mm; axes are known to 0.03 rad and links to 3 mm a
coordinate.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.studies.touching_arms import touches, two_arms

NOISE, AXIS, LINK_ERROR = 0.001, 0.03, 0.003
COUNT = 300
RUN = """
robot = "rough.urdf"
recording = "touches.csv"

[[senses]]
kind = "touches"
seen_from = "left"
seen = "right"
columns = ["lx", "ly", "lz", "rx", "ry", "rz"]
std = 0.001
"""


def urdf(body: bs.Body, axis: np.ndarray, links: np.ndarray) -> str:
    """The arms with other axes and links, (n_frames, 3)."""
    lines = ['<robot name="two_arms">', *(f'<link name="{frame}"/>' for frame in body.frames)]
    for k in range(1, len(body.frames)):
        turns = body.carriers[k] in body.joints
        x, a = (" ".join(f"{v:.9g}" for v in vector[k]) for vector in (links, axis))
        lines.append(
            f'<joint name="{body.carriers[k]}" type="{"revolute" if turns else "fixed"}">'
            f'<parent link="{body.frames[body.parent[k]]}"/><child link="{body.frames[k]}"/>'
            f'<origin xyz="{x}"/><axis xyz="{a}"/>'
            '<limit lower="-2.6" upper="2.6" effort="1" velocity="1"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rough robot, what both skins felt, and the run file."""
    folder, rng = tmp_path_factory.mktemp("touched"), np.random.default_rng(5)
    body = two_arms(rng)
    felt = touches(body, 0.1, 1500, rng)
    links = np.array(body.placement)[:, :3, 3]
    axis = np.array(body.axis) + AXIS * rng.normal(size=links.shape)
    joints = np.array([name in body.joints for name in body.carriers])[:, None]
    wrong = links + LINK_ERROR * joints * rng.normal(size=links.shape)
    (folder / "rough.urdf").write_text(urdf(body, axis, wrong))
    seen = felt.observed + NOISE * rng.normal(size=felt.observed.shape)
    table = np.hstack([felt.q, seen, felt.touching])[:COUNT]
    head = ",".join([*body.joints, "lx", "ly", "lz", "rx", "ry", "rz"])
    np.savetxt(folder / "touches.csv", table, delimiter=",", header=head, comments="", fmt="%.6f")
    (folder / "touch.toml").write_text(RUN)
    return folder


def calibrated(
    folder: Path, capsys: pytest.CaptureFixture[str], *more: str
) -> tuple[float, float, dict[str, object]]:
    """Held-out rms of the touches before and after, mm, and the whole answer."""
    command = ["calibrate", str(folder / "touch.toml"), "--free", "axes", "links", "--json"]
    name = "-".join(more).strip("-") or "batch"
    assert run([*command, "--out", str(folder / name), *more]) == 0
    answer = json.loads(capsys.readouterr().out)
    [before], [after] = (list(answer[key].values()) for key in ("nominal", "held_out"))
    return before["rms"], after["rms"], answer


@pytest.mark.parametrize(("learner", "most"), [("online-gradient", 4.5), ("batch", 2.0)])
def test_touches_teach_both_arms(
    folder: Path, capsys: pytest.CaptureFixture[str], learner: str, most: float
) -> None:
    """Noise alone leaves 1.73 mm; the gradient has seen each touch once."""
    before, after, answer = calibrated(folder, capsys, "--learner", learner)
    assert before > 15
    assert 1.6 < after < most
    assert answer["learner"] == learner
    stored = bs.load(folder / f"learner-{learner}")
    assert stored.body.joints == tuple(stored.described.joints)
    assert (folder / f"learner-{learner}" / "robot.urdf").is_file()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (', "rx", "ry", "rz"]', ', "rx", "ry"]'),
        ("std = 0.001", "touching = [0.0, 0.0, 0.1]"),
    ],
)
def test_columns_that_say_no_touch_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], old: str, new: str
) -> None:
    (folder / "half.toml").write_text(RUN.replace(old, new))
    assert run(["calibrate", str(folder / "half.toml"), "--out", str(folder / "no")]) == 2
    said = capsys.readouterr().err
    assert "columns" in said
    assert said.count("\n") == 1
