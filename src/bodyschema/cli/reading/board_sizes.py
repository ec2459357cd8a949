"""The size of a printed board is doubted unless the run file says otherwise: printers scale."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bodyschema.cli.reading.part_entry import PartEntry
from bodyschema.cli.reading.sense_entry import SenseEntry

Parts = dict[str, PartEntry]


def with_doubted_sizes(
    parts: Mapping[str, PartEntry], senses: Sequence[SenseEntry]
) -> tuple[Parts, tuple[SenseEntry, ...]]:
    """Parts and senses in which every board has a part of kind "target", its size.

    One that is known to be right is named with known = "exactly".
    """
    made, all_senses = dict(parts), list[SenseEntry]()
    for entry in senses:
        if entry.kind == "board" and not entry.scale:
            name = f"size_of_{entry.seen}"
            made.setdefault(name, PartEntry("target"))
            entry = replace(entry, scale=name)
        all_senses.append(entry)
    return made, tuple(all_senses)
