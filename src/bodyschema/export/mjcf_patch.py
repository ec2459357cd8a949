"""Change attributes of named elements of an MJCF, and keep every other byte; see `urdf_patch`.

Elements are those below <worldbody>: <default>, <equality> and <sensor> have others of the same
tags. What stands in an included file is not here, and is refused by name.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.urdf_xml import lenient

_START_TAG = re.compile(rb"<[^\s/>]+((?:\s+[^\s=]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*)(\s*/?>)")
_ATTRIBUTE = re.compile(rb"\s+([^\s=]+)\s*=\s*(?:\"[^\"]*\"|'[^']*')", re.DOTALL)

TURNS = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
"""Attributes that say how an element is turned, of which it may have one."""

FOLDERS = ("meshdir", "texturedir", "assetdir")


@dataclass
class _Element:
    tag: str
    attributes: dict[str, str]
    start: int
    framed: bool
    """Whether it stands in a <frame>, which its place is relative to."""


class MjcfPatch:
    """Changes of a file, made when `text` is called."""

    def __init__(self, source: bytes, name: str) -> None:
        """Find the elements. Raises InputError for what is no XML."""
        self._source, self._name = source, name
        self._found: dict[tuple[str, str], _Element] = {}
        self._others: list[_Element] = []
        self._open: list[str] = []
        self._of_files = False
        self._set: dict[int, dict[str, str]] = {}
        self._dropped: dict[int, set[str]] = {}
        self._children: dict[int, list[str]] = {}
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        try:
            self._parser.Parse(lenient(source), True)
        except (expat.ExpatError, LookupError, ValueError) as error:
            raise InputError(f"cannot read '{name}' as XML: {error}.") from error

    def has(self, tag: str, name: str) -> bool:
        """Whether the file has an element of that name."""
        return (tag, name) in self._found

    def set(self, tag: str, name: str, attributes: Mapping[str, str]) -> None:
        """Give an element other values. Raises InputError if it is not in the file."""
        self._set.setdefault(self._element(tag, name).start, {}).update(attributes)

    def place(self, tag: str, name: str, place: Mapping[str, str]) -> None:
        """Give an element another place, by `pos` and `quat`.

        Raises:
            InputError: it is not in the file, or stands in a <frame>.
        """
        element = self._element(tag, name)
        if element.framed:
            raise InputError(
                f"<{tag}> '{name}' of '{self._name}' stands in a <frame>; write its place without "
                "one, or export a URDF, --out corrected.urdf."
            )
        self.set(tag, name, place)
        self._dropped.setdefault(element.start, set()).update(set(TURNS) - {*place})

    def add_child(self, tag: str, name: str, child: str, attributes: Mapping[str, str]) -> None:
        """Put an element of nothing into another, first of all."""
        if (child, attributes["name"]) in self._found:
            raise InputError(f"the MJCF has a {child} '{attributes['name']}' already; rename it.")
        text = "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
        start = self._element(tag, name).start
        self._children.setdefault(start, []).append(f"<{child}{text}/>")

    def anchor(self, folder: Path) -> None:
        """Name the folders of meshes, and files that are included, in full."""
        compilers = [one for one in self._others if one.tag == "compiler"]
        for element in self._others:
            keys = ("file",) if element.tag == "include" else FOLDERS
            given = {key: element.attributes[key] for key in keys if key in element.attributes}
            full = {key: str(folder / value) for key, value in given.items()}
            if full and element.tag != "mujoco":
                self._set.setdefault(element.start, {}).update(full)
        if self._of_files and not any(
            key in one.attributes for one in compilers for key in FOLDERS
        ):
            root = next(one for one in self._others if one.tag == "mujoco")
            text = (
                f"<compiler meshdir={quoteattr(str(folder))} texturedir={quoteattr(str(folder))}/>"
            )
            self._children.setdefault(root.start, []).append(text)

    def text(self) -> bytes:
        """The file with all changes."""
        changes = []
        for start in {*self._set, *self._dropped, *self._children}:
            match = _START_TAG.match(self._source, start)
            if match is None:
                raise InputError(f"an element of '{self._name}' is in an entity; write it out.")
            changes.append((match.start(), match.end(), self._tag(start, match)))
        pieces, done = [], 0
        for start, end, text in sorted(changes):
            pieces += [self._source[done:start], text]
            done = end
        return b"".join([*pieces, self._source[done:]])

    def _tag(self, start: int, match: re.Match[bytes]) -> bytes:
        """The start tag at a byte, with its changes and its new children."""
        new = {key.encode(): value for key, value in self._set.get(start, {}).items()}
        dropped = {key.encode() for key in self._dropped.get(start, ())}
        head = self._source[start : match.start(1)]
        for one in _ATTRIBUTE.finditer(match[1]):
            if one[1] in new:
                gap = one[0][: len(one[0]) - len(one[0].lstrip())]
                head += gap + one[1] + b"=" + quoteattr(new.pop(one[1])).encode()
            elif one[1] not in dropped:
                head += one[0]
        for key, value in new.items():
            head += b" " + key + b"=" + quoteattr(value).encode()
        children = "".join(self._children.get(start, ())).encode()
        if children and match[2].endswith(b"/>"):
            name = self._source[start + 1 : match.start(1)]
            return head + b">" + children + b"</" + name + b">"
        return head + match[2] + children

    def _element(self, tag: str, name: str) -> _Element:
        element = self._found.get((tag, name))
        if element is None:
            names = [other for kind, other in self._found if kind == tag]
            raise InputError(
                f"'{self._name}' has no <{tag}> '{name}' itself, unless in a file that it includes "
                f"or without a name{did_you_mean(name, names)}"
            )
        return element

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        above = [one for one in self._open if one in ("body", "frame", "worldbody", "replicate")]
        framed = bool(above) and above[-1] not in ("body", "worldbody")
        element = _Element(tag, attributes, self._parser.CurrentByteIndex, framed)
        self._of_files |= "file" in attributes
        if "worldbody" in self._open and "name" in attributes:
            self._found.setdefault((tag, attributes["name"]), element)
        elif tag in ("mujoco", "compiler", "include"):
            self._others.append(element)
        self._open.append(tag)

    def _end(self, _tag: str) -> None:
        self._open.pop()
