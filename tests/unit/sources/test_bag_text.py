"""The robot description that was recorded beside the joints."""

from __future__ import annotations

from pathlib import Path

import pytest

from bodyschema.cli.reading.robot import read_robot
from bodyschema.errors import InputError
from bodyschema.sources.bag_text import bag_text

URDF = '<robot name="r"><link name="base"/></robot>'


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with a description and a number."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    types = {"/robot_description": "std_msgs/msg/String", "/number": "std_msgs/msg/Float64"}
    values = {"/robot_description": URDF, "/number": 3.0}
    folder = tmp_path / "bag"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, kind in types.items():
            connection = writer.add_connection(topic, kind, typestore=store)
            message = store.types[kind](data=values[topic])
            writer.write(connection, 1, store.serialize_cdr(message, kind))
    return next(folder.glob("*.mcap"))


def test_the_robot_of_a_bag(bag: Path) -> None:
    assert bag_text(f"{bag}#/robot_description") == URDF
    assert read_robot(Path(f"{bag}#/robot_description")).frames == ("base",)


def test_what_is_no_text_is_said(bag: Path) -> None:
    with pytest.raises(InputError, match="holds no text; the topic of a robot is"):
        bag_text(f"{bag}#/number")
    with pytest.raises(InputError, match=r"no topic '/robot_descriptio' in .*; did you mean"):
        bag_text(f"{bag}#/robot_descriptio")
