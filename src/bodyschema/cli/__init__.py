"""The command line: `bodyschema VERB`, one file a verb.

Exit codes: 0 done; 1 the answer is "no" (refused, changed, contradicted); 2 what was given cannot
be used, or what was found cannot be written; 70 a fault of bodyschema; 130 stopped by Ctrl-C; 141
the reader of standard output has gone; 143 stopped by SIGTERM.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from bodyschema.cli.process import own_process, said_after
from bodyschema.errors import BodyschemaError


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of the command `bodyschema`.

    Args:
        arguments: of a caller who keeps the process; None for those of this process, which is then
            the command's own: its signals, streams and environment are set.
    """
    from bodyschema.cli.endings import ended

    whole = arguments is None
    if whole:
        own_process()
    code = ended(lambda: run(sys.argv[1:] if arguments is None else arguments), whole)
    if whole:
        said_after()
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run one verb; returns its exit code and prints errors of the input in one sentence."""
    from bodyschema.cli.verbs import verb_of

    try:
        if list(arguments[:1]) == ["study"]:
            # Each study has flags of its own; only the one that is asked for is loaded.
            from bodyschema.cli.study import study_verb

            return study_verb(arguments[1:]).run()
        if list(arguments) in (["--version"], ["-V"]):
            from bodyschema import __version__

            print(f"bodyschema {__version__}")
            return 0
        return int(verb_of(arguments).run())
    except BodyschemaError as error:
        print(f"bodyschema: {error}", file=sys.stderr)
        return 2
