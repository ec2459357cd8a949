"""Videos joined to the readings of encoders: times, units, gaps, and clocks that do not meet."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.clip import join_clip
from bodyschema.sources.joint_track import JointTrack, joint_track
from bodyschema.sources.recording import Recording
from bodyschema.sources.video import Video
from bodyschema.sources.video_writer import video_writer

pytest.importorskip("av")
cv2 = pytest.importorskip("cv2")

FRAMES = 15


@pytest.fixture(scope="module")
def video(tmp_path_factory) -> Video:
    """Half a second of frames that become brighter, 30 a second."""
    path = tmp_path_factory.mktemp("video") / "a.mp4"
    with video_writer(path, (33, 32), 30) as write:
        for k in range(FRAMES):
            write(np.full((32, 33, 3), 10 * k, dtype=np.uint8))
    return Video.open(path)


def table(time, **columns) -> Recording:
    named = {"time": np.asarray(time, float)}
    named |= {k: np.asarray(v, float) for k, v in columns.items()}
    return Recording("'joints.csv'", named, {})


def ramp(begin: float, end: float, step: float = 0.1) -> JointTrack:
    """A joint whose position is the time."""
    time = np.arange(begin, end + step / 2, step)
    return joint_track(table(time, elbow=time))


def test_written_videos_read_back(video):
    assert (video.width, video.height, video.count) == (32, 32, FRAMES)
    means = [frame.image.mean() for frame in video.frames()]
    np.testing.assert_allclose(means, 10 * np.arange(FRAMES), atol=3)


def test_the_same_pictures_give_the_same_bytes(tmp_path, video):
    paths = [tmp_path / name for name in ("a.mp4", "b.mp4")]
    for path in paths:
        with video_writer(path, (32, 32), 30) as write:
            for frame in video.frames():
                write(frame.image)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_positions_are_those_at_the_frames(video):
    clip = join_clip(video, ramp(-1, 2))
    np.testing.assert_allclose(clip.time, np.arange(FRAMES) / 30, atol=1e-6)
    np.testing.assert_allclose(clip.positions[:, 0], clip.time, atol=1e-9)
    assert clip.left_out == 0


def test_a_start_shifts_the_clock_and_frames_without_readings_are_left_out(video):
    clip = join_clip(video, ramp(100, 101), start=99.9)
    assert clip.left_out == 3
    moments = list(clip.moments())
    assert [m.index for m in moments] == list(range(3, FRAMES))
    assert moments[0].image.mean() == pytest.approx(30, abs=3)
    np.testing.assert_allclose(moments[0].positions, [100.0], atol=1e-6)
    assert moments[0].grey.shape == (32, 32)


def test_clocks_that_do_not_meet_are_named(video):
    with pytest.raises(
        InputError, match=r"from 0.000 to 0.467 s.*from 100.000 to 101.000 s.*--start"
    ):
        join_clip(video, ramp(100, 101))


def test_frames_a_second_replace_the_stamps(video):
    clip = join_clip(video, ramp(0, 5), fps=10)
    np.testing.assert_allclose(clip.time, np.arange(FRAMES) / 10)
    with pytest.raises(InputError, match="above zero"):
        join_clip(video, ramp(0, 5), fps=0)


def test_pictures_go_with_rows_if_there_are_as_many(tmp_path):
    for k in range(12):
        cv2.imwrite(str(tmp_path / f"f{k}.png"), np.full((20, 20, 3), k, np.uint8))
    pictures = Video.open(tmp_path)
    track = ramp(5, 6.1)
    clip = join_clip(pictures, track)
    np.testing.assert_allclose(clip.time, track.time)
    assert [int(m.image.mean()) for m in clip.moments()] == list(range(12))
    with pytest.raises(InputError, match=r"12 pictures and 21 rows.*--fps"):
        join_clip(pictures, ramp(0, 2))


def test_no_lines_are_drawn_over_gaps():
    track = joint_track(table([0, 0.1, 0.9, 1.0], elbow=[0, 1, 2, 3]))
    assert track.at(0.05) == pytest.approx(0.5)
    assert np.isnan(track.at(0.5)).all()
    assert np.isnan(track.at(1.1)).all()
    assert track.at(1.0005) == pytest.approx(3), "tables are written rounded"


def test_joints_and_units_by_patterns():
    q = table([0, 1], q_arm=[0, 180], q_grip=[0, 50], cmd_arm=[1, 1])
    track = joint_track(q, ["q_*"], ["deg", "q_grip=1"])
    assert track.joints == ("q_arm", "q_grip")
    np.testing.assert_allclose(track.positions[1], [np.pi, 50])
    assert joint_track(q).joints == ("q_arm", "q_grip", "cmd_arm")


@pytest.mark.parametrize(
    ("columns", "joints", "units", "message"),
    [
        ({"a": [0, 1]}, ["b*"], ["rad"], "no joint 'b.*there are: 'a'"),
        ({"a": [0, 1]}, [], ["turns"], "unknown unit 'turns'"),
        ({"a": [0, 1]}, [], ["b=deg"], "no joint 'b' to have the unit 'deg'"),
        ({"a": [0, 1], "b": [0, 1]}, [], ["b=deg"], "joint 'a' has no unit"),
        ({"a": [0, np.nan]}, [], ["rad"], "column 'a' of 'joints.csv' holds nan in row 1"),
        ({}, [], ["rad"], "no column of numbers beside the time"),
    ],
)
def test_unfit_tables(columns, joints, units, message):
    with pytest.raises(InputError, match=message):
        joint_track(table([0, 1], **columns), joints, units)


def test_times_are_needed_and_run_forward():
    with pytest.raises(InputError, match="time goes back in row 1"):
        joint_track(table([1, 0], a=[0, 1]))
    clockless = Recording("'joints.csv'", {"t_s": np.arange(2.0), "a": np.arange(2.0)}, {})
    with pytest.raises(InputError, match="name the time column"):
        joint_track(clockless)
    assert joint_track(clockless, time_column="t_s").joints == ("a",)
