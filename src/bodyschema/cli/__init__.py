"""The command line: `bodyschema VERB`, one file a verb.

Exit codes: 0 done; 1 the answer is "no" (refused, changed); 2 the input cannot be used; 130 stopped
by Ctrl-C.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated

from bodyschema.errors import BodyschemaError


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of the command `bodyschema`."""
    try:
        code = run(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader (`head`, `less`) has gone; there is nobody left to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run one verb; returns its exit code and prints errors of the input in one sentence."""
    import tyro

    from bodyschema.cli.calibrate import Calibrate
    from bodyschema.cli.check import Check
    from bodyschema.cli.export import Export
    from bodyschema.cli.find_body import FindBody
    from bodyschema.cli.hand_eye import HandEyeVerb
    from bodyschema.cli.payload import PayloadVerb
    from bodyschema.cli.plan import PlanPoses
    from bodyschema.cli.report import Report
    from bodyschema.cli.simulate import Simulate
    from bodyschema.cli.study import ListStudies, study_verb
    from bodyschema.cli.touch import TouchVerb
    from bodyschema.cli.track import Track
    from bodyschema.cli.view import View

    verbs = (
        Annotated[Calibrate, tyro.conf.subcommand("calibrate")]
        | Annotated[Simulate, tyro.conf.subcommand("simulate")]
        | Annotated[PlanPoses, tyro.conf.subcommand("plan")]
        | Annotated[Check, tyro.conf.subcommand("check")]
        | Annotated[Report, tyro.conf.subcommand("report")]
        | Annotated[View, tyro.conf.subcommand("view")]
        | Annotated[Export, tyro.conf.subcommand("export")]
        | Annotated[Track, tyro.conf.subcommand("track")]
        | Annotated[HandEyeVerb, tyro.conf.subcommand("hand-eye")]
        | Annotated[FindBody, tyro.conf.subcommand("find-body")]
        | Annotated[PayloadVerb, tyro.conf.subcommand("payload")]
        | Annotated[TouchVerb, tyro.conf.subcommand("touch")]
        | Annotated[ListStudies, tyro.conf.subcommand("study")]
    )
    try:
        if list(arguments[:1]) == ["study"]:
            # Each study has flags of its own; only the one that is asked for is loaded.
            return study_verb(arguments[1:]).run()
        verb = tyro.cli(
            verbs,
            prog="bodyschema",
            description="Keeps a robot's model of its own body true while the robot works.",
            args=list(arguments) or ["--help"],
            config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
        )
        return int(verb.run())
    except BodyschemaError as error:
        print(f"bodyschema: {error}", file=sys.stderr)
        return 2
