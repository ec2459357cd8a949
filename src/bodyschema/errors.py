"""The errors that users see: one root, children that name the alternatives."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST_NAMES, LONGEST_NAME = 2000, 100
"""Of names that a misspelt one is compared with, and letters of such a name."""


class BodyschemaError(Exception):
    """Root of all errors raised on purpose by this library."""

    def __str__(self) -> str:
        # Messages quote names from files, which must not speak to a terminal.
        return shown(super().__str__())


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


def shown(text: str) -> str:
    """A text with escapes, marks of direction and halves of characters written out.

    Args:
        text: as it stands in a file; new lines stay.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else _written(c) for c in text)


def _written(letter: str) -> str:
    return letter.encode("unicode_escape").decode("ascii")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for a close match, else the list of what exists."""
    names = [str(name) for name in known]
    # Likeness costs the square of a length, and nobody mistypes a page.
    near = [name for name in names[:MOST_NAMES] if len(name) <= LONGEST_NAME]
    close = difflib.get_close_matches(word[:LONGEST_NAME], near, n=3, cutoff=0.6)
    if close:
        return "; did you mean " + " or ".join(f"'{name}'" for name in close) + "?"
    if not names:
        return "; there are none."
    listed = ", ".join(f"'{name[:LONGEST_NAME]}'" for name in names[:12])
    return f"; there are: {listed}{' ...' if len(names) > 12 else ''}."
