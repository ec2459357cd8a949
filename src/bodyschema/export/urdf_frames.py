"""Add frames to a URDF: each a link of nothing and a fixed joint, before the robot's end tag.

Every other byte stays as it is; see `urdf_patch`.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.joint_edit import clean
from bodyschema.judging.places import FramePlace
from bodyschema.model.urdf_xml import lenient

INDENT = "  "
"""Of an element directly under <robot>."""


def with_frames(source: bytes, frames: Sequence[FramePlace]) -> bytes:
    """The URDF with these frames added.

    Args:
        source: the file as read from disk, in an encoding that holds ASCII.
        frames: what to add; a parent comes before what hangs on it.

    Raises:
        InputError: the file is not a well-formed URDF, or a frame's name is taken or its parent is
            missing.
    """
    if not frames:
        return source
    outline = _Outline()
    end = outline.read(source)
    for frame in frames:
        if frame.frame in outline.links or joint_name(frame.frame) in outline.joints:
            raise InputError(
                f"the URDF has a link or joint of the name of '{frame.frame}' already; "
                "leave out --add-frames, or rename the frame."
            )
        if frame.parent not in outline.links:
            raise InputError(f"the URDF has no link '{frame.parent}' for '{frame.frame}'.")
        outline.links.add(frame.frame)
    newline = "\r\n" if b"\r\n" in source else "\n"
    lines = [INDENT + line for frame in frames for line in _lines(frame)]
    added = "".join(line + newline for line in lines).encode("ascii", "xmlcharrefreplace")
    before = source[:end]
    gap = b"" if before.endswith((b"\n", b"\r")) else newline.encode()
    return before + gap + added + source[end:]


def joint_name(frame: str) -> str:
    """Of the fixed joint that carries a frame."""
    return f"{frame}_joint"


def _lines(place: FramePlace) -> list[str]:
    xyz, rpy = (
        " ".join(repr(clean(float(v))) for v in values)
        for values in (place.T[:3, 3], lie.rpy_from_rotation(place.T[:3, :3]))
    )
    return [
        f"<link name={quoteattr(place.frame)}/>",
        f'<joint name={quoteattr(joint_name(place.frame))} type="fixed">',
        f'{INDENT}<origin xyz="{xyz}" rpy="{rpy}"/>',
        f"{INDENT}<parent link={quoteattr(place.parent)}/>",
        f"{INDENT}<child link={quoteattr(place.frame)}/>",
        "</joint>",
    ]


class _Outline:
    """Names of links and joints, and where the robot ends."""

    def __init__(self) -> None:
        self.links: set[str] = set()
        self.joints: set[str] = set()
        self._depth, self._end = 0, -1
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._stop

    def read(self, source: bytes) -> int:
        """Byte at which `</robot>` begins."""
        try:
            self._parser.Parse(lenient(source), True)
        except (expat.ExpatError, LookupError, ValueError) as error:
            raise InputError(f"cannot read the URDF as XML: {error}.") from error
        if not source.startswith(b"</", self._end):
            raise InputError("frames can be added to a URDF in UTF-8 or ASCII that has </robot>.")
        return self._end

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        named = {"link": self.links, "joint": self.joints}.get(tag) if self._depth == 1 else None
        if named is not None:
            named.add(attributes.get("name", ""))
        self._depth += 1

    def _stop(self, _tag: str) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._end = self._parser.CurrentByteIndex
