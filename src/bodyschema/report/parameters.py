"""The parameter table: every value with its error, or with what it cannot be told apart from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.export.load_entry import load_entries
from bodyschema.judging.places import OPEN, PREFIX
from bodyschema.judging.settled import Settled, settled
from bodyschema.model.variables import GROUPS
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.units import listed, read_as, signed, significant, with_error

HEADINGS = {
    "offsets": "Joint offsets: the true joint value is its reading plus this",
    "gears": "Gear errors: the joint moves by so much more than its encoder says",
    "axes": "Joint axes: tilts of the axis",
    "links": "Links: shifts of the joint in its parent's frame",
}
MOST_PARTNERS = 4
WHOLLY = 0.05
"""Share of the prior variance in open directions up to which a value is called determined."""
ROOTS = "load:"
"""Groups of parameters that are shown as the masses and moments they stand for."""
CLEAR = 2.0
"""Standard deviations from which a correction is told from none."""


@dataclass(frozen=True)
class Row:
    """One parameter as it is shown."""

    name: str
    value: str
    std: str
    unit: str
    prior: str
    state: str
    """"determined", "partly" or "open"."""
    clear: bool
    partners: str


ONE_OF_MANY = "the files hold one of many equally good answers, the one nearest to the model"
"""What the files have of parameters that are not determined."""


@dataclass(frozen=True)
class ParameterTable:
    """All parameters, group by group."""

    evidence: Evidence
    title: str = "Corrections"

    def render(self) -> str:
        """See `Section`."""
        calibration = self.evidence.calibration
        loads = calibration.details.get("loads") or load_entries(calibration.estimate)
        held = calibration.details.get("held", ONE_OF_MANY)
        kept = settled(calibration)
        return parameter_html(calibration.estimate, calibration.identifiability, kept, loads, held)


def parameter_html(
    estimate: Estimate,
    known: Identifiability,
    kept: Settled,
    loads: Sequence[Mapping[str, Any]],
    held: str,
) -> str:
    """The table of an estimate, group by group.

    Args:
        estimate: what was learned.
        known: what the data determine of it.
        kept: what of it is written; the others are folded.
        loads: in place of their roots, see `load_entry`.
        held: what the files have of the rest.
    """
    groups = estimate.variables.groups
    order = sorted(range(len(groups)), key=lambda i: list(dict.fromkeys(groups)).index(groups[i]))

    def rows(changed: bool) -> list[tuple[str, list[Row]]]:
        chosen = [i for i in order if bool(kept.changed[i]) == changed]
        return [
            (_heading(group), [_row(estimate, known, kept, i) for i in members])
            for group, members in groupby(chosen, key=lambda i: groups[i])
            if not group.startswith(ROOTS)
        ]

    parts, folded = rows(True), rows(False)
    parts += [(f"Load {entry['name']}", _load_rows(entry)) for entry in loads]
    return render(
        "parameters.html",
        tables=[table for table in (parts, folded) if table],
        folded=sum(len(members) for _, members in folded) if parts else 0,
        clear=f"{CLEAR:g}",
        held=held,
    )


def _row(estimate: Estimate, known: Identifiability, kept: Settled, i: int) -> Row:
    """A correction as it is written, or of what is not written what the fit has."""
    variables, joint = estimate.variables, estimate.variables.groups[i] in GROUPS
    scale, unit = read_as(variables.units[i])
    x, error = (kept.x, kept.std) if joint and kept.changed[i] else (estimate.x, estimate.std)
    value, std = float(scale * x[i]), float(scale * error[i])
    share = 0.0 if joint and kept.changed[i] else float(known.open_share[i])
    determined = share <= OPEN
    texts = with_error(value, std) if determined else (signed(value, 2), "")
    partners = known.partners(variables.names[i])
    return Row(
        name=variables.names[i],
        value=texts[0],
        std=texts[1],
        unit=unit,
        prior=significant(float(scale * variables.prior_std[i]), 2),
        state="open" if not determined else "partly" if share > WHOLLY else "determined",
        clear=determined and abs(value) > CLEAR * std,
        partners=listed(partners, MOST_PARTNERS),
    )


def _heading(group: str) -> str:
    if group.startswith(PREFIX):
        return f"Frame {group.removeprefix(PREFIX)}: shifts and turns from its first guess"
    kind, _, name = group.partition(":")
    return HEADINGS.get(group) or f"{kind.capitalize()} {name}: changes against what was believed"


def _load_rows(entry: Mapping[str, Any]) -> list[Row]:
    """Mass, centre and moments of a load, in place of its roots."""
    untold = {one["what"] for one in entry["not_told"]}
    rows = [("mass", entry["mass"], entry["mass_std"], 1.0, "kg", "mass" not in untold)]
    for axis, value, std in zip("xyz", entry["com"], entry["com_std"], strict=True):
        rows.append((f"centre_{axis}", value, std, 1e3, "mm", "com" not in untold))
    for moment, std in entry["inertia_std"].items():
        i, j = ("xyz".index(c) for c in moment[2:])
        told = moment not in untold
        rows.append((moment, entry["inertia"][i][j], std, 1e3, "g m²", told))
    return [
        Row(
            f"{entry['name']}.{what}",
            *with_error(scale * value, scale * std),
            unit,
            "",
            "determined" if told else "open",
            told and abs(value) > CLEAR * std,
            "",
        )
        for what, value, std, scale, unit, told in rows
    ]
