"""Frames from video files, folders and patterns; what is broken is told in one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.video import Video

av = pytest.importorskip("av")
cv2 = pytest.importorskip("cv2")

COUNT, WIDTH, HEIGHT = 12, 64, 48


def shade(index: int) -> int:
    """Grey of a frame."""
    return 20 * index


def write_video(path: Path, codec: str = "mpeg4", first: str = "", count: int = COUNT) -> Path:
    """Grey frames at 25 a second; `first` is a flag of the container."""
    with av.open(str(path), "w", options={"movflags": first} if first else {}) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for index in range(count):
            image = np.full((HEIGHT, WIDTH, 3), shade(index), np.uint8)
            image[:, :8] = 255, 0, 0
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    return path


@pytest.mark.parametrize(
    ("name", "codec"), [("a.mp4", "libx264"), ("a.avi", "mpeg4"), ("a.mkv", "libx264")]
)
def test_frames_come_in_order_with_their_times(tmp_path: Path, name: str, codec: str) -> None:
    video = Video.open(write_video(tmp_path / name, codec))
    frames = list(video.frames())
    assert (video.width, video.height, video.count or COUNT) == (WIDTH, HEIGHT, COUNT)
    assert [frame.index for frame in frames] == list(range(COUNT))
    np.testing.assert_allclose([frame.time for frame in frames], np.arange(COUNT) / 25, atol=1e-3)
    np.testing.assert_allclose(video.times(), [frame.time for frame in frames], atol=1e-9)
    assert all(frame.image.shape == (HEIGHT, WIDTH, 3) for frame in frames)
    assert [abs(int(f.image[24, 40, 1]) - shade(f.index)) < 6 for f in frames] == [True] * COUNT
    red, _, blue = frames[0].image[24, 3]
    assert red > 200
    assert blue < 60


def test_only_wanted_frames_are_given(tmp_path: Path) -> None:
    video = Video.open(write_video(tmp_path / "a.mp4"))
    assert [frame.index for frame in video.frames({2, 9})] == [2, 9]


def test_pictures_of_a_folder_follow_their_numbers(tmp_path: Path) -> None:
    for index in (0, 1, 2, 10):
        cv2.imwrite(str(tmp_path / f"i_{index}.png"), np.full((4, 6, 3), index, np.uint8))
    (tmp_path / "notes.txt").write_text("no picture")
    folder, pattern = Video.open(tmp_path), Video.open(tmp_path / "i_{row}.png")
    assert [frame.image[0, 0, 0] for frame in folder.frames()] == [0, 1, 2, 10]
    assert (folder.count, pattern.count, folder.width, folder.height) == (4, 3, 6, 4)
    assert [(f.index, f.time) for f in pattern.frames({1})] == [(1, None)]
    with pytest.raises(InputError, match="carry no times"):
        folder.times()


def test_a_video_that_is_cut_off_is_told(tmp_path: Path) -> None:
    whole = write_video(tmp_path / "whole.mp4", "libx264", "faststart").read_bytes()
    for name, share in (("late.mp4", 0.97), ("early.mp4", 0.6)):
        (tmp_path / name).write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match=rf"{name}' breaks off at frame \d+ of 12"):
            list(Video.open(tmp_path / name).frames())
    with av.open(str(tmp_path / "whole.mp4")) as container:
        ends = [p.pos + p.size for p in container.demux(video=0) if p.size]
    (tmp_path / "between.mp4").write_bytes(whole[: sorted(ends)[7]])  # no frame is damaged
    with pytest.raises(InputError, match=r"between\.mp4' breaks off at frame 8 of 12"):
        list(Video.open(tmp_path / "between.mp4").frames())
    headless = write_video(tmp_path / "headless.mp4").read_bytes()
    (tmp_path / "headless.mp4").write_bytes(headless[: len(headless) // 2])
    with pytest.raises(InputError, match="may be cut off"):
        Video.open(tmp_path / "headless.mp4")


def test_a_video_without_a_decoder_is_told(tmp_path: Path) -> None:
    content = write_video(tmp_path / "a.mkv", "libx264").read_bytes()
    assert b"V_MPEG4/ISO/AVC" in content
    (tmp_path / "a.mkv").write_bytes(content.replace(b"V_MPEG4/ISO/AVC", b"V_NOBODYS/CODE!"))
    with pytest.raises(InputError, match="no decoder"):
        Video.open(tmp_path / "a.mkv")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nothing.mp4", "no video at"),
        ("text.mp4", "cannot be read as a video"),
        ("sound.wav", "holds no pictures"),
        ("empty", "holds no pictures; expected"),
        ("i_{row}.png", "counted from 0"),
        ("{number}.png", "write {row}"),
        ("{{row}}.png", "write {row}"),
        ("broken", "is no picture"),
    ],
)
def test_what_is_no_video_is_told(tmp_path: Path, name: str, message: str) -> None:
    (tmp_path / "text.mp4").write_text("hello")
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "a.png").write_bytes(b"\x89PNG")
    with av.open(str(tmp_path / "sound.wav"), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=8000)
        silence = av.AudioFrame.from_ndarray(np.zeros((1, 800), np.int16), layout="mono")
        silence.sample_rate = 8000
        container.mux(stream.encode(silence))
    with pytest.raises(InputError, match=message):
        Video.open(tmp_path / name)


def test_a_video_without_frames_is_told(tmp_path: Path) -> None:
    video = write_video(tmp_path / "a.avi", count=0)
    with pytest.raises(InputError, match=r"a\.avi'"):
        list(Video.open(video).frames())
