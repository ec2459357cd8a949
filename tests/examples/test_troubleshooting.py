"""Messages that the troubleshooting page explains are messages of the program."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
TERM = re.compile(r"^(`.*)\n: ", re.MULTILINE)


def quoted() -> list[str]:
    """Parts of messages, cut where the page leaves something out."""
    terms = [message for line in TERM.findall(PAGE) for message in re.findall(r"`([^`]+)`", line)]
    return [part.strip() for message in terms for part in re.split(r"\.\.\.|[A-Z]{2,}", message)]


@pytest.fixture(scope="module")
def source() -> str:
    """All strings of the program as one text: adjacent literals joined, braces left out."""
    text = "\n".join(
        path.read_text(encoding="utf-8") for path in sorted((ROOT / "src").rglob("*.py"))
    )
    joined = re.sub(r"[\"']\s*\n\s*f?[\"']", "", text)
    return re.sub(r"\{[^{}]*\}", "", joined)


@pytest.mark.parametrize("message", [part for part in quoted() if len(part) > 4])
def test_the_message_is_one_of_ours(message: str, source: str) -> None:
    assert message in source


def test_the_page_explains_many() -> None:
    assert len(quoted()) > 15
