"""Points, outlines and wrenches in one estimate, and three senses of which none is enough."""

from __future__ import annotations

import numpy as np
import pytest

import together

pytest.importorskip("cv2")


@pytest.mark.usefixtures("offscreen")
def test_each_sense_tells_another_joint_and_all_together_tell_them_all() -> None:
    std, off = together.arm4(2)
    mean = {name: each.mean(axis=0) for name, each in std.items()}
    assert (mean["all"] <= 0.08).all()
    assert (mean["wrenches"][:2] > 3).all()
    assert mean["wrenches"][2] < 0.1 < mean["outlines"][2]
    assert (mean["outlines"][:2] < 0.06).all()
    assert mean["points"][2] > 3
    z = np.concatenate([(off[name] / std[name]).ravel() for name in std])
    assert np.abs(z).max() < 4
    assert np.mean(np.abs(z) < 1.96) > 0.8


def test_what_one_sense_leaves_open_another_closes() -> None:
    found = together.arm7(1)
    opened = {name: " ".join(sentences) for name, sentences in found["open"].items()}
    assert "j1.offset" in opened["pixels"]
    assert "j7.offset" in opened["pixels"]
    assert "j7.offset" in opened["touches"]
    assert "j1.offset" in opened["gravity"]
    assert opened["all"] == ""
    assert max(found["std_deg"]["all"].values()) < 0.2
    assert found["within_95"] > 0.8
