"""Motion of cells: found where it is, and not where it has only leaked to."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.vision.background import background_flow
from bodyschema.vision.flow import CellFlow, cell_flow, in_company, prepare, reduction, repeats

cv2 = pytest.importorskip("cv2")

SIZE = (192, 144)


def blots(seed: int, shape: tuple[int, int]) -> np.ndarray:
    """A random texture."""
    raw = np.random.default_rng(seed).integers(0, 256, shape).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), 1.5), None, 20, 235, cv2.NORM_MINMAX)


def with_patch(wall: np.ndarray, x: float) -> np.ndarray:
    """The wall, before it a textured patch of 64 x 64 pixels at column x."""
    patch, image = blots(5, (64, 64)), wall.copy()
    A = np.array([[1.0, 0.0, x], [0.0, 1.0, 48.0]])
    mask = cv2.warpAffine(np.full_like(patch, 255), A, SIZE) > 127
    return np.where(mask, cv2.warpAffine(patch, A, SIZE), image)


def noisy(image: np.ndarray, seed: int, sigma: float = 2.0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0, sigma, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def between(before: np.ndarray, after: np.ndarray, turns: bool = False) -> CellFlow:
    return cell_flow(prepare(before, 16), prepare(after, 16), 16, 1, turns)


def test_a_moving_patch_moves_its_cells_and_no_others():
    wall = blots(1, SIZE[::-1])
    flow = between(noisy(with_patch(wall, 64.0), 1), noisy(with_patch(wall, 66.0), 2)).own
    inside = np.zeros(flow.shape[:2], dtype=bool)
    inside[3:7, 4:8] = True
    # Dense flow falls somewhat short on a texture as fine as this.
    np.testing.assert_allclose(flow[4:6, 5:7, 0], 1.7, atol=0.4)
    np.testing.assert_allclose(flow[4:6, 5:7, 1], 0.0, atol=0.2)
    far = ~cv2.dilate(inside.astype(np.uint8), np.ones((3, 3))).astype(bool)
    assert np.abs(flow[far]).max() < 0.05


def test_flow_does_not_leak_to_a_plain_wall():
    """Dense flow alone gives the cells beside the patch a good part of its motion."""
    wall = np.full(SIZE[::-1], 128, dtype=np.uint8)
    flow = between(noisy(with_patch(wall, 64.0), 1), noisy(with_patch(wall, 66.0), 2)).own
    assert np.hypot(*flow[4, 5]) > 1.0
    beside = np.concatenate([flow[3:7, 2], flow[3:7, 9], flow[1, 4:8], flow[8, 4:8]])
    assert np.abs(beside).max() < 0.1


def test_noise_and_a_shadow_are_no_motion():
    wall = blots(2, SIZE[::-1])
    darker = wall.astype(float)
    darker[:, 60:130] *= 0.85
    assert np.abs(between(noisy(wall, 1, 4.0), noisy(wall, 2, 4.0)).own).max() < 0.1
    assert np.abs(between(wall, darker.astype(np.uint8)).own[:, 5:7]).max() < 0.1


def test_a_shaking_camera_moves_nothing_of_its_own():
    wall = blots(3, (200, 260))
    before, after = wall[20:164, 20:212], wall[21:165, 22:214]
    flow = between(before, after)
    np.testing.assert_allclose(flow.background[..., 0], -2.0, atol=0.2)
    assert np.hypot(*np.moveaxis(flow.own, -1, 0)).mean() < 0.15


def test_a_repeated_picture_is_told_from_motion():
    wall = blots(1, SIZE[::-1])
    first = prepare(noisy(with_patch(wall, 64.0), 1), 16)
    assert repeats(first, prepare(noisy(with_patch(wall, 64.0), 2), 16), 16, 1)
    assert not repeats(first, prepare(noisy(with_patch(wall, 66.0), 2), 16), 16, 1)


def flags(*rows: str) -> np.ndarray:
    return np.array([[cell == "#" for cell in row] for row in rows])


def test_lone_cells_and_thin_lines_are_no_company():
    moves = flags(
        "#....#..", "........", "..#.....", "........", ".#####..", "........", ".......#"
    )
    assert not in_company(moves).any()
    block = flags("......", ".##...", ".##.#.", "......")
    np.testing.assert_array_equal(in_company(block), flags("......", ".##...", ".##...", "......"))


def test_what_enters_at_the_border_stays_whole():
    enters = flags("......", ".....#", "....##", "....##", "......", "##....")
    kept = in_company(enters)
    np.testing.assert_array_equal(kept[:5], enters[:5])
    assert not kept[5].any()


@pytest.mark.parametrize(
    ("width", "cell", "factor"), [(320, 16, 1), (640, 16, 2), (1280, 32, 4), (1280, 16, 2)]
)
def test_large_pictures_are_reduced_by_whole_factors(width, cell, factor):
    assert reduction(width, cell) == factor
    prepared = prepare(np.zeros((480, width), dtype=np.uint8), cell)
    assert prepared.shape == (480 // cell * cell // factor, width // factor)


def test_a_turning_camera_is_fitted_past_a_large_arm():
    """The eight numbers are those of a rotation; two fifths of the cells do as they like."""
    rng = np.random.default_rng(0)
    rows, cols = 15, 20
    y, x = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, cols), indexing="ij")
    truth = np.stack(
        [3.0 + 0.2 * y + 0.3 * x**2 - 0.1 * x * y, -1.0 - 0.2 * x + 0.3 * x * y - 0.1 * y**2],
        axis=-1,
    )
    seen = truth + 0.02 * rng.normal(size=truth.shape)
    seen[5:, 10:] += [-2.0, 1.5]
    fitted = background_flow(seen, np.ones((rows, cols)), turns=True)
    assert np.abs(fitted - truth).max() < 0.1


def test_a_camera_that_stands_gives_exactly_nothing():
    seen = np.zeros((9, 12, 2))
    seen[:4, :9] = [3.0, 1.0]
    assert not background_flow(seen, np.ones((9, 12)), turns=True).any()
    assert not background_flow(seen, np.ones((9, 12)), turns=False).any()
