"""Robots for the stage, built into a MuJoCo model: a five-joint arm of capsules and the iCub.

The arm has the measures of a Katana 6M180; where it is seen from, and through which lens, is drawn
at random. The iCub looks at its own right arm with its left eye, in a random posture that shows the
hand. Each camera sits on joints of its own: a pan and tilt head, or the neck.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.meshes import triangles_of
from bodyschema.simulation import eyes, icub, katana
from bodyschema.simulation.postures import draw_postures
from bodyschema.simulation.real_robot import RealRobot, bare_description

Array = NDArray[np.float64]
RobotName = Literal["arm", "humanoid"]

CAMERA = "eye"
"""Name of the camera in the model."""
ARM_REACH = np.array([0.12, 0.12, 0.16, 0.25, 0.5])
"""rad, motions of the five-joint arm about its posture."""
HUMANOID_REACH = np.array([0.08, 0.08, 0.12, 0.12, 0.25, 0.2, 0.2])
"""rad, motions of the iCub's right arm, shoulder to wrist."""
HEAD_REACH = 0.05
"""rad, motions of the joints that carry the camera."""
POSTURES = np.array([1.0, 0.5, 0.6, 0.6, 0.8])
"""rad either way of `katana.CENTRE`, postures of the five-joint arm."""
LENS_REACH = (0.3, 0.22)
"""Tangents of the angles off the optical axis within which the arm stays."""
LEAST_SPREAD = 0.3
"""Tangent that the arm spans from elbow to hand, so that it does not point at the camera."""
LINK_RADIUS = (0.05, 0.045, 0.04, 0.035, 0.03)
"""m, capsules of the arm."""


@dataclass(frozen=True)
class RobotOnStage:
    """A robot in a specification that other things can still be added to."""

    spec: Any
    """MuJoCo's specification."""
    arm: tuple[str, ...]
    """Joints that move the body before the camera."""
    head: tuple[str, ...]
    """Joints that carry the camera."""
    home: dict[str, float]
    """rad, the posture of all joints that are not at zero."""
    reach: Array
    """(arm + head,) rad of their motions about home."""
    hand: str
    """Body that holds things."""
    rod: Array
    """(2, 3) m in the hand, ends of what it may hold."""
    rod_radius: float
    """m"""
    sleeve: tuple[str, float, float, float]
    """Body that may wear a sleeve, its length along the body's axis from, to, and radius, m."""
    moving: tuple[str, ...]
    """Bodies that the arm's joints move, those further out included."""
    T_world_cam: Array
    """(4, 4) of the optical frame at home."""
    far: float
    """m from the camera to where the robot works."""


def five_joint_arm(
    mujoco: Any, patterns_of: Callable[[Any], list[str]], rng: np.random.Generator
) -> RobotOnStage:
    """The arm of capsules and a camera about 1 m away.

    Args:
        mujoco: the module.
        patterns_of: adds materials to a specification and returns their names.
        rng: of posture and camera.
    """
    body, spec = katana.katana(), mujoco.MjSpec()
    patterns = patterns_of(spec)
    place = spec.worldbody
    capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
    place.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.07, 0.09, 0], pos=[0, 0, 0.08],
        material=patterns[0], contype=0, conaffinity=0,
    )  # fmt: skip
    for k in range(1, 6):
        place = place.add_body(name=body.frames[k], pos=body.placement[k, :3, 3])
        place.add_joint(
            name=body.joints[k - 1], type=mujoco.mjtJoint.mjJNT_HINGE, axis=body.axis[k]
        )
        reach = float(body.placement[k + 1, 0, 3])
        if k > 1:
            place.add_geom(
                type=capsule, fromto=[0, 0, 0, reach, 0, 0], size=[LINK_RADIUS[k - 1], 0, 0],
                material=patterns[k], contype=0, conaffinity=0, mass=0.1,
            )  # fmt: skip
        else:
            place.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.06, 0, 0],
                           material=patterns[5], contype=0, conaffinity=0, mass=0.1)  # fmt: skip
    for y in (-0.025, 0.025):
        place.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 0.012, 0.03], pos=[0.13, y, 0],
            material=patterns[6], contype=0, conaffinity=0, mass=0.1,
        )  # fmt: skip
    T_world_cam = katana.draw_scene(rng).T_world_cam
    head = spec.worldbody.add_body(
        name="head",
        pos=T_world_cam[:3, 3] - 0.1 * T_world_cam[:3, 2],
        quat=_quat(mujoco, T_world_cam),
    )
    tilt = head.add_body(name="head_top")
    for name, axis, holder in (("head_pan", [0, 1, 0], head), ("head_tilt", [1, 0, 0], tilt)):
        holder.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        holder.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.001, 0, 0], mass=0.1,
                        contype=0, conaffinity=0)  # fmt: skip
    tilt.add_camera(name=CAMERA, pos=[0, 0, 0.1], quat=[0, 1, 0, 0], fovy=rng.uniform(30.0, 35.0))
    posture = _posture_in_view(T_world_cam, rng)
    return RobotOnStage(
        spec=spec, arm=body.joints, head=("head_pan", "head_tilt"),
        home=dict(zip(body.joints, posture.tolist(), strict=True)),
        reach=np.concatenate([ARM_REACH, [HEAD_REACH] * 2]), hand="roll",
        rod=np.array([[0.14, 0.0, 0.0], [0.20, 0.0, 0.18]]), rod_radius=0.03,
        sleeve=("elbow", -0.01, 0.15, 0.065),
        moving=body.frames[1:6], T_world_cam=T_world_cam, far=1.0,
    )  # fmt: skip


