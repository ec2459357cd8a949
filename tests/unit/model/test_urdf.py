"""Reading robot descriptions: what is left out, what is wrong, and meshes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.export.urdf_patch import JointEdit, patch_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

LINKS = '<link name="base"/><link name="arm"/><link name="hand"/>'


def joint(name: str, parent: str, child: str, inside: str = "", kind: str = "revolute") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{inside}</joint>"
    )


SHOULDER, WRIST = joint("shoulder", "base", "arm"), joint("wrist", "arm", "hand")

Reader = Callable[..., Body]


@pytest.fixture
def read(tmp_path: Path) -> Reader:
    """Read a robot from what stands between <robot> and </robot>."""

    def reader(inside: str, **options: object) -> Body:
        path = tmp_path / "robot.urdf"
        path.write_text(f'<?xml version="1.0"?><robot name="r">{inside}</robot>')
        return Body.from_urdf(path, **options)  # type: ignore[arg-type]

    return reader


def test_what_is_left_out_has_the_default_of_the_format(read: Reader) -> None:
    body = read(LINKS + SHOULDER + WRIST)
    assert body.name == "r"
    assert body.frames == ("base", "arm", "hand")
    assert body.joints == ("shoulder", "wrist")
    assert (body.placement == np.eye(4)).all()
    assert body.axis[1:].tolist() == [[1, 0, 0]] * 2
    assert (body.lower == -np.inf).all()
    assert (body.upper == np.inf).all()


def test_origins_axes_and_limits(read: Reader) -> None:
    inside = (
        '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><axis xyz="0 0 -2"/>'
        '<limit upper="1.5" effort="1"/>'
    )
    body = read(LINKS + joint("shoulder", "base", "arm", inside) + WRIST)
    tip = relative_pose(body, [0.5, 0.0], "base", "arm") @ [1, 0, 0, 1]
    assert tip[:3] == pytest.approx([1 + np.sin(0.5), 2 + np.cos(0.5), 3])
    assert body.axis[1].tolist() == [0, 0, -1]
    assert (body.lower[0], body.upper[0]) == (0, 1.5)


def test_continuous_joints_have_no_limits_and_joints_may_stand_before_links(read: Reader) -> None:
    limit = '<limit lower="-1" upper="1"/>'
    body = read(WRIST + joint("shoulder", "base", "arm", limit, "continuous") + LINKS)
    assert body.joints == ("wrist", "shoulder"), "columns follow the file"
    assert body.frames == ("base", "arm", "hand"), "frames follow the tree"
    assert (body.lower[1], body.upper[1]) == (-np.inf, np.inf)


def test_mimic_chains_end_at_the_joint_that_moves(read: Reader) -> None:
    text = LINKS + '<link name="tip"/><link name="nail"/>' + SHOULDER
    text += joint("nail", "tip", "nail", '<mimic joint="tip" multiplier="3" offset="0.3"/>')
    text += joint("wrist", "arm", "hand", '<mimic joint="shoulder"/>')
    text += joint("tip", "hand", "tip", '<mimic joint="wrist" multiplier="-2" offset="0.1"/>')
    body = read(text)
    assert body.joints == ("shoulder",)
    assert (body.driver[1:] == 0).all()
    rates = dict(zip(body.frames, zip(body.rate, body.shift, strict=True), strict=True))
    assert rates["hand"] == (1, 0)
    assert rates["tip"] == pytest.approx((-2, 0.1))
    assert rates["nail"] == pytest.approx((-6, 0.6))


def mimic(attributes: str) -> str:
    return LINKS + SHOULDER + joint("wrist", "arm", "hand", f"<mimic {attributes}/>")


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (LINKS + SHOULDER, r"one root link, it has 2: \['base', 'hand'\]"),
        ("", "one root link, it has 0"),
        (LINKS + SHOULDER + joint("wrist", "hand", "hand"), r"\['wrist'\] .*form a loop apart"),
        (LINKS + SHOULDER + WRIST + joint("w", "base", "hand"), "'hand' has two parents"),
        (LINKS + SHOULDER + SHOULDER, "has two joints named 'shoulder'; rename one"),
        (LINKS + '<link name="arm"/>' + SHOULDER + WRIST, "has two links named 'arm'"),
        ("<link/>", "has a <link> without a name"),
        (LINKS + joint("a", "base", "armm"), "names link 'armm'; did you mean 'arm'"),
        (LINKS + joint("a", "base", "arm", "", "spherical"), "type 'spherical'; expected one of"),
        (mimic('joint="sholder"'), "'wrist' mimics 'sholder', .* did you mean 'shoulder'"),
        (mimic('joint="wrist"'), "'wrist' .*mimics itself through others"),
        (mimic('joint="shoulder" multiplier="x"'), "<mimic> of 'wrist' .*1 numbers?, it is 'x'"),
        (
            LINKS + joint("a", "base", "arm", "", "fixed")
            + joint("b", "arm", "hand", '<mimic joint="a"/>'),
            "'b' mimics 'a', which is no moving joint",
        ),
    ],
)  # fmt: skip
def test_bodies_that_are_no_trees_are_refused(read: Reader, inside: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(inside)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<origin xyz="1 2"/>', "<origin> of 'shoulder' .*3 numbers, it is '1 2'"),
        ('<origin xyz="1 2 x"/>', "3 numbers, it is '1 2 x'"),
        ('<origin rpy="0 nan 0"/>', "3 numbers, it is '0 nan 0'"),
        ('<origin rpy="0 ${pi} 0"/>', "3 numbers"),
        ('<axis xyz="0 0 0"/>', "<axis> of joint 'shoulder' .*has no length"),
        ('<axis xyz="0 1"/>', "<axis> of 'shoulder' .*3 numbers"),
        ('<limit lower="low"/>', "<limit> of 'shoulder' .*it is 'low'"),
    ],
)
def test_bad_numbers_are_refused(read: Reader, inside: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(LINKS + joint("shoulder", "base", "arm", inside) + WRIST)


def test_a_fixed_joint_may_have_a_zero_axis(read: Reader) -> None:
    body = read(LINKS + SHOULDER + joint("wrist", "arm", "hand", '<axis xyz="0 0 0"/>', "fixed"))
    assert body.joints == ("shoulder",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot>", "is not well-formed XML: "),
        ("joint,axis\n", "is not well-formed XML: "),
        ("<sdf/>", "is no URDF: its root is <sdf>, expected <robot>"),
    ],
)
def test_files_that_are_no_urdf_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "x.urdf"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        Body.from_urdf(path)
    with pytest.raises(InputError, match=r"no robot description at .* give the path of a URDF"):
        Body.from_urdf(tmp_path / "y.urdf")


def visual(geometry: str) -> str:
    return f'<link name="base"><visual><geometry>{geometry}</geometry></visual></link>'


@pytest.mark.parametrize(
    ("geometry", "shape", "size"),
    [
        ('<box size="1 2 3"/>', "box", (1, 2, 3)),
        ('<cylinder radius="1" length="2"/>', "cylinder", (1, 2)),
        ('<sphere radius="3"/>', "sphere", (3,)),
        ('<mesh filename="a.stl" scale="1 2 3"/>', "mesh", (1, 2, 3)),
        ('<mesh filename="a.stl"/>', "mesh", (1, 1, 1)),
    ],
)
def test_visible_shapes(read: Reader, geometry: str, shape: str, size: tuple[float, ...]) -> None:
    (found,) = read(visual(geometry)).visuals
    assert (found.frame, found.shape, found.size) == ("base", shape, size)
    assert (found.placement == np.eye(4)).all()


def test_shapes_that_nobody_draws_are_left_out_and_bad_ones_refused(read: Reader) -> None:
    assert read(visual('<capsule radius="1"/>')).visuals == ()
    assert read('<link name="base"><visual/></link>').visuals == ()
    with pytest.raises(InputError, match=r"<box> of link 'base' .*3 numbers"):
        read(visual('<box size="1 2"/>'))


def test_meshes_are_found_beside_above_and_in_packages(read: Reader, tmp_path: Path) -> None:
    mesh = tmp_path / "share" / "my_robot" / "meshes" / "hand.stl"
    mesh.parent.mkdir(parents=True)
    mesh.touch()

    def resolved(address: str, **options: object) -> str:
        return read(visual(f'<mesh filename="{address}"/>'), **options).visuals[0].mesh

    assert resolved("meshes/a.stl") == str(tmp_path / "meshes" / "a.stl")
    assert resolved("../a.stl") == str(tmp_path.parent / "a.stl")
    assert resolved("file:///opt/a.stl") == "/opt/a.stl"
    assert resolved("package://my_robot/meshes/hand.stl") == str(mesh)
    assert resolved("model://my_robot/meshes/hand.stl") == str(mesh)
    assert resolved("package://lost/a.stl") == "package://lost/a.stl"
    packages = {"lost": tmp_path / "found"}
    assert resolved("package://lost/a.stl", packages=packages) == str(tmp_path / "found" / "a.stl")


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_without_encoders_are_held_at_their_origins(read: Reader, kind: str) -> None:
    inside = '<origin xyz="0 0 1"/><axis xyz="0 0 0"/>'
    body = read(LINKS + joint("root", "base", "arm", inside, kind) + WRIST)
    assert body.joints == ("wrist",)
    assert relative_pose(body, [0.0], "base", "hand")[:3, 3].tolist() == [0, 0, 1]
    (remark,) = body.remarks
    assert f"'root' is {kind}" in remark
    assert "'arm' was held at its origin on 'base'" in remark
    assert read(LINKS + SHOULDER + WRIST).remarks == ()


LAX = [
    pytest.param('<robot name="r"><sensor:camera name="eye"/>%s</robot>', id="prefix"),
    pytest.param('\n<?xml version="1.0"?>\n<robot name="r">%s</robot>', id="late declaration"),
    pytest.param('<robot name="r"><!-- -- arm -- --->%s</robot>', id="dashes"),
    pytest.param(
        '<robot name="r"><gazebo><![CDATA[<!-- a -- ]]></gazebo>%s</robot>', id="no comment"
    ),
]


@pytest.mark.parametrize("text", LAX)
def test_what_is_no_xml_but_read_by_everybody_is_read_and_patched(
    tmp_path: Path, text: str
) -> None:
    path = tmp_path / "robot.urdf"
    inside = '<origin xyz="0 0 0.1"/>'
    path.write_text(text % (LINKS + joint("shoulder", "base", "arm", inside) + WRIST))
    assert Body.from_urdf(path).joints == ("shoulder", "wrist")
    source = path.read_bytes()
    patched = patch_urdf(source, {"shoulder": JointEdit(xyz=(0.0, 0.0, 0.2))})
    assert patched == source.replace(b"0 0 0.1", b"0 0 0.2")
