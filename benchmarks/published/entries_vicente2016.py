"""What is stored of the studies of Vicente, Jamone and Bernardino (2016).

Figures 6, 7, 8, 10 are drawn of Table 1's runs, 9 of Table 2's, 13 of those of 12. Table 1 is run
on its 40 different movements, once each (the paper's 120 are 40 movements, three times each).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bodyschema.studies.vicente2016_table2 import PAPER as TABLE_2
from published.entry import RARE, SHARES, Entry, Told

QUICK: Mapping[str, Any] = {"runs": 1, "frames": 20}
CLOSED: Mapping[str, Any] = QUICK | {"closed_frames": 5}
MOVEMENTS: Mapping[str, Any] = {"runs": 40}
LEAVE = (
    *RARE, "*frames_per_second", "*seconds_per_frame",
    # Of one or two movements, no spread; of so few frames, no end.
    "*.sd", "*nees", "*nees_within", "*settled_after*",
)  # fmt: skip
ESTIMATION = {"position_mm": ("mm", "5.45 ± 2.55"), "orientation_deg": ("deg", "6.14 ± 2.49")}
REACHING = {"position_mm": ("mm", "5.13 ± 2.57"), "orientation_deg": ("deg", "5.81 ± 2.49")}
BEFORE = {"position_mm": ("mm", "43.79 ± 5.40"), "orientation_deg": ("deg", "13.30 ± 3.13")}
MODELS = {"": "within", "mismatched.": "outside"}
TABLE_1 = (
    ("without_adaptation", "estimation error without adaptation", BEFORE),
    ("estimation", "estimation error, end of the open loop", ESTIMATION),
    ("reaching", "reaching error, end of the closed loop", REACHING),
)
LAST_DEG = "orientation_deg"


def vicente2016() -> Iterable[Entry]:
    """One entry a study."""
    for figure in ("table1", "figure6", "figure7", "figure8", "figure10"):
        told = TOLD[figure]
        yield _entry(figure, CLOSED, MOVEMENTS, told)
    for figure in ("table2", "figure9"):
        yield _entry(figure, CLOSED, {"runs": 2, "closed_frames": 0}, _table2())
    yield _entry("generalisation", QUICK, {"runs": 4}, _generalisation())
    for figure in ("figure12", "figure13"):
        yield _entry(figure, CLOSED | {"particles": 50}, {"runs": 1}, _figure12())


def _entry(
    figure: str, small: Mapping[str, Any], full: Mapping[str, Any], told: Mapping[str, Told]
) -> Entry:
    return Entry("vicente2016", figure, small, full, copies=5, leave=LEAVE, least=SHARES, told=told)


def _table1() -> dict[str, Told]:
    return {
        f"{model}{key}.{part}.{of}": Told(
            f"{words}, {unit}, {of}, {says}", _of(paper, of) if not model else ""
        )
        for model, says in MODELS.items()
        for key, words, papers in TABLE_1
        for part, (unit, paper) in papers.items()
        for of in ("mean", "sd")
    } | {
        f"{model}{key}": Told(f"{words}, {says}")
        for model, says in MODELS.items()
        for key, words in (
            ("ess_last", "effective size of the last ten frames, share"),
            ("nees", "NEES at the end of the open loop, mean (6 if right)"),
            ("nees_within", "share of movements within the central 95 % of NEES"),
        )
    }


def _of(paper: str, of: str) -> str:
    """Mean or standard deviation of "mean ± sd"."""
    return paper.split(" ± ")[of == "sd"]


def _course(words: Mapping[str, str], what: str) -> dict[str, Told]:
    return {
        f"course.{at}.{part}.mean": Told(f"{what} {says}, {unit}, mean", "a picture")
        for at, says in words.items()
        for part, (unit, _) in ESTIMATION.items()
    }


def _figure10() -> dict[str, Told]:
    return {
        f"{model}particles.{m}.{key}.{part}": Told(
            f"{m} particles: {words}, {unit}, {says}", "a picture"
        )
        for model, says in MODELS.items()
        for m in (200, 2000)
        for key, words in (
            ("without_adaptation", "without adaptation"), ("end", "end of the open loop"),
            ("last_frames_median", "median of the last 20 frames"),
        )
        for part, (unit, _) in ESTIMATION.items()
    }  # fmt: skip


def _table2() -> dict[str, Told]:
    return {
        f"{model}particles.{m}.estimation.{part}.mean": Told(
            f"{m} particles: estimation error, {unit}, mean, {says}",
            f"{papers[part == LAST_DEG]:.2f}" if not model else "",
        )
        for m, papers in TABLE_2.items()
        for part, (unit, _) in ESTIMATION.items()
        for model, says in MODELS.items()
    }


def _generalisation() -> dict[str, Told]:
    return {
        f"errors.{name}.{place}.{part}.mean": Told(
            f"{name}, {place} of the room, {unit}, mean", "joint offsets are better"
        )
        for name in ("no adaptation", "joint offsets", "Cartesian error")
        for place in ("same half", "other half")
        for part, (unit, _) in ESTIMATION.items()
    }


def _figure12() -> dict[str, Told]:
    return {
        f"{model}methods.{method}.{when}.distance_mm.mean": Told(
            f"{words}: fingertips apart, mm, mean, {says}",
            "" if model or method == "track" else paper,
        )
        for model, says in MODELS.items()
        for method, when, words, paper in (
            ("particle-filter", "before", "before", "about 160"),
            ("particle-filter", "after", "after, filter", "about 120"),
            ("track", "after", "after, tracker", ""),
        )
    }


TOLD: Mapping[str, Mapping[str, Told]] = {
    "table1": _table1(),
    "figure6": _course(
        {"1_quarters": "after 30 frames", "2_quarters": "after 60", "3_quarters": "after 90",
         "4_quarters": "after 120"},
        "estimation error",
    ),
    "figure7": _course(
        {"first": "in the first frame of the closed loop", "fifth": "in the tenth",
         "last": "in the last"},
        "real reaching error",
    ),
    "figure8": _course(
        {"first": "in the first frame of the closed loop", "fifth": "in the tenth",
         "last": "in the last"},
        "estimated reaching error",
    ),
    "figure10": _figure10(),
}  # fmt: skip
