"""`bodyschema export`: put the corrections of a result into another robot description."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from bodyschema.errors import InputError, did_you_mean


@dataclass(frozen=True)
class Export:
    """Apply a calibration to a URDF: a newer version, one with meshes, the original."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that `calibrate` or `track` wrote."""
    robot: Path
    """URDF or xacro with the joints that were calibrated."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("corrected.urdf")
    """File to write; the input is never touched."""
    overwrite: bool = False
    """Replace the file if it is there."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Patch and write; see the module's text."""
        from bodyschema.atomic import new_file
        from bodyschema.export.corrections import read_corrections
        from bodyschema.export.urdf_edits import urdf_edits
        from bodyschema.export.urdf_patch import patch_urdf
        from bodyschema.model.urdf import parse_urdf, urdf_text
        from bodyschema.model.variables import free_joints

        if self.out.resolve() == self.robot.resolve():
            raise InputError(f"'{self.out}' is the input; name another file for the result.")
        if self.out.exists() and not self.overwrite:
            raise InputError(f"'{self.out}' exists; name another file or pass --overwrite.")
        corrections = read_corrections(self.result)
        text = urdf_text(self.robot, {})
        body = parse_urdf(text, self.robot, {})
        variables = free_joints(body)
        unknown = [name for name in corrections if name not in variables.names]
        if unknown:
            hint = did_you_mean(unknown[0], variables.names)
            raise InputError(f"'{self.robot.name}' has no {unknown[0]}{hint}")
        corrected = body.with_variables(
            variables, [corrections.get(n, 0.0) for n in variables.names]
        )
        edits = urdf_edits(body, corrected)
        with new_file(self.out) as temporary:
            temporary.write_bytes(patch_urdf(text, edits))
        if self.json:
            print(json.dumps({"urdf": str(self.out), "joints": sorted(edits)}))
        else:
            print(
                f"Corrected {len(edits)} joints in {self.out}. Next: diff {self.robot} {self.out}"
            )
        return 0
