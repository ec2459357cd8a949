"""`bodyschema check`: is what a verb found still true of a new recording?

A few postures are tested as a whole. A recording with times, long and dense enough, is watched as
well: then the answer also says when something changed. A load and a tracked robot are found anew
and compared with what was found before.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from bodyschema.errors import InputError, shown

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer
    from bodyschema.answers.recheck import Recheck
    from bodyschema.cli.run_file import RunFile
    from bodyschema.monitoring.stream_check import StreamCheck


@dataclass(frozen=True)
class Check:
    """Test a result on a new recording: a robot's morning test. Exit code 1 if it changed."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that a verb wrote."""
    recording: tuple[Path, ...]
    """New recording with the same columns; several files are joined row by row. Or a run file that
    says where the new data lie, as pictures always need."""
    false_alarm: float = 0.01
    """Chance of calling what is unchanged changed."""
    least_mm: float | None = None
    """A change that moves what is seen by less does not matter; half of what noise left open in the
    calibration when absent."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Test; returns 1 when something has changed."""
        from bodyschema.answers.answer import load
        from bodyschema.answers.recheck import check_json
        from bodyschema.cli.check_words import describe_changes, describe_check

        if not 0 < self.false_alarm < 1:
            raise InputError(
                f"--false-alarm is a probability, between 0 and 1; got {self.false_alarm}."
            )
        found, stream = self._test(load(self.result))
        changed = found.test.changed or (stream is not None and bool(stream.changes))
        if self.json:
            print(json.dumps(check_json(found, stream)))
        elif stream is not None and stream.changes:
            print(shown(describe_changes(stream)))
        else:
            print(shown(describe_check(found, self.false_alarm)))
        return 1 if changed else 0

    def _test(self, stored: Answer) -> tuple[Recheck, StreamCheck | None]:
        if stored.verb in ("payload", "touch"):
            return self._load(stored), None
        if stored.verb == "track":
            return self._pictures(stored), None
        if stored.verb == "find-body":
            raise InputError(
                f"'{self.result}' is an answer of {stored.verb}, which holds no belief that new "
                f"data could contradict; run {stored.verb} on them and compare."
            )
        return self._senses(stored)

    def _senses(self, stored: Answer) -> tuple[Recheck, StreamCheck | None]:
        """A calibrated robot."""
        from bodyschema.answers.recheck import recheck_senses
        from bodyschema.cli.loading import read_senses

        senses = read_senses(self._run(stored), stored.estimate.reference)
        least = None if self.least_mm is None else self.least_mm / 1e3
        return recheck_senses(stored, senses, self.false_alarm, least)

    def _load(self, stored: Answer) -> Recheck:
        """What a wrist carries."""
        from bodyschema.answers.held_recording import hold
        from bodyschema.answers.recheck import recheck_load
        from bodyschema.cli.reading.wrist_sections import held_tables

        table, _, declared, wrist = held_tables(self._run(stored))
        return recheck_load(stored, hold(table, declared, wrist.motion), self.false_alarm)

    def _pictures(self, stored: Answer) -> Recheck:
        """A robot without markers."""
        from bodyschema.answers.filtered import METHOD
        from bodyschema.answers.recheck import recheck_pictures
        from bodyschema.cli.tracking.album import KEYS, Album, markerless
        from bodyschema.seeds.image_seeds import spread_out

        if stored.learner == METHOD:
            raise InputError(
                f"'{self.result}' was found by the published filter, which has no error bar to "
                "check it against; track without --method, and check that."
            )
        if self.recording[0].suffix != ".toml":
            raise InputError(
                f"'{self.result}' was tracked in pictures, so new pictures are needed to check it: "
                "give the run file that names them, --recording new.toml."
            )
        album = Album.open(self._run(stored)).round(stored.body)
        keys = sorted(spread_out(album.q, KEYS))
        learner, frames = markerless(album), list(album.seen(keys))
        return recheck_pictures(stored, learner, album.variables, frames, self.false_alarm)

    def _run(self, stored: Answer) -> RunFile:
        """The stored run on the new recording, or what a new run file says."""
        from bodyschema.cli.run_file import on_recording, read_run_file, run_from_record

        if self.recording[0].suffix == ".toml":
            return read_run_file(self.recording[0], stored.verb)
        paths = tuple(map(os.path.abspath, self.recording))
        run = run_from_record(stored.run)
        if run.wrist is not None:
            run = replace(run, wrist=replace(run.wrist, empty_recording=""))
        return on_recording(run, paths)
