"""Surfaces: pieces of a body, their planes, decimation and its cache."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.simulation import icub
from bodyschema.vision import decimation
from bodyschema.vision.surface import Surface
from icub_arm import BUDGET, LINKS, arm

trimesh = pytest.importorskip("trimesh")

URDF = """<robot name="arm">
  <link name="base"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <link name="upper"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <link name="cap"><visual><geometry><mesh filename="cap.stl"/></geometry></visual></link>
  <link name="bare"/>
  <joint name="elbow" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 1 0"/></joint>
  <joint name="screw" type="fixed"><parent link="upper"/><child link="cap"/>
    <origin xyz="0.3 0 0"/></joint>
  <joint name="rod" type="continuous"><parent link="cap"/><child link="bare"/></joint>
</robot>"""


@pytest.fixture
def body(tmp_path: Path) -> Body:
    trimesh.creation.icosphere(subdivisions=3, radius=0.05).export(tmp_path / "cap.stl")
    (tmp_path / "arm.urdf").write_text(URDF)
    return Body.from_urdf(tmp_path / "arm.urdf")


def test_links_behind_fixed_joints_are_one_piece(body: Body) -> None:
    surface = Surface.of(body, faces=0)
    assert surface.frames == ("base", "upper")
    assert np.diff(surface.fo).tolist() == [12, 2 * 1280]
    upper = surface.vertices[surface.vo[1] :]
    np.testing.assert_allclose(upper.max(axis=0)[0], 0.35, atol=1e-3)
    assert Surface.of(body, ["cap"], faces=0).frames == ("upper",)


def test_faces_are_kept_within_the_budget_of_their_piece(body: Body) -> None:
    assert np.diff(Surface.of(body, faces=200).fo).tolist() == [12, 200]
    assert np.diff(Surface.of(body, faces={"cap": 300}).fo).tolist() == [12, 300]


def test_planes_hold_their_faces_and_point_outward(body: Body) -> None:
    surface = Surface.of(body, ["base", "upper"])
    normal, d = surface.planes[:, :3], surface.planes[:, 3]
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1)
    for corner in surface.faces.T:
        np.testing.assert_allclose(np.sum(normal * surface.vertices[corner], axis=1), d, atol=1e-15)
    assert (d[:12] > 0).all()  # the box has its own origin inside


def test_offsets_and_edges_stay_within_their_piece() -> None:
    surface = arm()
    for b in range(len(surface.frames)):
        faces = surface.faces[surface.fo[b] : surface.fo[b + 1]]
        edges = surface.edges[surface.eo[b] : surface.eo[b + 1]]
        assert surface.vo[b] <= min(faces.min(), edges[:, :2].min())
        assert max(faces.max(), edges[:, :2].max()) < surface.vo[b + 1]
        assert (surface.fo[b] <= edges[:, 2]).all()
        assert (edges[:, 2] < surface.fo[b + 1]).all()
    assert surface.fo[-1] == 1182
    assert surface.eo[-1] == len(surface.edges)


def test_vertices_of_equal_position_are_welded_and_empty_faces_dropped() -> None:
    V = [[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1], [-0.0, 0, 1]]
    surface = Surface.build({"a": (V, [[0, 1, 2], [3, 5, 4], [0, 6, 1]])})
    assert surface.vertices.shape == (4, 3)
    assert len(surface.faces) == 2
    assert len(surface.edges) == 5


def test_the_cache_is_used_and_mistrusted(
    body: Body, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"
    monkeypatch.setenv("BODYSCHEMA_CACHE", str(cache))
    first = Surface.of(body, faces=200)
    stored = sorted(cache.rglob("*.npz"))
    assert len(stored) == 2
    with monkeypatch.context() as patch:
        patch.setattr(decimation, "triangles_of", None)  # would fail if a mesh were read
        np.testing.assert_array_equal(Surface.of(body, faces=200).vertices, first.vertices)
    for path in stored:
        path.write_bytes(path.read_bytes()[:100])
    np.testing.assert_array_equal(Surface.of(body, faces=200).vertices, first.vertices)
    assert len(Surface.of(body, faces=100).faces) == 112


def test_the_cache_follows_the_content_of_the_mesh(body: Body, tmp_path: Path) -> None:
    before = Surface.of(body, ["cap"], faces=0)
    trimesh.creation.box(extents=(0.1, 0.1, 0.1)).export(tmp_path / "cap.stl")
    after = Surface.of(body, ["cap"], faces=0)
    assert len(before.faces) - len(after.faces) == 1280 - 12


def test_a_cache_that_cannot_be_written_does_no_harm(
    body: Body, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "file"
    place.write_text("in the way")  # a folder cannot be made here, whoever runs the test
    monkeypatch.setenv("BODYSCHEMA_CACHE", str(place))
    assert len(Surface.of(body, faces=200).faces) == 212


def test_decimation_is_the_same_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    for name in ("one", "two"):
        monkeypatch.setenv("BODYSCHEMA_CACHE", str(tmp_path / name))
        made.append(Surface.of(icub.bare_icub(), LINKS, BUDGET))
        shutil.rmtree(tmp_path / name)
    np.testing.assert_array_equal(made[0].vertices, made[1].vertices)
    np.testing.assert_array_equal(made[0].edges, made[1].edges)


def test_a_surface_that_cannot_be_is_refused(body: Body) -> None:
    with pytest.raises(InputError, match="did you mean 'upper'"):
        Surface.of(body, ["uper"])
    with pytest.raises(InputError, match=r"'bare' of arm has no shape.*'base', 'cap', 'upper'"):
        Surface.of(body, ["bare"])
    with pytest.raises(InputError, match="at least one triangle"):
        Surface.build({"a": (np.zeros((3, 3)), [[0, 1, 2]])})
    with pytest.raises(InputError, match="a face without one"):
        Surface.build({"a": (np.eye(3), [[0, 1, 3]])})
