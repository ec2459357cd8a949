"""`bodyschema inspect` on every recording that people have sent: it says what is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from bodyschema.cli.suggested import Suggestion
from bodyschema.sources.contents import contents

DATA = {
    "cr5_lerobot": 6, "doosan_a0509_wrist": 0, "figaroh_talos_contact": 9,
    "figaroh_tiago_mocap": 8, "fr3_eyeinhand_kincal": 7, "franka_handeye_charuco": 7,
    "kuka_lwr_bag": 7, "rct_industrial": 2, "ur3e_fixed_cameras": 6, "ur5_artag_handeye": 0,
}  # fmt: skip
"""Data set -> joints that are found without its robot."""

CASES = ("B_angles_in_degrees", "D_millimetres", "H_lag", "S_two_recordings", "T_two_clocks")


@pytest.mark.parametrize("name", DATA)
def test_data(name: str, shared_data: Callable[[str], Path]) -> None:
    found = contents(shared_data(name))
    suggested = Suggestion.of(found)
    assert len(suggested.joints) == DATA[name]
    assert any(stream.samples for stream in found.streams)


@pytest.mark.parametrize("name", CASES)
def test_cases(name: str, shared_cases: Callable[[str], Path]) -> None:
    found = contents(shared_cases(name))
    suggested = Suggestion.of(found)
    assert len(suggested.joints) == 6
    assert suggested.seen[0].group.kind == "poses"
    assert suggested.unit == ("deg" if name.startswith("B") else "rad")


def test_a_bag_and_an_incomplete_data_set(shared_cases: Callable[[str], Path]) -> None:
    found = contents(shared_cases("V_bag_mcap_lerobot"))
    assert [stream.kind for stream in found.streams] == [
        "sensor_msgs/msg/JointState", "LeRobot states", "LeRobot image",
    ]  # fmt: skip
    assert "was it downloaded whole?" in found.notes[0]
