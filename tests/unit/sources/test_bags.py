"""Topics of bags as recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.bags import is_bag, topics_of
from bodyschema.sources.tables import open_recording


def test_a_bag_needs_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rosbags.highlevel", None)
    assert is_bag("a.mcap#/pose")
    with pytest.raises(MissingExtraError, match=r"pip install 'bodyschema\[bags\]'"):
        open_recording(tmp_path / "a.mcap")


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Joint states, poses, and texts, which nobody reads."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind: Any = store.types
    stamp, head = kind["builtin_interfaces/msg/Time"], kind["std_msgs/msg/Header"]
    point, turn = kind["geometry_msgs/msg/Point"], kind["geometry_msgs/msg/Quaternion"]
    made = []
    for i in range(8):
        header = head(stamp=stamp(sec=100 + i, nanosec=500_000_000), frame_id="base")
        joints = kind["sensor_msgs/msg/JointState"](
            header=header, name=["a", "b"], position=np.array([0.1 * i, 0.2]),
            velocity=np.array([1.0, 2.0]), effort=np.array([]),
        )  # fmt: skip
        pose = kind["geometry_msgs/msg/Pose"](
            position=point(x=1.0, y=2.0, z=3.0 + i), orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0)
        )
        posed = kind["geometry_msgs/msg/PoseStamped"](header=header, pose=pose)
        text = kind["std_msgs/msg/String"](data="hello")
        made += [("/joint_states", joints), ("/eye/pose", posed), ("/chatter", text)]
    with Writer(tmp_path / "bag", version=9) as writer:
        topics = {
            topic: writer.add_connection(topic, message.__msgtype__, typestore=store)
            for topic, message in made[:3]
        }
        for i, (topic, message) in enumerate(made):
            raw = store.serialize_cdr(message, message.__msgtype__)
            writer.write(topics[topic], 10**9 * (7 + i), raw)
    return tmp_path / "bag"


def test_topics_are_recordings(bag: Path) -> None:
    assert topics_of(bag) == (f"{bag}#/joint_states", f"{bag}#/eye/pose")
    joints = open_recording(f"{bag}#/joint_states")
    assert joints.time().tolist() == [100.5 + i for i in range(8)], "of the header"
    assert joints.columns["a"].tolist() == pytest.approx(0.1 * np.arange(8))
    assert joints.columns["d_b"].tolist() == [2] * 8
    pose = open_recording(f"{bag}#/eye/pose")
    values, _ = pose.matrix(["x", "y", "z", "qx", "qy", "qz", "qw"])
    assert values[2].tolist() == [1, 2, 5, 0, 0, 0, 1]


def test_what_is_no_topic_is_said(bag: Path) -> None:
    with pytest.raises(InputError, match=r'2 topics .* "bag#/joint_states", "bag#/eye/pose".*join'):
        open_recording(bag)
    with pytest.raises(InputError, match=r"no topic '/pose' in .*'/eye/pose'"):
        open_recording(f"{bag}#/pose")
    with pytest.raises(InputError, match="no recording at"):
        open_recording("/nowhere/a.mcap")
