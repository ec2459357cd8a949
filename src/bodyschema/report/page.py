"""Templates: HTML round the numbers, with everything escaped that is not marked as HTML."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from bodyschema.errors import MissingExtraError

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, **values: Any) -> str:
    """Fill in one of the templates beside this file.

    Raises:
        MissingExtraError: jinja2 is not installed.
    """
    return _environment().get_template(template).render(**values)


@cache
def _environment() -> Environment:
    try:
        from jinja2 import Environment, PackageLoader, StrictUndefined
    except ImportError:
        raise MissingExtraError("jinja2", "report", "report.html") from None
    return Environment(
        loader=PackageLoader("bodyschema.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
