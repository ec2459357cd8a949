"""`bodyschema track` on videos: frames matched to rows, by number and by time; what is written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.cli.run_file import RunFile, read_run_file
from bodyschema.cli.tracking.album import Album, _by_time
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.joint_track import JointTrack
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from small_arm import CAMERA, POSTURES, TRACK, WRONG, write_arm

av = pytest.importorskip("av")
cv2 = pytest.importorskip("cv2")
pytest.importorskip("trimesh")
pytest.importorskip("matplotlib")

RATE, BEGINNING = 10, 100.0
"""Frames a second, and the recording's time at the first, s."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An arm that swings before a camera, its video, and its encoders at two rates."""
    folder = tmp_path_factory.mktemp("video")
    body = write_arm(folder)
    times = np.arange(12) / RATE
    q = np.array([np.interp(times, times[::4], column[:3]) for column in POSTURES.T]).T
    surface, wide = bs.Surface.of(body), CAMERA.width
    with av.open(str(folder / "eye.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=RATE, options={"crf": "10"})
        stream.width, stream.height, stream.pix_fmt = wide, CAMERA.height, "yuv420p"
        for pose in piece_poses(body, q + WRONG, [CAMERA], surface.frames)[:, 0]:
            image = np.where(silhouette(surface, pose, CAMERA)[..., None], [200, 180, 60], 30)
            frame = av.VideoFrame.from_ndarray(image.astype(np.uint8), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    fine = np.arange(0, times[-1] - 0.15, 0.04)
    lines = {"rows.csv": (times, q), "clock.csv": (fine + BEGINNING, None)}
    for name, (t, values) in lines.items():
        if values is None:
            values = np.array([np.interp(fine, times, column) for column in q.T]).T
        rows = "\n".join(f"{a},{b[0]},{b[1]}" for a, b in zip(t, values, strict=True))
        (folder / name).write_text(f"t,lift,bend\n{rows}\n")
    return folder


def read_track(path: Path) -> RunFile:
    return read_run_file(path, "track")


def track_file(folder: Path, recording: str, source: str) -> Path:
    text = TRACK.replace("joints.csv", recording).replace('images = "image_{row:03}.png"', source)
    path = folder / f"{recording}.toml"
    path.write_text(text.replace('masks = "mask_{row:03}.png"\n', ""))
    return path


def test_rows_are_frames_without_a_start(folder: Path) -> None:
    album = Album.open(read_track(track_file(folder, "rows.csv", 'video = "eye.mp4"')))
    assert len(album) == 12
    assert [images.time for images in album.seen([3, 7])] == pytest.approx([0.3, 0.7])
    pictures = [pictures[0] for pictures in album.pictures([3, 3, 7])]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert (pictures[0] != pictures[2]).any()


def test_joints_are_interpolated_at_the_frames_with_a_start(folder: Path) -> None:
    by_row = Album.open(read_track(track_file(folder, "rows.csv", 'video = "eye.mp4"')))
    source = f'video = "eye.mp4"\nstart = {BEGINNING}'
    album = Album.open(read_track(track_file(folder, "clock.csv", source)))
    assert album.numbers[:, 0].tolist() == list(range(10))  # the encoders end before the video
    np.testing.assert_allclose(album.time, BEGINNING + np.arange(10) / RATE)
    np.testing.assert_allclose(album.q, by_row.q[:10], atol=0.02)


def test_a_video_becomes_a_corrected_robot_and_a_page(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = track_file(folder, "rows.csv", 'video = "eye.mp4"'), folder / "out"
    before = (folder / "arm.urdf").read_bytes()
    command = ["track", str(path), "--seeds", "64", "--overlays", "1", "--json", "--out"]
    assert run([*command, str(out)]) == 0
    answer = json.loads(capsys.readouterr().out)
    found = [answer["corrections"][f"{name}.offset"] for name in ("lift", "bend")]
    np.testing.assert_allclose(found, WRONG, atol=np.deg2rad(0.3))
    assert (folder / "arm.urdf").read_bytes() == before
    corrected = bs.Body.from_urdf(out / "robot.urdf")
    q = np.array([[0.2, -0.4]])
    T = [
        relative_pose(body, x, "base", "fore")
        for body, x in ((corrected, q), (bs.Body.from_urdf(folder / "arm.urdf"), q + found))
    ]
    np.testing.assert_allclose(*T, atol=1e-9)
    page = (out / "report.html").read_text()
    assert "Found" in page
    assert "data:image/jpeg;base64," in page
    assert "http" not in page.replace("http://www.w3.org", "")
    assert run([*command, str(folder / "again")]) == 0
    for name in ("report.html", "track.json", "run.json", "robot.urdf"):
        assert (folder / "again" / name).read_bytes() == (out / name).read_bytes()
    capsys.readouterr()
    assert run(["export", str(out), "--robot", str(folder / "arm.urdf"), "--out",
                str(folder / "copy.urdf")]) == 0  # fmt: skip
    assert bs.Body.from_urdf(folder / "copy.urdf").placement == pytest.approx(corrected.placement)


@pytest.mark.parametrize(
    ("recording", "source", "message"),
    [
        ("clock.csv", 'video = "eye.mp4"', "has 12 frames and 'clock.csv' 24 rows"),
        ("clock.csv", 'video = "eye.mp4"\nstart = 7.0', "the rows from 100.000 s"),
        ("rows.csv", 'video = "eye.mp4"\nimages = "{row}.png"', "needs either images"),
        ("rows.csv", 'images = "{row}.png"\nstart = 1.0', "pictures have no clock"),
        ("rows.csv", 'video = "eye.mp4"\nstart = "now"', "start = 'now' in [cameras.eye]"),
        ("rows.csv", 'video = "ear.mp4"', "no video at"),
    ],
)
def test_what_does_not_match_is_told(
    folder: Path, recording: str, source: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = track_file(folder, recording, source)
    assert run(["track", str(path), "--out", str(folder / "none")]) == 2
    assert message in capsys.readouterr().err
    assert not (folder / "none").exists()


def test_a_folder_with_inputs_or_other_things_is_never_replaced(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = track_file(folder, "rows.csv", 'video = "eye.mp4"')
    assert run(["track", str(path), "--out", str(folder), "--overwrite"]) == 2
    assert "inputs are never touched" in capsys.readouterr().err
    (folder / "other").mkdir()
    (folder / "other" / "thesis.tex").write_text("years of work")
    assert run(["track", str(path), "--out", str(folder / "other"), "--overwrite"]) == 2
    assert "which is no result" in capsys.readouterr().err


def test_pictures_that_hide_the_arm_are_not_learned_from(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are told as lost, and the answer is that of the others."""
    frames = [pictures[0] for pictures in
              Album.open(read_track(track_file(folder, "rows.csv", 'video = "eye.mp4"')))
              .pictures(range(12))]  # fmt: skip
    hidden = (4, 5)
    for number, picture in enumerate(frames):
        shown = picture[..., ::-1].copy()
        if number in hidden:
            shown[20:] = 90
        cv2.imwrite(str(folder / f"hidden_{number}.png"), shown)
    path = track_file(folder, "rows.csv", 'images = "hidden_{row}.png"')
    command = ["track", str(path), "--seeds", "64", "--overlays", "0", "--json"]
    assert run([*command, "--out", str(folder / "hidden")]) == 0
    answer = json.loads(capsys.readouterr().out)
    lost = [frame["frame"] for frame in answer["frames"] if frame["lost"]]
    assert lost == list(hidden)
    page = (folder / "hidden" / "report.html").read_text()
    assert "The hand is lost in 2 of 12 moments: pictures 4, 5." in page
    assert answer["matched"] > 0.9
    found = [answer["corrections"][f"{name}.offset"] for name in ("lift", "bend")]
    np.testing.assert_allclose(found, WRONG, atol=np.deg2rad(0.3))


def test_frames_of_two_cameras_must_belong_together() -> None:
    """A camera that lost frames 2 to 4 leaves those moments out."""
    clock = np.arange(8) / RATE
    track = JointTrack("here", ("lift",), clock, clock[:, None])
    other = np.delete(clock, [2, 3, 4]) + 0.02
    numbers, q, time = _by_time(track, [clock, other])
    assert numbers.tolist() == [[0, 0], [1, 1], [5, 2], [6, 3], [7, 4]]
    np.testing.assert_allclose(time, clock[[0, 1, 5, 6, 7]])
    np.testing.assert_allclose(q[:, 0], time)
    numbers, _, _ = _by_time(track, [clock, clock[::2]])  # a camera of half the rate
    assert numbers.tolist() == [[0, 0], [2, 1], [4, 2], [6, 3]]
    with pytest.raises(InputError, match="within half a frame"):
        _by_time(track, [clock, clock + 50])
