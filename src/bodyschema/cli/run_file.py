"""The run file: one TOML that names the robot, the recording, and what is seen of what.

    robot = "arm.urdf"                      # URDF, xacro, or a DH table (.toml, .json)
    skeleton = "arm.toml"                   # instead: an arrangement, to learn the geometry of
    recording = "data.csv"                  # CSV or Parquet; a list of files is joined row by row
    time = "t"                              # optional: the column of times; "" if there is no clock
    learner = "batch"                       # optional; or an online learner, see LEARNERS

    [joints]
    unit = "rad"                            # or "deg", "mrad"
    columns = { elbow = "q3" }              # optional: columns that are not named like the joint

    [frames.tracker]                        # a frame that the robot description does not have
    parent = "base_link"
    xyz = [0.0, 0.0, 0.0]                   # optional: m, in the parent
    rpy = [0.0, 0.0, 0.0]                   # optional: rad, fixed axes
    known = "no"                            # "exactly", "roughly" or "no"

    [[senses]]
    kind = "points"                         # or "poses"
    seen_from = "tracker"                   # the frame that the coordinates are in
    seen = "marker"                         # the frame whose place they are
    columns = ["x", "y", "z"]
    unit = "mm"
    layout = "matrix3x4"                    # poses only; see LAYOUTS
    inverse = false                         # poses only: columns hold T_seen_seen_from

    [free]                                  # optional
    groups = ["offsets", "axes", "links"]   # chosen by held-out error when absent
    joints = ["elbow"]                      # those between the frames when absent

Paths are relative to the run file. Keys that are not known are refused. With `skeleton` the
frames are those of the arrangement (see `model.arrangement`), and [[senses]] may be left out:
marker `hand` is then read from the columns hand_x, hand_y and hand_z, in m.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

from bodyschema.cli.entry_types import check_types
from bodyschema.errors import InputError, did_you_mean

Table = TypeVar("Table")

KNOWLEDGE = ("exactly", "roughly", "no")

LEARNERS = ("batch", "gauss-newton", "smoother", "online-gradient", "pool")
"""All samples at once; or one after the other in one pass, see `judging.one_pass`."""


@dataclass(frozen=True)
class JointColumns:
    """How joint readings are recorded."""

    unit: str = "rad"
    columns: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FrameEntry:
    """A fixed frame besides those of the robot description."""

    parent: str
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    known: str = "no"


@dataclass(frozen=True)
class SenseEntry:
    """Columns that one sense is read from."""

    kind: str
    seen_from: str
    seen: str
    columns: tuple[str, ...]
    unit: str = "m"
    layout: str = "matrix3x4"
    inverse: bool = False


@dataclass(frozen=True)
class FreeEntry:
    """What may be wrong, where the user says."""

    groups: tuple[str, ...] | None = None
    joints: tuple[str, ...] | None = None


@dataclass(frozen=True)
class RunFile:
    """A whole run, resolved."""

    robot: str
    recording: tuple[str, ...]
    joints: JointColumns
    frames: dict[str, FrameEntry]
    senses: tuple[SenseEntry, ...]
    free: FreeEntry = FreeEntry()
    time: str | None = None
    packages: dict[str, str] = field(default_factory=dict)
    folds: int = 5
    seed: int = 0
    learner: str = "batch"
    skeleton: str = ""
    """Arrangement of a robot without a description; `robot` is empty then."""

    @property
    def description(self) -> Path:
        """The file that describes the robot, or the arrangement."""
        return Path(self.skeleton or self.robot)


def read_run_file(path: Path) -> RunFile:
    """Read a run file; its paths come back absolute.

    Raises:
        InputError: missing, malformed, a key unknown or missing.
    """
    if not path.is_file():
        raise InputError(f"no run file at '{path}'; give the path of a TOML file.")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"'{path}' is not valid TOML: {error}.") from None
    return run_from_table(table, path.resolve().parent, f"'{path.name}'")


def run_from_table(table: Mapping[str, Any], here: Path, where: str) -> RunFile:
    """The run that a table describes; `here` anchors its paths, `where` names it in messages.

    Raises:
        InputError: a key is unknown or missing.
    """
    recording = table.get("recording", [])
    names = [recording] if isinstance(recording, str) else list(recording)
    entries = {
        **table,
        "robot": str(here / table["robot"]) if table.get("robot") else "",
        "skeleton": str(here / table["skeleton"]) if table.get("skeleton") else "",
        "recording": tuple(str(here / name) for name in names),
        "joints": entry_of(JointColumns, table.get("joints", {}), f"[joints] of {where}"),
        "frames": {
            name: entry_of(FrameEntry, entry, f"[frames.{name}] of {where}")
            for name, entry in table.get("frames", {}).items()
        },
        "senses": tuple(
            entry_of(SenseEntry, entry, f"[[senses]] {number} of {where}")
            for number, entry in enumerate(table.get("senses", []), start=1)
        ),
        "free": entry_of(FreeEntry, table.get("free", {}), f"[free] of {where}"),
        "packages": {k: str(here / v) for k, v in table.get("packages", {}).items()},
    }
    described = bool(entries["robot"]) + bool(entries["skeleton"])
    if not described or not names:
        missing = "recording" if described else "robot"
        raise InputError(f'{where} names no {missing}; add: {missing} = "path".')
    if described > 1:
        raise InputError(f"{where} names a robot and a skeleton; keep the one that you have.")
    if entries["skeleton"] and entries["frames"]:
        raise InputError(
            f"{where} has [frames] beside a skeleton; name markers and camera in the arrangement."
        )
    return entry_of(RunFile, entries, where)


def run_from_record(record: Mapping[str, Any]) -> RunFile:
    """The run that a result folder's run.json records.

    Raises:
        InputError: it does not say what was seen.
    """
    known = {field.name for field in fields(RunFile)}
    table = {key: value for key, value in record.items() if key in known}
    run = run_from_table(table, Path.cwd(), "run.json")
    if not run.senses:
        raise InputError("run.json does not say what was seen; calibrate from a run file.")
    return run


def entry_of(kind: type[Table], table: Mapping[str, Any], where: str) -> Table:
    """A frozen record of a TOML table; lists become tuples."""
    if not isinstance(table, Mapping):
        raise InputError(f"{where} is {table!r}; it must be a section with keys.")
    known = {f.name: f for f in fields(kind)}  # type: ignore[arg-type]
    for key in table:
        if key not in known:
            raise InputError(f"unknown key '{key}' in {where}{did_you_mean(key, known)}")
    for name, entry in known.items():
        required = entry.default is MISSING and entry.default_factory is MISSING
        if required and name not in table:
            raise InputError(f"{where} lacks the key '{name}'.")
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in table.items()}
    check_types(kind, values, where)
    made = kind(**values)
    _check(made, where)
    return made


def _check(entry: object, where: str) -> None:
    if isinstance(entry, FrameEntry):
        if entry.known not in KNOWLEDGE:
            raise InputError(
                f"known = '{entry.known}' in {where}{did_you_mean(entry.known, KNOWLEDGE)}"
            )
        for name in ("xyz", "rpy"):
            if len(getattr(entry, name)) != 3:
                raise InputError(f"{name} in {where} must be three numbers.")
    if isinstance(entry, SenseEntry) and entry.kind not in ("points", "poses"):
        raise InputError(
            f"kind = '{entry.kind}' in {where}{did_you_mean(entry.kind, ('points', 'poses'))}"
        )
    if isinstance(entry, RunFile):
        if entry.folds < 2:
            raise InputError(f"folds = {entry.folds} in {where}; at least 2 are needed.")
        if entry.learner not in LEARNERS:
            raise InputError(
                f"learner = '{entry.learner}' in {where}{did_you_mean(entry.learner, LEARNERS)}"
            )
