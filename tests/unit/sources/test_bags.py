"""Topics of bags as recordings."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.bags import bag_topics, is_bag, stamps, topics_of
from bodyschema.sources.mended_mcap import MAGIC
from bodyschema.sources.tables import open_recording, write_table


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
    with pytest.raises(InputError, match="chatter' holds std_msgs/msg/String, 8 messages"):
        open_recording(f"{bag}#/chatter")


def test_topics_that_are_not_read_are_listed_and_timed(bag: Path) -> None:
    found = {topic.name: topic for topic in bag_topics(bag)}
    assert found["/chatter"].kind == "std_msgs/msg/String"
    assert [t.readable for t in found.values()] == [True, True, False]
    assert stamps(bag, "/chatter").tolist() == [9 + 3.0 * i for i in range(8)]


def test_numbers_of_any_writer_are_the_same_to_the_last_digit(tmp_path: Path) -> None:
    """ROS 1, SQLite and MCAP, written by rosbags: what a table of the same numbers holds."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    rng = np.random.default_rng(5)
    table = {name: rng.standard_normal(20) for name in ("a", "b")}
    write_table(tmp_path / "t.csv", table)
    expected = open_recording(tmp_path / "t.csv")

    def message(store: Any, i: int) -> Any:
        kind = store.types
        first = {"seq": i} if "seq" in kind["std_msgs/msg/Header"].__annotations__ else {}
        stamp = kind["builtin_interfaces/msg/Time"](sec=3 + i, nanosec=0)
        header = kind["std_msgs/msg/Header"](**first, stamp=stamp, frame_id="")
        place = np.array([table["a"][i], table["b"][i]])
        none = np.zeros(0)
        return kind["sensor_msgs/msg/JointState"](header, ["a", "b"], place, none, none)

    plugins = {"sq": StoragePlugin.SQLITE3, "mc": StoragePlugin.MCAP}
    kind = "sensor_msgs/msg/JointState"
    for name, plugin in plugins.items():
        store = get_typestore(Stores.ROS2_HUMBLE)
        with Writer(tmp_path / name, version=9, storage_plugin=plugin) as writer:
            topic = writer.add_connection("/joint_states", kind, typestore=store)
            for i in range(20):
                writer.write(topic, i, store.serialize_cdr(message(store, i), kind))
    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(tmp_path / "one.bag") as writer1:
        topic1 = writer1.add_connection("/joint_states", kind, typestore=store)
        for i in range(20):
            writer1.write(topic1, i, store.serialize_ros1(message(store, i), kind))
    lone = tmp_path / "lone.db3"
    lone.write_bytes(next((tmp_path / "sq").glob("*.db3")).read_bytes())
    inner = next((tmp_path / "mc").glob("*.mcap"))
    for place in (tmp_path / "sq", tmp_path / "mc", tmp_path / "one.bag", lone, inner):
        found = open_recording(place)
        assert found.time().tolist() == [3.0 + i for i in range(20)]
        for name in table:
            assert found.columns[name].tobytes() == expected.columns[name].tobytes()


