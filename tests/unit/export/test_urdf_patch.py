"""The URDF patch: the asked numbers change, every other byte stays."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.urdf_patch import JointEdit, patch_urdf

ARM = b"""<?xml version="1.0"?>
<!-- an arm: <joint name="elbow"> in a comment is no joint -->
<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro">
  <link name='base'/>
  <link name='hand' />
  <joint type='revolute'   name='elbow'>   <!-- the elbow -->
    <origin rpy='0 0 0'  xyz='0.1 0  0.25'/>
    <parent link="base"/>
    <child link="hand"/>
    <axis xyz="0 0 1"></axis>
    <limit lower="-1.5" upper="1.5" effort="1" velocity="2" />
  </joint>
  <ros2_control name="c" type="system">
    <joint name="elbow"><param name="min">-1</param></joint>
  </ros2_control>
  <transmission name="t"><joint name="elbow"/></transmission>
  <gazebo><![CDATA[<joint name="elbow"/>]]></gazebo>
</robot>

"""

numbers = st.floats(-1e4, 1e4)
vectors = st.tuples(numbers, numbers, numbers)


def robot(joint: bytes) -> bytes:
    """Put one joint into an otherwise empty robot."""
    return b"<robot name='r'>\n  " + joint + b"\n</robot>"


def read(source: bytes, tag: str, attribute: str) -> tuple[float, ...]:
    """Read numbers of the first joint back by another parser."""
    element = ET.fromstring(source).find(f"joint/{tag}")
    assert element is not None
    return tuple(float(word) for word in element.attrib[attribute].split())


def patch(joint: bytes, **values: object) -> bytes:
    """Patch the joint `a` of a one-joint robot; return what became of the joint."""
    patched = patch_urdf(robot(joint), {"a": JointEdit(**values)})  # type: ignore[arg-type]
    return patched.removeprefix(robot(b"")[:-9]).removesuffix(b"\n</robot>")


# ---- existing attributes ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edit", "old", "new"),
    [
        (JointEdit(xyz=(0.1, 0.0, 0.26)), b"'0.1 0  0.25'", b"'0.1 0  0.26'"),
        (JointEdit(rpy=(0.0, -0.5, 0.0)), b"'0 0 0' ", b"'0 -0.5 0' "),
        (JointEdit(axis=(0.0, 0.6, 0.8)), b'xyz="0 0 1"', b'xyz="0 0.6 0.8"'),
        (JointEdit(lower=-1.25), b'"-1.5"', b'"-1.25"'),
        (JointEdit(upper=1.75), b'"1.5"', b'"1.75"'),
    ],
)
def test_only_the_changed_numbers_change(edit: JointEdit, old: bytes, new: bytes) -> None:
    assert ARM.count(old) == 1
    assert patch_urdf(ARM, {"elbow": edit}) == ARM.replace(old, new)


@pytest.mark.parametrize("edits", [{}, {"elbow": JointEdit()}])
def test_no_edits_return_the_same_bytes(edits: dict[str, JointEdit]) -> None:
    assert patch_urdf(ARM, edits) == ARM


def test_values_that_the_file_already_has_change_nothing() -> None:
    same = JointEdit((0.1, -0.0, 0.25), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), -1.5, 1.5)
    assert patch_urdf(ARM, {"elbow": same}) == ARM


@pytest.mark.parametrize("spelling", [b"-.50", b"-5E-1", b"-0.5000000000000001", b" -0.50 "])
def test_other_spellings_of_the_same_number_stay(spelling: bytes) -> None:
    joint = b'<joint name="a"><limit lower="%b"/></joint>' % spelling
    assert patch(joint, lower=-0.5) == joint


def test_line_endings_stay_crlf() -> None:
    source = ARM.replace(b"\n", b"\r\n")
    patched = patch_urdf(source, {"elbow": JointEdit(lower=-2.0)})
    assert patched == source.replace(b'"-1.5"', b'"-2.0"')


def test_several_joints_are_patched_at_once_in_any_order() -> None:
    joint = b"<joint name='%b'><origin xyz='0 0 0'/></joint>"
    source = robot(b"".join(joint % name for name in (b"a", b"b", b"c")))
    edits = {"c": JointEdit(xyz=(3.0, 0.0, 0.0)), "a": JointEdit(xyz=(1.0, 0.0, 0.0))}
    xyz = [
        origin.attrib["xyz"] for origin in ET.fromstring(patch_urdf(source, edits)).iter("origin")
    ]
    assert xyz == ["1.0 0 0", "0 0 0", "3.0 0 0"]


@pytest.mark.parametrize(
    "old", [b"", b"0 0", b"&#48; 0 0", b"${x} 0 0", b"0&#32;0 0", b"nan 0 0", b"0\n0\t0"]
)
def test_values_in_other_spellings_are_replaced(old: bytes) -> None:
    patched = patch_urdf(
        robot(b'<joint name="a"><origin xyz="%b"/></joint>' % old),
        {"a": JointEdit((1.0, 2.0, 3.0))},
    )
    assert read(patched, "origin", "xyz") == (1.0, 2.0, 3.0)


def test_angle_brackets_and_entities_in_other_attributes_are_harmless() -> None:
    joint = b"""<joint note="x > y /> 'q'" name='a&#x62;&amp;c'>"""
    joint += b"""<origin  note='">' xyz = '0 0 0'/></joint>"""
    patched = patch_urdf(robot(joint), {"ab&c": JointEdit(xyz=(0.0, 0.0, 1.0))})
    assert patched == robot(joint.replace(b"0 0 0", b"0 0 1.0"))


def test_of_two_origins_the_first_counts() -> None:
    joint = b'<joint name="a"><origin xyz="0 0 0"/><origin xyz="5 5 5"/></joint>'
    assert patch(joint, xyz=(0.0, 0.0, 1.0)) == joint.replace(b"0 0 0", b"0 0 1.0")


# ---- missing attributes and elements ---------------------------------------------------------


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (b'<origin xyz="1 0 0"/>', b'<origin xyz="1 0 0" rpy="0.0 0.0 0.5"/>'),
        (b"<origin xyz='1 0 0' ></origin>", b"<origin xyz='1 0 0' rpy='0.0 0.0 0.5' ></origin>"),
        (b'<origin\n  xyz="1 0 0"\n/>', b'<origin\n  xyz="1 0 0"\n  rpy="0.0 0.0 0.5"\n/>'),
        (b"<origin/>", b'<origin rpy="0.0 0.0 0.5"/>'),
    ],
)
def test_missing_attribute_follows_the_last_one(before: bytes, after: bytes) -> None:
    joint = b'<joint name="a">%b</joint>'
    assert patch(joint % before, rpy=(0.0, 0.0, 0.5)) == joint % after


def test_missing_limits_are_written_into_the_limit_element() -> None:
    joint = b'<joint name="a"><limit effort="1"%b/></joint>'
    assert patch(joint % b"", lower=-1.0, upper=2.0) == joint % b' lower="-1.0" upper="2.0"'


def test_defaults_of_the_specification_are_not_written() -> None:
    joint = b'<joint name="a"><parent link="p"/><limit effort="1"/></joint>'
    default = {"xyz": (0.0, 0.0, 0.0), "rpy": (0.0, -0.0, 0.0), "axis": (1.0, 0.0, 0.0)}
    assert patch(joint, **default, lower=0.0) == joint


ORIGIN, AXIS = b'<origin xyz="0.0 0.0 1.0"/>', b'<axis xyz="0.0 1.0 0.0"/>'


@pytest.mark.parametrize(
    ("before", "after"),
    [
        pytest.param(
            b'<joint name="a">\n\n\t<child link="c"/> <!-- hand -->\n\n  </joint>',
            b'<joint name="a">\n\n\t<child link="c"/> <!-- hand -->\n\t%b\n\n  </joint>',
            id="own-lines",
        ),
        pytest.param(
            b'<joint name="a">\r\n    <child link="c"></child >\r\n  </joint>',
            b'<joint name="a">\r\n    <child link="c"></child >\r\n    %b\r\n  </joint>',
            id="crlf",
        ),
        pytest.param(
            b'<joint name="a">\n    <!-- p --> <parent link="p"/> <mimic/>\n  </joint>',
            b'<joint name="a">\n    <!-- p --> <parent link="p"/>\n    %b <mimic/>\n  </joint>',
            id="two-on-a-line",
        ),
        pytest.param(
            b'<joint name="a"><parent link="p"/><child link="c"/><dynamics/></joint>',
            b'<joint name="a"><parent link="p"/><child link="c"/>%b<dynamics/></joint>',
            id="one-line",
        ),
        pytest.param(
            b'<joint name="a"> <child link="c"/> <!-- c --> </joint>',
            b'<joint name="a"> <child link="c"/> %b <!-- c --> </joint>',
            id="one-line-spaced",
        ),
        pytest.param(
            b'<joint\n name="a"><child link="c"/></joint>',
            b'<joint\n name="a"><child link="c"/>%b</joint>',
            id="break-in-the-tag",
        ),
        pytest.param(
            b'<joint name="a">\n    <dynamics/>\n  </joint>',
            b'<joint name="a">\n    <dynamics/>\n    %b\n  </joint>',
            id="no-links",
        ),
        pytest.param(
            b'<joint name="a" />', b'<joint name="a">\n    %b\n  </joint>', id="self-closed"
        ),
        pytest.param(
            b'<joint name="a"></joint>', b'<joint name="a">\n    %b\n  </joint>', id="empty"
        ),
        pytest.param(
            b'<joint name="a">\n  </joint>', b'<joint name="a">\n    %b\n  </joint>', id="blank"
        ),
    ],
)
@pytest.mark.parametrize(
    ("edit", "element"),
    [({"xyz": (0.0, 0.0, 1.0)}, ORIGIN), ({"axis": (0.0, 1.0, 0.0)}, AXIS)],
)
def test_missing_element_is_one_more_line_below_the_links(
    before: bytes, after: bytes, edit: dict[str, object], element: bytes
) -> None:
    assert patch(before, **edit) == after % element


def test_axis_goes_below_the_origin_be_it_old_or_new() -> None:
    joint = b'<joint name="a">\n    <parent link="p"/>\n%b    <limit/>\n  </joint>'
    both = joint % (b"    " + ORIGIN + b"\n    " + AXIS + b"\n")
    assert patch(joint % b"", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.0, 1.0)) == both
    assert patch(joint % (b"    " + ORIGIN + b"\n"), axis=(0.0, 1.0, 0.0)) == both


def test_robot_in_one_line_stays_in_one_line() -> None:
    patched = patch_urdf(b'<robot><joint name="a"/></robot>', {"a": JointEdit((0.0, 0.0, 1.0))})
    assert patched == b'<robot><joint name="a">' + ORIGIN + b"</joint></robot>"


# ---- encodings -------------------------------------------------------------------------------

ACCENTED = '<?xml version="1.0" encoding="{}"?>\n<!-- épaule, Ö -->\n<robot>\n'
ACCENTED += '  <joint name="épaule" note="Ö">\n    <origin xyz="0 0 0"/>\n  </joint>\n</robot>\n'


@pytest.mark.parametrize(
    ("declared", "codec"),
    [
        ("utf-8", "utf-8"),
        ("utf-8", "utf-8-sig"),
        ("latin-1", "latin-1"),
        ("ISO-8859-1", "latin-1"),
        ("windows-1252", "cp1252"),
        ("utf-16", "utf-16"),
        ("utf-16", "utf-16-le"),
        ("utf-16", "utf-16-be"),
    ],
)
def test_offsets_are_right_in_every_encoding(declared: str, codec: str) -> None:
    text = ACCENTED.format(declared)
    patched = patch_urdf(text.encode(codec), {"épaule": JointEdit(xyz=(0.0, 0.5, 0.0))})
    assert patched == text.replace("0 0 0", "0 0.5 0").encode(codec)


@pytest.mark.parametrize(
    "source",
    [
        b'<?xml version="1.0" encoding="klingon"?><robot/>',
        b'<?xml version="1.0" encoding="shift_jis"?><robot/>',
        b"<robot name='\xff'/>",
        b"\xff\xfe<\0r",
        b"\xff\xfe<\0r\0o",
        b"",
    ],
)
def test_unreadable_bytes_are_refused(source: bytes) -> None:
    with pytest.raises(InputError, match=r"cannot read|UTF-16"):
        patch_urdf(source, {})


# ---- refusals --------------------------------------------------------------------------------


def test_unknown_joint_names_the_close_one() -> None:
    with pytest.raises(InputError, match="no joint 'elbw' in the URDF; did you mean 'elbow'"):
        patch_urdf(ARM, {"elbw": JointEdit()})


def test_joints_elsewhere_are_not_joints_of_the_body() -> None:
    source = b"<robot><transmission><joint name='a'/></transmission></robot>"
    with pytest.raises(InputError, match="no joint 'a'"):
        patch_urdf(source, {"a": JointEdit()})


def test_duplicated_joint_names_both_lines() -> None:
    with pytest.raises(InputError, match="two joints 'a', lines 2 and 3"):
        patch_urdf(robot(b"<joint name='a'/>\n<joint name='a'/>"), {})


def test_joint_without_limit_element_has_no_limits_to_change() -> None:
    with pytest.raises(InputError, match="joint 'a' has no <limit>"):
        patch(b'<joint name="a" type="continuous"/>', lower=0.0)


def test_other_xml_is_not_a_urdf() -> None:
    with pytest.raises(InputError, match="root element is <sdf>, expected <robot>"):
        patch_urdf(b"<sdf/>", {})


def test_malformed_xml_names_the_line() -> None:
    with pytest.raises(InputError, match="mismatched tag: line 3"):
        patch_urdf(b"<robot>\n  <link>\n</robot>", {})


def test_element_out_of_an_entity_cannot_be_changed() -> None:
    source = b"<!DOCTYPE robot [<!ENTITY o '<origin xyz=\"0 0 0\"/>'>]>" + robot(
        b'<joint name="a">&o;<axis xyz="0 0 1"/></joint>'
    )
    patched = patch_urdf(source, {"a": JointEdit(axis=(0.0, 1.0, 0.0))})
    assert patched == source.replace(b"0 0 1", b"0 1.0 0.0")
    with pytest.raises(InputError, match="<origin> is in an entity"):
        patch_urdf(source, {"a": JointEdit(xyz=(0.0, 1.0, 0.0))})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"xyz": (0.0, 1.0)}, "<origin xyz> needs 3 finite numbers"),
        ({"rpy": (0.0, math.nan, 0.0)}, "<origin rpy> needs 3 finite numbers"),
        ({"upper": math.inf}, "<limit upper> needs 1 finite number"),
        ({"axis": (0.0, 0.0, 2.0)}, "axis needs a unit vector"),
        ({"lower": 1.0, "upper": 0.0}, "lower limit 1.0 is above the upper 0.0"),
    ],
)
def test_numbers_that_would_break_the_file_are_refused(
    values: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        JointEdit(**values)  # type: ignore[arg-type]


# ---- numbers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (0.1 + 0.2, b"0.3"),
        (math.pi / 2, b"1.5707963267948966"),
        (math.cos(math.pi / 2), b"0.0"),
        (-0.0, b"0.0"),
        (1.0 / 3.0, b"0.3333333333333333"),
        (1e-13, b"1e-13"),
    ],
)
def test_rounding_noise_is_dropped_and_digits_are_kept(value: float, written: bytes) -> None:
    joint = b'<joint name="a"><limit lower="%b"/></joint>'
    assert patch(joint % b"7", lower=value) == joint % written


@given(vectors, vectors, numbers, numbers)
def test_what_is_written_reads_back(
    xyz: tuple[float, float, float], rpy: tuple[float, float, float], one: float, other: float
) -> None:
    edit = JointEdit(xyz, rpy, lower=min(one, other), upper=max(one, other))
    patched = patch_urdf(ARM, {"elbow": edit})
    assert read(patched, "origin", "xyz") == pytest.approx(xyz, rel=0.0, abs=1e-12)
    turned = lie.rotation_from_rpy(read(patched, "origin", "rpy"))
    assert turned == pytest.approx(lie.rotation_from_rpy(rpy), rel=0.0, abs=1e-11)
    assert read(patched, "limit", "lower") == pytest.approx((edit.lower,), rel=0.0, abs=1e-12)
    assert read(patched, "limit", "upper") == pytest.approx((edit.upper,), rel=0.0, abs=1e-12)
    assert patch_urdf(patched, {"elbow": edit}) == patched


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"])))
def test_any_comment_before_the_joint_stays(text: str) -> None:
    comment = f"<!-- {text.replace('-', '')} -->".encode()  # XML allows no -- in a comment
    source = ARM.replace(b"<robot", comment + b"<robot")
    patched = patch_urdf(source, {"elbow": JointEdit(lower=-2.0)})
    assert patched == source.replace(b'"-1.5"', b'"-2.0"')


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ((0.0, 1.57079632679, 0.0), (0.0, 1.595, 0.0)),
        ((3.1415926, 0.2, 0.0), (3.18, 0.2, 0.01)),
        ((0.0, 0.0, -3.14159265359), (0.0, 0.01, -3.2)),
        ((0.1, 0.2, 6.2), (0.1, 0.2, 6.3)),
    ],
)
def test_the_angles_stay_on_the_branch_that_is_written(
    old: tuple[float, float, float], new: tuple[float, float, float]
) -> None:
    """A quarter turn and a bit is not said as half a turn, a bit less, and half a turn."""
    again = tuple(float(v) for v in lie.rpy_from_rotation(lie.rotation_from_rpy(new)))
    assert max(abs(a - b) for a, b in zip(again, new, strict=True)) > 1
    written = read(
        patch_urdf(_with_rpy(old), {"elbow": JointEdit(rpy=(again[0], again[1], again[2]))}),
        "origin",
        "rpy",
    )
    assert written == pytest.approx(new, rel=0.0, abs=1e-9)


def _with_rpy(rpy: tuple[float, float, float]) -> bytes:
    """The arm whose elbow is turned by angles that are written so."""
    words = " ".join(map(repr, rpy)).encode()
    return ARM.replace(b"rpy='0 0 0'", b"rpy='" + words + b"'")
