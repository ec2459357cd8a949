"""Recordings one after the other, and frames that were moved between them."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from bodyschema.cli.run_file import RunFile, run_from_record, run_from_table
from bodyschema.errors import InputError
from bodyschema.export.documents import plain

HERE = Path("/data")


def table(**more: Any) -> dict[str, Any]:
    sense = {"kind": "points", "seen_from": "board", "seen": "mark", "columns": ["x", "y", "z"]}
    return {
        "robot": "arm.urdf",
        "append": ["mon.csv", "tue-2.csv"],
        "frames": {
            "board": {"parent": "table", "per_recording": True},
            "table": {"parent": "base", "per_recording": True},
            "mark": {"parent": "tip"},
        },
        "senses": [sense, {**sense, "seen_from": "mark", "seen": "tip", "recording": "own.csv"}],
        **more,
    }


def read(**more: Any) -> RunFile:
    return run_from_table(table(**more), HERE, "'run.toml'")


def test_every_sense_of_every_recording() -> None:
    run = read()
    assert {name: entry.parent for name, entry in run.frames.items()} == {
        "mark": "tip",
        "board_mon": "table_mon",
        "board_tue_2": "table_tue_2",
        "table_mon": "base",
        "table_tue_2": "base",
    }
    found = [(entry.recording, entry.seen_from, entry.seen) for entry in run.senses]
    assert found == [
        (("/data/mon.csv",), "board_mon", "mark"),
        (("/data/tue-2.csv",), "board_tue_2", "mark"),
        (("/data/own.csv",), "mark", "tip"),
    ]
    assert (run.recording, run.append) == ((), ())
    assert run_from_record({**plain(asdict(run)), "versions": {}}) == run


def test_the_recording_comes_first() -> None:
    run = read(recording=["mon.csv", "eye.csv"], append=[["sun.csv", "eye.csv"]])
    assert [entry.recording for entry in run.senses[:2]] == [
        ("/data/mon.csv", "/data/eye.csv"),
        ("/data/sun.csv", "/data/eye.csv"),
    ]


def test_recordings_of_one_name_are_numbered() -> None:
    run = read(append=["mon/data.csv", "tue/data.csv"])
    assert {"board_1", "board_2"} <= {*run.frames}


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"append": [], "recording": "a.csv"}, "is per_recording, and no recordings are appended"),
        ({"append": "tue.csv"}, "append = 'tue.csv' in 'run.toml'; expected a list"),
        ({"apend": ["a.csv"]}, "unknown key 'apend' .*did you mean 'append'"),
        ({"senses": []}, r"append in 'run.toml' is for recordings of \[\[senses\]\]"),
        (
            {"frames": {"a": {"parent": "b"}, "b": {"parent": "base", "per_recording": True}}},
            "hangs on 'b', which is per_recording; set per_recording = true there",
        ),
        (
            {"frames": {"b": {"parent": "c", "per_recording": True}, "b_mon": {"parent": "c"}}},
            "has a frame 'b_mon' already",
        ),
        (
            {"frames": {"b": {"parent": "c", "per_recordings": True}}},
            "did you mean 'per_recording'",
        ),
    ],
)
def test_what_cannot_be_used_is_said(more: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(**more)
