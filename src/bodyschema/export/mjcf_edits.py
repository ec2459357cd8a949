"""Corrections put into the user's own MJCF, and not one byte more.

The place of a zero in MJCF is `ref`: a joint turns by q - ref, so one whose reading is o short has
ref - o. Where axis or placement were corrected too, the frame of the only joint of a body gives

    P M(a, q + o) Tr(-p),        T_0 = P M(a, r) Tr(-p),   axis = a,   ref = r - o

for the p and r of the file. Of several joints in one body only the zeros can be written: the frames
between them have no place of their own. MuJoCo itself writes six digits and no comments, so numbers
are spliced into the file; it is only asked what is in it (extra `sim`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.documents import file_bytes
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.export.joint_edit import clean
from bodyschema.export.mjcf_patch import MjcfPatch
from bodyschema.export.urdf_edits import SAME, described, node_offsets
from bodyschema.judging.places import FramePlace
from bodyschema.model.kernels import FIXED, PRISMATIC
from bodyschema.model.mjcf import compiled_mjcf
from bodyschema.model.mjcf_tree import OPTICAL
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

PLACED = ("body", "site", "camera")
"""Elements of MJCF that a fixed frame may be."""


def edited_mjcf(
    path: Path,
    nominal: Body,
    corrected: Body,
    added: Sequence[FramePlace] = (),
    elsewhere: bool = False,
) -> tuple[bytes, list[str]]:
    """The MJCF with corrected numbers.

    Args:
        path: of the file, which `read_mjcf` has read.
        nominal: the body that it describes.
        corrected: the same robot; frames that it has besides are skipped.
        added: frames to add, as sites; each hangs on a body of the file.
        elsewhere: it is to lie in another folder: then the folders of meshes and the files that
            it includes are named in full.

    Returns:
        The file, and the names of the joints that were changed.

    Raises:
        InputError: a correction that has no place in the file.
        MissingExtraError: mujoco is not installed.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("mujoco", "sim", f"writing '{path.name}'") from None
    model, spec, _ = compiled_mjcf(mujoco, path)
    patch = MjcfPatch(file_bytes(path, f"no MJCF at '{path}'."), str(path))
    matched, changed = described(nominal, corrected), []
    offsets = node_offsets(matched) - node_offsets(nominal)
    degree = bool(spec.compiler.degree)
    for k in range(1, len(nominal.frames)):
        moved = _differs(nominal, matched, k)
        if moved or abs(offsets[k]) > SAME:
            if matched.kind[k] == FIXED:
                _move(patch, matched.frames[k], matched.placement[k])
            else:
                _correct(patch, model, matched, k, float(offsets[k]), moved, degree)
            changed.append(nominal.carriers[k])
    for place in added:
        patch.add_child("body", place.parent, "site", {"name": place.frame, **_place(place.T)})
    if elsewhere:
        patch.anchor(path.resolve().parent)
    return patch.text(), sorted(changed)


def _differs(nominal: Body, matched: Body, k: int) -> bool:
    """Whether more than the zero was corrected."""
    turned = nominal.kind[k] != FIXED and np.abs(nominal.axis[k] - matched.axis[k]).max() > SAME
    return bool(turned or np.abs(nominal.placement[k] - matched.placement[k]).max() > SAME)


def _correct(
    patch: MjcfPatch, model: Any, body: Body, k: int, offset: float, moved: bool, degree: bool
) -> None:
    """Write what was corrected of one joint."""
    name, axis = body.carriers[k], body.axis[k]
    try:
        joint = model.joint(name)
    except KeyError:
        raise InputError(f"{name} of the MJCF has no name; give it one.") from None
    ref = float(model.qpos0[joint.qposadr[0]])
    slides = bool(body.kind[k] == PRISMATIC)
    if moved:
        b = int(model.jnt_bodyid[joint.id])
        if model.body_jntnum[b] > 1:
            raise InputError(
                f"more than the zero of joint '{name}' was corrected, and its body has several "
                "joints: give each a body of its own in the MJCF, or export a URDF, "
                "--out corrected.urdf."
            )
        turn = np.zeros(3) if slides else ref * axis
        shift = ref * axis if slides else np.zeros(3)
        back = lie.transform(np.eye(3), -model.jnt_pos[joint.id])
        T = body.placement[k] @ lie.transform(lie.exp_so3(turn), shift) @ back
        patch.place("body", model.body(b).name, _place(T))
        patch.set("joint", name, {"axis": _text(axis)})
    if offset:
        value = ref - offset
        written = float(np.degrees(value)) if degree and not slides else value
        patch.set("joint", name, {"ref": _text([written])})


def _move(patch: MjcfPatch, name: str, T: Array) -> None:
    """Write where a fixed frame is."""
    tag = next((tag for tag in PLACED if patch.has(tag, name)), "")
    if not tag:
        raise InputError(f"frame '{name}' has no place of its own in the MJCF.")
    T = T @ lie.transform(OPTICAL, np.zeros(3)) if tag == "camera" else T
    patch.place(tag, name, _place(T))


def _place(T: Array) -> dict[str, str]:
    x, y, z, w = lie.quaternion_xyzw(T[:3, :3])
    return {"pos": _text(T[:3, 3]), "quat": _text([w, x, y, z])}


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(clean(float(number))) for number in numbers)
