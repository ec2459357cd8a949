"""The studies that are stored; a new one joins by one entry and `check.py --store NAME`."""

from __future__ import annotations

from collections.abc import Mapping

from published.entries_hersch2008 import hersch2008
from published.entries_nabeshima import nabeshima
from published.entries_vicente2016 import vicente2016
from published.entry import Entry

ENTRIES: Mapping[str, Entry] = {
    entry.name: entry for entry in (*hersch2008(), *nabeshima(), *vicente2016())
}
"""Name -> entry."""
