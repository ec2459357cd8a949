"""Reading an MJCF (MuJoCo's own XML) into a Body, by way of MuJoCo's compiler (extra `sim`).

A body of MJCF has any number of joints, each with a point p and an axis a of its own, and is at its
place in the file where every joint stands at its `ref` r:

    T_parent_body = T_0  prod_j  Tr(p_j) M_j(q_j - r_j) Tr(-p_j)

A Body has one joint a frame, P_k M_k(q_k). So the joints of a body carry frames of their own, of
which the last is the body itself where its joint goes through its origin, and P_k holds M_k(-r_k).
Sites and cameras are fixed frames; those of cameras look along z, as optical frames do. Joints that
an equality ties to another one by a line mimic it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bodyschema.documents import file_bytes
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.mjcf_copies import refuse_copies
from bodyschema.model.mjcf_tree import MjcfTree
from bodyschema.model.mjcf_visuals import mjcf_visuals
from bodyschema.model.tree import Body

MISSING = "no robot description at '{}'; give the path of an MJCF file."

LIGHTEST = 1e-6
"""kg and kg m^2 of bodies whose meshes are not there: kinematics do not depend on them."""


def read_mjcf(path: Path) -> Body:
    """Read a robot description in MJCF.

    Args:
        path: the file; what it includes lies beside it. Meshes may be missing: then there are none.

    Raises:
        InputError: the file is missing, or MuJoCo does not compile it.
        MissingExtraError: mujoco is not installed.
    """
    file_bytes(path, MISSING.format(path))
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("mujoco", "sim", f"reading '{path.name}'") from None
    model, _, lacking = compiled_mjcf(mujoco, path)
    tree = MjcfTree(mujoco, model)
    for b in range(1, model.nbody):
        tree.add_body(b)
    tree.add_sites_and_cameras()
    remarks = tree.remarks
    if lacking:
        remarks.append(
            f"'{path.name}' was read without its shapes, of which a file cannot be read "
            f"({lacking}); joints do not depend on them."
        )
    return Body.build(
        name=_model_name(model) or path.stem,
        frames=tree.frames,
        carriers=tree.carriers,
        parent=tree.parent,
        kind=tree.kind,
        axis=tree.axis,
        placement=tree.placement,
        limits=tree.limits,
        mimics=_mimics(mujoco, model, tree, remarks),
        visuals=mjcf_visuals(mujoco, model, [tree.frames[k] for k in tree.of_body], path.parent),
        remarks=remarks,
    )


def compiled_mjcf(mujoco: Any, path: Path) -> tuple[Any, Any, str]:
    """The model, its specification, and why it is without its shapes; "" where it has them.

    Raises:
        InputError: MuJoCo does not compile it, or would make too many copies.
    """
    refuse_copies(path)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except Exception as error:
        raise _uncompiled(path, error) from None
    try:
        return spec.compile(), spec, ""
    except Exception as error:
        try:
            bare = _without_shapes(mujoco, path)
            return bare.compile(), bare, _short(error)
        except Exception:  # what is wrong is something else: what was said first counts
            raise _uncompiled(path, error) from None


def _without_shapes(mujoco: Any, path: Path) -> Any:
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in [g for g in spec.geoms if g.meshname or g.hfieldname or g.material]:
        spec.delete(geom)
    for shapes in (spec.skins, spec.meshes, spec.hfields, spec.materials, spec.textures):
        for shape in list(shapes):
            spec.delete(shape)
    spec.compiler.boundmass = spec.compiler.boundinertia = LIGHTEST
    return spec


def _uncompiled(path: Path, error: Exception) -> InputError:
    return InputError(f"'{path}' is no MJCF that MuJoCo compiles: {_short(error)}.")


def _short(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")[:200]


def _model_name(model: Any) -> str:
    return bytes(model.names[: model.names.index(b"\0")]).decode("utf-8", "replace")


def _mimics(
    mujoco: Any, model: Any, tree: MjcfTree, remarks: list[str]
) -> dict[str, tuple[str, float, float]]:
    """Joint -> (joint followed, rate, shift) of every equality that is a line."""
    found: dict[str, tuple[str, float, float]] = {}
    for e in range(model.neq):
        if model.eq_type[e] != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[e]:
            continue
        follower, leader = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        a0, a1, *rest = (float(value) for value in model.eq_data[e, :5])
        name = tree.joint_name(follower)
        if leader < 0 or any(rest) or {follower, leader} & tree.held or name in found:
            remarks.append(
                f"The equality of joint '{name}' is no line of one other joint: it counts as "
                "a joint of its own."
            )
            continue
        y0, x0 = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (follower, leader))
        found[name] = (tree.joint_name(leader), a1, y0 + a0 - a1 * x0)
    for name, (leader_name, _, _) in found.items():
        if leader_name in found:
            raise InputError(
                f"joint '{name}' follows '{leader_name}', which follows another one; tie both to "
                "the joint that moves."
            )
    return found
