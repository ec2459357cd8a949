"""The elements of a URDF as readers of robot descriptions take them, who are laxer than XML.

Robots that are read everywhere have prefixes that nobody declared (<sensor:camera>), a declaration
that is not on the first line, and two dashes inside a comment. None of that is about the robot.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from xml.parsers import expat

_COMMENT = re.compile(rb"<!\[CDATA\[.*?\]\]>|<!--(.*?)-->", re.DOTALL)
_LATE_DECLARATION = re.compile(rb"\A(\s+)(<\?xml\s.*?\?>)", re.DOTALL)


def lenient(source: bytes) -> bytes:
    """The same text for an XML parser, with every element at its byte; see the module's text."""
    late = _LATE_DECLARATION.match(source)
    if late is not None:
        source = late[1] + b" " * len(late[2]) + source[late.end() :]
    return _COMMENT.sub(_without_dashes, source)


def _without_dashes(match: re.Match[bytes]) -> bytes:
    inside = match[1]
    if inside is None or (b"--" not in inside and not inside.endswith(b"-")):
        return match[0]
    return b"<!--" + inside.replace(b"-", b" ") + b"-->"


def xml_root(source: bytes) -> ET.Element:
    """The root element; prefixes are part of the names, declared or not.

    Raises:
        expat.ExpatError: no XML, even so.
    """
    tree = ET.TreeBuilder()
    parser = expat.ParserCreate()
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.CharacterDataHandler = tree.data
    parser.Parse(lenient(source), True)
    root: ET.Element = tree.close()
    return root
