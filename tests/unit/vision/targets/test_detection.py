"""Corners of drawn boards, numbered as `Target` says and where a pin-hole puts them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.vision.targets.target import Target
from drawn_board import K, drawn

cv2 = pytest.importorskip("cv2")

from bodyschema.vision.targets.detection import dictionary, find_target  # noqa: E402

Array = NDArray[np.float64]

TARGETS = {
    "chessboard": Target("chessboard", 8, 5, 0.025),
    "charuco": Target("charuco", 7, 5, 0.025, 0.018, "4X4_50"),
    "tags": Target("tags", 4, 3, 0.04, 0.03, "APRILTAG_36h11", first_id=5),
    "one tag": Target("tags", 1, 1, 0.12, 0.08, "4X4_50", first_id=3),
    "circles": Target("circles", 7, 5, 0.025),
    "asymmetric": Target("circles", 4, 7, 0.018, asymmetric=True),
}


def pose(target: Target, turn: tuple[float, float, float]) -> Array:
    R = lie.exp_so3(np.array(turn))
    middle = (target.corners.min(axis=0) + target.corners.max(axis=0)) / 2
    return lie.transform(R, np.array([0.01, -0.01, 0.4]) - R @ middle)


def seen(target: Target, T: Array) -> Array:
    p = (target.corners @ T[:3, :3].T + T[:3, 3]) @ K.T
    return p[:, :2] / p[:, 2:]


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("turn", [(0.3, -0.2, 0.1), (-0.2, 0.4, 2.8), (0.2, 0.2, -1.4)])
def test_corners_lie_where_they_are(name: str, turn: tuple[float, float, float]) -> None:
    target = TARGETS[name]
    T = pose(target, turn)
    found = find_target(target, drawn(target, T))
    assert found is not None
    assert len(found) >= 0.8 * len(target.corners)
    # A pattern that looks the same turned round may be numbered either way.
    errors = [found.image - seen(target, T @ F)[found.ids] for _, F in target.turns]
    rms = min(float(np.sqrt(np.mean(e**2))) for e in errors)
    assert rms < {"circles": 0.25, "asymmetric": 0.25, "tags": 0.3, "one tag": 0.3}.get(name, 0.1)
    assert (found.std > 0.04).all()
    assert (found.std < 1).all()


def test_only_symmetric_patterns_have_turns() -> None:
    counts = {(8, 5): 1, (9, 7): 2, (8, 6): 2, (6, 6): 4, (5, 5): 2}
    for (columns, rows), turns in counts.items():
        assert len(Target("chessboard", columns, rows, 0.02).turns) == turns
    assert len(TARGETS["charuco"].turns) == 1
    assert len(Target("circles", 10, 10, 0.02).turns) == 4
    for renumbered, F in Target("chessboard", 6, 6, 0.02).turns:
        corners = Target("chessboard", 6, 6, 0.02).corners
        assert corners[renumbered] == pytest.approx(corners @ F[:3, :3].T + F[:3, 3])


def test_a_blurred_corner_is_stated_to_be_worse() -> None:
    target = TARGETS["charuco"]
    rng = np.random.default_rng(0)
    sharp = drawn(target, pose(target, (0.3, -0.2, 0.1))).astype(float)
    noise = rng.normal(0, 3, sharp.shape)
    blurred = cv2.GaussianBlur(sharp, (0, 0), 1.3)
    stds = []
    for picture in (sharp, blurred):
        found = find_target(target, np.clip(picture + noise, 0, 255).astype(np.uint8))
        assert found is not None
        stds.append(float(np.median(found.std**2 - 0.05**2) ** 0.5))
    assert stds[1] > 1.2 * stds[0]


def test_nothing_is_found_where_nothing_is() -> None:
    grey = np.full((480, 640), 128, np.uint8)
    for target in TARGETS.values():
        assert find_target(target, grey) is None


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"kind": "chess"}, "did you mean 'chessboard'"),
        ({"columns": 1}, "3 of each or more"),
        ({"square_m": 25.0}, "in m"),
        ({"marker_m": 0.01}, "has no tags"),
        ({"kind": "charuco"}, "needs dictionary"),
    ],
)
def test_what_is_no_target_is_refused(changed: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(TARGETS["chessboard"], **changed).check("[[senses]] 1")


def test_an_unknown_dictionary_is_refused() -> None:
    with pytest.raises(InputError, match="4X4_50"):
        dictionary("4x4_5")
    assert dictionary("DICT_4X4_50") is not None
