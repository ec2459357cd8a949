"""Descriptions of every form with the corrections of one answer: the same tool for every reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.export.corrected_descriptions import corrected_description
from bodyschema.export.mjcf_writer import write_mjcf
from bodyschema.judging.settled import settled
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

FORMS = ("urdf", "xml", "json")

WORST = 2e-14
"""m and 1; written numbers are short where that changes no more than rounding does."""


@pytest.fixture
def described(case, tmp_path: Path) -> Callable[[str], Path]:
    """The nominal robot in a form, in a folder of its own."""
    pytest.importorskip("mujoco")

    def write(form: str) -> Path:
        path = tmp_path / "given" / f"arm.{form}"
        path.parent.mkdir(exist_ok=True)
        if form == "json":
            (path.parent / "inner.urdf").write_bytes(case.source)
            path.write_text('{"robot": [{"description": "inner.urdf"}]}')
        else:
            path.write_bytes(case.source if form == "urdf" else write_mjcf(case.nominal))
        return path

    return write


@pytest.mark.parametrize("out", ["urdf", "xml"])
@pytest.mark.parametrize("form", FORMS)
def test_any_form_in_any_form_out(case, described, worst_pose, tmp_path, form, out) -> None:
    made = corrected_description(
        case.calibration, described(form), tmp_path / f"new.{out}", {}, {}, add_frames=True
    )
    assert made.kind == {"urdf": "urdf", "xml": "mjcf"}[out]
    assert made.patched == (form == out)
    assert len(made.changed) >= 2
    (tmp_path / f"new.{out}").write_bytes(made.text)
    body = Body.from_file(tmp_path / f"new.{out}")
    corrected = settled(case.calibration).body
    assert worst_pose(corrected, body) < WORST  # camera and marker as well


def test_bytes_are_kept(case, described, tmp_path) -> None:
    for form in ("urdf", "xml"):
        path = described(form)
        made = corrected_description(case.calibration, path, tmp_path / f"new.{form}", {}, {})
        before, after = path.read_bytes().splitlines(), made.text.splitlines()
        assert len(before) == len(after)
        changed = sum(one != other for one, other in zip(before, after, strict=True))
        assert changed == len(made.changed)


def test_other_readers_have_the_same_tool(case, described, tmp_path) -> None:
    """Pinocchio, MuJoCo and, where it is installed, yourdfpy."""
    pin, mujoco = pytest.importorskip("pinocchio"), pytest.importorskip("mujoco")
    text = {}
    for out in ("urdf", "xml"):
        text[out] = tmp_path / f"new.{out}"
        made = corrected_description(case.calibration, described("urdf"), text[out], {}, {})
        text[out].write_bytes(made.text)
    q = np.random.default_rng(4).uniform(-2, 2, (10, 4))
    expected = relative_pose(settled(case.calibration).body, q, "base", "tip")
    found = {"pinocchio": [], "mujoco": []}
    model = pin.buildModelFromUrdf(str(text["urdf"]))
    data, own = model.createData(), mujoco.MjModel.from_xml_path(str(text["xml"]))
    state = mujoco.MjData(own)
    for values in q:
        pin.framesForwardKinematics(model, data, pin.neutral(model))
        position = pin.neutral(model)
        for name, value in zip(case.nominal.joints, values, strict=True):
            joint = model.joints[model.getJointId(name)]
            # An endless joint has a cosine and a sine.
            both = [np.cos(value), np.sin(value)]
            position[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else both
            state.joint(name).qpos[0] = value
        pin.framesForwardKinematics(model, data, position)
        found["pinocchio"].append(data.oMf[model.getFrameId("tip")].homogeneous)
        mujoco.mj_kinematics(own, state)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = state.body("tip").xmat.reshape(3, 3), state.body("tip").xpos
        found["mujoco"].append(T)
    for name, poses in found.items():
        assert np.abs(np.array(poses) - expected).max() < WORST, name


def test_yourdfpy_has_the_same_tool(case, described, tmp_path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "new.urdf"
    path.write_bytes(corrected_description(case.calibration, described("urdf"), path, {}, {}).text)
    robot = yourdfpy.URDF.load(str(path), build_scene_graph=True, load_meshes=False)
    for values in np.random.default_rng(4).uniform(-2, 2, (10, 4)):
        robot.update_cfg(dict(zip(case.nominal.joints, values, strict=True)))
        expected = relative_pose(settled(case.calibration).body, values, "base", "tip")
        assert np.abs(robot.get_transform("tip", "base") - expected).max() < 1e-9


def test_another_ending_is_refused(case, described, tmp_path) -> None:
    with pytest.raises(InputError, match=r"into a \.urdf or, as MJCF, an \.xml"):
        corrected_description(case.calibration, described("urdf"), tmp_path / "new.sdf", {}, {})
