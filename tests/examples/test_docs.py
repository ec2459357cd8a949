"""The tutorial does what it says: its blocks run in order, and their output has the words shown.

Blocks marked sh whose first word is bodyschema run through the console script of this environment,
blocks marked python share one namespace, and a block marked text is output of the block before it.
Numbers are not compared, nor is the layout of tables.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<!\w)[-+]?\d[\d.]*(e[-+]?\d+)?\b")
PAGES = (
    "first_steps.md",
    "a_sense_of_your_own.md",
    "wrist_camera.md",
    "lerobot_arm.md",
    "ros2.md",
    "researchers.md",
)


def blocks(page: str) -> Iterator[tuple[str, str]]:
    """(language, text) of the blocks that are run or compared."""
    for language, text in BLOCK.findall((DOCS / page).read_text(encoding="utf-8")):
        if language in ("python", "text") or text.startswith("bodyschema "):
            yield language, text


def shell(text: str, here: Path) -> str:
    """What a block of commands prints."""
    scripts = str(Path(sys.executable).parent)
    path = os.pathsep.join([scripts, os.environ.get("PATH", "")])
    done = subprocess.run(
        ["sh", "-e", "-c", text],
        cwd=here,
        env={**os.environ, "PATH": path, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def execute(text: str, page: str, namespace: dict[str, Any]) -> str:
    """What a block of Python prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text, page, "exec"), namespace)
    return printed.getvalue()


def words(text: str) -> str:
    """The words of a text, without numbers, signs and lines."""
    return " ".join(re.findall(r"[A-Za-z_]\w*", NUMBER.sub(" ", text)))


@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_run_in_order(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, Any] = {"__name__": "__main__"}
    printed = ""

    for language, text in blocks(page):
        if language == "sh":
            printed = shell(text, tmp_path)
        elif language == "python":
            printed = execute(text, page, namespace)
        else:
            for line in filter(str.strip, text.splitlines()):
                assert words(line) in words(printed), f"'{line}' is not in the output:\n{printed}"


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_blocks_to_run_and_to_compare(page: str) -> None:
    assert {"sh", "text"} <= {language for language, _ in blocks(page)}


def test_words_leave_out_numbers_and_frames_of_tables() -> None:
    assert words("│ r_elbow.offset │ -1.97 │ p = 2.7e-47 deg, hand_1") == (
        "r_elbow offset p deg hand_1"
    )
