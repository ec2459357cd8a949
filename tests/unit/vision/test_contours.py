"""Silhouettes and their scores against plain pixel loops: any soup, any place, any thread."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.vision.contours import (
    ContourFit,
    fit_contours,
    silhouette,
    silhouette_spans,
)
from bodyschema.vision.depth_buffer import depth_image
from bodyschema.vision.observed import ObservedMask, contour_of
from bodyschema.vision.surface import Surface
from bodyschema.vision.warm_up import warm_up
from icub_arm import arm, eyes, hypotheses

pytest.importorskip("cv2")

VIEW = Camera.from_fov("view", "eye", 48, 36, 1.2)
HERE = np.eye(4)[None]
SEEDS = st.integers(0, 2**32 - 1)


def soup(rng: np.random.Generator, near_eye: bool) -> Surface:
    """Triangles that share vertices at random: open, non-manifold and wrongly wound."""
    n = int(rng.integers(1, 25))
    centre, size = ([0, 0, rng.uniform(-0.2, 0.8)], 0.4) if near_eye else ([0, 0, 3], 0.8)
    vertices = rng.normal(size=(int(rng.integers(4, 3 * n + 4)), 3)) * size + centre
    if not near_eye:
        vertices[:, 2] = np.maximum(vertices[:, 2], 0.3)
    faces = np.array([rng.choice(len(vertices), 3, replace=False) for _ in range(n)])
    return Surface.build({"soup": (vertices, faces)})


def plain_silhouette(surface: Surface, camera: Camera) -> np.ndarray:
    """Union of all triangles, each asked about every pixel, in float64."""
    return np.isfinite(depth_image(surface, HERE, camera))


def fits(a: ContourFit) -> np.ndarray:
    return np.stack([a.inside, a.area, a.distance, a.boundary])


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, near_eye=st.booleans())
def test_any_soup_covers_the_pixels_of_its_triangles(seed: int, near_eye: bool) -> None:
    """A pixel centre within 1e-3 px of an edge may fall on either side in float32."""
    surface = soup(np.random.default_rng(seed), near_eye)
    seen = silhouette(surface, HERE, VIEW)
    moved = [
        plain_silhouette(surface, Camera("", "", 48, 36, VIEW.matrix + 1e-3 * shift))
        for shift in (np.zeros((3, 3)), *(s * e for s in (-1, 1) for e in SHIFTS))
    ]
    sure = np.all(moved, axis=0) | ~np.any(moved, axis=0)
    np.testing.assert_array_equal(seen[sure], moved[0][sure])
    assert (~sure).sum() <= 12


SHIFTS = np.zeros((2, 3, 3))
SHIFTS[0, 0, 2] = SHIFTS[1, 1, 2] = 1


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS)
def test_scores_are_those_of_counting_pixels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    surface, other = soup(rng, near_eye=bool(seed % 2)), soup(rng, near_eye=False)
    mask = silhouette(other, HERE, VIEW)
    observed = ObservedMask.of(mask, truncation=7.0)
    imagined = silhouette(surface, HERE, VIEW)
    fit = fit_contours(surface, HERE[None, None], [VIEW], [observed])
    rim, distance = contour_of(imagined), np.diff(observed.distance_sums, axis=1)
    assert fit.inside.item() == (imagined & mask).sum()
    assert fit.area.item() == imagined.sum()
    assert fit.boundary.item() == rim.sum()
    assert fit.distance.item() == distance[rim].sum()


def test_spans_are_sorted_and_apart_and_make_the_mask() -> None:
    surface, camera = arm(), eyes()[0]
    T = hypotheses(1)[0, 0]
    mask = np.zeros((240, 320), dtype=bool)
    spans = silhouette_spans(surface, T, camera)
    for r, a, b in spans:
        assert 0 <= a < b <= 320
        mask[r, a:b] = True
    same_row = spans[1:, 0] == spans[:-1, 0]
    assert (spans[1:, 1] > spans[:-1, 2])[same_row].all()
    np.testing.assert_array_equal(mask, silhouette(surface, T, camera))
    assert mask.sum() > 4000


def test_every_view_of_the_arm_is_that_of_the_depth_buffer() -> None:
    T = hypotheses(6)
    for c, camera in enumerate(eyes()):
        for hypothesis in T:
            expected = np.isfinite(depth_image(arm(), hypothesis[c], camera))
            seen = silhouette(arm(), hypothesis[c], camera)
            assert (seen != expected).sum() <= 1  # a centre within float32 of an edge


def test_the_truth_fits_best_and_perfectly() -> None:
    T, cameras = hypotheses(40), eyes()
    observed = [ObservedMask.of(silhouette(arm(), T[0, c], cameras[c])) for c in (0, 1)]
    fit = fit_contours(arm(), T, cameras, observed)
    assert (fit.jaccard[0] == 1).all()
    assert (fit.chamfer[0] == 0).all()
    assert (fit.jaccard[1:] < 0.95).all()
    assert (fit.chamfer[1:] > 0.5).all()
    alone = fit_contours(arm(), T, cameras, observed, chamfer=False)
    np.testing.assert_array_equal(alone.jaccard, fit.jaccard)
    assert not alone.boundary.any()


def test_the_number_of_threads_changes_no_byte() -> None:
    T, cameras = hypotheses(50), eyes()
    observed = [ObservedMask.of(silhouette(arm(), T[0, c], cameras[c])) for c in (0, 1)]
    expected = fits(fit_contours(arm(), T, cameras, observed)).tobytes()
    for repeat in range(100):
        threads = 1 + repeat % 3
        again = fit_contours(arm(), T, cameras, observed, threads=threads)
        assert fits(again).tobytes() == expected


def test_several_threads_may_call_at_once() -> None:
    T, cameras = hypotheses(20), eyes()
    observed = [ObservedMask.of(silhouette(arm(), T[0, c], cameras[c])) for c in (0, 1)]
    expected = [fits(fit_contours(arm(), T[:n], cameras, observed)) for n in range(1, 20)]

    def call(n: int) -> np.ndarray:
        return fits(fit_contours(arm(), T[:n], cameras, observed, threads=1 + n % 2))

    with ThreadPoolExecutor(4) as pool:
        for found, truth in zip(pool.map(call, list(range(1, 20)) * 5), expected * 5, strict=True):
            np.testing.assert_array_equal(found, truth)


def comb(teeth: int) -> Surface:
    """Thin upright triangles side by side: two crossings a tooth in every row."""
    x = np.linspace(-0.9, 0.9, teeth)
    low = np.stack([x, np.full(teeth, 1.0), np.full(teeth, 1.0)], axis=1)
    half = np.array([0.8 / teeth, 0, 0])
    corners = [low - half, low + half, low * np.array([1, -1, 1])]
    vertices = np.stack(corners, axis=1).reshape(-1, 3)
    return Surface.build({"comb": (vertices, np.arange(3 * teeth).reshape(-1, 3))})


@pytest.mark.parametrize("teeth", [31, 32, 200])
def test_rows_that_overflow_are_done_again(teeth: int) -> None:
    """A row has 63 places at first: 31 teeth fit, 32 do not."""
    surface, camera = comb(teeth), Camera.from_fov("", "", 640, 40, np.pi / 2)
    expected = plain_silhouette(surface, camera)
    seen = silhouette(surface, HERE, camera)
    assert (seen != expected).sum() <= 1
    fit = fit_contours(surface, HERE[None, None], [camera], [ObservedMask.of(expected)])
    assert fit.area.item() == seen.sum()
    assert fit.boundary.item() == contour_of(seen).sum()


def test_an_overflow_leaves_its_neighbours_alone() -> None:
    """A comb that is turned away fits the rows; between two that do not, it must not be harmed."""
    surface, camera = comb(100), Camera.from_fov("", "", 640, 40, np.pi / 2)
    away = HERE.copy()
    away[0, 2, 3] = 200.0
    T = np.stack([HERE, away, HERE])[:, None]
    observed = [ObservedMask.of(silhouette(surface, HERE, camera))]
    fit = fit_contours(surface, T, [camera], observed)
    full = fit.observed.item()
    assert fit.area[:, 0].tolist() == [full, silhouette(surface, away, camera).sum(), full]


def test_a_body_out_of_view_is_no_evidence() -> None:
    surface = soup(np.random.default_rng(0), near_eye=False)
    for shift in ([100.0, 0, 0], [0, 100.0, 0], [-100.0, 0, 0], [0, 0, -100.0]):
        T = HERE.copy()
        T[0, :3, 3] = shift
        fit = fit_contours(surface, T[None, None], [VIEW], [ObservedMask.of(np.ones((36, 48)))])
        assert fit.area.item() == fit.boundary.item() == 0
        assert fit.jaccard.item() == 0
        assert np.isnan(fit.chamfer.item())


def test_a_body_that_fills_the_view_has_no_contour() -> None:
    wall = Surface.build({"": ([[-99, -99, 1], [99, -99, 1], [0, 99, 1]], [[0, 1, 2]])})
    fit = fit_contours(wall, HERE[None, None], [VIEW], [ObservedMask.of(np.ones((36, 48)))])
    assert fit.area.item() == 36 * 48
    assert fit.jaccard.item() == 1
    assert fit.boundary.item() == 0


def test_cameras_of_different_sizes_may_look() -> None:
    small, large = eyes(160, 120)[0], eyes(640, 480)[1]
    T = hypotheses(2)
    observed = [
        ObservedMask.of(silhouette(arm(), T[0, c], camera))
        for c, camera in enumerate((small, large))
    ]
    fit = fit_contours(arm(), T, [small, large], observed)
    assert (fit.jaccard[0] == 1).all()


def test_warming_up_tells_its_progress() -> None:
    told: list[tuple[int, int, str]] = []
    warm_up(lambda done, steps, name: told.append((done, steps, name)))
    assert [done for done, _, _ in told] == list(range(told[0][1] + 1))


def test_what_does_not_fit_together_is_refused() -> None:
    surface, seen = comb(3), ObservedMask.of(np.ones((36, 48)))
    with pytest.raises(InputError, match=r"1 cameras, 1 pieces.*\(1, 4, 4\)"):
        fit_contours(surface, HERE, [VIEW], [seen])
    with pytest.raises(InputError, match="1 cameras and 2 observed"):
        fit_contours(surface, HERE[None, None], [VIEW], [seen, seen])
    with pytest.raises(InputError, match=r"36 rows and 48 columns.*\(5, 5\)"):
        fit_contours(surface, HERE[None, None], [VIEW], [ObservedMask.of(np.ones((5, 5)))])
    with pytest.raises(InputError, match="near plane"):
        silhouette(surface, HERE, VIEW, near=0.0)
