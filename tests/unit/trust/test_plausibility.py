"""Whether what is left over is small against what was seen."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.free_hand import free_hand, hand_readings
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.trust.declarations import Declaration
from bodyschema.trust.neighbours import Neighbour
from bodyschema.trust.plausibility import (
    REFUSE,
    WARN,
    left_share,
    misdeclared,
    plausible,
    reach,
    refuse_beyond,
)
from simulated import points, poses, postures, random_poses, seen_arm

Array = NDArray[np.float64]


def arm() -> tuple[Body, Poses]:
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    return body, poses(body, postures(40, body, rng), rng)


def left(sense: Poses, position: float, rotation: float) -> Array:
    """Residuals (n, 6) of so many m and rad each."""
    residual = np.zeros((len(sense), 6))
    residual[:, 0], residual[:, 4] = position, rotation
    return residual


def test_noise_is_plausible() -> None:
    body, seen = arm()
    residual = seen.residual(body)
    assert plausible(body, [seen], [residual]).level == "good"
    assert left_share(body, [seen], [residual]) < 0.02


@pytest.mark.parametrize(
    ("share", "level"),
    [(0.9 * WARN, "good"), (1.1 * WARN, "limited"), (1.1 * REFUSE, "contradicted")],
)
def test_levels_by_the_share_of_positions_and_of_rotations(share: float, level: str) -> None:
    body, seen = arm()
    one = left_share(body, [seen], [left(seen, 1e-2, 0.0)])
    two = left_share(body, [seen], [left(seen, 0.0, 1e-2)])
    for residual in (left(seen, 1e-2 * share / one, 0.0), left(seen, 0.0, 1e-2 * share / two)):
        trust = plausible(body, [seen], [residual])
        assert trust.level == level
        assert all(f"{100 * share:.0f} %" in reason for reason in trust.reasons)


def test_outliers_are_not_asked() -> None:
    body, seen = arm()
    residual = seen.residual(body)
    residual[::3] = 5.0
    assert plausible(body, [seen], [residual]).level == "good"


def test_noise_of_a_motion_that_is_hardly_one_is_no_contradiction() -> None:
    """1 mm of noise on 2 mm of motion, 1 degree on 2."""
    body, _ = arm()
    rng = np.random.default_rng(1)
    small = poses(body, 1e-3 * postures(40, body, rng), rng)
    assert plausible(body, [small], [left(small, 1e-3, 0.017)]).level == "good"


def test_a_handful_of_samples_says_nothing() -> None:
    body, seen = arm()
    few = seen.take(range(4))
    assert plausible(body, [few], [left(few, 9.0, 3.0)]).level == "good"


def test_reach_is_that_of_the_links_and_of_what_slides() -> None:
    body, seen = arm()
    links = np.linalg.norm(body.placement[:, :3, 3], axis=1)
    own = [k for k, name in enumerate(body.frames) if name not in ("tracker", "tool")]
    assert reach(body, seen) == pytest.approx(links[own].sum())
    A = random_poses(30, np.random.default_rng(2))
    hand = free_hand().attach("eye", "base").attach("target", "hand")
    assert reach(hand, Poses.make(hand_readings(A), A, "eye", "target")) > 0.9


def test_what_is_seen_beyond_all_reach_is_refused() -> None:
    body, _ = arm()
    rng = np.random.default_rng(3)
    seen = points(body, postures(40, body, rng), rng)
    far = Points.make(seen.q, 1e3 * seen.position, "tracker", "tool")
    refuse_beyond(body, [seen], ())
    unit = Declaration('unit = "mm" for the lengths', "unit", 'unit = "mm"')
    named = Neighbour(unit, 500.0, (300.0, 0.0), (1e-3, 0.0))
    with pytest.raises(InputError, match=r"spreads over .* m where .* reaches .*unit = \"mm\""):
        refuse_beyond(body, [far], [named])
    with pytest.raises(InputError, match="look at the unit of the lengths"):
        refuse_beyond(body, [far], ())


def test_neighbours_in_a_sentence() -> None:
    first = Declaration("inverse = true", "mount", "inverse = true")
    second = Declaration("joint 'a' counted the other way round", "joint 0")
    one = Neighbour(first, 300.0, (0.6, 0.5), (1e-3, 2e-3))
    assert misdeclared(()).level == "good"
    trust = misdeclared([one])
    assert trust.level == "contradicted"
    [reason] = trust.reasons
    assert "inverse = true" in reason
    assert "300 times better" in reason
    assert "600 mm and 28.6 deg" in reason
    assert "1.00 mm and 0.115 deg" in reason
    assert "write inverse = true" in reason
    [both] = misdeclared([one, Neighbour(second, 290.0, (0.6, 0.5), (1e-3, 2e-3))]).reasons
    assert "or with joint 'a'" in both
    assert "round (the data do not tell these apart), the" in both
