"""`bodyschema payload`: wrist force/torque + motion -> what hangs on the wrist, with error bars."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from bodyschema.atomic import new_folder

if TYPE_CHECKING:
    from bodyschema.cli.wrist.held_recording import HeldRecording


@dataclass(frozen=True)
class PayloadVerb:
    """Find mass, centre of mass and inertia of what a wrist carries (see docs/payload.md).

    Exit code 1 if the motion does not tell the mass or the centre of mass.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN.toml")]
    """The recording, and which columns are what."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("payload")
    """Folder for payload.yaml, report.html and the URDF; must not hold anything yet."""
    calibration: Path | None = None
    """A calibration.yaml (or its folder) that the payload is entered into; a copy is written."""
    overwrite: bool = False
    """Replace the output folder."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Read, fit, write; returns 1 when mass or centre of mass is not told."""
        from bodyschema.cli.wrist.held_recording import identify
        from bodyschema.cli.wrist.payload_answer import describe, payload_answer, told
        from bodyschema.cli.wrist.payload_file import read_payload_file
        from bodyschema.export.result_folder import check_place, refuse_inputs

        run = read_payload_file(self.run_file)
        files = (run.robot, run.empty_recording, *run.recording)
        inputs = [Path(name) for name in files if name]
        refuse_inputs(self.out, [self.run_file, *inputs])
        check_place(self.out, self.overwrite, "payload.yaml")
        held = identify(run)
        answer = payload_answer(held)
        with new_folder(self.out, self.overwrite) as folder:
            self._write(folder, held, answer, asdict(run))
        print(json.dumps(answer) if self.json else describe(answer, self.out))
        return 0 if told(answer) else 1

    def _write(
        self, folder: Path, held: HeldRecording, answer: dict[str, Any], run: dict[str, Any]
    ) -> None:
        from bodyschema.export.payload import entered, payload_text, urdf_with_load
        from bodyschema.report.payload import payload_html

        (folder / "payload.yaml").write_text(payload_text(answer), encoding="utf-8")
        (folder / "run.json").write_text(json.dumps(run, indent=1) + "\n", encoding="utf-8")
        if self.calibration is not None:
            text = entered(self.calibration, answer)
            (folder / "calibration.yaml").write_text(text, encoding="utf-8")
        if held.run.robot and held.run.sensor.link and Path(held.run.robot).suffix == ".urdf":
            source = Path(held.run.robot).read_bytes()
            loads = {load["name"]: load["flange"] for load in answer["loads"]}
            patched = urdf_with_load(source, held.run.sensor.link, loads)
            (folder / "robot.urdf").write_bytes(patched)
        page = payload_html(held.fit, answer, held.events)
        (folder / "report.html").write_text(page, encoding="utf-8")
