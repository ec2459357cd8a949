"""`bodyschema export`: put the corrections of a result into another robot description."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from bodyschema.errors import shown


@dataclass(frozen=True)
class Export:
    """Put corrections and loads into a URDF: a newer version, one with meshes, the original."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that a verb wrote which corrects joints or knows a load on a link."""
    robot: Path
    """URDF or xacro with the joints that were calibrated."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("corrected.urdf")
    """File to write; the input is never touched."""
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
        from bodyschema.atomic import check_new_file, new_file
        from bodyschema.export.corrections import corrected_body, corrected_urdf
        from bodyschema.export.double_zeros import double_zeros
        from bodyschema.export.result_folder import inputs_of, refuse_inputs
        from bodyschema.export.static_transforms import added_frames
        from bodyschema.export.urdf_frames import with_frames
        from bodyschema.model.urdf import parse_urdf, urdf_text

        check_new_file(self.out, self.overwrite)
        answer = load(self.result)
        refuse_inputs(self.out, [self.robot, self.result, *inputs_of(None, answer.run)])
        packages = answer.run.get("packages", {})
        text = urdf_text(self.robot, packages, answer.run.get("robot_arguments", {}))
        nominal = parse_urdf(text, self.robot, packages)
        patched, changed = corrected_urdf(answer, text, nominal, self.shift_limits)
        if self.add_frames:
            patched = with_frames(patched, added_frames(answer, nominal))
        notes = double_zeros(nominal, corrected_body(answer, nominal))
        with new_file(self.out, self.overwrite) as temporary:
            temporary.write_bytes(patched)
        if self.json:
            print(json.dumps({"urdf": str(self.out), "joints": changed, "notes": notes}))
        else:
            diff = shlex.join(["diff", str(self.robot), str(self.out)])
            print(shown(f"Corrected {len(changed)} joints in {self.out}. Next: {diff}"))
            print(shown("".join(f"{note}\n" for note in notes)), end="")
        return 0
