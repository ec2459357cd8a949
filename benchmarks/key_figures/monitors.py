"""Changes that are noticed, blamed and learned again; and alarms without one."""

from __future__ import annotations

from pathlib import Path

import false_alarms
import hard_streams
import image_jump
import joint_jump
from key_figures.figure import Values


def joints(data: Path) -> Values:
    """A joint of an arm before a tracker jumps by a degree, four arms."""
    found = joint_jump.measure(4, 2.0, "points")
    return {
        "certified": found["certified_s"]["median"],
        "detected": found["detected"],
        "delay": found["delay_s"]["median"],
        "again": found["again_s"]["median"],
        "blamed": found["blamed_right"],
        "false_alarms": found["false_alarms"],
    }


def images(data: Path) -> Values:
    """The same before the robot's own eyes, one arm."""
    found = image_jump.measure(1, 1.0, 20.0)
    return {
        "certified": found["certified_s"]["median"],
        "detected": found["detected"],
        "delay": found["delay_s"]["median"],
        "again": found["again_s"]["median"],
        "blamed": found["blamed_right"],
        "false_alarms": found["false_alarms"],
    }


def calm(data: Path) -> Values:
    """Ten minutes without a change in each of four noises."""
    runs = [false_alarms.watch(name, 0, 10.0) for name in false_alarms.CONDITIONS]
    return {
        "alarms": sum(run["alarms"] for run in runs),
        "confirmed": sum(run["confirmed"] for run in runs),
        "wrong": sum(run["wrong"] for run in runs),
        "hours": sum(run["hours"] for run in runs),
    }


def hard(data: Path) -> Values:
    """Noise that remembers, wild samples, bursts, gaps and early changes, one stream each."""
    found = [hard_streams.summary([hard_streams.run(n, 0)]) for n in hard_streams.CONDITIONS]
    return {
        "wrong": sum(one["wrong"] for one in found),
        "noticed": sum(one["noticed"] for one in found),
        "blamed": sum(one["blamed_right"] for one in found),
        "false_changes": sum(one["false_changes"] for one in found),
    }
