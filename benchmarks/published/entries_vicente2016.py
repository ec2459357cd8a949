"""What is stored of the studies of Vicente, Jamone and Bernardino (2016)."""

from __future__ import annotations

from collections.abc import Iterable

from published.entry import RARE, SHARES, Entry


def vicente2016() -> Iterable[Entry]:
    """One entry a study."""
    quick = {"runs": 1, "frames": 20}
    closed = quick | {"closed_frames": 5}
    # Figures 6, 7, 8, 10 are drawn of Table 1's runs, 9 of Table 2's, 13 of those of 12.
    small = {
        "generalisation": quick,
        **dict.fromkeys(("table1", "figure6", "figure7", "figure8", "figure10"), closed),
        **dict.fromkeys(("table2", "figure9"), closed),
        **dict.fromkeys(("figure12", "figure13"), closed | {"particles": 50}),
    }
    for figure, settings in small.items():
        yield Entry("vicente2016", figure, settings, copies=5, leave=RARE, least=SHARES)
