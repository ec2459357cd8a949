"""Films of robots that move: the same each time, and true."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.simulation.film import HEIGHT, WIDTH
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.simulation.random_motions import draw_motions

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

pytestmark = pytest.mark.usefixtures("offscreen")


@pytest.fixture(scope="module")
def film():
    return Studio(MovingScene("arm", "always", seed=1, motions=1, noise=0.0)).film()


def test_motions_stay_about_home_with_rests_between():
    rng = np.random.default_rng(0)
    home, reach = np.array([0.3, -0.2, 1.0]), np.array([0.1, 0.2, 0.3])
    drawn = draw_motions(home, 8, reach, rng)
    time = np.arange(0, drawn.seconds, 0.01)
    q = drawn.at(time)
    assert (np.abs(q - home) <= reach + 1e-12).all()
    assert (drawn.turn != 0).any(axis=1).all()
    rest = (time > drawn.end[0] + 0.01) & (time < drawn.end[0] + 0.45)
    assert np.ptp(q[rest], axis=0).max() < 1e-12


def test_the_same_scene_gives_the_same_film(film):
    again = Studio(MovingScene("arm", "always", seed=1, motions=1, noise=0.0)).film()
    np.testing.assert_array_equal(again.pictures, film.pictures)
    np.testing.assert_array_equal(again.q, film.q)
    assert again.delay_s == film.delay_s


def test_a_distractor_changes_nothing_of_the_robot(film):
    other = Studio(MovingScene("arm", "none", seed=1, motions=1, noise=0.0)).film()
    np.testing.assert_array_equal(other.q, film.q)
    np.testing.assert_array_equal(other.body, film.body)
    assert (other.pictures != film.pictures).any()


def test_pictures_show_the_robot_a_delay_ago():
    """A delay of three frames: each picture is what was seen three frames before without it."""
    pictures = []
    for frames in (0, 3):
        studio = Studio(MovingScene("arm", "none", seed=1, motions=1, noise=0.0))
        studio.delay = frames / 30
        pictures.append(studio.film().pictures)
    np.testing.assert_array_equal(pictures[1][3:], pictures[0][:-3])
    assert (pictures[0] != pictures[1]).any()


def test_speeds_are_what_the_outline_shows():
    """A small turn of one joint moves the body's pixels by speed times angle."""
    studio = Studio(MovingScene("arm", "none", seed=1, motions=1, noise=0.0))
    film, home, step = studio.film(), studio.motions.home, 0.01
    for joint in (0, 1):
        shares = []
        for sign in (-1, 1):
            studio._pose(home + sign * step * np.eye(len(home))[joint], np.zeros(0), 0.0)
            shares.append(np.isin(studio._shapes_seen(), studio._shapes))
        y, x = np.indices((HEIGHT, WIDTH))
        centres = [np.array([x[body].mean(), y[body].mean()]) for body in shares]
        moved = np.hypot(*(centres[1] - centres[0])) / (2 * step)
        expected = film.speed[joint][film.speed.sum(axis=0) > 0].mean()
        assert 0.5 * expected < moved < 1.5 * expected


def test_a_rod_is_carried_from_when_it_is_taken_until_it_is_released():
    scene = MovingScene(
        "humanoid", "none", seed=2, motions=3, carried="rod", taken=1, released=2, noise=0.0
    )
    film = Studio(scene).film()
    time, share = film.time[film.labelled], film.thing.mean(axis=(1, 2))
    begin, end = (film.motion_end[k] + film.delay_s + 0.1 for k in (0, 1))
    assert not share[time < begin].any()
    assert (share[time > begin + 0.1] > 0.001).all()
    still = film.thing[time > end + 0.1]
    last = film.body[time > end + 0.1]
    alone = ~last.any(axis=0)
    assert (still[:, alone] == still[0, alone]).mean() > 0.999


def test_a_scene_without_motion_or_with_negative_noise_is_refused():
    with pytest.raises(InputError, match="at least one motion"):
        MovingScene(motions=0)
    with pytest.raises(InputError, match="0 or more"):
        MovingScene(noise=-1.0)
