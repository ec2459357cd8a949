"""All studies, by paper and figure; a new one joins by one line."""

from __future__ import annotations

import importlib
from typing import Any

PAPERS = {
    "hersch2008": "Hersch, Sauser, Billard 2008: online learning of the body schema",
    "nabeshima": "Nabeshima, Kuniyoshi: a method for sustainable coordination",
    "vicente2016": "Vicente, Jamone, Bernardino 2016: body schema from imagined images",
}
"""Papers, and what each is."""

STUDIES: dict[tuple[str, str], str] = {
    ("hersch2008", "figure3"): "hersch2008_figure3:Figure3",
    ("hersch2008", "figure4"): "hersch2008_figure4:Figure4",
    ("hersch2008", "figure7"): "hersch2008_figure7:Figure7",
    ("hersch2008", "theorem1"): "hersch2008_theorem1:Theorem1",
    ("hersch2008", "figure10"): "hersch2008_figure10:Figure10",
    ("hersch2008", "figure11"): "hersch2008_figure11:Figure11",
    ("hersch2008", "figure13"): "hersch2008_figure13:Figure13",
    ("nabeshima", "figure3"): "nabeshima_coincidence:Figure3",
    ("nabeshima", "figure4"): "nabeshima_coincidence:Figure4",
    ("nabeshima", "figure5"): "nabeshima_coincidence:Figure5",
    ("nabeshima", "find-body"): "nabeshima_find_body:FindBody",
    ("nabeshima", "hand-eye"): "nabeshima_hand_eye:HandEye",
    ("nabeshima", "corners"): "nabeshima_corners:Corners",
    ("nabeshima", "figure8"): "nabeshima_figure8:Figure8",
    ("nabeshima", "figure9"): "nabeshima_figure9:Figure9",
    ("nabeshima", "rendered"): "nabeshima_rendered:Rendered",
    ("nabeshima", "figure10"): "nabeshima_figure10:Figure10",
    ("nabeshima", "figure11"): "nabeshima_figure11:Figure11",
    ("nabeshima", "touch"): "nabeshima_touch:TouchStudy",
    ("nabeshima", "payload"): "nabeshima_payload:Payload",
    ("nabeshima", "life"): "nabeshima_life:Life",
    ("vicente2016", "table1"): "vicente2016_table1:Table1",
    ("vicente2016", "table2"): "vicente2016_table2:Table2",
    ("vicente2016", "generalisation"): "vicente2016_generalisation:Generalisation",
    ("vicente2016", "figure6"): "vicente2016_figure6:Figure6",
    ("vicente2016", "figure7"): "vicente2016_figure6:Figure7",
    ("vicente2016", "figure8"): "vicente2016_figure6:Figure8",
    ("vicente2016", "figure9"): "vicente2016_table2:Figure9",
    ("vicente2016", "figure10"): "vicente2016_figure10:Figure10",
    ("vicente2016", "figure12"): "vicente2016_figure12:Figure12",
    ("vicente2016", "figure13"): "vicente2016_figure12:Figure13",
}
"""(paper, figure) -> module of this package and class in it."""


def study_class(paper: str, figure: str) -> type[Any]:
    """The class of a study; its module is loaded at the first call."""
    module, name = STUDIES[paper, figure].split(":")
    found: type[Any] = getattr(importlib.import_module(f"bodyschema.studies.{module}"), name)
    return found
