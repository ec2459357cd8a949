"""Any tree with anything wrong: written or patched and read again, it has the same poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.urdf_edits import baked_placements, urdf_edits
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_frame, free_joints, join

Array = NDArray[np.float64]
properties = settings(derandomize=True, deadline=None, database=None, max_examples=150)

RATES = st.one_of(st.sampled_from([1.0, -1.0, 0.0, -2.5]), st.floats(-3, 3))
# Rotations by quarter turns put many placements into gimbal lock.
ANGLES = st.one_of(st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, 1e-9]), st.floats(-4, 4))
LENGTHS = st.one_of(st.just(0.0), st.floats(-2, 2))
SIZES = st.sampled_from([0.0, 1e-10, 1e-3, 0.3])


@dataclass(frozen=True)
class Wrong:
    """A tree and the same tree with everything off."""

    nominal: Body
    corrected: Body
    q: Array


def vectors(numbers: st.SearchStrategy[float]) -> st.SearchStrategy[Array]:
    return st.tuples(numbers, numbers, numbers).map(np.array)


@st.composite
def trees(draw: st.DrawFn) -> Body:
    """Trees of up to six frames, all kinds of joints, some of them mimicking an earlier one."""
    n = draw(st.integers(1, 5))
    carriers = [f"joint_{k}" for k in range(1, n + 1)]
    kind = [draw(st.sampled_from([FIXED, REVOLUTE, REVOLUTE, PRISMATIC])) for _ in carriers]
    leaders: list[str] = []
    mimics = {}
    limits = {}
    for name, one in zip(carriers, kind, strict=True):
        if one != FIXED and leaders and draw(st.booleans()):
            mimics[name] = (draw(st.sampled_from(leaders)), draw(RATES), draw(LENGTHS))
        elif one != FIXED:
            leaders.append(name)
            low = draw(LENGTHS)
            limits[name] = draw(st.sampled_from([(low, low + 1), (-np.inf, np.inf)]))
    axis = [draw(vectors(st.floats(-1, 1)).filter(lambda a: np.linalg.norm(a) > 0.1))
            for _ in carriers]  # fmt: skip
    turns = [draw(vectors(ANGLES)) for _ in carriers]
    shifts = [draw(vectors(LENGTHS)) for _ in carriers]
    placement = lie.transform(lie.rotation_from_rpy(turns), np.array(shifts))
    return Body.build(
        name="tree",
        frames=["root", *(f"link_{k}" for k in range(1, n + 1))],
        carriers=["", *carriers],
        parent=[-1, *(draw(st.integers(0, k)) for k in range(n))],
        kind=[FIXED, *kind],
        axis=[[0.0, 0.0, 1.0], *axis],
        placement=[np.eye(4), *placement],
        limits=limits,
        mimics=mimics,
    )


@st.composite
def wrongs(draw: st.DrawFn) -> Wrong:
    nominal = draw(trees())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    fixed = [f for k, f in enumerate(nominal.frames) if k and nominal.kind[k] == FIXED]
    free = join(
        free_joints(nominal, ["offsets", "axes", "links"]),
        *(free_frame(nominal, frame) for frame in fixed),
    )
    x = draw(SIZES) * rng.uniform(-1, 1, len(free)) * rng.integers(0, 2, len(free))
    q = rng.uniform(-3, 3, (5, len(nominal.joints)))
    return Wrong(nominal, nominal.with_variables(free, x), q)


def poses(body: Body, like: Body, q: Array) -> Array:
    """Of the frames of another body, at the readings of its joints, by name."""
    columns = [like.joints.index(joint) for joint in body.joints]
    rows = [body.frame_index(frame) for frame in like.frames]
    return frame_poses(body, q[:, columns])[:, rows]


def read(text: bytes) -> Body:
    return parse_urdf(text, Path("robot.urdf"), {})


@properties
@given(wrongs())
def test_written_anew(wrong: Wrong) -> None:
    body = wrong.corrected
    back = read(write_urdf(body))
    assert back.joints == body.joints
    assert np.abs(poses(back, body, wrong.q) - poses(body, body, wrong.q)).max() < 1e-9
    limited = np.isfinite(body.lower) & np.isfinite(body.upper)
    assert np.allclose(back.lower[limited], body.lower[limited], rtol=0, atol=1e-9)


@properties
@given(wrongs())
def test_patched(wrong: Wrong) -> None:
    source = write_urdf(wrong.nominal)
    nominal = read(source)
    patched = read(patch_urdf(source, urdf_edits(nominal, wrong.corrected)))
    body = wrong.corrected
    assert np.abs(poses(patched, body, wrong.q) - poses(body, body, wrong.q)).max() < 1e-9
    assert np.array_equal(patched.shift, nominal.shift)
    assert np.array_equal(patched.rate, nominal.rate)
    assert np.array_equal(patched.upper, nominal.upper)
    stops = read(patch_urdf(source, urdf_edits(nominal, wrong.corrected, stops=True)))
    by_name = [body.joints.index(joint) for joint in patched.joints]
    shift = np.where(np.isfinite(nominal.lower), body.offset[by_name], 0.0)
    # Offsets that are too small to be written do not shift the limits either.
    assert np.allclose(stops.upper, nominal.upper - shift, rtol=0, atol=2e-12)


@properties
@given(wrongs())
def test_the_patched_file_describes_the_body_with_its_offsets_inside(wrong: Wrong) -> None:
    source = write_urdf(wrong.nominal)
    patched = read(patch_urdf(source, urdf_edits(read(source), wrong.corrected)))
    none = np.zeros(len(wrong.corrected.joints))
    inside = replace(wrong.corrected, placement=baked_placements(wrong.corrected), offset=none)
    assert urdf_edits(inside, patched) == {}
