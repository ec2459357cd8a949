"""The errors that users see: one root, children that name the alternatives."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class BodyschemaError(Exception):
    """Root of all errors raised on purpose by this library."""


class InputError(BodyschemaError):
    """What was given cannot be used; the message says what to give instead."""


class MissingExtraError(BodyschemaError):
    """An optional package is needed for what was asked."""

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        self.package, self.extra = package, extra
        super().__init__(
            f"{purpose} needs the package '{package}', which is not installed; "
            f"run: pip install 'bodyschema[{extra}]'."
        )


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for a close match, else the list of what exists."""
    names = [str(name) for name in known]
    close = difflib.get_close_matches(word, names, n=3, cutoff=0.6)
    if close:
        return "; did you mean " + " or ".join(f"'{name}'" for name in close) + "?"
    if not names:
        return "; there are none."
    shown = ", ".join(f"'{name}'" for name in names[:12])
    return f"; there are: {shown}{' ...' if len(names) > 12 else ''}."
