"""Texts in bags, such as the robot description that was published beside the joints."""

from __future__ import annotations

from pathlib import Path

from bodyschema.errors import InputError, did_you_mean
from bodyschema.sources.bags import MARK, opened_bag


def bag_text(path: str | Path) -> str:
    """The first text of a topic of a bag, `run.mcap#/robot_description`.

    Raises:
        InputError: no such bag or topic, or one without text.
        MissingExtraError: rosbags is not installed.
    """
    name, _, topic = str(path).partition(MARK)
    with opened_bag(Path(name)) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        if not wanted:
            there = [c.topic for c in reader.connections]
            raise InputError(f"no topic '{topic}' in '{name}'{did_you_mean(topic, there)}")
        for connection, _, raw in reader.messages(connections=wanted):
            text = getattr(reader.deserialize(raw, connection.msgtype), "data", None)
            if isinstance(text, str):
                return text
    raise InputError(f"'{path}' holds no text; the topic of a robot is /robot_description.")
