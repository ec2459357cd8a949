"""Senses of forces: wrenches on a wrist and torques of motors, from the columns of an entry."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bodyschema.cli.reading.columns import columns_of
from bodyschema.cli.reading.joints import column_of
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.senses.sense import Sense
from bodyschema.senses.torques import Torques
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.sources.physical_units import FORCES, TORQUES, factor

SIGNS = ("on_sensor", "on_object")


def wrenches(entry: SenseEntry, at: Moments) -> Sense:
    """What a sensor on the wrist feels. Raises InputError."""
    values, rows = columns_of(entry, at, 6)
    if entry.sign not in SIGNS:
        raise InputError(
            f"sign = '{entry.sign}' of a sense of wrenches{did_you_mean(entry.sign, SIGNS)} The "
            'load\'s pull on the sensor is "on_sensor": its force points down at rest.'
        )
    if isinstance(entry.loads, dict):
        raise InputError('loads of a sense of wrenches are a list, such as ["gripper", "cup"].')
    scales = [factor(entry.force_unit, FORCES), factor(entry.torque_unit, TORQUES)]
    wrench = values * np.repeat(scales, 3) * (-1.0 if entry.sign == "on_sensor" else 1.0)
    more: dict[str, Any] = {"loads": entry.loads, "sensor": entry.sensor, "gravity": entry.gravity}
    more |= at.motion(entry, rows) | at.more(entry, rows, scales)
    return WristWrenches.make(at.q[rows], wrench, entry.seen_from, entry.seen, **more)


def torques(entry: SenseEntry, at: Moments) -> Sense:
    """What the motors exert. Raises InputError."""
    if not isinstance(entry.loads, dict):
        raise InputError(
            'loads of a sense of torques are named by their links: { link_1 = "load_1" }.'
        )
    count = len(at.body.joints)
    scales = np.full(count, factor(entry.torque_unit, TORQUES))
    if entry.per_ampere:
        scales = np.array(entry.per_ampere, dtype=np.float64)
    one = len(entry.columns) == 1 and "{joint}" in entry.columns[0]
    named = [column_of(joint, at.joints) for joint in at.body.joints]
    every = tuple(entry.columns[0].replace("{joint}", name) for name in named) if one else ()
    columns = replace(entry, columns=every) if one else entry
    values, rows = columns_of(columns, at, count)
    if len(scales) != count:
        raise InputError(f"per_ampere has {len(scales)} numbers for {count} joints.")
    motors = np.array(entry.motors) if entry.motors else None
    more: dict[str, Any] = {"motors": motors, "drive": entry.drive}
    more |= {"gravity": entry.gravity, **at.motion(entry, rows), **at.more(entry, rows, scales)}
    ends = entry.seen_from, entry.seen
    return Torques.make(at.q[rows], values * scales, entry.loads, *ends, **more)
