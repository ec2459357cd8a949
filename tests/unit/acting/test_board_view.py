"""Plans keep a board in the picture, from its front and about as far away as before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.acting.board_view import BoardView
from bodyschema.acting.candidates import View, find_candidates, view_of
from bodyschema.acting.information_gain import expected_jacobians
from bodyschema.estimation.problem import Problem
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import pixels
from bodyschema.model.parts import lens
from bodyschema.model.tree import Body
from bodyschema.senses.pixels import PICTURED, Pixels
from bodyschema.simulation.wrist_camera import WristCamera, simulate_wrist_camera, with_camera
from bodyschema.vision.targets.target import Target

SIZE = (640, 480)
K = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
CORNERS = Target("charuco", 7, 5, 0.025, 0.02, "4X4_50").corners - [0.0875, 0.0625, 0.0]


@pytest.fixture(scope="module")
def seen() -> tuple[Body, Pixels]:
    recorded = simulate_wrist_camera(WristCamera(20, 1, 0.0))
    body = with_camera(recorded.believed)
    body = body.with_part("lens", lens(Camera("c", "c", *SIZE, K)))
    each = np.repeat(np.arange(20), len(CORNERS))
    q, target = recorded.postures.q[each], np.tile(CORNERS, (20, 1))
    ends, zeros = ("camera", "board", "lens"), np.zeros((len(q), 2))
    blank = Pixels.make(q, zeros, *ends, target, rows=each, time=each, size=SIZE)
    return body, replace(blank, observed=blank.predict(body))


def inside(body: Body, q: np.ndarray) -> np.ndarray:
    """Share of the corners that are in the picture, (n,)."""
    T = relative_pose(body, q, "camera", "board")
    p = np.einsum("nij,mj->nmi", T[:, :3, :3], CORNERS) + T[:, None, :3, 3]
    image = pixels(body.part("lens").values, p.reshape(-1, 3)).reshape(len(q), -1, 2)
    return np.asarray(((image >= 0) & (image < SIZE)).all(axis=2).mean(axis=1))


def test_postures_keep_the_board_in_the_picture(seen: tuple[Body, Pixels]) -> None:
    body, sense = seen
    found = find_candidates(body, [sense], 300, np.random.default_rng(0))
    assert len(found.q) > 50
    assert inside(body, found.q).min() == 1.0
    # The view of a frame alone, whose origin is the board's middle, lets corners go.
    view = View.of(body, sense)
    assert view is not None
    anywhere = find_candidates(body, [sense], 4000, np.random.default_rng(0), anywhere=True).q
    assert inside(body, anywhere[view.holds(body, anywhere)]).min() < 1.0


def test_neither_the_back_nor_far_away_nor_steeply(seen: tuple[Body, Pixels]) -> None:
    body, sense = seen
    view = view_of(body, sense)
    assert isinstance(view, BoardView)
    q = sense.q[:1]
    assert view.holds(body, sense.q).mean() > 0.8
    where = relative_pose(body, q, "base", "camera")[0]
    for far, held in ((0.3, True), (1.5, False), (0.05, False), (-0.3, False)):
        there = np.eye(4)
        there[:3, 3] = [0.0, 0.0, far]
        there[:3, :3] = np.diag([1.0, -1.0, -1.0])
        moved = body.with_placement("board", where @ there)
        assert bool(view.holds(moved, q)[0]) is held, far
    turned = np.eye(4)
    turned[:3, 3] = [0.0, 0.0, 0.3]
    turned[:3, :3] = np.array([[1, 0, 0], [0, 0.1, 0.995], [0, -0.995, 0.1]])
    assert not view.holds(body.with_placement("board", where @ turned), q)[0]
    back = np.diag([1.0, 1.0, 1.0, 1.0])
    back[2, 3] = 0.3
    assert not view.holds(body.with_placement("board", where @ back), q)[0]


def test_nothing_recorded_and_no_size_set_no_view(seen: tuple[Body, Pixels]) -> None:
    body, sense = seen
    assert view_of(body, sense.take(np.arange(0))) is None
    assert isinstance(view_of(body, replace(sense, size=(0, 0))), View)


def test_a_picture_tells_as_much_as_its_whole_board(seen: tuple[Body, Pixels]) -> None:
    body, sense = seen
    problem = Problem(body, (sense,), {"camera": "no", "board": "no"}, body.joints[1:-1])
    fit = problem.fit(problem.variables(("offsets",)), (sense,))
    q = sense.q[:: len(CORNERS)][:5]
    assert len(sense.pictured(body, q)) == 5 * PICTURED
    J = expected_jacobians(fit, [sense], q, np.ones((5, 1), dtype=bool))
    assert np.linalg.matrix_rank(J[0]) >= 6, "a pose, not two numbers"
