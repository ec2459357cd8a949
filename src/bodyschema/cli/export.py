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
    """Put corrections into a robot description, a recording, a lens file, or LeRobot's.

    One of --robot (a newer version, one with meshes, the original), --recording, --calibration and
    --lens. A description goes out as the ending of --out says: .urdf, or .xml for MJCF.
    """

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that a verb wrote which corrects joints or knows a load on a link."""
    robot: Path | None = None
    """Description with the joints that were calibrated: URDF, xacro, MJCF, or a table."""
    recording: Path | None = None
    """Write this recording again, its joints' readings corrected; all other columns stay."""
    calibration: Path | None = None
    """Write this calibration file of LeRobot again, its zeros put right; units stay."""
    lens: str | None = None
    """Write this lens: .yaml is camera_info of ROS, .yml OpenCV's."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """File to write, `corrected` with an ending when absent; the input is never touched."""
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
        from bodyschema.model.description import is_mjcf

        kinds = {"robot": ".urdf", "recording": ".csv", "calibration": ".json", "lens": ".yaml"}
        given = [name for name in kinds if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(
                "name what is to be corrected: --robot arm.urdf, --recording data.csv, "
                "--calibration motors.json or --lens camera; one of them."
            )
        ending = ".xml" if self.robot and is_mjcf(self.robot) else kinds[given[0]]
        out = self.out or Path("corrected").with_suffix(ending)
        check_new_file(out, self.overwrite)
        answer = load(self.result)
        read = [one for one in (self.robot, self.recording, self.calibration) if one is not None]
        refuse_inputs(out, [*read, self.result, *inputs_of(None, answer.run)])
        if self.robot is not None:
            return self._description(answer, self.robot, out)
        if self.lens is not None:
            return self._lens(answer, self.lens, out)
        (source,) = read
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
        from bodyschema.export.corrected_descriptions import corrected_description

        packages = answer.run.get("packages", {})
        arguments = answer.run.get("robot_arguments", {})
        made = corrected_description(
            answer, robot, out, packages, arguments, self.add_frames, self.shift_limits
        )
        with new_file(out, self.overwrite) as temporary:
            temporary.write_bytes(made.text)
        if self.json:
            told = {made.kind: str(out), "joints": made.changed, "notes": made.notes}
            print(json.dumps(told))
        else:
            diff = shlex.join(["diff", str(robot), str(out)])
            after = f" Next: {diff}" if made.patched else ""
            print(shown(f"Corrected {len(made.changed)} joints in {out}.{after}"))
            print(shown("".join(f"{note}\n" for note in made.notes)), end="")
        return 0

    def _lens(self, answer: Answer, name: str, out: Path) -> int:
        from bodyschema.atomic import new_file
        from bodyschema.export.lens_files import lens_text

        with new_file(out, self.overwrite) as temporary:
            temporary.write_text(lens_text(answer, name, answer.run, out.suffix), encoding="utf-8")
        if self.json:
            print(json.dumps({"lens": name, "file": str(out)}))
        else:
            print(shown(f"Lens '{name}' in {out}."))
        return 0
