"""Solids: closed, outward, met by lines as another library says, and nearest where missed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.solid import Solid
from bodyschema.model.tree import Body, Visual

trimesh = pytest.importorskip("trimesh")

PLACE = lie.transform(lie.exp_so3([0.3, -0.2, 0.5]), [0.01, 0.02, 0.03])
SOLIDS = {
    "box": (Solid.box((0.1, 0.2, 0.3), PLACE), 0.006),
    "cylinder": (Solid.cylinder(0.05, 0.3, PLACE), np.pi * 0.05**2 * 0.3),
    "ball": (Solid.ball(0.1, PLACE), 4 / 3 * np.pi * 1e-3),
}


def lines(count, seed=0):
    """Points and unit directions through and past the solids."""
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(count, 3))
    return 0.08 * rng.normal(size=(count, 3)), u / np.linalg.norm(u, axis=1, keepdims=True)


@pytest.mark.parametrize("name", SOLIDS)
def test_shapes_are_closed_and_look_outward(name):
    solid, volume = SOLIDS[name]
    mesh = trimesh.Trimesh(solid.vertices, solid.faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=3e-3)


@pytest.mark.parametrize("name", SOLIDS)
def test_entries_are_those_of_another_library(name):
    solid, _ = SOLIDS[name]
    mesh = trimesh.Trimesh(solid.vertices, solid.faces, process=False)
    for p, u in zip(*lines(60), strict=True):
        met = solid.pressed(u, p, u)
        hits, _, faces = mesh.ray.intersects_location([p - u], [u], multiple_hits=True)
        entries = sorted(
            (h - p) @ u for h, f in zip(hits, faces, strict=True) if mesh.face_normals[f] @ u < 0
        )
        assert met.inside == bool(entries)
        if entries:
            assert (met.points - p) @ u == pytest.approx(entries, abs=1e-6)
            assert (met.normals @ u < 0).all()


def test_a_missed_solid_is_passed_at_its_nearest_place():
    solid, _ = SOLIDS["box"]
    _, u = lines(60, seed=3)
    for direction in u:
        away = lie.tangent_basis(direction)[:, 0]
        p = solid.centre + 0.25 * away
        met = solid.pressed(direction, p, direction)
        assert not met.inside
        # Brute force: dense points of the faces that the push presses on.
        pressed = solid.corners[solid.normals @ direction < 0]
        shares = np.random.default_rng(0).dirichlet([0.3, 0.3, 0.3], 4000)
        dense = np.einsum("sk,mki->msi", shares, pressed).reshape(-1, 3) - p
        gaps = np.linalg.norm(dense - (dense @ direction)[:, None] * direction, axis=1)
        gap = met.points[0] - p
        gap = np.linalg.norm(gap - (gap @ direction) * direction)
        assert gap <= gaps.min() + 1e-9
        assert gap == pytest.approx(gaps.min(), abs=2e-3)


def test_only_faces_that_are_pressed_count():
    box = Solid.box((0.2, 0.2, 0.2))
    down = np.array([0.0, 0.0, -1.0])
    met = box.pressed(down, np.zeros(3), down)
    assert met.points == pytest.approx(np.array([[0.0, 0.0, 0.1]]))
    slanted = np.array([0.6, 0.0, -0.8])
    assert box.pressed(slanted, np.zeros(3), slanted, limit=0.7).normals[0] == pytest.approx(-down)


def test_a_mesh_file_is_scaled_and_placed(tmp_path: Path):
    source, _ = SOLIDS["cylinder"]
    path = tmp_path / "cylinder.stl"
    trimesh.Trimesh(1e3 * source.vertices, source.faces).export(path)
    read = Solid.from_mesh(path, scale=1e-3, T=np.eye(4))
    assert read.centre == pytest.approx(source.centre, abs=1e-6)
    assert read.radius == pytest.approx(source.radius, abs=1e-6)


def test_the_shape_of_a_link_in_the_frame_of_the_sensor():
    body = Body.random_chain(2, np.random.default_rng(0))
    visual = Visual("link_2", np.eye(4), "box", (0.1, 0.1, 0.1))
    body = body.attach("sensor", "link_2", PLACE)
    body = type(body)(**{**body.__dict__, "visuals": (visual,)})
    seen = Solid.from_link(body, "link_2", "sensor")
    assert seen.centre == pytest.approx(lie.inverse(PLACE)[:3, 3])
    with pytest.raises(InputError, match="a joint moves"):
        Solid.from_link(body, "link_2", "link_1")
    with pytest.raises(InputError, match="has no shape"):
        Solid.from_link(body, "link_1")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Solid.box((0.1, 0.2)),
        lambda: Solid.box((0.1, 0.2, -0.1)),
        lambda: Solid.cylinder(0.1, np.nan),
        lambda: Solid.ball(0.1, np.eye(3)),
        lambda: Solid(np.zeros((3, 3)), np.array([[0, 1, 3]])),
        lambda: Solid.from_mesh("nowhere.stl"),
    ],
)
def test_what_is_no_solid_is_refused(make):
    with pytest.raises(InputError):
        make()