def _posture_in_view(T_world_cam: Array, rng: np.random.Generator) -> Array:
    """(5,) rad: all beyond the shoulder inside the image, the arm seen from the side."""
    body, T_cam_world = katana.katana(), lie.inverse(T_world_cam)
    while True:
        q = katana.CENTRE + rng.uniform(-1, 1, 5) * POSTURES
        T = [relative_pose(body, q, "base", name) for name in ("elbow", "wrist", "roll", "hand")]
        c = np.array([(T_cam_world @ pose)[:3, 3] for pose in T])
        flat = c[:, :2] / c[:, 2:]
        spread = np.hypot(*np.diff(flat, axis=0).T).sum()
        if (np.abs(flat) < LENS_REACH).all() and spread > LEAST_SPREAD:
            return np.asarray(q)


def humanoid(
    mujoco: Any, patterns_of: Callable[[Any], list[str]], rng: np.random.Generator
) -> RobotOnStage:
    """The iCub, its right arm in textured clothes, seen by its left eye."""
    body, robot = icub.bare_icub(), _real_icub()
    spec = mujoco.MjSpec.from_string(_icub_description())
    spec.compiler.discardvisual = False
    patterns = patterns_of(spec)
    moving = []
    for i, (frame, V, F) in enumerate(_arm_meshes()):
        shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.add_mesh(name=f"mesh_{i}", uservert=V.ravel(), userface=F.ravel(), inertia=shell)
        spec.body(frame).add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"mesh_{i}", contype=0, conaffinity=0, mass=0,
            material=patterns[1 + i % 5],
        )  # fmt: skip
        moving.append(frame)
    fovy = float(2 * np.rad2deg(np.arctan(eyes.HEIGHT / 2 / eyes.FOCAL_LENGTH)))
    fovy *= rng.uniform(0.85, 1.15)
    spec.body(icub.LEFT_EYE).add_camera(name=CAMERA, quat=[0, 1, 0, 0], fovy=fovy)
    q = draw_postures(robot, body, 1, rng)
    root, hand = body.frames[0], robot.poses(q, icub.LEFT_EYE, [icub.HAND])[0, 0]
    return RobotOnStage(
        spec=spec, arm=icub.RIGHT_ARM, head=icub.NECK,
        home=dict(zip(body.joints, q[0].tolist(), strict=True)),
        reach=np.concatenate([HUMANOID_REACH, [HEAD_REACH] * 3]), hand=icub.HAND,
        rod=np.array([[-0.06, 0.02, -0.08], [-0.06, 0.02, 0.16]]), rod_radius=0.02,
        sleeve=("r_forearm", -0.11, -0.01, 0.048), moving=tuple(moving),
        T_world_cam=robot.poses(q, root, [icub.LEFT_EYE])[0, 0], far=float(hand[2, 3]),
    )  # fmt: skip


@cache
def _real_icub() -> RealRobot:
    frames = icub.nominal_frames()
    return RealRobot(icub.urdf_path().read_bytes(), frames, icub.bare_icub().joints, {})


@cache
def _icub_description() -> str:
    return bare_description(icub.urdf_path().read_bytes(), icub.nominal_frames())


@cache
def _arm_meshes() -> list[tuple[str, Array, Any]]:
    """Frame, vertices and faces of the shapes of the right arm."""
    body = icub.bare_icub()
    first = body.frame_index("r_shoulder_1")
    shown = []
    for visual in body.visuals:
        above = body.frame_index(visual.frame)
        while above not in (first, -1):
            above = int(body.parent[above])
        if above == first:
            shown.append((visual.frame, *triangles_of(visual)))
    return shown


def _quat(mujoco: Any, T: Array) -> Array:
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    return quat
