"""The run file: one TOML that names the robot, the recording, and what is seen of what.

    robot = "arm.urdf"                      # URDF, xacro, MJCF, or a table, see "Robot"
    robot_arguments = { dof = "7" }         # optional: of a xacro file
    skeleton = "arm.toml"                   # instead: an arrangement, to learn the geometry of
    recording = "data.csv"                  # CSV or Parquet; a list of files is joined row by row
    append = ["tuesday.csv"]                # optional: further recordings with the same columns
    join = "rows"                           # optional; "time": files are streams of their own
    time = "t"                              # optional: the column of times; "" if there is no clock
    rate_hz = 100.0                         # optional: rows a second of files without times
    learner = "batch"                       # optional; or an online learner, see LEARNERS

    [joints]
    unit = "rad"                            # or "deg", "mrad", "percent" of the limits
    columns = { elbow = "q3" }              # optional: columns that are not named like the joint
    wrist = { column = "m5", sign = -1, scale = 0.088, zero = 2048, unit = "deg" }  # optional

    [frames.tracker]                        # a frame that the robot description does not have
    parent = "base_link"
    xyz = [0.0, 0.0, 0.0]                   # optional: m, in the parent
    rpy = [0.0, 0.0, 0.0]                   # optional: rad, fixed axes
    known = "no"                            # "exactly", "roughly" or "no"
    per_recording = false                   # optional: moved between the recordings of `append`

    [parts.eye]                             # what predictions need besides frames: see "Parts"
    kind = "lens"                           # or load, sensor, clock, target, drive, constants
    known = "roughly"                       # "exactly", "roughly" or "no"
    fx = 615.0                              # or file = "camera_info.yaml", see "Pixels"
    size = [640, 480]

    [[senses]]                              # as many as there are, of any kinds; see "Senses"
    kind = "points"
    seen_from = "tracker"                   # the frame that the coordinates are in
    seen = "marker"                         # the frame whose place they are
    columns = ["x", "y", "z"]
    unit = "mm"
    recording = "tracker.csv"               # optional: its own, with the same joint columns
    std = 0.5                               # optional: noise, in the units of the columns
    stated = true                           # optional: the noise is known and is not learnt
    clock = "late"                          # optional: a part "clock", whose lag is looked for
    where = "marker == 3"                   # optional: rows of a long table that are meant

    [free]                                  # optional
    groups = ["offsets", "axes", "links"]   # chosen by held-out error when absent
    joints = ["elbow"]                      # those between the frames when absent

Paths are relative to the run file. Keys that are not known are refused, and so are those that a
kind does not use. Parts that are not known exactly are free in every model. Rows of several
recordings are numbered through, in the order in which the run file names them. With `skeleton` the
frames are those of the arrangement (see `model.arrangement`), and [[senses]] may be left out:
marker `hand` is then read from the columns hand_x, hand_y and hand_z, in m.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from bodyschema.cli.entry_types import (
    entry_of,
    files,
    frozen,
    listed,
    one_of,
    refuse_unknown,
    section,
)
from bodyschema.cli.reading.appended import with_appended
from bodyschema.cli.reading.board_ends import with_board_ends
from bodyschema.cli.reading.board_sizes import with_doubted_sizes
from bodyschema.cli.reading.checks import check_keys
from bodyschema.cli.reading.joint_columns import JointColumns, joint_columns
from bodyschema.cli.reading.lens_entries import part_with_lens, with_lens_parts
from bodyschema.cli.reading.part_entry import PartEntry
from bodyschema.cli.reading.picture_sections import PictureSections
from bodyschema.cli.reading.robot import argument_words
from bodyschema.cli.reading.run_entries import (
    JOINS,
    FrameEntry,
    FreeEntry,
    HandEyeEntry,
    WantedEntry,
)
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.reading.wrist_sections import WristSections
from bodyschema.cli.verb_sections import check_verb, take_sections
from bodyschema.documents import toml_file
from bodyschema.errors import InputError

LEARNERS = ("batch", "gauss-newton", "smoother", "online-gradient", "pool")
"""All samples at once; or one after the other in one pass, see `judging.one_pass`."""

MOST_FOLDS = 1000
"""Of the held-out test: each is a fit."""

PICTURES = ("masks", "images")
"""Keys of a sense that name pictures."""


@dataclass(frozen=True)
class RunFile:
    """A whole run, resolved."""

    robot: str
    recording: tuple[str, ...]
    joints: JointColumns
    frames: dict[str, FrameEntry]
    senses: tuple[SenseEntry, ...]
    parts: dict[str, PartEntry] = field(default_factory=dict)
    free: FreeEntry = field(default_factory=FreeEntry)
    wanted: tuple[WantedEntry, ...] = ()
    """What the answer is to speak of; what was seen when empty."""
    join: str = "rows"
    """"time" where files of `recording` are streams of their own, see `streams`."""
    append: tuple[str, ...] = ()
    """Empty once it is read: each recording is one of senses of its own, see `appended`."""
    time: str | None = None
    rate_hz: float | None = None
    """Rows a second of recordings without a column of times."""
    packages: dict[str, str] = field(default_factory=dict)
    robot_arguments: dict[str, str] = field(default_factory=dict)
    """Of a robot that is a xacro file, by name."""
    folds: int = 5
    seed: int = 0
    learner: str = "batch"
    skeleton: str = ""
    """Arrangement of a robot without a description; `robot` is empty then."""
    hand_eye: HandEyeEntry | None = None
    """What `hand-eye` reads: poses of a robot without a description."""
    wrist: WristSections | None = None
    """What `payload` and `touch` read."""
    pictures: PictureSections | None = None
    """What `track` reads."""

    def check(self, where: str) -> None:
        """Refuse words and numbers that mean nothing.

        Raises:
            InputError: in one sentence; `where` names the file.
        """
        if not 2 <= self.folds <= MOST_FOLDS:
            raise InputError(f"folds = {self.folds} in {where}; give 2 to {MOST_FOLDS}.")
        if self.seed < 0:
            raise InputError(f"seed = {self.seed} in {where}; it is 0 or more.")
        if self.rate_hz is not None and self.rate_hz <= 0:
            raise InputError(f"rate_hz = {self.rate_hz:g} in {where} must be above 0.")
        one_of("learner", self.learner, LEARNERS, where)
        one_of("join", self.join, JOINS, where)
        if self.join == "time" and (self.hand_eye or self.wrist or self.pictures):
            raise InputError(
                f'join = "time" in {where} is for [[senses]] of calibrate; leave it out, or for '
                "hand-eye write it into [hand_eye]."
            )

    @property
    def description(self) -> Path:
        """The file that describes the robot, or the arrangement."""
        return Path(self.skeleton or self.robot)

    @property
    def recordings(self) -> tuple[tuple[str, ...], ...]:
        """Every recording that a sense is read from, once, in the order of the file."""
        own = (entry.recording or self.recording for entry in self.senses)
        first = (self.recording,) if self.recording else ()
        return tuple(dict.fromkeys((*first, *own)))

    @property
    def inputs(self) -> list[str]:
        """Files that were read besides the robot and its recording."""
        from bodyschema.cli.reading.pictures import files_of

        files = [name for entry in self.senses for name in entry.recording]
        files += [self.joints.calibration] if self.joints.calibration else []
        files += [part.file.partition("#")[0] for part in self.parts.values() if part.file]
        files += [name for part in (self.wrist, self.pictures) if part for name in part.files]
        patterns = [getattr(entry, key) for entry in self.senses for key in PICTURES]
        return files + [name for pattern in patterns if pattern for name in files_of(pattern)]


def read_run_file(path: Path, verb: str = "calibrate") -> RunFile:
    """Read a run file for a verb; its paths come back absolute.

    Raises:
        InputError: missing, malformed, a key unknown or missing, or of another verb.
    """
    missing = f"no run file at '{path}'; give the path of a TOML file."
    table = toml_file(path, missing, "not valid TOML")
    run = run_from_table(table, path.resolve().parent, f"'{path.name}'")
    if run.hand_eye is not None and verb != "hand-eye":
        raise InputError(
            f"[hand_eye] of '{path.name}' is read by 'bodyschema hand-eye', not by {verb}; leave "
            "it out, and name the robot."
        )
    check_verb(run, verb, f"'{path.name}'")
    return run


def run_from_table(table: Mapping[str, Any], here: Path, where: str) -> RunFile:
    """The run that a table describes; `here` anchors its paths, `where` names it in messages.

    Raises:
        InputError: a key is unknown or missing.
    """
    table = with_lens_parts(take_sections(table, here, where), where)
    entries = {
        **table,
        "robot": _path(table.get("robot"), here),
        "skeleton": _path(table.get("skeleton"), here),
        "recording": files(table.get("recording"), "recording", where, here),
        "joints": joint_columns(table.get("joints", {}), f"[joints] of {where}", here),
        "frames": {
            name: entry_of(FrameEntry, entry, f"[frames.{name}] of {where}")
            for name, entry in section(table.get("frames", {}), f"[frames] of {where}").items()
        },
        "senses": tuple(
            _sense(entry, here, f"[[senses]] {number} of {where}")
            for number, entry in enumerate(_entries(table, "senses", where), start=1)
        ),
        "parts": {
            name: _part(entry, here, f"[parts.{name}] of {where}")
            for name, entry in section(table.get("parts", {}), f"[parts] of {where}").items()
        },
        "wanted": tuple(
            entry_of(WantedEntry, entry, f"[[wanted]] {number} of {where}")
            for number, entry in enumerate(_entries(table, "wanted", where), start=1)
        ),
        "hand_eye": _hand_eye(table.get("hand_eye"), f"[hand_eye] of {where}"),
        "free": entry_of(FreeEntry, table.get("free", {}), f"[free] of {where}"),
        "packages": {
            name: files(folder, name, f"[packages] of {where}", here)[0]
            for name, folder in section(table.get("packages", {}), f"[packages] of {where}").items()
            if _named(folder, name, f"[packages] of {where}")
        },
        "robot_arguments": argument_words(table.get("robot_arguments", {})),
    }
    refuse_unknown(RunFile, entries, where)
    doubted = with_doubted_sizes(entries["parts"], entries["senses"])
    entries["parts"], entries["senses"] = doubted
    ends = with_board_ends(entries["wanted"], entries["senses"], entries["frames"])
    entries["wanted"] = ends
    appended = [
        files(one, "append", where, here)
        for one in listed(entries.get("append"), "append", where, "recordings")
    ]
    entries |= with_appended(entries, appended, where)
    described = bool(entries["robot"]) + bool(entries["skeleton"])
    owned = entries["senses"] and all(entry.recording for entry in entries["senses"])
    needed = described or entries["wrist"] or entries["hand_eye"]
    if not needed or not (entries["recording"] or owned):
        missing = "recording" if needed else "robot"
        raise InputError(f'{where} names no {missing}; add: {missing} = "path".')
    if described > 1:
        raise InputError(f"{where} names a robot and a skeleton; keep the one that you have.")
    for part in ("frames", "parts"):
        if entries["skeleton"] and entries[part]:
            raise InputError(
                f"{where} has [{part}] beside a skeleton; name markers and camera in the "
                "arrangement."
            )
    return entry_of(RunFile, entries, where)


def _hand_eye(table: Any, where: str) -> HandEyeEntry | None:
    return None if table is None else entry_of(HandEyeEntry, table, where)


def _path(named: Any, here: Path) -> Any:
    """The path of a file, "" for none; anything else as it is, to be refused by its type."""
    return str(here / named) if isinstance(named, str) and named else named or ""


def _entries(table: Mapping[str, Any], key: str, where: str) -> list[Any]:
    return listed(table.get(key), key, where, f"sections [[{key}]]")


def _named(name: Any, key: str, where: str) -> bool:
    """Whether it is the name of a file or folder. Raises InputError for what is no name."""
    if not isinstance(name, str):
        raise InputError(f"{key} = {name!r:.80} in {where}; expected a path.")
    return True


def _sense(table: Any, here: Path, where: str) -> SenseEntry:
    from bodyschema.cli.reading.sense_kinds import COMMON, KINDS

    table = section(table, where)
    used = {name: (*COMMON, *kind.keys) for name, kind in KINDS.items()}
    if "kind" in table:
        check_keys(table["kind"], table, used, "senses", where)
    entry = dict(table)
    if "recording" in entry:
        entry["recording"] = files(entry["recording"], "recording", where, here)
    for key in PICTURES:
        if entry.get(key) and _named(entry[key], key, where):
            entry[key] = str(here / entry[key])
    needed = KINDS[table["kind"]].needed if "kind" in table else ()
    for key in needed:
        if key not in table:
            raise InputError(f"{where} lacks the key '{key}', which {table['kind']} need.")
    return entry_of(SenseEntry, entry, where)


def _part(table: Any, here: Path, where: str) -> PartEntry:
    from bodyschema.cli.reading.part_kinds import COMMON, KINDS

    table = section(table, where)
    used = {name: (*COMMON, *kind.keys) for name, kind in KINDS.items()}
    if "kind" in table:
        check_keys(table["kind"], table, used, "parts", where)
    return entry_of(PartEntry, part_with_lens(table, here, where), where)


def run_from_record(record: Mapping[str, Any]) -> RunFile:
    """The run that a result folder's run.json records.

    Raises:
        InputError: it does not say what was seen.
    """
    known = {field.name for field in fields(RunFile)}
    table = {key: value for key, value in record.items() if key in known}
    parts = section(table.get("parts", {}), "parts of run.json")
    table["senses"] = [_given(SenseEntry, e) for e in _entries(table, "senses", "run.json")]
    table["parts"] = {name: _given(PartEntry, entry) for name, entry in parts.items()}
    run = run_from_table(table, Path.cwd(), "run.json")
    if not (run.senses or run.wrist or run.pictures):
        raise InputError("run.json does not say what was seen; calibrate from a run file.")
    return run


def on_recording(run: RunFile, files: tuple[str, ...]) -> RunFile:
    """The same run on a new recording.

    Raises:
        InputError: senses have recordings or pictures of their own, which files do not replace.
    """
    own = [entry for entry in run.senses if entry.recording or entry.masks or entry.images]
    if own:
        raise InputError(
            f"the {own[0].kind} seen from {own[0].seen_from} come from a recording of their own; "
            "give a run file that names the new ones, --recording new.toml."
        )
    return replace(run, recording=files)


def _given(kind: type[Any], entry: Any) -> Any:
    """What a recorded entry says beyond the defaults, which belong to all kinds."""
    usual = {
        f.name: f.default if f.default is not MISSING else f.default_factory for f in fields(kind)
    }
    usual = {k: v() if v in (dict, list) else v for k, v in usual.items()}
    if not isinstance(entry, Mapping):
        return entry
    return {k: v for k, v in entry.items() if k not in usual or frozen(v) != usual[k]}
