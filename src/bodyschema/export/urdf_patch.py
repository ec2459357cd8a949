"""Change joint placements, axes and limits in a URDF, and not one byte more.

Writers that parse a URDF into a tree and print it again lose comments, gazebo, transmission or
ros2_control elements, and reformat the rest. Here expat only tells at which byte each element
starts and ends; the new numbers are spliced into the user's own bytes, so `git diff` shows the
changed attributes and nothing else. Only `<joint>` directly under `<robot>` is a joint of the
body: ros2_control and transmission hold elements of the same name. A number that a reader
already takes from the file, be it written or the URDF's default, is left as it stands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

from bodyschema.errors import InputError, did_you_mean
from bodyschema.export.joint_edit import DEFAULTS, JointEdit, clean, nearest_rpy
from bodyschema.model.urdf_xml import lenient

__all__ = ["JointEdit", "patch_urdf"]

Change = tuple[int, int, bytes]  # the bytes from start to end become the text

_START_TAG = re.compile(rb"<[^\s/>]+(?:\s+[^\s=]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*(\s*/?>)")
_ATTRIBUTE = re.compile(rb"(\s+)([^\s=]+)\s*=\s*([\"'])(.*?)\3", re.DOTALL)
_LINE_COMMENTS = re.compile(rb"(?:[ \t]*<!--(?:(?!-->)[^\r\n])*-->)+(?=[ \t]*[\r\n])")
_TOKEN = re.compile(rb"\S+")
_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_UTF16 = {b"\xff\xfe": "le", b"<\0": "le", b"\xfe\xff": "be", b"\0<": "be"}
_STATED_LIMITS = {
    "limit": ("lower", "upper"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit"),
}
"""Elements and attributes of a joint that are values of its coordinate, rad or metres."""


def patch_urdf(source: bytes, edits: Mapping[str, JointEdit]) -> bytes:
    """Return the URDF with the edited attributes replaced and every other byte kept.

    Args:
        source: The URDF file as read from disk, in any encoding that expat reads.
        edits: New values by joint name. With no edits the same bytes come back.

    Raises:
        InputError: The file is not a well-formed URDF or names a joint twice; or an edit is
            for a joint that is not there, or for the limits of a joint without `<limit>`.
    """
    byte_order = _UTF16.get(source[:2])
    if byte_order is None:
        return _patch(source, edits)
    try:  # through UTF-8, where ASCII stays ASCII; the byte order mark comes along
        recoded = source.decode(f"utf-16-{byte_order}").encode()
    except UnicodeDecodeError as error:
        raise InputError(f"the URDF starts like UTF-16 but is not: {error}.") from error
    return _patch(recoded, edits, encoding="utf-8").decode().encode(f"utf-16-{byte_order}")


def _patch(source: bytes, edits: Mapping[str, JointEdit], encoding: str | None = None) -> bytes:
    joints = _JointFinder(encoding).find(source)
    changes: list[Change] = []
    for name, edit in edits.items():
        if name not in joints:
            raise InputError(f"no joint '{name}' in the URDF{did_you_mean(name, joints)}")
        changes += _joint_changes(source, joints[name], name, edit)
    pieces, done = [], 0
    for start, end, text in sorted(changes, key=lambda change: change[0]):
        pieces += [source[done:start], text]
        done = end
    return b"".join([*pieces, source[done:]])


@dataclass
class _Element:
    """One element of the file, at the byte offsets that expat reports."""

    tag: str
    attributes: Mapping[str, str]
    start: int
    line: int
    end: int = -1
    """Where `</tag>` starts; for `<tag/>` the byte after it."""
    children: list[_Element] = field(default_factory=list)


class _JointFinder:
    """Collects the joints directly under `<robot>` while expat walks through the file."""

    def __init__(self, encoding: str | None) -> None:
        self._joints: dict[str, _Element] = {}
        self._open: list[_Element] = []
        self._parser = expat.ParserCreate(encoding)
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def find(self, source: bytes) -> dict[str, _Element]:
        """Return the place of each joint by its name."""
        try:
            self._parser.Parse(lenient(source), True)
        except (expat.ExpatError, LookupError, ValueError) as error:  # the XML, or its encoding
            raise InputError(f"cannot read the URDF as XML: {error}.") from error
        return self._joints

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        place = self._parser.CurrentByteIndex, self._parser.CurrentLineNumber
        element = _Element(tag, attributes, *place)
        if self._open:
            self._open[-1].children.append(element)
        elif tag != "robot":
            raise InputError(f"not a URDF: the root element is <{tag}>, expected <robot>.")
        if len(self._open) == 1 and tag == "joint" and "name" in attributes:
            name = attributes["name"]
            first = self._joints.setdefault(name, element)
            if first is not element:
                raise InputError(f"two joints '{name}', lines {first.line} and {element.line}.")
        self._open.append(element)

    def _end(self, tag: str) -> None:
        self._open.pop().end = self._parser.CurrentByteIndex


def _joint_changes(source: bytes, joint: _Element, name: str, edit: JointEdit) -> Iterator[Change]:
    added = []
    for tag, wanted in edit.numbers().items():
        # Of several elements with one tag, readers take the first.
        element = next((child for child in joint.children if child.tag == tag), None)
        if element is not None:
            for attribute, numbers in wanted.items():
                if attribute == "rpy":
                    numbers = _as_written(element, numbers)
                yield from _attribute_changes(source, element, attribute, numbers)
        elif tag == "limit" and wanted:
            raise InputError(f"joint '{name}' has no <limit>: leave lower and upper None.")
        elif any(numbers != DEFAULTS[tag, key] for key, numbers in wanted.items()):
            written = (b' %b="%b"' % (key.encode(), _text(xs)) for key, xs in wanted.items())
            added.append(b"<%b%b/>" % (tag.encode(), b"".join(written)))
    if added:
        yield _addition(source, joint, added)
    if edit.shift_limits is not None and joint.attributes.get("type") != "continuous":
        yield from _shifted_limits(source, joint, name, edit.shift_limits)


def _as_written(origin: _Element, rpy: tuple[float, ...]) -> tuple[float, ...]:
    """The angles on the branch of those that are written."""
    words = origin.attributes.get("rpy", "0 0 0").split()
    try:
        r, p, y = map(float, words)
    except ValueError:
        return rpy
    near = nearest_rpy((rpy[0], rpy[1], rpy[2]), (r, p, y))
    return tuple(map(clean, near))


def _shifted_limits(source: bytes, joint: _Element, name: str, shift: float) -> Iterator[Change]:
    """Add the shift to the limits that are written; of a pair with one end, also to the other."""
    for tag, pair in _STATED_LIMITS.items():
        element = next((child for child in joint.children if child.tag == tag), None)
        if element is None or not any(attribute in element.attributes for attribute in pair):
            continue
        for attribute in pair:
            written = element.attributes.get(attribute, "0")
            try:
                limit = float(written)
            except ValueError:
                raise InputError(
                    f"<{tag} {attribute}> of joint '{name}' is '{written}', expected a number."
                ) from None
            if math.isfinite(limit):
                yield from _attribute_changes(source, element, attribute, (clean(limit + shift),))


def _attribute_changes(
    source: bytes, element: _Element, name: str, numbers: tuple[float, ...]
) -> Iterator[Change]:
    """Replace the numbers that differ, or write the attribute after the last one."""
    tag_end = _start_tag(source, element).end()
    attributes = list(_ATTRIBUTE.finditer(source, element.start, tag_end))
    old = next((match for match in attributes if match[2] == name.encode()), None)
    if old is not None:
        tokens = [match.span() for match in _TOKEN.finditer(source, *old.span(4))]
        if len(tokens) != len(numbers):
            yield *old.span(4), _text(numbers)
            return
        for (start, end), number in zip(tokens, numbers, strict=True):
            token = _NUMBER.fullmatch(source, start, end)
            if token is None or clean(float(token[0])) != number:
                yield start, end, _text((number,))
    elif numbers != DEFAULTS.get((element.tag, name), (0.0,)):
        at = attributes[-1].end() if attributes else element.start + 1 + len(element.tag)
        gap, quote = attributes[-1].group(1, 3) if attributes else (b" ", b'"')
        yield at, at, gap + name.encode() + b"=" + quote + _text(numbers) + quote


def _addition(source: bytes, joint: _Element, elements: list[bytes]) -> Change:
    """Add the elements below the joint's links (and origin), indented like these."""
    tag = _start_tag(source, joint)
    siblings = [child for child in joint.children if child.tag in ("parent", "child", "origin")]
    if joint.children:
        last = (siblings or joint.children)[-1]
        gap = _gap_before(source, last.start, tag.end())
        at = last.end
        if not _start_tag(source, last)[1].endswith(b"/>"):
            at = source.index(b">", last.end) + 1
        comments = _LINE_COMMENTS.match(source, at)
        if comments:  # what stands on the sibling's line is about the sibling
            at = comments.end()
        return at, at, b"".join(gap + element for element in elements)
    outer = _gap_before(source, joint.start, 0)
    inner = outer + outer.lstrip(b"\r\n")
    body = b"".join(inner + element for element in elements)
    if tag[1].endswith(b"/>"):
        return tag.start(1), tag.end(), b">" + body + outer + b"</joint>"
    return tag.end(), tag.end(), body + (outer if joint.end == tag.end() else b"")


def _start_tag(source: bytes, element: _Element) -> re.Match[bytes]:
    match = _START_TAG.match(source, element.start)
    if match is None:  # expat then points at the entity's `&`
        raise InputError(f"line {element.line}: <{element.tag}> is in an entity; write it out.")
    return match


def _gap_before(source: bytes, position: int, floor: int) -> bytes:
    """Line break and indentation of the line at position, or the spaces there if one line."""
    at = max(source.rfind(b"\n", floor, position), source.rfind(b"\r", floor, position))
    if at < 0:
        head = source[floor:position]
        return head[len(head.rstrip()) :]
    line = source[at + 1 : position]
    indent = line[: len(line) - len(line.lstrip(b" \t"))]
    return (b"\r\n" if source[at - 1 : at + 1] == b"\r\n" else source[at : at + 1]) + indent


def _text(numbers: tuple[float, ...]) -> bytes:
    return " ".join(map(repr, numbers)).encode()
