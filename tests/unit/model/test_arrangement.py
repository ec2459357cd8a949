"""Arrangements become bodies of unknown geometry; what cannot be one is refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema import Body, InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.arrangement import read_arrangement
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import path_between, relative_pose

TORSO = """
name = "torso"
root = "pelvis"

[joints]
elbow = "shoulder"
shoulder = { parent = "waist", limits = [-1.5, 1.5] }
waist = "pelvis"
lift = { parent = "waist", kind = "prismatic", limits = [0, 0.2] }
neck = "waist"

[markers]
hand = "elbow"
chest = "waist"

[camera]
name = "eye"
parent = "neck"
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "torso.toml"
    path.write_text(text)
    return path


def test_joints_keep_their_order_and_hang_where_they_are_told(tmp_path):
    body = Body.from_arrangement(written(tmp_path, TORSO))
    assert body.name == "torso"
    assert body.joints == ("elbow", "shoulder", "waist", "lift", "neck")
    parents = {
        frame: body.frames[p] for frame, p in zip(body.frames, body.parent, strict=True) if p >= 0
    }
    assert parents == {
        "waist_link": "pelvis",
        "shoulder_link": "waist_link",
        "lift_link": "waist_link",
        "neck_link": "waist_link",
        "elbow_link": "shoulder_link",
        "hand": "elbow_link",
        "chest": "waist_link",
        "eye": "neck_link",
    }
    kinds = dict(zip(body.frames, body.kind, strict=True))
    assert (kinds["lift_link"], kinds["elbow_link"], kinds["hand"]) == (PRISMATIC, REVOLUTE, FIXED)
    assert body.lower[body.joint_index("shoulder")] == -1.5
    assert body.upper[body.joint_index("lift")] == 0.2
    assert np.isinf(body.upper[body.joint_index("neck")])
    path, climbed = path_between(body, "eye", "hand")
    assert [body.frames[k] for k in path] == [
        "eye",
        "neck_link",
        "shoulder_link",
        "elbow_link",
        "hand",
    ]
    assert climbed == 2


def test_nothing_is_known_of_the_geometry(tmp_path):
    body = Body.from_arrangement(written(tmp_path, TORSO))
    n = len(body.frames)
    assert np.array_equal(body.placement, np.tile(np.eye(4), (n, 1, 1)))
    assert np.array_equal(body.axis, np.tile([0.0, 0.0, 1.0], (n, 1)))
    assert read_arrangement(tmp_path / "torso.toml").looks == "eye"


def test_without_a_camera_the_root_looks(tmp_path):
    path = written(tmp_path, '[joints]\none = "base"\n')
    found = read_arrangement(path)
    assert (found.looks, found.name, found.markers) == ("base", "torso", {})
    assert found.body().frames == ("base", "one_link")


def test_written_as_urdf_it_is_the_same_tree(tmp_path):
    body = Body.from_arrangement(written(tmp_path, TORSO))
    (tmp_path / "torso.urdf").write_bytes(write_urdf(body))
    again = Body.from_urdf(tmp_path / "torso.urdf")
    assert again.joints == body.joints
    q = np.array([0.3, -0.2, 0.5, 0.1, 0.4])
    ends = (q, "eye", "hand")
    assert relative_pose(again, *ends) == pytest.approx(relative_pose(body, *ends), abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('waist = "pelvis"', 'waist = "elbow"', "elbow, shoulder, waist.* in a circle.*'pelvis'"),
        ('waist = "pelvis"', 'waist = "pelvic"', "'pelvic', which is no joint.*mean 'pelvis'"),
        ('hand = "elbow"', 'hand = "elbows"', "marker 'hand'.*'elbows'.*did you mean 'elbow'"),
        ('parent = "neck"', 'parent = "nek"', "camera 'eye'.*did you mean 'neck'"),
        ('neck = "waist"', 'neck = "waist"\nneck = "waist"', "not a readable arrangement.*line 11"),
        ('chest = "waist"', 'elbow_link = "waist"', "two frames.*'elbow_link'"),
        ('neck = "waist"', 'pelvis = "waist"', "two links or joints.*'pelvis'"),
        ('kind = "prismatic"', 'kind = "prismatik"', "did you mean 'prismatic'"),
        ("limits = [0, 0.2]", "limits = [0.2, 0]", "the lower first"),
        ("limits = [0, 0.2]", 'limits = ["0", 1]', "two numbers"),
        ("limits = [0, 0.2]", "limit = [0, 0.2]", "unknown key 'limit' of joint 'lift'"),
        ('neck = "waist"', "neck = 3", "'neck'.* does not say what it hangs on"),
        ('name = "eye"', 'title = "eye"', r"unknown key 'title' in \[camera\]"),
        ('parent = "neck"', "", r"\[camera\].*does not say"),
        ("[markers]", "[marker]", "unknown key 'marker'.*did you mean 'markers'"),
        ("[joints]", "joints = 3\n[markers]\n[other]", "not a readable arrangement"),
    ],
)
def test_what_cannot_be_an_arrangement_is_refused(tmp_path, old, new, message):
    assert old in TORSO
    with pytest.raises(InputError, match=message):
        read_arrangement(written(tmp_path, TORSO.replace(old, new)))


def test_a_file_that_is_missing_or_empty_is_refused(tmp_path):
    with pytest.raises(InputError, match="no arrangement at"):
        Body.from_arrangement(tmp_path / "none.toml")
    with pytest.raises(InputError, match="names no joint"):
        read_arrangement(written(tmp_path, 'name = "empty"'))
    with pytest.raises(InputError, match=r"joints .* must be a table"):
        read_arrangement(written(tmp_path, "joints = 3"))
