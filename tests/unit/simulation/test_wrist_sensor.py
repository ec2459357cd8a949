"""MuJoCo's wrist sensor agrees with the regressor; contacts and things are what they say."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.senses.wrenches import load_regressor
from bodyschema.simulation.contacts import NEAR, draw_contact, pushes
from bodyschema.simulation.held_objects import held_object
from bodyschema.simulation.loads import NOISE, RATE, draw_path, draw_sensor

mujoco = pytest.importorskip("mujoco")
trimesh = pytest.importorskip("trimesh")

from bodyschema.simulation.wrist_sensor import WristSensor, record  # noqa: E402

TIME = np.arange(200) / RATE


def test_mujoco_feels_what_the_regressor_says():
    load = held_object("mesh").load
    felt = WristSensor(load).feel(draw_path(np.random.default_rng(0), 2.0, 1.0), TIME)
    said = load_regressor(felt.a_g, felt.w, felt.dw) @ load.phi
    assert np.abs(felt.w).max() > 0.5
    assert said == pytest.approx(felt.wrench, abs=1e-9)


def test_a_push_on_the_object_is_taken_off_what_the_sensor_exerts():
    thing, rng = held_object("box"), np.random.default_rng(1)
    path = draw_path(rng, 2.0, 0.5)
    contacts = [draw_contact(thing.solid, 3.0, kind, t, rng)
                for kind, t in (("point", 0.1), ("soft", 0.8), ("moving", 1.2))]  # fmt: skip
    robot = WristSensor(thing.load)
    push = pushes(contacts, TIME)
    pushed, free = robot.feel(path, TIME, push), robot.feel(path, TIME)
    assert np.linalg.norm(push[:, :3], axis=1).max() > 2.9
    assert free.wrench - pushed.wrench == pytest.approx(push, abs=1e-9)


def test_readings_have_the_errors_of_the_sensor():
    rng = np.random.default_rng(2)
    thing, sensor = held_object("rod"), draw_sensor(rng, 0.02)
    felt = WristSensor(thing.load).feel(draw_path(rng, 2.0, 0.2), TIME)
    read = record(felt, sensor, rng, gain=0.01).wrench
    R = sensor.R_mount_sensor
    exact = 1.01 * np.hstack([felt.wrench[:, :3] @ R, felt.wrench[:, 3:] @ R]) + sensor.bias
    # Noise, and the step of a reading on top of it.
    assert np.std(read - exact, axis=0) == pytest.approx(NOISE * np.sqrt(13 / 12), rel=0.2)


@pytest.mark.parametrize("name", ["box", "rod", "mesh"])
def test_things_have_the_inertia_of_their_shape(name):
    thing = held_object(name)
    mesh = trimesh.Trimesh(thing.solid.vertices, thing.solid.faces, process=True)
    assert mesh.is_watertight
    mesh.density = thing.load.mass / mesh.volume
    assert thing.load.com == pytest.approx(mesh.center_mass, abs=1e-9)
    assert thing.load.moments == pytest.approx(mesh.moment_inertia, abs=1e-9)
    assert thing.load.physical


def test_contacts_push_from_outside_at_the_first_place_or_at_a_hidden_one():
    cup, rng = held_object("mesh").solid, np.random.default_rng(3)
    for hidden in (False, True):
        for _ in range(20):
            contact = draw_contact(cup, 2.0, "point", 0.0, rng, hidden)
            u = contact.force / np.linalg.norm(contact.force)
            met = cup.pressed(contact.force, contact.point, u)
            gaps = np.linalg.norm(met.points - contact.point, axis=1)
            assert gaps.min() < NEAR
            assert (np.argmin(gaps) > 0) == hidden


def test_an_unknown_thing_is_refused():
    with pytest.raises(InputError, match="did you mean 'box'"):
        held_object("bax")
