"""`lens = "camera_info.yaml"` wherever a run file takes a lens."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from bodyschema.cli.reading.part_kinds import made
from bodyschema.cli.run_file import RunFile, run_from_record, run_from_table
from bodyschema.errors import InputError
from bodyschema.model.tree import Body

INFO = """image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [615.5, 0, 320.25, 0, 616.5, 241.75, 0, 0, 1]}
distortion_model: equidistant
distortion_coefficients: {rows: 1, cols: 4, data: [0.1, -0.2, 0.01, 0.002]}
"""
VALUES = [615.5, 616.5, 320.25, 241.75, 0.1, -0.2, 0.01, 0.002]
URDF = '<robot name="r"><link name="base"/></robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With a lens in two files."""
    (tmp_path / "eye.yaml").write_text(INFO)
    (tmp_path / "plain.yaml").write_text(INFO.split("distortion")[0])
    return tmp_path


def run_of(folder: Path, **more: Any) -> RunFile:
    sense = {
        "kind": "pixels", "seen_from": "c", "seen": "m", "columns": ["u", "v"], "lens": "eye.yaml",
    }  # fmt: skip
    table = {"robot": "r.urdf", "recording": "d.csv", "senses": [sense], **more}
    return run_from_table(table, folder, "'run.toml'")


def test_a_sense_names_a_file(folder: Path) -> None:
    run = run_of(folder)
    assert run.senses[0].lens == "eye_lens"
    entry = run.parts["eye_lens"]
    assert (entry.known, entry.model, entry.size) == ("roughly", "fisheye", (640, 480))
    lens = made(entry, "eye_lens", Body.from_urdf(URDF))
    assert lens.values.tolist() == VALUES
    assert str(folder / "eye.yaml") in run.inputs


def test_a_part_names_a_file(folder: Path) -> None:
    part = {"kind": "lens", "file": "plain.yaml", "known": "exactly"}
    run = run_of(folder, parts={"eye.yaml": part})
    assert run.senses[0].lens == "eye.yaml"  # the name of a part comes first
    entry = run.parts["eye.yaml"]
    assert (entry.known, entry.fx, entry.distortion) == ("exactly", 615.5, ())


def test_the_record_needs_the_file_no_more(folder: Path) -> None:
    run = run_of(folder)
    record = json.loads(json.dumps(asdict(run)))
    (folder / "eye.yaml").unlink()
    assert run_from_record(record).parts == run.parts


def test_a_camera_names_a_file(folder: Path) -> None:
    camera = {"parent": "base", "lens": "eye.yaml", "images": "{row}.png"}
    table = {"robot": "r.urdf", "recording": "d.csv", "cameras": {"left": camera}}
    run = run_from_table(table, folder, "'run.toml'")
    assert run.pictures is not None
    eye = run.pictures.cameras["left"].camera("left")
    assert [*eye.intrinsics, *eye.distortion] == VALUES
    assert eye.fisheye
    assert str(folder / "eye.yaml") in run.inputs
    record = json.loads(json.dumps(asdict(run)))
    (folder / "eye.yaml").unlink()
    assert run_from_record(record).pictures == run.pictures


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"parts": {"eye_lens": {"kind": "clock"}}},
            "would be the part 'eye_lens', which is there",
        ),
        ({"parts": {"a": {"kind": "lens", "file": "eye.yaml", "fx": 3.0}}}, "fx in .* is said by"),
        ({"parts": {"a": {"kind": "lens", "file": "none.yaml"}}}, "no lens at"),
        (
            {"parts": {"a": {"kind": "clock", "file": "eye.yaml"}}},
            "'file' in .* is for parts of lens",
        ),
        (
            {"parts": {"a": {"kind": "lens", "file": "eye.yaml", "size": [1, 2]}}},
            "size = .* and pic",
        ),
        (
            {"cameras": {"a": {"parent": "b", "lens": "eye.yaml", "distortion": [1.0]}}},
            "is said by",
        ),
        ({"cameras": {"a": {"parent": "b", "lens": "eye.yaml", "size": [1, 2]}}}, "needs size"),
        ({"cameras": {"a": {"parent": "b", "lens": "none.yaml"}}}, "no lens at"),
    ],
)
def test_what_contradicts_is_refused(folder: Path, more: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        run_of(folder, **more)
