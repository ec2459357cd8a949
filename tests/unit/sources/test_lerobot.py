"""LeRobot data sets of both layouts, and what is said of those that cannot be read."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("av")
pytest.importorskip("pyarrow")

from bodyschema.errors import InputError
from bodyschema.sources.clip import episode_clip
from bodyschema.sources.joint_track import joint_track
from bodyschema.sources.lerobot import is_lerobot, open_episode
from bodyschema.sources.video import Video
from lerobot_folder import (
    CAMERA,
    FPS,
    FRAMES,
    VERSION_2,
    VERSION_3,
    states,
    version_2,
    version_3,
    write_info,
)

both_layouts = pytest.mark.parametrize("layout", [version_2, version_3])


@both_layouts
def test_states_names_and_video_of_an_episode(tmp_path, layout):
    folder = layout(tmp_path)
    assert is_lerobot(folder)
    for number in range(3):
        episode = open_episode(folder, number, "head")
        assert episode.joints == ("shoulder", "elbow")
        values, present = episode.recording.matrix(episode.joints, "1")
        assert present.all()
        np.testing.assert_allclose(values, states(number), atol=1e-6)
        np.testing.assert_allclose(episode.recording.time(), np.arange(FRAMES) / FPS, atol=1e-6)


@both_layouts
def test_the_frames_are_those_of_the_episode(tmp_path, layout):
    folder = layout(tmp_path)
    for number in range(3):
        episode = open_episode(folder, number)
        track = joint_track(episode.recording, (), ("1",), "timestamp")
        clip = episode_clip(Video.open(episode.video), track, episode)
        moments = list(clip.moments())
        assert len(moments) == FRAMES
        np.testing.assert_allclose([m.image.mean() for m in moments], 40 + 60 * number, atol=4)
        np.testing.assert_allclose([m.positions for m in moments], states(number), atol=1e-4)


def test_units_are_stated_by_who_asks(tmp_path):
    episode = open_episode(version_2(tmp_path), 1)
    track = joint_track(episode.recording, (), ("deg", "elbow=1"), "timestamp")
    np.testing.assert_allclose(track.positions[-1], [np.pi / 180, 1.0], atol=1e-6)


def test_the_end_of_a_camera_key_names_it_and_others_are_listed(tmp_path):
    folder = version_2(tmp_path)
    assert CAMERA in str(open_episode(folder, 0, "head").video)
    with pytest.raises(InputError, match=r"no camera 'hed'.*did you mean 'head'"):
        open_episode(folder, 0, "hed")
    with pytest.raises(InputError, match="there are 0 to 2"):
        open_episode(folder, 3)


def test_two_cameras_ask_which(tmp_path):
    folder = version_2(tmp_path)
    cameras = {CAMERA: {"dtype": "video"}, "observation.images.wrist": {"dtype": "video"}}
    write_info(folder, VERSION_2, features={"observation.state": {}, **cameras})
    with pytest.raises(InputError, match="has 2 cameras; name one"):
        open_episode(folder)


def test_names_that_do_not_fit_are_numbered(tmp_path):
    folder = version_2(tmp_path)
    cameras = {CAMERA: {"dtype": "video"}}
    for stated, expected in (
        (None, ("state_0", "state_1")),
        (["dim"], ("state_0", "state_1")),
        ({"motors": ["a", "b"]}, ("a", "b")),
    ):
        features = {"observation.state": {"names": stated}, **cameras}
        write_info(folder, VERSION_2, features=features)
        assert open_episode(folder).joints == expected


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"codebase_version": "v1.6"}, "version v1.6; versions 2 and 3"),
        ({"features": {CAMERA: {"dtype": "video"}}}, "no feature 'observation.state'"),
        ({"video_path": None}, "does not state 'video_path'"),
        ({"data_path": "data/{batch}.parquet"}, "path with an unknown part"),
        ({"data_path": "data/none.parquet"}, "was it downloaded whole"),
        ({"data_path": "../../{episode_index}.parquet"}, "outside of its folder"),
        ({"video_path": "/etc/{video_key}"}, "outside of its folder"),
        ({"data_path": "{episode_index:100000000d}"}, "only {name} and {name:03d} may stand"),
        ({"data_path": "{episode_index.__class__}"}, "only {name} and {name:03d} may stand"),
        ({"data_path": "{video_key:9d}.parquet"}, "path with an unknown part"),
        ({"features": ["observation.state"]}, "must be a table of tables"),
        ({"features": {"observation.state": 1}}, "must be a table of tables"),
        ({"total_episodes": "3"}, "expected a whole number"),
        ({"chunks_size": [1]}, "expected a whole number"),
    ],
)
def test_unfit_data_sets(tmp_path, changes, message):
    folder = version_2(tmp_path)
    write_info(folder, VERSION_2, **changes)
    with pytest.raises(InputError, match=message):
        open_episode(folder)


@pytest.mark.parametrize("text", ["[]", "3", "[" * 100_000, '"\\ud800"'])
def test_an_info_that_is_no_table(tmp_path, text):
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(text)
    with pytest.raises(InputError, match=r"no table of keys|no readable JSON|half a character"):
        open_episode(tmp_path)


def test_an_episode_that_is_not_here_names_those_that_are(tmp_path):
    folder = version_2(tmp_path)
    first = min((folder / "data").rglob("*.parquet"))
    first.rename(first.with_name("episode_000040.parquet"))
    with pytest.raises(InputError, match=r"whole\? In its place there are .*'episode_000040\.par"):
        open_episode(folder)


def test_a_reference_to_a_large_file_is_not_the_file(tmp_path):
    folder = version_2(tmp_path)
    video = open_episode(folder).video
    video.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\n")
    with pytest.raises(InputError, match="git lfs pull"):
        open_episode(folder)


def test_broken_files(tmp_path):
    folder = version_2(tmp_path)
    table = next(folder.glob("data/*/episode_000000.parquet"))
    table.write_bytes(table.read_bytes()[:100])
    with pytest.raises(InputError, match="no whole Parquet file"):
        open_episode(folder)
    (folder / "meta" / "info.json").write_text("{")
    with pytest.raises(InputError, match="no readable JSON"):
        open_episode(folder)
    with pytest.raises(InputError, match="no LeRobot data set"):
        open_episode(tmp_path / "elsewhere")


def test_rows_that_are_no_parquet_are_said(tmp_path):
    write_info(tmp_path, VERSION_3, storage_format="lance")
    with pytest.raises(InputError, match=r"stored as lance .*write it again as Parquet"):
        open_episode(tmp_path)
