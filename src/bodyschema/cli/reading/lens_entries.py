"""Lenses of a run file that stand in files of their own: see `model.lens_file`.

    [parts.eye]                             # a part, with what else belongs to it
    kind = "lens"
    file = "camera_info.yaml"
    known = "exactly"

    [[senses]]
    lens = "camera_info.yaml"               # or at once: the part "camera_info_lens", known roughly

    [cameras.left]
    lens = "camera_info.yaml"               # with size and distortion

A record of the run holds the numbers, so that the file is not needed again.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bodyschema.errors import InputError
from bodyschema.model.lens_file import MARK, is_lens_file, read_lens

NUMBERS = ("fx", "fy", "cx", "cy")
OF_FILE = (*NUMBERS, "distortion", "model", "size")
"""Keys of a part that a file says."""


def part_with_lens(table: Mapping[str, Any], here: Path, where: str) -> Mapping[str, Any]:
    """A [parts] section with the numbers of its file.

    Args:
        table: the section.
        here: anchors the path of the file.
        where: names it in messages.

    Raises:
        InputError: the file holds no lens, or the section says what the file says, too.
    """
    file = table.get("file")
    if not isinstance(file, str) or not file:
        return table
    if all(key in table for key in NUMBERS):  # a record, in which it was read
        return table
    said = [key for key in (*OF_FILE, "fov_deg") if key in table and key != "size"]
    if said:
        raise InputError(f"{said[0]} in {where} is said by its file already; leave it out.")
    path = str(here / file)
    lens = read_lens(path)
    size = lens.size or table.get("size")
    if lens.size and table.get("size") not in (None, list(lens.size)):
        raise InputError(
            f"size = {table['size']!r:.40} in {where}, and pictures of '{file}' have "
            f"{list(lens.size)}; a lens is of pictures as they were taken."
        )
    numbers = dict(zip(NUMBERS, lens.intrinsics, strict=True))
    more = {"size": list(size)} if isinstance(size, list | tuple) else {}
    model = {"model": lens.model, "distortion": list(lens.distortion)} if lens.distortion else {}
    return {**table, **numbers, **model, **more, "file": path}


def with_lens_parts(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """A run file whose senses name parts alone: a lens file is a part of its own name.

    Raises:
        InputError: a part has that name already.
    """
    senses, parts = table.get("senses"), table.get("parts", {})
    if not isinstance(senses, list) or not isinstance(parts, Mapping):
        return dict(table)
    made: dict[str, Any] = {}
    entries = []
    for entry in senses:
        file = entry.get("lens") if isinstance(entry, Mapping) else None
        if not isinstance(file, str) or file in parts or not is_lens_file(file):
            entries.append(entry)
            continue
        path, _, camera = file.partition(MARK)
        name = "_".join(word for word in (Path(path).stem, camera, "lens") if word)
        if name in parts or made.get(name, {"file": file})["file"] != file:
            raise InputError(
                f"lens = '{file}' of {where} would be the part '{name}', which is there already; "
                "write a section [parts.NAME] with file = "
                f'"{file}", and name that.'
            )
        made[name] = {"kind": "lens", "file": file}
        entries.append({**entry, "lens": name})
    return {**table, "senses": entries, "parts": {**parts, **made}} if made else dict(table)


def camera_with_lens(table: Any, here: Path, where: str) -> Any:
    """A [cameras] section with the numbers of its lens file, if it names one.

    Raises:
        InputError: the file holds no lens, or the section says what the file says, too.
    """
    file = table.get("lens") if isinstance(table, Mapping) else None
    if not isinstance(file, str):
        return table
    said = [key for key in ("distortion", "model") if key in table]
    if said:
        raise InputError(f"{said[0]} in {where} is said by '{file}' already; leave it out.")
    path = str(here / file)
    lens = read_lens(path)
    size = list(lens.size) if lens.size else table.get("size")
    if size is None or table.get("size", size) != size:
        raise InputError(
            f"{where} needs size = [width, height] of its pictures"
            + (f", and those of '{file}' have {list(lens.size)}." if lens.size else ".")
        )
    given = {"lens": list(lens.intrinsics), "distortion": list(lens.distortion), "file": path}
    return {**table, **given, "size": size, **({"model": lens.model} if lens.distortion else {})}
