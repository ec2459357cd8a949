"""What seen points can tell of a humanoid: counted, named, and without effect on predictions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.determinable import Determinable, determinable
from bodyschema.estimation.identifiability import random_postures
from bodyschema.estimation.invisible import invisible_motions, take_out
from bodyschema.learners.skeletons.shortest_links import with_shortest_links
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints, free_skeleton
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.simulation.humanoid import BETWEEN, ENDS, EYE, STRAIGHT, humanoid
from simulated import seen_arm

Array = NDArray[np.float64]


def looks(body: Body, seen: Sequence[str], seen_from: str = EYE) -> list[Points]:
    nothing = np.empty((0, len(body.joints)))
    return [Points.make(nothing, np.empty((0, 3)), seen_from, marker) for marker in seen]


def told(body: Body, seen: Sequence[str]) -> Determinable:
    return determinable(body, free_skeleton(body), looks(body, seen))


CENTRES = [frame for frame in humanoid().frames[1:] if frame != EYE]


@pytest.mark.parametrize(
    ("seen", "rank"),
    [
        (ENDS, 108), ([*ENDS, *BETWEEN], 115), (BETWEEN, 75), (ENDS[:1], 31), (ENDS[2:3], 43),
        (CENTRES, 132),
    ],
    ids=["hands and feet", "all markers", "joints between", "a hand", "a foot", "every centre"],
)  # fmt: skip
def test_the_counts_of_the_humanoid(seen: Sequence[str], rank: int) -> None:
    found = told(humanoid(), seen)
    assert (found.rank, found.variables) == (rank, 135)
    values = found.singular_values
    # A gap of many decades: the rank is beyond doubt.
    assert values[rank] < 1e-13 * values[0] < 1e-9 * values[rank - 1]


def test_the_counts_do_not_depend_on_the_ranges() -> None:
    wide, own = told(humanoid(STRAIGHT), ENDS), told(humanoid(), ENDS)
    assert wide.rank == own.rank
    assert wide.condition < own.condition / 5


def test_open_directions_are_said_in_plain_words() -> None:
    """With all markers seen: the joints whose own centre nobody sees, and the pelvis."""
    body = humanoid()
    found = told(body, [*ENDS, *BETWEEN])
    unseen = [joint for joint in body.joints if joint not in BETWEEN]
    slides = {f"{joint} slides along its axis" for joint in unseen}
    shifts = {f"the origin of pelvis moves along its {c} axis" for c in "xyz"}
    assert {d.sentence.partition(":")[0] for d in found.directions} == slides | shifts
    assert all(direction.inherent for direction in found.directions)


@pytest.mark.parametrize("turned", [False, True], ids=["parallel frames", "turned frames"])
def test_a_plain_motion_is_invisible_however_far_it_goes(turned: bool) -> None:
    """Two objective body schemas, one subjective: the prediction is the same to rounding."""
    rng = np.random.default_rng(3)
    body = seen_arm(4, rng) if turned else humanoid()
    if turned:
        placement = body.placement.copy()
        placement[1:, :3, :3] = lie.exp_so3(rng.normal(size=(len(placement) - 1, 3)))
        body = replace(body, placement=placement)
    eye, seen = ("tracker", ["tool"]) if turned else (EYE, ENDS)
    variables = free_skeleton(body)
    q = random_postures(body, 20, rng)
    truth = [sense.imagined(body, q) for sense in looks(body, seen, eye)]
    motions = invisible_motions(body, variables)
    hidden = [m for m in motions if m.frame not in (eye, *seen)]
    assert len(hidden) >= (len(body.joints) if turned else 27)
    for motion in hidden:
        other = body.with_variables(variables, 0.3 * motion.row)
        assert max(np.abs(sense.residual(other)).max() for sense in truth) < 1e-12
    for motion in motions:
        if motion.frame in seen:
            other = body.with_variables(variables, 0.3 * motion.row)
            assert max(np.abs(sense.residual(other)).max() for sense in truth) > 0.1


def test_a_link_that_is_known_holds_the_slide_that_needs_it() -> None:
    body = humanoid()
    names = {m.sentence.partition(" ")[0] for m in invisible_motions(body, free_joints(body))}
    # The camera, the hands and the feet are not free: their carriers cannot slide.
    carriers = {"neck_roll", "r_elbow", "l_elbow", "r_ankle_roll", "l_ankle_roll"}
    assert carriers.isdisjoint(names)
    assert {"waist", "r_knee"} <= names


def test_a_space_is_split_into_motions_and_the_rest() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng)
    variables = free_skeleton(body)
    motions = invisible_motions(body, variables)[:3]
    other = rng.normal(size=(2, len(variables)))
    scale = variables.scale
    span = np.vstack([[m.row / scale for m in motions], other])
    space = np.linalg.qr(span.T)[0].T
    inside, rest = take_out(space, motions, scale)
    assert inside == motions
    assert rest.shape == (2, len(variables))
    np.testing.assert_allclose(rest @ rest.T, np.eye(2), atol=1e-12)
    assert max(np.abs(rest @ (m.row / scale)).max() for m in motions) < 1e-9


def test_nothing_seen_tells_nothing_and_poses_no_more_than_points() -> None:
    """How a hand is turned at zero posture is no part of a skeleton, and its turns tell nothing
    that its positions do not."""
    body = humanoid()
    variables = free_skeleton(body)
    empty = np.empty((0, 24))
    posed = Poses.make(empty, np.empty((0, 4, 4)), EYE, "r_hand")
    assert determinable(body, variables, [posed]).rank == told(body, ENDS[:1]).rank
    blind = determinable(body, variables, looks(body, []))
    assert (blind.rank, len(blind.directions)) == (0, 135)


def slid(body: Body, rng: np.random.Generator) -> Body:
    """Another body that hands and feet cannot tell from this one."""
    variables = free_skeleton(body)
    rows = [m.row for m in invisible_motions(body, variables) if m.frame not in (EYE, *ENDS)]
    return body.with_variables(variables, rng.normal(0, 0.1, len(rows)) @ np.array(rows))


def test_shortest_links_put_crossing_axes_together_again() -> None:
    """Shoulders and hips have three joints each in one point; nobody told the learner."""
    rng = np.random.default_rng(5)
    true = humanoid()
    learned = slid(true, rng)
    plain = with_shortest_links(learned, free_skeleton(learned), looks(learned, ENDS))
    lengths = np.linalg.norm(plain.placement[:, :3, 3], axis=1)
    together = [f"{side}{name}" for side in ("r_", "l_") for name in ("hip_roll", "hip_pitch")]
    rows = [plain.frame_index(name) for name in [*together, "r_shoulder_roll", "l_shoulder_roll"]]
    assert np.linalg.norm(learned.placement[rows, :3, 3], axis=1).min() > 0.01
    assert lengths[rows].max() < 1e-6
    assert lengths.sum() <= np.linalg.norm(true.placement[:, :3, 3], axis=1).sum() + 1e-6


def test_shortest_links_change_nothing_that_is_seen() -> None:
    rng = np.random.default_rng(6)
    body = humanoid()
    rotated = body.with_placement("waist", lie.transform(lie.exp_so3([0.3, 0.1, -0.4]), [0, 0, 0]))
    learned = slid(rotated, rng)
    senses = looks(learned, [*ENDS, *BETWEEN])
    q = random_postures(learned, 20, rng)
    truth = [sense.imagined(learned, q) for sense in senses]
    plain = with_shortest_links(learned, free_skeleton(learned), senses)
    assert not np.allclose(plain.placement, learned.placement)
    assert max(np.abs(sense.residual(plain)).max() for sense in truth) < 1e-12
