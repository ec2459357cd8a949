"""A planar arm of boxes folds into itself, and the hulls notice."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.acting.self_collision import SelfCollision
from bodyschema.acting.shapes import MARGIN, convex_hull, hulls_of
from bodyschema.errors import MissingExtraError
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.tree import Body, Visual

pytest.importorskip("fcl")
pytest.importorskip("trimesh")

JOINTS = ("joint_1", "joint_2", "joint_3")


def boxes(length: float = 0.8) -> list[Visual]:
    """A box along x on each link, shorter than the link so that neighbours stay apart."""
    middle = lie.transform(np.eye(3), [0.5, 0.0, 0.0])
    return [Visual(f"link_{i}", middle, "box", (length, 0.1, 0.1)) for i in (1, 2, 3)]


@pytest.fixture
def arm() -> Body:
    """Three links of 1 m that turn about z."""
    step = lie.transform(np.eye(3), [1.0, 0.0, 0.0])
    return Body.build(
        "planar",
        frames=["base", "link_1", "link_2", "link_3"],
        carriers=["", *JOINTS],
        parent=[-1, 0, 1, 2],
        kind=[FIXED, REVOLUTE, REVOLUTE, REVOLUTE],
        axis=[[0, 0, 1]] * 4,
        placement=[np.eye(4), np.eye(4), step, step],
    )


def looked_at(
    arm: Body, visuals: list[Visual], recorded: np.ndarray | None = None
) -> SelfCollision:
    q = np.empty((0, 3)) if recorded is None else recorded
    test = SelfCollision.of(arm, visuals, JOINTS, q, np.random.default_rng(0))
    assert test is not None
    return test


def test_a_folded_arm_collides_and_a_stretched_one_does_not(arm: Body) -> None:
    test = looked_at(arm, boxes())
    assert [(test.hulls[a].frame, test.hulls[b].frame) for a, b in test.pairs] == [
        ("link_1", "link_3")
    ]
    q = np.array([[0.0, 0.0, 0.0], [0.0, 2.1, 2.1], [0.7, -2.1, -2.1], [0.0, 1.5, 1.0]])
    assert test.free(q).tolist() == [True, False, False, True]


def test_hulls_have_a_margin(arm: Body) -> None:
    """Hulls are thicker than the shapes by the margin, and not by much more."""
    hull = convex_hull(
        "link", np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    )
    assert hull.points.min() == pytest.approx(-MARGIN, abs=0.002)
    assert hull.points.max() == pytest.approx(1 + MARGIN, abs=0.002)
    a, b, c = np.moveaxis(hull.points[hull.triangles], 1, 0)
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - 0.5)
    assert (outward > 0).all()


def test_pairs_that_always_met_while_recording_are_faults_of_the_hulls(arm: Body) -> None:
    folded = np.tile([0.0, 2.1, 2.1], (5, 1)) + 0.01 * np.random.default_rng(0).normal(size=(5, 3))
    assert len(looked_at(arm, boxes(), folded).pairs) == 0


def test_meshes_and_round_shapes_are_read(arm: Body, tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box((800.0, 100.0, 100.0)).export(tmp_path / "link.stl")
    middle = lie.transform(np.eye(3), [0.5, 0.0, 0.0])
    lying = lie.transform(lie.exp_so3([0.0, np.pi / 2, 0.0]), [0.5, 0.0, 0.0])
    visuals = [
        Visual("link_1", middle, "mesh", (1e-3, 1e-3, 1e-3), str(tmp_path / "link.stl")),
        Visual("link_2", middle, "sphere", (0.1,)),
        Visual("link_3", lying, "cylinder", (0.05, 0.8)),
        Visual("link_3", middle, "mesh", (1, 1, 1), "package://lost/link.stl"),
    ]
    test = looked_at(arm, visuals)
    assert test.unread == ("package://lost/link.stl",)
    assert test.hulls[0].radius == pytest.approx(0.41, abs=0.02)
    assert test.free(np.array([[0.0, 0.0, 0.0], [0.0, 2.1, 2.1]])).tolist() == [True, False]


def test_a_joint_that_stays_makes_its_links_one_part(arm: Body) -> None:
    test = SelfCollision.of(
        arm, boxes(), ("joint_1", "joint_2"), np.empty((0, 3)), np.random.default_rng(0)
    )
    assert test is not None
    assert len(test.pairs) == 0


def test_no_shape_no_test(arm: Body) -> None:
    lost = [Visual("link_1", np.eye(4), "mesh", (1, 1, 1), "package://lost/link.stl")]
    rng = np.random.default_rng(0)
    assert SelfCollision.of(arm, lost, JOINTS, np.empty((0, 3)), rng) is None
    assert SelfCollision.of(arm, [], JOINTS, np.empty((0, 3)), rng) is None


def test_a_broken_mesh_is_one_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "broken.stl").write_text("no mesh")
    broken = Visual("link_1", np.eye(4), "mesh", (1, 1, 1), str(tmp_path / "broken.stl"))
    assert hulls_of([broken]) == ([], [str(tmp_path / "broken.stl")])


def test_missing_packages_are_named(arm: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fcl", None)
    with pytest.raises(MissingExtraError, match=r"python-fcl.*bodyschema\[mesh\]"):
        looked_at(arm, boxes())
    monkeypatch.setitem(sys.modules, "trimesh", None)
    mesh = Visual("link_1", np.eye(4), "mesh", (1, 1, 1), "link.stl")
    with pytest.raises(MissingExtraError, match=r"trimesh.*bodyschema\[mesh\]"):
        looked_at(arm, [mesh])
