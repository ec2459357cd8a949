"""Sections of the run file that only some verbs read, and the words for those that do not."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile

READERS = {
    "wrist": ("payload", "touch"),
    "pictures": ("track",),
}
"""Verbs that read what a run says of a wrist, and of pictures without markers."""

INSTEAD = {
    "wrist": 'for calibrate, describe it as [[senses]] with kind = "wrenches"',
    "pictures": 'for calibrate, describe it as [[senses]] with kind = "outlines"',
}


def take_sections(table: Mapping[str, Any], here: Path, where: str) -> dict[str, Any]:
    """The table with "wrist" and "pictures" in place of the sections that they are made of.

    Args:
        table: of a run file, or of run.json, in which they are made already.
        here: anchors its paths.
        where: names it in messages.

    Raises:
        InputError: a key is unknown or missing.
    """
    from bodyschema.cli.entry_types import section
    from bodyschema.cli.reading import picture_sections, wrist_sections

    inner = [section(table.get(key) or {}, f"{key} of {where}") for key in ("wrist", "pictures")]
    rest = {**table, **inner[0], **inner[1]}
    wrist = {k: rest.pop(k) for k in (*wrist_sections.SECTIONS, *wrist_sections.KEYS) if k in rest}
    pictures = {k: rest.pop(k) for k in ("cameras", "doubts", *picture_sections.KEYS) if k in rest}
    rest["wrist"] = wrist_sections.read_sections(wrist, here, where) if wrist else None
    rest["pictures"] = picture_sections.read_sections(pictures, here, where) if pictures else None
    return rest


def check_verb(run: RunFile, verb: str, where: str) -> None:
    """Refuse sections that a verb does not read, and a run without those that it needs.

    Raises:
        InputError: in one sentence.
    """
    from bodyschema.cli.reading.picture_sections import check_pictures
    from bodyschema.cli.reading.touch_sections import check_touch
    from bodyschema.cli.reading.wrist_sections import check_wrist

    for name, verbs in READERS.items():
        given = getattr(run, name)
        if given is not None and verb not in verbs:
            section = "[wrench]" if name == "wrist" else "[cameras]"
            raise InputError(
                f"{section} of {where} is read by 'bodyschema {' and '.join(verbs)}', not by "
                f"{verb}; {INSTEAD[name]}, or leave it out."
            )
    if run.senses and verb in ("payload", "touch", "track"):
        raise InputError(
            f"[[senses]] of {where} are read by 'bodyschema calibrate', not by {verb}; leave them "
            "out."
        )
    checks = {"payload": (check_wrist,), "touch": (check_wrist, check_touch)}
    checks["track"] = (check_pictures,)
    for check in checks.get(verb, ()):
        check(run, where)
    widened = run.free.offset_deg is not None or run.free.offset_mm is not None
    if widened and verb != "track":
        raise InputError(
            f"offset_deg and offset_mm in [free] of {where} are read by 'bodyschema track', not by "
            f"{verb}; leave them out."
        )
