"""Places of contacts: exact on exact wrenches, and with covariances that finite changes confirm."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.learners.published.linear_relation import Moments, PaperRelation
from bodyschema.learners.touch.evidence import Principal
from bodyschema.learners.touch.place import locate, misfit, twist
from bodyschema.model.solid import Solid

NOISE = np.diag([0.02, 0.02, 0.02, 5e-4, 5e-4, 5e-4]) ** 2
BOX = Solid.box((0.1, 0.12, 0.18), lie.transform(np.eye(3), [0.016, -0.021, 0.092]))


def wrench(f, r, pitch=0.0):
    """Of a force at a point, with a couple along it."""
    return np.concatenate([f, np.cross(r, f) + pitch * np.asarray(f)])


def seen(*wrenches):
    """As principal wrenches with the noise of one sample."""
    return Principal(np.array(wrenches), np.repeat(NOISE[None], len(wrenches), axis=0))


def directions(count, spread, rng):
    """Forces of 1 N about the downward direction."""
    turns = spread * rng.normal(size=(count, 3))
    return lie.exp_so3(turns) @ np.array([0.0, 0.0, -1.0])


def test_one_exact_force_is_found_on_the_surface():
    f, r = np.array([0.3, 0.1, -1.0]), np.array([0.03, -0.05, 0.182])
    found = locate(seen(wrench(f, r)), f, BOX)
    assert found.places[0].point == pytest.approx(r, abs=1e-6)
    assert found.places[0].normal == pytest.approx([0, 0, 1])
    assert found.places[0].misfit < 1e-6
    assert found.inside


def test_the_push_comes_from_outside_whatever_the_rough_direction():
    f, r = np.array([0.0, 0.0, -1.0]), np.array([0.0, -0.02, 0.182])
    for rough in (f, f + 0.3):
        assert locate(seen(wrench(f, r)), rough, BOX).places[0].point == pytest.approx(r, abs=1e-6)


def test_a_miss_is_the_nearest_place_and_says_so():
    f, r = np.array([0.0, 0.0, -5.0]), np.array([0.076, -0.02, 0.182])
    found = locate(seen(wrench(f, r)), f, BOX)
    assert not found.inside
    assert found.places[0].point[0] == pytest.approx(0.066, abs=1e-6)
    assert found.places[0].misfit > 50


def test_the_covariance_is_what_noise_does():
    rng = np.random.default_rng(0)
    f, r = np.array([0.4, -0.2, -1.0]), np.array([0.01, -0.02, 0.182])
    exact = wrench(f, r)
    stated = locate(seen(exact), f, BOX).places[0].covariance
    noisy = exact + rng.normal(size=(600, 6)) @ np.sqrt(NOISE)
    points = np.array([locate(seen(w), f, BOX).places[0].point for w in noisy])
    measured = np.cov(points.T)
    assert stated[:2, :2] == pytest.approx(measured[:2, :2], rel=0.2, abs=3e-7)
    assert np.abs(stated[2]).max() < 1e-12


@pytest.mark.parametrize("spread", [0.0, 0.2])
def test_a_surface_that_may_be_off_is_in_the_covariance_and_yields_to_forces_that_meet(spread):
    """By a surface 3 mm off, the place errs as stated; forces that meet say where it is."""
    rng, doubt, squares, apart = np.random.default_rng(5), 3e-3, [], []
    r = np.array([0.01, -0.02, 0.182])
    for _ in range(200):
        exact = [wrench(10 * f, r) for f in directions(4, spread, rng)]
        noisy = [w + np.sqrt(np.diag(NOISE)) * rng.normal(size=6) for w in exact]
        told = Solid(BOX.vertices + doubt * rng.normal(size=3), BOX.faces)
        place = locate(seen(*noisy), noisy[0][:3], told, doubt).places[0]
        d = place.point - r
        squares.append(d @ np.linalg.solve(place.covariance, d) / 3)
        apart.append(np.linalg.norm(d))
    assert np.mean(squares) == pytest.approx(1.0, abs=0.25)
    size = np.sqrt(np.mean(np.square(apart)))
    assert size < 1e-3 if spread else size == pytest.approx(doubt, rel=0.2)


def test_a_surface_that_may_be_off_excuses_what_lies_beside_it_by_so_much():
    rng, r = np.random.default_rng(6), np.array([0.01, -0.02, 0.182])
    found = seen(*(wrench(20 * f, r) for f in directions(4, 0.3, rng)))
    off = Solid(BOX.vertices + np.array([0.0, 0.0, 0.004]), BOX.faces)
    exact, doubted = (locate(found, found.wrenches[0, :3], off, s) for s in (0.0, 2e-3))
    assert exact.places[0].misfit > 50
    assert doubted.places[0].misfit == pytest.approx(4.0, rel=0.2)


def test_the_misfit_of_the_truth_is_chi_square():
    rng = np.random.default_rng(1)
    f, r = np.array([0.4, -0.2, -1.0]), np.array([0.01, -0.02, 0.182])
    noisy = wrench(f, r) + rng.normal(size=(2000, 6)) @ np.sqrt(NOISE)
    assert np.mean([misfit(seen(w), r) for w in noisy]) == pytest.approx(3.0, abs=0.2)


def test_a_couple_along_the_force_is_no_point():
    f, r = np.array([0.0, 0.0, -2.0]), np.array([0.01, -0.02, 0.182])
    found = locate(seen(wrench(f, r, pitch=0.006)), f, BOX)
    assert found.pitch == pytest.approx(0.006)
    assert found.places[0].misfit > 20
    # Noise of the torque along the force, and of the force with its arm across it.
    arm = np.hypot(0.01, 0.02)
    expected = np.hypot(5e-4, 0.02 * arm) / 2
    assert twist(wrench(f, r), NOISE, r)[1] == pytest.approx(expected, rel=1e-6)


def test_two_entries_are_told_apart_by_another_direction():
    slabs = [Solid.box((0.2, 0.2, 0.01), lie.transform(np.eye(3), [0, 0, z])) for z in (0.1, 0.2)]
    both = Solid(
        np.vstack([slab.vertices for slab in slabs]),
        np.vstack([slabs[0].faces, slabs[1].faces + len(slabs[0].vertices)]),
    )
    f, below = np.array([0.0, 0.0, -1.0]), np.array([0.02, 0.03, 0.105])
    one = locate(seen(10 * wrench(f, below)), f, both)
    assert [round(place.point[2], 3) for place in one.places] == [0.205, 0.105]
    slanted = np.array([0.3, 0.0, -1.0])
    two = locate(seen(10 * wrench(f, below), 10 * wrench(slanted, below)), f, both)
    assert two.places[0].point == pytest.approx(below, abs=1e-6)
    assert two.places[0].chance > 0.999


def test_without_a_surface_several_directions_find_the_point():
    rng = np.random.default_rng(2)
    r = np.array([0.05, -0.03, 0.15])
    errors, scaled, plain = [], [], []
    for _ in range(60):
        forces = directions(10, np.radians(20), rng)
        noisy = [wrench(f, r) + rng.normal(size=6) @ np.sqrt(NOISE / 10) for f in forces]
        found = locate(Principal(np.array(noisy), np.repeat(NOISE[None] / 10, 10, axis=0)),
                       forces.sum(axis=0), None)  # fmt: skip
        e = found.places[0].point - r
        errors.append(np.linalg.norm(e))
        scaled.append(e @ np.linalg.solve(found.places[0].covariance, e))
        moments = Moments.empty(4)
        for w in noisy:
            moments = moments.add(np.hstack([lie.skew(w[:3]), w[3:, None]]))
        plain.append(PaperRelation(4, rotation=False).solve(moments).x[:3] - r)
    assert np.median(errors) < 1.5e-3
    assert np.median(errors) < 1.1 * np.median(np.linalg.norm(plain, axis=1))
    assert 2.0 < np.mean(scaled) < 4.5


def test_one_direction_without_a_surface_leaves_its_line_open():
    rng = np.random.default_rng(3)
    f, r = np.array([0.0, 0.0, -1.0]), np.array([0.05, -0.03, 0.15])
    exact = np.array([3 * wrench(f, r), wrench(f, r)])
    place = locate(seen(*exact), f, None).places[0]
    assert place.point[:2] == pytest.approx(r[:2], abs=1e-5)
    # Noise turns the two forces a little apart, which must not be taken for two directions.
    for _ in range(20):
        noisy = exact + rng.normal(size=(2, 6)) @ np.sqrt(NOISE)
        spread = locate(seen(*noisy), f, None).places[0].covariance
        assert np.linalg.eigvalsh(spread)[-1] == pytest.approx(1.0, rel=1e-3)
