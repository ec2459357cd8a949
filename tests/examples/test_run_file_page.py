"""Every key that a run file may have stands on the page of the run file."""

from __future__ import annotations

import dataclasses
import importlib
import re
from pathlib import Path

import pytest

from bodyschema.cli.reading.joint_columns import JointEntry
from bodyschema.cli.reading.part_entry import PartEntry
from bodyschema.cli.reading.picture_sections import CameraEntry, DoubtEntry
from bodyschema.cli.reading.run_entries import FrameEntry, FreeEntry, HandEyeEntry, WantedEntry
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.reading.touch_sections import SurfaceEntry, TouchEntry
from bodyschema.cli.reading.wrist_sections import SECTIONS
from bodyschema.cli.run_file import RunFile
from bodyschema.senses.wrist_declaration import (
    GravityColumns,
    LoadSegments,
    MotionReading,
    PoseColumns,
    SensorPlace,
    VectorColumns,
    WrenchColumns,
)

PAGE = Path(__file__).parents[2] / "docs" / "run_file.md"
AUTOMODULE = re.compile(r"automodule:: (\S+)")
RECORDS = (
    CameraEntry, DoubtEntry, FrameEntry, FreeEntry, GravityColumns, HandEyeEntry, JointEntry,
    LoadSegments, MotionReading, PartEntry, PoseColumns, RunFile, SenseEntry, SensorPlace,
    SurfaceEntry, TouchEntry, VectorColumns, WantedEntry, WrenchColumns,
)  # fmt: skip
MADE = {"wrist", "pictures"}
"""Fields of RunFile that are made of sections with names of their own."""


@pytest.fixture(scope="module")
def page() -> str:
    """The page with the docstrings that it takes in."""
    text = PAGE.read_text(encoding="utf-8")
    modules = map(importlib.import_module, AUTOMODULE.findall(text))
    return text + "".join(module.__doc__ or "" for module in modules)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_every_key_stands_on_the_page(record: type, page: str) -> None:
    keys = {entry.name for entry in dataclasses.fields(record)} - MADE
    assert {key for key in keys if not re.search(rf"\b{key}\b", page)} == set()


def test_every_section_of_a_wrist_does(page: str) -> None:
    assert {name for name in SECTIONS if f"[{name}]" not in page} == set()
