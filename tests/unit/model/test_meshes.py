"""Triangles of visible shapes: primitives, mesh files, scales, and what cannot be read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.meshes import triangles_of
from bodyschema.model.tree import Visual

trimesh = pytest.importorskip("trimesh")

PLACEMENT = lie.transform(lie.exp_so3([0.3, -0.2, 0.5]), [0.1, 0.2, 0.3])


def volume(visual: Visual) -> float:
    """Signed volume of the shape's mesh: positive if its faces point outward."""
    vertices, faces = triangles_of(visual)
    return float(trimesh.Trimesh(vertices, faces, process=False).volume)


@pytest.mark.parametrize(
    ("shape", "size", "expected"),
    [
        ("box", (0.1, 0.2, 0.3), 0.006),
        ("cylinder", (0.1, 0.4), np.pi * 0.01 * 0.4),
        ("sphere", (0.1,), 4 / 3 * np.pi * 1e-3),
    ],
)
def test_primitives_have_their_volume(shape: str, size: tuple[float, ...], expected: float) -> None:
    assert volume(Visual("link", PLACEMENT, shape, size)) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("ending", ["stl", "obj", "dae"])
def test_a_mesh_file_is_scaled_and_placed(ending: str, tmp_path: Path) -> None:
    if ending == "dae":
        pytest.importorskip("collada")
    path = tmp_path / f"box.{ending}"
    trimesh.creation.box(extents=(1, 2, 3)).export(path)
    visual = Visual("link", PLACEMENT, "mesh", (0.1, 0.1, 0.2), str(path))
    vertices, _ = triangles_of(visual)
    local = (vertices - PLACEMENT[:3, 3]) @ PLACEMENT[:3, :3]
    np.testing.assert_allclose(local.max(axis=0), [0.05, 0.1, 0.3], atol=1e-6)
    assert volume(visual) == pytest.approx(0.012, rel=1e-5)


def test_the_unit_of_a_dae_file_is_heeded(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    path = tmp_path / "box.dae"
    trimesh.creation.box(extents=(1, 2, 3)).export(path)
    path.write_bytes(path.read_bytes().replace(b"</asset>", b'<unit meter="0.01"/></asset>'))
    vertices, _ = triangles_of(Visual("link", np.eye(4), "mesh", (1, 1, 1), str(path)))
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [0.01, 0.02, 0.03], rtol=1e-6)


def test_a_mirrored_mesh_is_not_inside_out(tmp_path: Path) -> None:
    path = tmp_path / "box.stl"
    trimesh.creation.box(extents=(1, 2, 3)).export(path)
    assert volume(Visual("link", np.eye(4), "mesh", (1, -1, 1), str(path))) > 0


def test_a_missing_or_broken_mesh_is_named(tmp_path: Path) -> None:
    missing = Visual("elbow", np.eye(4), "mesh", (1, 1, 1), "package://robot/elbow.stl")
    with pytest.raises(InputError, match=r"package://robot/elbow\.stl.*elbow.*not found"):
        triangles_of(missing)
    path = tmp_path / "broken.obj"
    path.write_text("v 0 0 0\n")
    with pytest.raises(InputError, match=r"broken\.obj.*cannot be read"):
        triangles_of(Visual("elbow", np.eye(4), "mesh", (1, 1, 1), str(path)))
