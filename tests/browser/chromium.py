"""Headless Chromium, if this machine has one."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


def found() -> str:
    """Its path; the test is skipped where there is none."""
    for name in NAMES:
        path = shutil.which(name)
        if path:
            return path
    pytest.skip("no Chromium on this machine (looked for " + ", ".join(NAMES) + ")")


def opened(chromium: str, folder: Path, page: Path, *flags: str) -> str:
    """What Chromium prints when it has opened a page."""
    command = [chromium, *FLAGS, f"--user-data-dir={folder / 'profile'}", *flags, page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=90, check=True).stdout


def title_of(
    chromium: str, folder: Path, page: Path, width: int, *flags: str, height: int = 900
) -> dict[str, Any]:
    """The JSON that the page has put into its title, in a window of this size."""
    size = f"--window-size={width},{height}"
    text = opened(chromium, folder, page, size, "--dump-dom", *flags)
    title = re.search(r"<title>(\{.*?\})</title>", text, re.S)
    assert title, "the page did not answer"
    answer: dict[str, Any] = json.loads(html.unescape(title.group(1)))
    return answer
