"""`bodyschema view`: a result in space, to be turned; as a file or on this machine alone."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from bodyschema.documents import is_folder
from bodyschema.errors import BodyschemaError, InputError

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer
    from bodyschema.cli.recall import Recalled
    from bodyschema.view.postures import Recorded


@dataclass(frozen=True)
class View:
    """Turn a result in space: the body before and after, what was seen, how sure it is.

    Without --html the page is served to this machine's browsers alone until Ctrl-C.
    """

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that any verb wrote, except find-body."""
    html: Path | None = None
    """Write the page into this file instead of serving it; it needs no other file, no network."""
    robot: Path | None = None
    """Description with the shapes to draw, when the one of the result has none or is gone."""
    package: tuple[str, ...] = ()
    """NAME=FOLDER of a ROS package that meshes lie in; any number of them."""
    port: int = 0
    """To serve on; any that is free when 0."""
    open: bool = False
    """Open the page in the browser."""
    overwrite: bool = False
    """Replace the file if it is there."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Write or serve the page; returns 0."""
        from bodyschema.answers.answer import load
        from bodyschema.atomic import check_new_file
        from bodyschema.report.report import HEADINGS
        from bodyschema.view.page import page_html
        from bodyschema.view.scene import scene_of

        if self.html is not None:
            check_new_file(self.html, self.overwrite)
        answer = load(self.result)
        if answer.verb == "find-body":
            raise InputError(
                "find-body tells which pixels are the robot, and nothing in space; see its "
                "report.html."
            )
        title = HEADINGS.get(answer.verb, "").format(answer.body.name)
        recalled = self._recalled(answer)
        page = page_html(
            scene_of(
                answer,
                title or f"Calibration of {answer.body.name}",
                recalled.senses,
                recalled.visuals,
                recalled.notes,
                None if any(map(len, recalled.senses)) else _recorded(answer),
            )
        )
        if self.html is None:
            return self._serve(page)
        return self._write(page, self.html)

    def _recalled(self, answer: Answer) -> Recalled:
        """What was recorded, as far as it is at hand; what is not is a note on the page."""
        from bodyschema.cli.recall import Recalled, recall

        named = answer.run.get("packages")
        packages = {**(named if isinstance(named, dict) else {}), **_packages(self.package)}
        try:
            return recall({**answer.run, "packages": packages}, answer.body, self.robot)
        except BodyschemaError as error:
            if self.robot is not None:
                raise
            return Recalled((), (), (f"The run was not read again: {error}",))

    def _write(self, page: str, place: Path) -> int:
        from bodyschema.atomic import new_file

        with new_file(place, self.overwrite) as temporary:
            temporary.write_text(page, encoding="utf-8")
        if self.open:
            _browse(place.resolve().as_uri())
        print(json.dumps({"html": str(place)}) if self.json else f"Open {place} in a browser.")
        return 0

    def _serve(self, page: str) -> int:
        from bodyschema.view.loopback import address, serve

        with serve(page, self.port) as server:
            here = address(server)
            said = f"Open {here} in a browser; Ctrl-C ends it."
            print(json.dumps({"url": here}) if self.json else said, flush=True)
            if self.open:
                _browse(here)
            try:
                server.serve_forever()
            except KeyboardInterrupt:
                print()
        return 0


def _recorded(answer: Answer) -> Recorded | None:
    """The joints' readings of a run whose main sense is pictures or forces; None without."""
    import numpy as np

    from bodyschema.cli.reading.recorded_senses import read_recordings
    from bodyschema.cli.run_file import run_from_record
    from bodyschema.view.postures import Recorded

    try:
        opened = read_recordings(run_from_record(answer.run), answer.body)
    except BodyschemaError:
        return None
    for moments in opened.values():
        if len(moments) and answer.body.joints:
            return Recorded.even(moments.q, moments.first + np.arange(len(moments)))
    return None


def _packages(given: tuple[str, ...]) -> dict[str, str]:
    """NAME=FOLDER by name."""
    found = {}
    for entry in given:
        name, equals, folder = entry.partition("=")
        if not (name and equals and is_folder(Path(folder))):
            raise InputError(
                f"--package takes NAME=FOLDER with a folder that is there, not '{entry}'; for "
                "example --package my_robot=/opt/ros/share/my_robot."
            )
        found[name] = folder
    return found


def _browse(address: str) -> None:
    import webbrowser

    webbrowser.open(address)
