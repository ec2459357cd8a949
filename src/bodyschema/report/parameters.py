"""The parameter table: every value with its error, or with what it cannot be told apart from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.export.calibration_yaml import OPEN
from bodyschema.export.static_transforms import PREFIX
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


@dataclass(frozen=True)
class ParameterTable:
    """All parameters, group by group."""

    evidence: Evidence
    title: str = "Corrections"

    def render(self) -> str:
        """See `Section`."""
        calibration = self.evidence.calibration
        return parameter_html(calibration.estimate, calibration.identifiability)


ONE_OF_MANY = "the files hold one of many equally good answers, the one nearest to the model"


def parameter_html(estimate: Estimate, known: Identifiability, held: str = ONE_OF_MANY) -> str:
    """The table of an estimate, group by group.

    Args:
        estimate: what was learned.
        known: what the data determine of it.
        held: what the files have of the rest.
    """
    groups = estimate.variables.groups
    order = sorted(range(len(groups)), key=lambda i: list(dict.fromkeys(groups)).index(groups[i]))
    parts = [
        (_heading(group), [_row(estimate, known, i) for i in members])
        for group, members in groupby(order, key=lambda i: groups[i])
    ]
    return render("parameters.html", parts=parts, clear=f"{CLEAR:g}", held=held)


def _row(estimate: Estimate, known: Identifiability, i: int) -> Row:
    variables = estimate.variables
    scale, unit = read_as(variables.units[i])
    value, std = float(scale * estimate.x[i]), float(scale * estimate.std[i])
    share = float(known.open_share[i])
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
    return HEADINGS[group]
