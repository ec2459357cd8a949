"""Templates: HTML round the numbers, with everything escaped that is not marked as HTML.

Escape and other characters that a terminal would obey are written out: pages are read there, too.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from bodyschema.errors import MissingExtraError, shown

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
        finalize=_printable,
    )


def _printable(value: Any) -> Any:
    """Plain text with its characters of control written out; HTML and numbers as they are."""
    return shown(value) if type(value) is str else value
