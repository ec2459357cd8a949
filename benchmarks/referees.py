"""Silhouettes by others: a ray caster (Embree) and a renderer (MuJoCo, OpenGL)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.camera import Camera
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def iou(a: Flags, b: Flags) -> float:
    """Intersection over union of two masks."""
    return float(np.count_nonzero(a & b) / np.count_nonzero(a | b))


def ray_silhouette(surface: Surface, T: Array, camera: Camera, near: float = 0.01) -> Flags:
    """Which pixels' rays meet a triangle, from the near plane on, (height, width).

    Args:
        surface: the visible body.
        T: (n_pieces, 4, 4) T_cam_piece.
        camera: the view.
        near: m.
    """
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    piece = np.repeat(np.arange(len(surface.frames)), np.diff(surface.vo))
    points = np.einsum("vij,vj->vi", T[piece, :3, :3], surface.vertices) + T[piece, :3, 3]
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, points[surface.faces].astype(np.float32))
    f_x, f_y, c_x, c_y = camera.intrinsics
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = np.stack([(u - c_x) / f_x, (v - c_y) / f_y, np.ones_like(u)], axis=-1)
    rays = rays.reshape(-1, 3).astype(np.float32)
    return np.asarray(scene.run(np.float32(near) * rays, rays) >= 0).reshape(v.shape)


def mujoco_silhouettes(surface: Surface, T: Array, camera: Camera) -> Flags:
    """MuJoCo's segmentation: its own mesh reader, camera and rasteriser, (n, height, width).

    Its OpenGL back end is chosen when mujoco is first imported: set MUJOCO_GL before.

    Args:
        surface: the visible body.
        T: (n, n_pieces, 4, 4) T_cam_piece.
        camera: a view whose axis is in the middle of the image.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.visual.map.znear, spec.stat.extent = 0.01, 1.0
    spec.visual.quality.offsamples = 0
    spec.visual.global_.offwidth, spec.visual.global_.offheight = camera.width, camera.height
    for b, frame in enumerate(surface.frames):
        V = surface.vertices[surface.vo[b] : surface.vo[b + 1]]
        F = surface.faces[surface.fo[b] : surface.fo[b + 1]] - surface.vo[b]
        shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.add_mesh(name=frame, uservert=V.ravel(), userface=F.ravel(), inertia=shell)
        body = spec.worldbody.add_body(name=frame, mocap=True)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=frame)
    fovy = 2 * np.rad2deg(np.arctan(camera.height / 2 / camera.matrix[1, 1]))
    spec.worldbody.add_camera(name="eye", quat=[0, 1, 0, 0], fovy=fovy)  # looks along +z
    model = spec.compile()
    data = mujoco.MjData(model)
    masks = np.empty((len(T), camera.height, camera.width), dtype=bool)
    with mujoco.Renderer(model, camera.height, camera.width) as renderer:
        renderer.enable_segmentation_rendering()
        for i, poses in enumerate(T):
            data.mocap_pos[:] = poses[:, :3, 3]
            data.mocap_quat[:] = lie.quaternion_xyzw(poses[:, :3, :3])[:, [3, 0, 1, 2]]
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera="eye")
            masks[i] = renderer.render()[..., 0] >= 0
    return masks
