"""Answer: what a person gets: verdict, estimate, errors, what is not told, and how to apply it.

    answer = bs.calibrate(body, senses, frames)
    print(answer.summary())
    answer.save("calibrated")                    # corrected URDF, YAML, report, and answer.json
    answer = bs.load("calibrated")               # the same answer on another day
    answer.check(new_senses).changed             # is the robot still the one that was calibrated?
    answer.plan(8, new_senses).q                 # postures that would tell most

`answer.json` holds the whole answer at full precision; what was seen stays in the recording.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema.acting.next_poses import Plan, plan_poses
from bodyschema.answers.loaded import checked
from bodyschema.atomic import found_again
from bodyschema.documents import is_file, json_file, printable, regular_file
from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.export.calibration_yaml import calibration_document
from bodyschema.export.double_zeros import double_zeros
from bodyschema.export.record import decoded
from bodyschema.export.result_folder import (
    ANSWER,
    FORM,
    result_files,
    run_record,
    write_files,
    write_result,
    writing_notes,
)
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.places import FramePlace, places
from bodyschema.judging.settled import settled
from bodyschema.model.tree import Body
from bodyschema.monitoring.change import ChangeTest, detect_change
from bodyschema.report.answer_first import angles, far_off, known, position
from bodyschema.report.section import Section
from bodyschema.report.summary import summary_text
from bodyschema.senses.sense import Sense

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FRAMES = ("pandas", "polars")
"""Packages of data frames."""

MOST_PLACES = 6
"""Frames that `repr` shows."""


@dataclass(frozen=True, repr=False)
class Answer(Calibration):
    """The answer of `calibrate` and `learn_skeleton`, with all that it was made from."""

    verb: str = "calibrate"
    """What was asked."""
    described: Body | None = None
    """The robot as described, without the frames that were attached."""
    run: Mapping[str, Any] = field(default_factory=dict)
    """What was asked, as run.json records it."""
    senses: tuple[Sense, ...] = ()
    """What was seen; not stored: empty in an answer that was loaded."""
    sections: tuple[Section, ...] = ()
    """Of the report, besides those of every answer; not stored."""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """Further files of the result folder, by name; not stored."""

    @classmethod
    def of(
        cls,
        found: Calibration,
        senses: Sequence[Sense],
        described: Body,
        run: Mapping[str, Any] | None = None,
        **more: Any,
    ) -> Answer:
        """An answer from what was found.

        Args:
            found: by the held-out test and the fit.
            senses: what was seen.
            described: the robot as described.
            run: what was asked.
            more: fields that differ from those found.
        """
        fields = {**vars(found), **more}
        notes = [*found.notes, *described.remarks]
        if found.corrects and found.verdict in ("calibrated", "learned"):
            notes += double_zeros(described, found.body)
        fields["notes"] = tuple(notes)
        return cls(**fields, described=described, run=run or {}, senses=tuple(senses))

    @property
    def document(self) -> dict[str, Any]:
        """Everything that was found in plain values, as calibration.yaml has it; for terminals."""
        document = calibration_document(self, writing_notes(self, self._described()))
        made: dict[str, Any] = printable(document)
        return made

    def __repr__(self) -> str:
        """Verdict, how far off, where the frames are: a few lines, for people."""
        return f"<bodyschema Answer of {self.verb}>\n{self._in_short()}"

    def _in_short(self) -> str:
        document = self.document
        far = far_off(document)
        lines = [f"{self.verdict}: {self.explanation}", *([far] if far else [])]
        lines += [f"Trust: {self.trust.level}"] if self.trust.level != "good" else []
        lines += [
            f"{entry['name']}: xyz {position(entry)} mm, rpy {angles(entry)} deg; {known(entry)}"
            for entry in document["transforms"][:MOST_PLACES]
        ]
        more = len(document["transforms"]) - MOST_PLACES
        lines += [f"... and {more} more in .transforms()"] if more > 0 else []
        return "\n".join([*lines, "More: .summary(), .transforms(), .plot(), .save(folder)"])

    def summary(self, width: int = 100, everything: bool = False) -> str:
        """What was asked for, whether to believe it, and what to change, as the terminal shows it.

        Args:
            width: columns of the text.
            everything: also errors before and after, all parameters, what the data cannot tell.
        """
        return summary_text(self.document, width, everything)

    def transforms(self) -> dict[str, FramePlace]:
        """Where the frames are that were asked for, by name ("T_base_camera"): `T`, `sd`, bounds.

        They go with the robot that `to_urdf` writes. Those that were free come first, then what was
        wanted; none where nothing may be put on a robot.
        """
        found = () if self.withheld else places(self)
        return {f"T_{place.parent}_{place.frame}": place for place in found}

    def to_frame(self, package: str = "pandas") -> Any:
        """A data frame with a row for each number that was free: name, group, value, std, unit.

        Args:
            package: "pandas" or "polars", which must be installed.

        Raises:
            InputError: it is not, or is another one.
        """
        if package not in FRAMES:
            raise InputError(f"package = '{package}'{did_you_mean(package, FRAMES)}")
        try:
            frames = importlib.import_module(package)
        except ImportError:
            raise InputError(f"{package} is not installed; run: pip install {package}.") from None
        variables, fit = self.estimate.variables, self.widened
        std = fit.std if len(variables) else fit.x
        return frames.DataFrame(
            {"name": list(variables.names), "group": list(variables.groups), "value": fit.x,
             "std": std, "unit": list(variables.units)}
        )  # fmt: skip

    def _repr_html_(self) -> str:
        """For notebooks: verdict and errors."""
        from bodyschema.report.report import short_html

        return short_html(self, self._described(), self.senses, self.run)

    def plot(self) -> Figure:
        """Held-out errors of every sample before and after, a panel for each thing seen.

        Raises:
            InputError: the answer was loaded, so that what was seen is not there.
            MissingExtraError: matplotlib is not installed.
        """
        from bodyschema.report.evidence import Evidence
        from bodyschema.report.residuals import residual_figure

        evidence = Evidence(self, self._described(), self._seen(), self.run)
        figure: Figure = residual_figure(evidence)
        return figure

    def to_urdf(self, add_frames: bool = False) -> str:
        """The corrected robot: the user's own file with the changed numbers, or one newly written.

        Without a description file it is a tree of bare links and joints, frames and all.

        Args:
            add_frames: also add the frames that were estimated, each a link and a fixed joint.
        """
        source = self._source()
        if source is not None:
            packages = self.run.get("packages", {})
            files = result_files(self, self._described(), source, packages, add_frames)
            return files["robot.urdf"].decode()
        return write_urdf(settled(self).body).decode()

    def save(self, folder: str | Path, overwrite: bool = False) -> list[Path]:
        """Write the result folder, whole or not at all; see `export.result_folder`.

        Args:
            folder: where; new, empty, or with `overwrite` an earlier result.
            overwrite: replace an earlier result.

        Returns:
            The paths of the files. report.html is there if the extra `report` is installed.

        Raises:
            InputError: the folder cannot be written, or holds something else.
        """
        source = self._source()
        more = {**self._report(source), **self.files}
        return write_result(
            self, self._described(), source, Path(folder), self.run, overwrite, more
        )

    def save_into(self, folder: Path) -> list[str]:
        """Write the same files into a folder that is there; returns their names."""
        source = self._source()
        more = {**self._report(source), **self.files}
        return write_files(self, self._described(), source, folder, self.run, more)

    def check(
        self, senses: Sequence[Sense], false_alarm: float = 0.01, least: float | None = None
    ) -> ChangeTest:
        """Whether the body has changed, from new samples; see `monitoring.change`.

        Args:
            senses: the new samples.
            false_alarm: chance of calling an unchanged body changed.
            least: m; a change that moves what is seen by less is none. Half of what noise alone
                leaves open when None.
        """
        least = self.least_change if least is None else least
        return detect_change(self.widened, senses, self.fields, false_alarm, least)

    def plan(self, n: int = 10, senses: Sequence[Sense] = (), seed: int = 0) -> Plan:
        """The next poses that tell most; see `acting.next_poses`.

        Args:
            n: how many.
            senses: what would be seen; the recorded ones when empty.
            seed: of the candidates.
        """
        return plan_poses(self.estimate, tuple(senses) or self._seen(), n, seed=seed)

    def _report(self, source: Path | None) -> dict[str, bytes]:
        if not (self.senses or self.sections):
            return {}
        from bodyschema.report.report import HEADINGS, report_html

        record, nominal = run_record(source, self.run), self._described()
        try:
            heading = HEADINGS.get(self.verb, "").format(nominal.name)
            page = report_html(self, nominal, self.senses, record, self.sections, heading)
        except MissingExtraError:
            return {}
        return {"report.html": page.encode()}

    def _source(self) -> Path | None:
        """The description, if it is still there."""
        source = Path(self._described().source)
        return source if is_file(source) else None

    def _described(self) -> Body:
        return self.fit.reference if self.described is None else self.described

    def _seen(self) -> tuple[Sense, ...]:
        if not self.senses:
            raise InputError(
                "this answer was loaded, and what was seen is not stored with it; give the senses."
            )
        return self.senses


def load(folder: str | Path) -> Answer:
    """Read a result folder back.

    Args:
        folder: that `save` or a verb of the command line wrote, or a file in it.

    Raises:
        InputError: it holds no answer, or one of another version.
    """
    place = Path(folder)
    with suppress(ValueError):  # half a character, which no name on a disk has
        found_again(place)
    path = (place.parent if is_file(place) else place) / ANSWER
    document = _table(path, f"no {ANSWER} in '{folder}'; name a folder that bodyschema wrote.")
    form = document.pop("form", None)
    if form != FORM:
        raise InputError(
            f"'{path}' has form {form!r:.40}, this version reads {FORM}; make it again."
        )
    try:
        answer = checked(decoded(Answer, document))
    except InputError as error:
        raise InputError(f"'{path}' is damaged: {error} Make it again.") from None
    record = path.parent / "run.json"
    missing = f"'{path}' cannot be read without {record.name} beside it; make it again."
    return replace(answer, run=_table(record, missing))


def _table(path: Path, missing: str) -> dict[str, Any]:
    """A table of a result folder."""
    regular_file(path, missing, MOST_BYTES)
    try:
        table = json_file(path, missing, "damaged and cannot be read", MOST_BYTES)
    except InputError as error:
        raise InputError(f"{error} Make it again.") from None
    if not isinstance(table, dict):
        raise InputError(f"'{path}' holds no table of keys; make it again.")
    return table


MOST_BYTES = 1 << 30
"""Of answer.json: residuals of ten million samples."""
