"""`bodyschema export`: put the corrections of a result into a description, or into recordings."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from bodyschema.errors import InputError, shown

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer


@dataclass(frozen=True)
class Export:
    """Put corrections and loads into a URDF, a recording, or a calibration file of LeRobot.

    One of --robot (a newer version, one with meshes, the original), --recording and --calibration.
    """

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that a verb wrote which corrects joints or knows a load on a link."""
    robot: Path | None = None
    """URDF or xacro with the joints that were calibrated."""
    recording: Path | None = None
    """Write this recording again, its joints' readings corrected; all other columns stay."""
    calibration: Path | None = None
    """Write this calibration file of LeRobot again, its zeros put right; units stay."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """File to write, corrected.urdf, .csv or .json when absent; the input is never touched."""
    add_frames: bool = False
    """Also add the frames that were estimated, each a link and a fixed joint."""
    shift_limits: bool = False
    """The limits are mechanical stops, and move with the joints' zeros."""
    overwrite: bool = False
    """Replace the file that --out names, if it is there."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Patch and write; see the module's text."""
        from bodyschema.answers.answer import load
        from bodyschema.atomic import check_new_file
        from bodyschema.cli.corrected_files import write_motors, write_recording
        from bodyschema.export.result_folder import inputs_of, refuse_inputs

        given = [one for one in (self.robot, self.recording, self.calibration) if one is not None]
        if len(given) != 1:
            raise InputError(
                "name what is to be corrected: --robot arm.urdf, --recording data.csv or "
                "--calibration motors.json; one of them."
            )
        (source,) = given
        out = self.out or Path("corrected").with_suffix(
            ".urdf" if self.robot else ".json" if self.calibration else ".csv"
        )
        check_new_file(out, self.overwrite)
        answer = load(self.result)
        refuse_inputs(out, [source, self.result, *inputs_of(None, answer.run)])
        if self.robot is not None:
            return self._description(answer, self.robot, out)
        write = write_motors if self.calibration is not None else write_recording
        done = write(answer, source, out, self.overwrite)
        if self.json:
            print(json.dumps(done))
        else:
            changed = ", ".join(done.get("columns", done.get("motors", ())))
            print(shown(f"Corrected {changed} in {out}."))
            print(shown("".join(f"{note}\n" for note in done["notes"])), end="")
        return 0

    def _description(self, answer: Answer, robot: Path, out: Path) -> int:
        from bodyschema.atomic import new_file
        from bodyschema.export.corrections import corrected_body, corrected_urdf
        from bodyschema.export.double_zeros import double_zeros
        from bodyschema.export.static_transforms import added_frames
        from bodyschema.export.urdf_frames import with_frames
        from bodyschema.model.urdf import parse_urdf, urdf_text

        packages = answer.run.get("packages", {})
        text = urdf_text(robot, packages, answer.run.get("robot_arguments", {}))
        nominal = parse_urdf(text, robot, packages)
        patched, changed = corrected_urdf(answer, text, nominal, self.shift_limits)
        if self.add_frames:
            patched = with_frames(patched, added_frames(answer, nominal))
        notes = double_zeros(nominal, corrected_body(answer, nominal))
        with new_file(out, self.overwrite) as temporary:
            temporary.write_bytes(patched)
        if self.json:
            print(json.dumps({"urdf": str(out), "joints": changed, "notes": notes}))
        else:
            diff = shlex.join(["diff", str(robot), str(out)])
            print(shown(f"Corrected {len(changed)} joints in {out}. Next: {diff}"))
            print(shown("".join(f"{note}\n" for note in notes)), end="")
        return 0
