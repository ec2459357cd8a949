"""The five-joint arm: its numbers, MuJoCo's opinion of them, its motion and noise."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation.katana import (
    RATE,
    SPEED,
    Noise,
    delayed,
    draw_motion,
    draw_scene,
    katana,
    perceive,
    project_points,
    stereo,
)


def test_stretched_out_and_bent_as_the_table_says():
    body = katana()
    straight = relative_pose(body, np.zeros(5), "base", "hand")
    assert np.allclose(straight[:3, 3], [0.6318, 0, 0.2015])
    lifted = relative_pose(body, [0, np.pi / 2, 0, 0, 0], "base", "hand")
    assert np.allclose(lifted[:3, 3], [0, 0, 0.2015 + 0.6318])
    wrist = relative_pose(body, [0, 0, 0, 0.5, 0], "base", "hand")
    assert wrist[2, 3] < 0.2015  # the fourth joint lowers
    assert np.allclose(relative_pose(body, [0.3, 0, 0, 0, 0], "base", "hand")[:2, 3],
                       0.6318 * np.array([np.cos(0.3), np.sin(0.3)]))  # fmt: skip


def test_mujoco_puts_hand_and_pixels_where_we_do():
    pytest.importorskip("mujoco")
    from bodyschema.simulation.real_robot import RealRobot

    rng = np.random.default_rng(0)
    body, scene = katana(), draw_scene(rng)
    q = draw_motion(3, rng, scene.T_world_cam)[1]
    real = RealRobot(write_urdf(body), {}, body.joints, {}).poses(q, "base", ["hand"])[:, 0]
    ours = relative_pose(body, q, "base", "hand")
    assert np.abs(real - ours).max() < 1e-9
    difference = project_points(scene, real, stereo()) - project_points(scene, ours, stereo())
    assert np.abs(difference).max() < 1e-5


def test_moves_keep_the_speed_limits():
    rng = np.random.default_rng(1)
    time, q = draw_motion(30, rng, draw_scene(rng).T_world_cam, speed=0.5)
    assert len(time) == len(q) == 30 * RATE
    assert (np.abs(np.diff(q, axis=0)).max(axis=0) * RATE <= 0.505 * SPEED).all()
    late = delayed(time, q, 1 / RATE)
    assert np.allclose(late[1:], q[:-1])


def test_noise_has_the_size_and_the_correlation_that_it_should():
    rng = np.random.default_rng(2)
    scene, eyes = draw_scene(rng), stereo(0.5)
    T = np.tile(np.eye(4), (20_000, 1, 1))
    T[:, :3, 3] = [0.4, 0, 0.2]
    clean = project_points(scene, T, eyes)
    noise = perceive(scene, T, eyes, rng, Noise(correlation=0.9)) - clean
    assert np.std(noise) == pytest.approx(0.5, rel=0.05)
    assert np.mean(noise[1:] * noise[:-1]) / 0.25 == pytest.approx(0.9, rel=0.08)
    wild = np.abs(perceive(scene, T, eyes, rng, Noise(wild=0.02)) - clean).max(axis=(1, 2)) > 5
    assert np.mean(wild) == pytest.approx(0.02, abs=0.004)
