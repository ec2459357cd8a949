"""`bodyschema find-body` on a bar that turns, and on input that cannot be used."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from bodyschema import load
from bodyschema.cli import run
from bodyschema.sources.tables import open_recording
from bodyschema.sources.video import Video
from lerobot_folder import CAMERA, VERSION_2, write_info, write_rows
from moving_bar import HEIGHT, WIDTH, record

cv2 = pytest.importorskip("cv2")
pytest.importorskip("av")

DEGREES = ("--unit", "deg")


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """Video and table."""
    return record(tmp_path_factory.mktemp("clip"))


@pytest.fixture(scope="module")
def found(clip, tmp_path_factory):
    """Exit code and output folder."""
    out = tmp_path_factory.mktemp("found") / "out"
    video, table = map(str, clip)
    code = run(["find-body", video, "--encoders", table, *DEGREES, "--out", str(out), "--json"])
    return code, out


@pytest.fixture
def attempt(clip, tmp_path, capsys):
    """Run with a table that was changed; returns exit code, output and errors."""

    def go(*arguments: str, change=None, source=None):
        table = dict(open_recording(clip[1]).columns)
        columns = change(table) if change else table
        path = tmp_path / "joints.csv"
        rows = np.column_stack(list(columns.values())).tolist()
        lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
        path.write_text("\n".join(lines))
        words = ["find-body", str(source or clip[0]), "--encoders", str(path), *DEGREES]
        code = run([*words, "--out", str(tmp_path / "out"), *arguments])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return go


def test_the_bar_is_found_and_the_wall_is_not(found):
    code, out = found
    answer = load(out).details
    assert code == 0
    assert load(out).verdict == "found"
    assert "The cells that are me" in (out / "report.html").read_text()
    mask = cv2.imread(str(out / "mask.png"), 0) > 0
    assert mask.shape == (HEIGHT, WIDTH)
    assert mask[72:110, 60:150].mean() > 0.3
    assert mask[:40].mean() < 0.02
    assert mask[:, :24].mean() < 0.02
    assert answer["cells_of_joint"]["turn"] == answer["body_cells"] > 5
    assert answer["cells_of_joint"]["idle"] == 0
    assert answer["frames"] > 100


def test_everything_is_written(found):
    _, out = found
    frames = Video.open(out / "overlay.mp4")
    assert (frames.width, frames.count) == (
        WIDTH,
        load(out).details["frames"],
    )
    assert len(list(out.glob("overlay_*.png"))) == 5
    with np.load(out / "evidence.npz") as kept:
        assert kept["evidence"].shape == (2, HEIGHT // 16, WIDTH // 16)
        assert list(kept["joints"]) == ["turn", "idle"]
        table = open_recording(out / "evidence.csv")
        np.testing.assert_allclose(table.columns["probability"], kept["probability"].ravel())
    assert list(table.columns)[:5] == ["u_px", "v_px", "probability", "me", "joint"]


def test_the_same_again_gives_the_same_pictures(found, clip, tmp_path):
    _, out = found
    video, table = map(str, clip)
    run(["find-body", video, "--encoders", table, *DEGREES, "--out", str(tmp_path / "again")])
    for name in ("evidence.csv", "mask.png", "overlay.mp4"):
        assert (tmp_path / "again" / name).read_bytes() == (out / name).read_bytes()


def test_in_words(attempt):
    code, out, _ = attempt("--pictures", "0")
    assert code == 0
    for words in ("cells are me", "moved furthest by turn", "frames", "Next:"):
        assert words in out


def test_a_folder_of_pictures_with_one_row_each(clip, tmp_path, attempt):
    folder = tmp_path / "frames"
    folder.mkdir()
    for frame in Video.open(clip[0]).frames():
        cv2.imwrite(str(folder / f"{frame.index}.png"), frame.image)
    code, _, err = attempt("--start", "2", source=folder)
    assert code == 2
    assert "say how many frames a second" in err
    code, out, _ = attempt("--json", "--pictures", "0", source=folder)
    assert code == 0
    answer = json.loads(out)
    assert answer["frames_left_out"] == 0
    assert answer["ms_per_frame"] > 0
    assert answer["parameters"] == []


def test_an_episode_of_a_lerobot_data_set(clip, tmp_path, capsys):
    """The same bar, told in the layout of version 2; its states are degrees."""
    table = open_recording(clip[1]).columns
    place = {"episode_index": 1, "episode_chunk": 0, "video_key": CAMERA}
    video = tmp_path / VERSION_2["video_path"].format(**place)
    video.parent.mkdir(parents=True)
    shutil.copy(clip[0], video)
    write_info(tmp_path, VERSION_2)
    states = np.column_stack([table["turn"], table["idle"]]).astype(np.float32)
    write_rows(tmp_path / VERSION_2["data_path"].format(**place), states, [1])
    words = ["find-body", str(tmp_path), *DEGREES, "--pictures", "0", "--json"]
    assert run([*words, "--episode", "1", "--out", str(tmp_path / "out")]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["frames"] == len(states)
    assert answer["cells_of_joint"]["shoulder"] == answer["body_cells"] > 5
    assert run([*words, "--episode", "7", "--out", str(tmp_path / "again")]) == 2
    assert "there are 0 to 2" in capsys.readouterr().err


def still(columns):
    return {name: v if name == "time" else 0 * v for name, v in columns.items()}


def put(name, row, value):
    def change(columns):
        column = columns[name].copy()
        column[row] = value
        return columns | {name: column}

    return change


@pytest.mark.parametrize(
    ("arguments", "change", "message"),
    [
        ((), put("turn", 7, np.nan), "column 'turn' of 'joints.csv' holds nan in row 7"),
        ((), put("time", 9, 0.01), "time goes back in row 9"),
        ((), lambda c: c | {"time": c["time"] + 500}, "from 0.000 to"),
        ((), still, "no joint moves while"),
        (("--joints", "elbow"), None, "no joint 'elbow' in 'joints.csv'"),
        (("--time-column", "t_s"), None, "no column 't_s'"),
        (("--camera-joints", "neck"), None, "no joint 'neck'"),
        (("--fps", "0"), None, "frames a second must be above zero"),
        (("--cell", "0"), None, "cell"),
        (("--pictures", "-3"), None, "give 0 or more"),
        (("--start", "nan"), None, "--start is nan"),
        (("--episode", "3"), None, "choose from a LeRobot data set"),
    ],
)
def test_bad_input_ends_in_one_sentence(attempt, tmp_path, arguments, change, message):
    code, out, err = attempt(*arguments, change=change)
    assert code == 2
    assert message in err
    assert err.startswith("bodyschema: ")
    assert len(err.strip().splitlines()) == 1
    assert not out
    assert not (tmp_path / "out").exists()


def test_sources_that_are_none(clip, tmp_path, capsys):
    assert run(["find-body", str(clip[0]), "--out", str(tmp_path / "out")]) == 2
    assert "--encoders" in capsys.readouterr().err
    words = ["find-body", str(tmp_path / "none.mp4"), "--encoders", str(clip[1])]
    assert run([*words, "--out", str(tmp_path / "out")]) == 2
    assert "no video at" in capsys.readouterr().err
    cut = tmp_path / "cut.mp4"
    shutil.copy(clip[0], cut)
    cut.write_bytes(cut.read_bytes()[:2000])
    assert run(["find-body", str(cut), "--encoders", str(clip[1])]) == 2
    assert "cannot be read as a video" in capsys.readouterr().err


def test_inputs_and_other_things_are_never_replaced(clip, tmp_path, capsys):
    video, table = map(str, clip)
    frames, other = tmp_path / "frames", tmp_path / "other"
    for folder in (frames, other):
        folder.mkdir()
    (other / "thesis.tex").write_text("years of work")
    cv2.imwrite(str(frames / "0.png"), np.zeros((64, 64, 3), np.uint8))
    for source, out, message in (
        (frames, frames, "inputs are never touched"),
        (frames, tmp_path, "inputs are never touched"),
        (frames / "{row}.png", frames, "inputs are never touched"),
        (video, other, "holds 'thesis.tex', which is no result"),
    ):
        words = ["find-body", str(source), "--encoders", table, *DEGREES, "--overwrite"]
        assert run([*words, "--out", str(out)]) == 2
        assert message in capsys.readouterr().err
    assert (frames / "0.png").is_file()
    assert (other / "thesis.tex").is_file()


def test_a_folder_is_planned_and_not_checked(found, clip, capsys):
    _, out = found
    assert run(["plan", str(out)]) == 0
    assert capsys.readouterr().out.startswith("Next:")
    assert run(["check", str(out), "--recording", str(clip[1])]) == 2
    assert "holds no belief" in capsys.readouterr().err
    assert run(["export", str(out), "--robot", str(clip[1])]) == 2
    assert capsys.readouterr().err.startswith("bodyschema: ")
