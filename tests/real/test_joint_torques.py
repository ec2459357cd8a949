"""The torques of an industrial arm that was not seen in the fit."""

from __future__ import annotations

from arm_torques import torque_percent


def test_held_out_torques_of_the_tx40_are_better_told_than_by_the_reference(shared_data):
    found = torque_percent(shared_data("figaroh_tx40_dynamics"))
    # 20.9 % is what a plain regression without the wrist's coupling leaves.
    assert found["base"] < 16
    assert found["physical"] < 16
    assert found["base_parameters"] < 84
