"""What to do with recordings of kinds that are not read: a sentence each, with the way there."""

from __future__ import annotations

from pathlib import Path

from bodyschema.documents import is_folder

_PICTURES = (
    "it holds pictures, and nothing here finds a board in them; find its corners and poses with "
    "OpenCV and write a table of them, a row a picture (docs/board_photographs.md has the script)."
)
_ARRAYS = (
    "write its numbers into a CSV table with a line of column names, bodyschema.sources.tables."
    "write_table(path, columns)."
)

_WAYS = {
    **dict.fromkeys((".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"), _PICTURES),
    **dict.fromkeys((".json", ".mat", ".h5", ".hdf5", ".xlsx", ".pkl"), _ARRAYS),
}


def conversion(path: Path) -> str:
    """How a recording of this kind becomes a table; "" where nobody knows.

    Args:
        path: a file, a pattern of files, or a folder.
    """
    if path.suffix.lower() not in _WAYS and is_folder(path):
        inside = sorted({file.suffix.lower() for file in path.iterdir()})
        return next((_WAYS[suffix] for suffix in inside if suffix in _WAYS), "")
    return _WAYS.get(path.suffix.lower(), "")
