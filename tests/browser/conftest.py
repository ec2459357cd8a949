"""The browser."""

from __future__ import annotations

import pytest

from browser.chromium import found


@pytest.fixture(scope="session")
def chromium() -> str:
    return found()