def test_what_a_bag_lacks_is_empty_and_transforms_are_by_their_frames(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind: Any = store.types
    stamp, head = kind["builtin_interfaces/msg/Time"], kind["std_msgs/msg/Header"]
    turn = kind["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    with Writer(tmp_path / "bag", version=9) as writer:
        name = "tf2_msgs/msg/TFMessage"
        topic = writer.add_connection("/tf", name, typestore=store)
        for i, frames in enumerate((["tag"], ["tag", "hand"], ["hand"])):
            header = head(stamp=stamp(sec=50 + i, nanosec=0), frame_id="eye")
            place = kind["geometry_msgs/msg/Vector3"](x=float(i), y=0.0, z=1.0)
            moved = kind["geometry_msgs/msg/Transform"](translation=place, rotation=turn)
            made = [
                kind["geometry_msgs/msg/TransformStamped"](header, frame, moved) for frame in frames
            ]
            writer.write(topic, 7, store.serialize_cdr(kind[name](made), name))
    found = open_recording(tmp_path / "bag")
    assert found.time().tolist() == [50, 51, 52], "of the transforms"
    assert found.empty["hand.x"].tolist() == [True, False, False]
    assert found.empty["tag.x"].tolist() == [False, False, True]
    assert found.columns["hand.x"].tolist()[1:] == [1, 2]
    assert found.columns["tag.qw"].tolist()[:2] == [1, 1]


def test_a_bag_that_breaks_off_is_one_sentence_with_what_is_there(bag: Path) -> None:
    import struct

    record = struct.Struct("<BQHIQQ")
    body = b"".join(record.pack(5, 22, 0, i, int(1e9) + i * 500_000_000, 0) for i in range(4))
    cut = bag.parent / "cut.mcap"
    cut.write_bytes(b"\x89MCAP0\r\n" + body[:-3])
    with pytest.raises(InputError, match=r"1\.00 s of messages are whole; `mcap recover cut\.mcap"):
        open_recording(cut)
    cut.write_bytes(b"\x89MCAP0\r\n" + body[:10])
    with pytest.raises(InputError, match="before any message is whole; record it again"):
        open_recording(cut)
    (bag.parent / "cut.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(50))
    with pytest.raises(InputError, match=r"`rosbag reindex cut\.bag`"):
        open_recording(bag.parent / "cut.bag")
    store = next(bag.glob("*.db3"))
    store.write_bytes(store.read_bytes()[:6000])
    with pytest.raises(InputError, match=r"`sqlite3 .*\.recover"):
        open_recording(f"{bag}#/joint_states")


@pytest.mark.parametrize("chunks", [True, False])
def test_all_up_to_a_cut_is_read(tmp_path: Path, chunks: bool) -> None:
    """Of a file whose recorder died: whole chunks in the order of their times, and a sentence."""
    pytest.importorskip("rosbags")
    count = 1000 if chunks else 100
    whole = many_messages(tmp_path, count)
    data = whole.read_bytes() if chunks else without_chunks(whole.read_bytes())
    counts = []
    for share in (0.4, 0.7, 0.95):
        whole.write_bytes(data[: int(share * len(data))])
        found = open_recording(f"{whole}#/joint_states")
        counts.append(len(found))
        assert found.columns["a"].tolist() == list(range(len(found)))
        (remark,) = found.remarks
        assert "breaks off" in remark
        assert f"{(len(found) - 1) * 0.01:.2f} s of messages are whole" in remark
        assert bag_topics(whole)[0].samples == len(found)
    assert counts == sorted(counts)
    assert counts[-1] > 0.7 * count
    whole.write_bytes(data[:150])
    with pytest.raises(InputError, match="before any message is whole; record it again"):
        open_recording(whole)


def test_a_chunk_whose_indexes_break_off_is_lost_for_all_topics(bag: Path) -> None:
    """One topic of it would be read and another one not."""
    pytest.importorskip("rosbags")
    from bodyschema.sources.mended_mcap import MESSAGE_INDEX, whole_records
    from input_writers import EYE, FORMS, JOINTS, POSE

    columns = dict.fromkeys(("a", *POSE), np.ones(9))
    FORMS["MCAP by rosbags"](columns, bag.parent)
    (path,) = (bag.parent / "mcap").glob("*.mcap")
    lone = path.rename(bag.parent / "lone.mcap")
    with lone.open("rb") as file:
        first = next(record for record in whole_records(file) if record.kind == MESSAGE_INDEX)
    lone.write_bytes(lone.read_bytes()[: first.at + first.length + 3])
    for topic in (JOINTS, EYE):
        with pytest.raises(InputError):
            open_recording(f"{lone}#{topic}")


def test_a_file_that_ends_as_it_should_says_nothing(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    assert open_recording(f"{many_messages(tmp_path, 5)}#/joint_states").remarks == ()


def many_messages(folder: Path, count: int) -> Path:
    """An MCAP file of joint states whose first joint counts them."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, kind = get_typestore(Stores.ROS2_HUMBLE), "sensor_msgs/msg/JointState"
    types: Any = store.types
    with Writer(folder / "b", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/joint_states", kind, typestore=store)
        for i in range(count):
            stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
            filler = ["a", *(f"joint_{i}" for i in range(200))]
            place, none = np.full(201, float(i)), np.zeros(0)
            message = types[kind](header, filler, place, none, none)
            writer.write(topic, 10**9 + i * 10**7, store.serialize_cdr(message, kind))
    return next((folder / "b").glob("*.mcap")).rename(folder / "lone.mcap")


def without_chunks(data: bytes) -> bytes:
    """The records of a file's chunks, one after the other, as some recorders write them."""
    import struct

    made, at = data[:8], 8
    while at < len(data) - 8:
        kind, length = struct.unpack_from("<BQ", data, at)
        content = data[at + 9 : at + 9 + length]
        if kind == 6:
            (letters,) = struct.unpack_from("<I", content, 28)
            assert not letters, "not packed"
            made += content[40:]
        elif kind in (1, 3, 4):
            made += data[at : at + 9 + length]
        at += 9 + length
    return made


@pytest.mark.parametrize("letters", [2**31, 10**4])
def test_a_chunk_that_is_damaged_where_a_file_breaks_off(bag: Path, letters: int) -> None:
    """Found by the fuzz bench: the name of the compression is longer than its chunk."""
    path = bag.parent / "damaged.mcap"
    head = struct.pack("<BQ", 6, 40) + struct.pack("<QQQII", 1, 2, 3, 0, letters) + bytes(8)
    for chunk in (head, struct.pack("<BQ", 6, 3) + bytes(3)):
        path.write_bytes(MAGIC + chunk)
        with pytest.raises(InputError, match=r"breaks off after .* before any message is whole"):
            open_recording(path)
