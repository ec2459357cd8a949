"""The verbs of the command, and which of them was asked for."""

from __future__ import annotations

import ast
import importlib
import inspect
import sys
from collections.abc import Sequence
from functools import reduce
from typing import Annotated, Any, Protocol

from bodyschema.errors import InputError, did_you_mean

VERBS = {
    "calibrate": "calibrate.Calibrate",
    "inspect": "inspect.Inspect",
    "simulate": "simulate.Simulate",
    "plan": "plan.PlanPoses",
    "check": "check.Check",
    "compare": "compare.Compare",
    "report": "report.Report",
    "view": "view.View",
    "export": "export.Export",
    "track": "track.Track",
    "hand-eye": "hand_eye.HandEyeVerb",
    "find-body": "find_body.FindBody",
    "payload": "payload.PayloadVerb",
    "touch": "touch.TouchVerb",
    "board": "board.Board",
    "study": "study.ListStudies",
    "doctor": "doctor.Doctor",
}
"""File and class of each, in the order of the help."""

DESCRIPTION = (
    "Keeps a robot's model of its own body true while the robot works. "
    "`bodyschema --version` says which this is, `bodyschema doctor` what it finds here."
)


class Verb(Protocol):
    """What the command line makes of the arguments of a verb."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        ...


def verb_of(arguments: Sequence[str]) -> Verb:
    """The verb with its settings.

    Raises:
        InputError: the first argument is no verb.
        SystemExit: after the help, or flags that do not fit, which are told with their neighbours.
    """
    import tyro

    name = arguments[0] if arguments else "--help"
    if not name.startswith("-") and name not in VERBS:
        raise InputError(f"no verb '{name}'{did_you_mean(name, VERBS)} See bodyschema --help.")
    settings: dict[str, Any] = {
        "prog": "bodyschema",
        "description": DESCRIPTION,
        "config": (tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
    }
    if name in VERBS:
        # Only what was asked for is loaded.
        settings |= {"prog": f"bodyschema {name}", "description": None}
        one: Verb = tyro.cli(_class(name), args=list(arguments[1:]), **settings)
        return one
    verbs = [Annotated[_class(verb), tyro.conf.subcommand(verb)] for verb in VERBS]
    union: Any = reduce(lambda a, b: a | b, verbs)
    any_of_them: Verb = tyro.cli(union, args=list(arguments) or ["--help"], **settings)
    return any_of_them


def _class(name: str) -> Any:
    file, kind = VERBS[name].split(".")
    module = importlib.import_module(f"bodyschema.cli.{file}")
    found = getattr(module, kind)
    if sys.flags.optimize >= 2:
        # Python was told to drop docstrings; the help is read from the source.
        tree = ast.parse(inspect.getsource(module))
        (of,) = (node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == kind)
        found.__doc__ = ast.get_docstring(of)
    return found
