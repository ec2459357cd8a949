"""Controller forms and the URDF link of a load."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.payload import controller_forms, urdf_with_load
from bodyschema.model.inertia import Inertia

MOMENTS = np.array([[3e-3, 1e-4, -2e-4], [1e-4, 2.5e-3, 3e-4], [-2e-4, 3e-4, 1.5e-3]])
LOAD = Inertia(0.6, np.array([0.02, -0.03, 0.09]), MOMENTS)


def numbers(text):
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text)]


def test_ur_takes_diagonal_then_products():
    form = controller_forms(LOAD)["ur"]
    assert form.startswith("set_target_payload(0.6, [0.02, -0.03, 0.09], [")
    np.testing.assert_allclose(numbers(form)[4:], [3e-3, 2.5e-3, 1.5e-3, 1e-4, -2e-4, 3e-4])


def test_franka_takes_columns():
    values = numbers(controller_forms(LOAD)["franka"])
    np.testing.assert_allclose(values[:4], [0.6, 0.02, -0.03, 0.09])
    np.testing.assert_allclose(np.reshape(values[4:], (3, 3), order="F"), MOMENTS)


def test_kukas_principal_axes_give_the_moments_back():
    mass, x, y, z, a, b, c, *j = numbers(controller_forms(LOAD)["kuka"])
    assert (mass, x, y, z) == (0.6, 20.0, -30.0, 90.0)
    # A about z, then B about the new y, then C about the newest x.
    axes = np.eye(3)[::-1]
    turns = [lie.exp_so3(np.radians(t) * e) for t, e in zip((a, b, c), axes, strict=True)]
    R = turns[0] @ turns[1] @ turns[2]
    np.testing.assert_allclose(R @ np.diag(j) @ R.T, MOMENTS, atol=1e-8)


def test_abbs_axes_of_moment_give_the_moments_back():
    form = controller_forms(LOAD)["abb"]
    mass, x, y, z, qw, qx, qy, qz, *j = numbers(form)
    assert (mass, x, y, z) == (0.6, 20.0, -30.0, 90.0)
    assert form.startswith("[0.6, [20.0, -30.0, 90.0], [")
    R = lie.rotation_from_xyzw([qx, qy, qz, qw])
    np.testing.assert_allclose(R @ np.diag(j) @ R.T, MOMENTS, atol=1e-8)


def test_xarm_takes_mm():
    assert controller_forms(LOAD)["xarm"] == "set_tcp_load(0.6, [20.0, -30.0, 90.0])"


def test_a_link_is_added_and_nothing_else_changed():
    source = b"<robot name='r'>\n  <link name='tool'/> <!-- kept -->\n</robot>\n"
    load = {"mass": 0.6, "com": [0.02, -0.03, 0.09], "inertia": MOMENTS.tolist()}
    done = urdf_with_load(source, "tool", {"load 1": load})
    assert done.startswith(b"<robot name='r'>\n  <link name='tool'/> <!-- kept -->\n")
    assert done.endswith(b"</robot>\n")
    assert b'<link name="payload_load_1">' in done
    assert b'ixz="-0.0002"' in done
    with pytest.raises(InputError, match="already"):
        urdf_with_load(done, "tool", {"load 1": load})
    with pytest.raises(InputError, match="does not end"):
        urdf_with_load(b"<robot>", "tool", {"load": load})


def test_no_controller_is_told_what_is_not() -> None:
    load = Inertia(1.0, np.array([0.0, 0.0, 0.1]), np.diag([1e-3, 2e-3, 2e-3]))
    assert controller_forms(load, {"mass"}) == {}
    assert controller_forms(load, {"com", "I_xx"}) == {}
    bare = controller_forms(load, {"I_xx"})
    assert bare["ur"] == "set_target_payload(1.0, [0.0, 0.0, 0.1])"
    assert "J" not in bare["kuka"]
    assert "franka" not in bare
    assert set(controller_forms(load)) == {"ur", "kuka", "franka", "abb", "xarm"}
    assert set(bare) == {"ur", "kuka", "xarm"}
