"""The table of the touch study, the published way and ours, within the premises and outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bodyschema.studies.touch_summary import percent, span_text

HEADERS = ("N", "theirs", "mean", "ours", "gains", "held", "refused")


def touch_lines(
    summary: Mapping[str, Any],
    surfaces: Sequence[str],
    forces: Sequence[float],
    others: Sequence[str],
) -> list[list[str]]:
    """Two lines for each surface and force in N; `others` are the contacts that are no points."""
    table = []
    for surface in surfaces:
        for force in (f"{force:g}" for force in forces):
            for ending, where in (("", "in"), ("_outside", "out")):
                theirs = summary[f"faithful{ending}"][surface][force]
                ours = summary[f"better{ending}"][surface][force]
                spans = [theirs, theirs["readings"]["mean"], ours]
                refused = ours.get("refused", {})
                table.append(
                    [
                        f"{'cup' if surface == 'mesh' else surface} {force} {where}",
                        *(span_text(part) for part in spans),
                        span_text(ours["gain"]) if "gain" in ours else "-",
                        percent(ours["coverage"]),
                        "/".join(percent(refused.get(kind)) for kind in others),
                    ]
                )
    return table


def touch_notes(summary: Mapping[str, Any], surfaces: Sequence[str]) -> list[str]:
    """How to read it, and what has no column."""
    speeds = list(summary["faithful"][surfaces[0]]["1"]["speeds"])
    by_speed = []
    for surface in surfaces:
        found = summary["faithful"][surface]["1"]["speeds"].values()
        thing = "cup" if surface == "mesh" else surface
        by_speed.append(f"{thing} {', '.join(span_text(cell) for cell in found)}")
    false = {s: summary["better_outside"][s]["1"]["false_per_hour"] for s in surfaces}
    felt = sum(false[s] * summary["free_hours"][s] for s in surfaces)
    return [
        "Millimetres between the place and the true one, median/95 %: by the published load "
        "and one reading of each touch, or the mean of its middle half; by ours, learned from "
        "20 s of motion; the same with the gains of the six readings off by 1 %. The paper "
        "says that errors on its table went up to 100 mm.",
        f"Theirs with 1 N, no other premise broken, at "
        f"{', '.join(f'x{speed}' for speed in speeds)}: {'; '.join(by_speed)}.",
        "Held: % of the true places in our 95 % ellipse. Refused: % of soft and of moving "
        "contacts that are not taken for a point.",
        f"False touches of ours: {felt:.0f} in {sum(summary['free_hours'].values()):g} h of "
        "free motion, out, load learned.",
        f"A sample of the finder took {summary['microseconds_a_sample_free']:.0f} "
        f"microseconds without a touch, {summary['microseconds_a_sample_touched']:.0f} when "
        "a third of the time something touched.",
    ]
