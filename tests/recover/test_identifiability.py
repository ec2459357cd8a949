"""What cannot be told is named, and nothing else is: cases whose answer is known by geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability, identifiability, random_postures
from bodyschema.estimation.loss import fisher_share
from bodyschema.estimation.normal_equations import level_rows, whiten
from bodyschema.estimation.solver import Solver
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.sense import Sense
from bodyschema.senses.wrist_wrenches import WristWrenches
from simulated import free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]
SENSES = {"points": points, "poses": poses}
N = 5
SAMPLES = 60


def told(body: Body, variables: Variables, senses: Sequence[Sense]) -> Identifiability:
    """Fit and judge; the rank must be that of the stacked Jacobian in units of the prior."""
    fit = Solver().fit(body, variables, senses)
    found = identifiability(fit, senses)
    assert found.rank == np.linalg.matrix_rank(stacked(fit, senses), tol=1.0)
    assert found.rank + len(found.directions) == len(variables)
    assert found.open_share.sum() == pytest.approx(len(found.directions))
    return found


def stacked(fit: Estimate, senses: Sequence[Sense]) -> Array:
    """(numbers, n_parameters) whitened Jacobian, weighted as in the fit."""
    estimate, rows = fit, []
    for sense, level, weight, nu in zip(senses, fit.levels, fit.weights, fit.freedom, strict=True):
        part = whiten(sense, estimate.reference, estimate.variables, estimate.x)
        root = np.sqrt(weight * fisher_share(nu, part.residual.shape[1]))
        J = part.jacobian * root[:, None, None] / level_rows(sense, level)[:, None]
        rows.append(J.reshape(-1, len(estimate.x)))
    return np.concatenate(rows) * estimate.variables.scale


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def body(rng: np.random.Generator) -> Body:
    """Five joints; the first turns about the vertical through the base."""
    return with_axis(seen_arm(N, rng), "link_1", [0, 0, 1])


def with_axis(body: Body, frame: str, axis: Sequence[float]) -> Body:
    axes = body.axis.copy()
    axes[body.frame_index(frame)] = axis
    return replace(body, axis=axes)


@pytest.fixture
def q(body: Body, rng: np.random.Generator) -> Array:
    return postures(SAMPLES, body, rng)


@pytest.mark.parametrize("sense", SENSES)
@pytest.mark.parametrize("seed", range(30))
def test_none_is_invented_where_all_can_be_told(seed: int, sense: str) -> None:
    rng = np.random.default_rng(seed)
    body = seen_arm(3 + seed % 4, rng)
    seen = SENSES[sense](body, postures(SAMPLES, body, rng), rng)
    found = told(body, free_joints(body, ["offsets"]), [seen])
    assert found.directions == ()
    assert found.sentences == ()
    assert found.rank == len(body.joints)
    assert (found.open_share == 0).all()


def test_a_joint_that_stood_still(body: Body, q: Array, rng: np.random.Generator) -> None:
    """Its offset is seen, but not apart from its gear."""
    q[:, 2] = 0.7
    found = told(body, free_joints(body, ["offsets", "gears"]), [points(body, q, rng)])
    (direction,) = found.directions
    assert set(direction.members) == {"joint_3.offset", "joint_3.gear"}
    assert not direction.inherent
    assert direction.sentence == (
        "joint_3.offset and joint_3.gear could not be told apart in these postures; "
        "rotate joint_3 further to determine them."
    )
    assert found.partners("joint_3.gear") == ("joint_3.offset",)
    assert found.partners("joint_2.gear") == ()


def test_a_joint_that_stood_still_at_zero(body: Body, q: Array, rng: np.random.Generator) -> None:
    q[:, 2] = 0.0
    found = told(body, free_joints(body, ["offsets", "gears"]), [points(body, q, rng)])
    assert found.sentences == (
        "joint_3.gear had too little effect in these postures; "
        "rotate joint_3 further to determine them.",
    )


@pytest.mark.parametrize("sense", SENSES)
def test_the_first_joint_and_an_unknown_tracker(
    sense: str, body: Body, q: Array, rng: np.random.Generator
) -> None:
    body = body.with_placement("tracker", lie.transform(np.eye(3), [0.8, 0.0, 0.3]))
    variables = join(free_joints(body, ["offsets"]), free_frame(body, "tracker"))
    found = told(body, variables, [SENSES[sense](body, q, rng)])
    (direction,) = found.directions
    # The tracker goes round the vertical together with the first joint.
    assert set(direction.members) == {"joint_1.offset", "tracker.turn_z", "tracker.link_y"}
    assert direction.inherent
    assert "cannot be told apart by any motion" in direction.sentence
    assert "measure how 'tracker' is mounted" in direction.sentence
    assert "tracker.turn_z" in found.partners("joint_1.offset")


def test_the_last_joint_and_a_tool_point_on_its_axis(
    body: Body, q: Array, rng: np.random.Generator
) -> None:
    """On the axis the last offset moves nothing; off it, the tool point goes round with it."""
    straight = lie.transform(np.eye(3), 0.1 * body.axis[body.frame_index("link_5")])
    on = body.with_placement("tip", np.eye(4)).with_placement("tool", straight)
    offsets = free_joints(body, ["offsets"])
    found = told(on, offsets, [points(on, q, rng)])
    assert found.sentences == (
        "joint_5.offset has no effect on what was seen; only another sense can tell it.",
    )
    assert told(on, offsets, [poses(on, q, rng)]).directions == ()
    assert told(body, offsets, [points(body, q, rng)]).directions == ()
    off = join(offsets, free_frame(body, "tool", 0.1, None))
    (direction,) = told(body, off, [points(body, q, rng)]).directions
    assert direction.inherent
    assert "joint_5.offset" in direction.members
    assert {name.split(".")[0] for name in direction.members} == {"joint_5", "tool"}


def test_one_joint_moves_alone(body: Body, q: Array, rng: np.random.Generator) -> None:
    """The point draws a circle: radius, height and phase for the offsets of joints 2 to 5."""
    q[:, [0, 2, 3, 4]] = q[0, [0, 2, 3, 4]]
    found = told(body, free_joints(body, ["offsets"]), [points(body, q, rng)])
    (direction,) = found.directions
    assert set(direction.members) == {f"joint_{i}.offset" for i in (2, 3, 4, 5)}
    assert not direction.inherent
    assert "could not be told apart in these postures; rotate joint_2" in direction.sentence
    assert found.partners("joint_1.offset") == ()


@pytest.mark.parametrize("sense", SENSES)
def test_links_slide_along_axes(sense: str, body: Body, q: Array, rng: np.random.Generator) -> None:
    """Link i longer along axis i and link i + 1 shorter by as much is the same arm."""
    found = told(body, free_joints(body, ["links"]), [SENSES[sense](body, q, rng)])
    assert len(found.directions) == N - 1
    assert all(direction.inherent for direction in found.directions)
    names = [sentence.partition(":")[0] for sentence in found.sentences]
    assert names == [f"joint_{i} slides along its axis" for i in range(1, N)]
    assert all("fix its link as modelled" in sentence for sentence in found.sentences)
    assert all(len(direction.members) >= 2 for direction in found.directions)


@pytest.mark.parametrize("n", [4, 6])
def test_all_free_leaves_the_directions_that_geometry_says(n: int) -> None:
    """A revolute arm has 4 n + 6 geometric numbers (Everett, Driels, Mooring 1987)."""
    rng = np.random.default_rng(n)
    body = seen_arm(n, rng)
    variables = free_all(body, ("offsets", "axes", "links"))
    seen = poses(body, postures(300, body, rng), rng, (1e-5, 1e-5))
    found = told(body, variables, [seen])
    assert found.rank == 4 * n + 6
    assert all(direction.inherent for direction in found.directions)


def test_directions_that_a_motion_could_close_come_first(
    body: Body, q: Array, rng: np.random.Generator
) -> None:
    q[:, 2] = 0.7
    groups = free_joints(body, ["offsets", "gears"])
    found = told(body, join(groups, free_frame(body, "tracker")), [points(body, q, rng)])
    assert [direction.inherent for direction in found.directions] == [False, True]


BOX = Inertia(0.6, np.array([0.016, -0.021, 0.092]), np.diag([3e-3, 2.4e-3, 1.6e-3]))
STOOD_STILL = (
    "moments of inertia of load had too little effect: only turning shows them, and what carries "
    "the load hardly turned or stood still; swing it about all axes, with quick changes of speed."
)


def carried(body: Body, q: Array, rng: np.random.Generator, speed: float) -> Identifiability:
    """A box on the tip, felt by a sensor that has no offset, with turns of so many rad/s."""
    body = body.with_part("load", parts.load(BOX))
    dq, ddq = speed * rng.normal(size=(2, *q.shape))
    felt = WristWrenches.make(q, np.zeros((len(q), 6)), "tip", "base", dq=dq, ddq=5 * ddq)
    there = felt.predict(body) + rng.normal(size=(len(q), 6)) * ([0.05] * 3 + [0.003] * 3)
    return told(body, free_part(body, "load"), [replace(felt, observed=there)])


def test_moments_of_a_load_that_stood_still(body: Body, q: Array, rng: np.random.Generator) -> None:
    """Six open directions of its roots are one sentence, in words; mass and centre are told."""
    found = carried(body, q, rng, speed=0.0)
    assert len(found.directions) == 6
    assert found.sentences == (STOOD_STILL,)
    assert {name for d in found.directions for name in d.members} == {
        f"load.{root}" for root in ("d1", "d2", "d3", "s12", "s23", "s13")
    }


def test_moments_of_a_load_that_swings_are_told(
    body: Body, q: Array, rng: np.random.Generator
) -> None:
    assert carried(body, q, rng, speed=2.0).directions == ()


def test_a_mass_beside_an_offset_that_gravity_never_crosses(
    body: Body, q: Array, rng: np.random.Generator
) -> None:
    """Mass, centre and offset are named in words; the remedy speaks of the load, not of a root."""
    body = body.with_part("load", parts.load(BOX)).with_part("ft", parts.force_sensor())
    still = q[:1].repeat(60, axis=0)
    felt = WristWrenches.make(still, np.zeros((60, 6)), "tip", "base", sensor="ft")
    felt = replace(felt, observed=felt.predict(body) + 0.01 * rng.normal(size=(60, 6)))
    offsets = [f"offset_{c}" for c in ("fx", "fy", "fz", "tx", "ty", "tz")]
    free = join(free_part(body, "load", ["alpha", "t1"]), free_part(body, "ft", offsets))
    said = " ".join(told(body, free, [felt]).sentences)
    assert "the mass of load" in said
    assert "the centre of mass of load" in said
    assert "alpha" not in said
    assert "rotate ft and load further" in said


def test_without_parameters_there_is_nothing_to_tell(
    body: Body, q: Array, rng: np.random.Generator
) -> None:
    seen = [points(body, q, rng)]
    fit = Solver().fit(body, free_joints(body, ()), seen)
    assert identifiability(fit, seen).rank == 0
    assert identifiability(fit, seen).directions == ()


def test_random_postures_keep_to_the_limits(body: Body, rng: np.random.Generator) -> None:
    limited = replace(body, lower=np.array([-1, -np.inf, 0, 0, 0]), upper=np.full(5, 0.5))
    q = random_postures(limited, 500, rng)
    assert (q <= 0.5).all()
    assert q[:, 0].min() == pytest.approx(-1, abs=0.05)
    assert q[:, 1].min() == pytest.approx(-np.pi, abs=0.05)
