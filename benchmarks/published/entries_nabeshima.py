"""What is stored of the studies of Nabeshima and Kuniyoshi."""

from __future__ import annotations

from collections.abc import Iterable

from published.entry import RARE, SHARES, Entry


def nabeshima() -> Iterable[Entry]:
    """One entry a study."""
    small = {
        "figure3": {"runs": 1}, "figure4": {"runs": 1}, "figure5": {"runs": 1, "motions": 3},
        "hand-eye": {"runs": 3}, "corners": {"runs": 1, "waggle": 2.0, "seconds": 3.0},
        "find-body": {"runs": 1, "motions": 3},
        "figure8": {"runs": 2}, "figure9": {"runs": 2}, "figure10": {"runs": 2},
        "figure11": {"runs": 1}, "touch": {"runs": 4, "hours": 0.02}, "payload": {"runs": 2},
    }  # fmt: skip
    full = {
        "figure3": {"runs": 20}, "figure4": {"runs": 20}, "figure5": {"runs": 4},
        "touch": {"runs": 60, "hours": 0.02},
    }  # fmt: skip
    for figure, settings in small.items():
        yield Entry(
            "nabeshima", figure, settings, full.get(figure, {}), copies=5, leave=RARE, least=SHARES
        )
