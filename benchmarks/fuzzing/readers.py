"""What is fuzzed: each reader with the files that it starts from and how they are mutated."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.model.meshes import triangles_of
from fuzzing import forms, odd, seeds


@dataclass(frozen=True)
class Reader:
    """One reader."""

    make: Callable[[Path], None]
    """Fills a folder with whole files."""
    kinds: Mapping[str, str]
    """Pattern of the files that are mutated -> key of `mutations.MUTATIONS`."""
    read: Callable[[Path, random.Random], Any]
    """Reads in the folder of a mutant; `path` is the file that was mutated."""
    share: float = 1.0
    """Of the mutants, against other readers."""
    confined: bool = False
    """Whether it may open only files of its own folder."""


def _urdf(path: Path, rng: random.Random) -> None:
    body = bs.Body.from_urdf(path)
    bs.relative_pose(body, np.zeros((2, len(body.joints))), body.frames[0], body.frames[-1])
    patch_urdf(path.read_bytes(), {})


def _mesh(path: Path, rng: random.Random) -> None:
    for visual in bs.Body.from_urdf(Path(f"{path.suffix[1:]}.urdf")).visuals:
        triangles_of(visual)


def _body(body: bs.Body) -> None:
    bs.relative_pose(body, np.zeros((2, len(body.joints))), body.frames[0], body.frames[-1])


def _mjcf(path: Path, rng: random.Random) -> None:
    from bodyschema.export.mjcf_patch import MjcfPatch

    body = bs.Body.from_file(path)
    _body(body)
    MjcfPatch(path.read_bytes(), path.name).text()


def _lens(path: Path, rng: random.Random) -> None:
    from bodyschema.model.lens_file import read_lens

    read_lens(f"{path}{'#cam1' * ('kalibr' in path.name)}")


def _motors(path: Path, rng: random.Random) -> None:
    """What one in a column is, and the file with its zeros put right."""
    import json

    from bodyschema.cli.reading.corrected_joints import with_motors
    from bodyschema.sources.motors import UNITS, read_motors

    motors = read_motors(path)
    slid = {name: motor.slid(2.5) for name, motor in motors.items()}
    for name, motor in slid.items():
        for unit in UNITS:
            motor.degrees(unit, name == "gripper")
    json.dumps(with_motors(json.loads(path.read_bytes()), slid))


def _cut(path: Path, rng: random.Random) -> None:
    """A topic, all of them, or what `inspect` says."""
    kind = rng.randrange(3)
    if kind == 2:
        code = seeds.quietly("inspect", str(path))
        assert code in (0, 2), f"exit {code}"
        return
    bs.open_recording(f"{path}#/joint_states" if kind else path).time()


def _calibrate(path: Path, rng: random.Random) -> None:
    from bodyschema.cli.loading import load
    from bodyschema.cli.run_file import read_run_file

    load(read_run_file(Path("run.toml")))


def _payload(path: Path, rng: random.Random) -> None:
    from bodyschema.cli.reading.touch_sections import solid_of
    from bodyschema.cli.reading.wrist_sections import held_tables
    from bodyschema.cli.run_file import read_run_file

    run = read_run_file(Path("run.toml"), "touch")
    table, _, declared, _ = held_tables(run)
    table.read(declared)
    solid_of(run, None)


def _hand_eye(path: Path, rng: random.Random) -> None:
    from bodyschema.cli.reading.pose_lists import read_pose_lists
    from bodyschema.cli.run_file import read_run_file

    read_pose_lists(read_run_file(Path("run.toml"), "hand-eye"))


def _track(path: Path, rng: random.Random) -> None:
    from bodyschema.cli.run_file import read_run_file
    from bodyschema.cli.tracking.album import Album

    album = Album.open(read_run_file(Path("run.toml"), "track"))
    list(album.seen(range(len(album.q))[:1]))


def _table(path: Path, rng: random.Random) -> None:
    recording = bs.open_recording(path)
    recording.time()
    for name in list(recording.columns)[:20]:
        recording.matrix([name], "mm")


def _bag(path: Path, rng: random.Random) -> None:
    _table(path.parent if path.suffix in (".db3", ".yaml") else path, rng)


def _lerobot(path: Path, rng: random.Random) -> None:
    from bodyschema.sources.clip import episode_clip
    from bodyschema.sources.joint_track import joint_track
    from bodyschema.sources.lerobot import open_episode

    home = Path(path.parts[0])
    if rng.randrange(2):
        bs.open_recording(home).time()
        return
    episode = open_episode(home)
    from bodyschema.sources.video import Video

    track = joint_track(episode.recording, episode.joints, ("1",))
    list(episode_clip(Video.open(episode.video), track, episode).moments())


def _picture(path: Path, rng: random.Random) -> None:
    from bodyschema.sources.video import Video

    list(Video.open(path.parent).frames())


def _video(path: Path, rng: random.Random) -> None:
    from bodyschema.sources.clip import join_clip
    from bodyschema.sources.joint_track import joint_track
    from bodyschema.sources.video import Video

    video = Video.open(Path("clip.mp4"))
    list(video.frames())
    list(join_clip(video, joint_track(bs.open_recording("joints.csv"))).moments())


VERBS = (*["load"] * 6, "report", "json", "check", "plan", "export", "view")


def _answer(path: Path, rng: random.Random) -> None:
    """The folder `out`, loaded and shown, or through a verb."""
    verb = rng.choice(VERBS)
    if verb == "load":
        answer = bs.load("out")
        answer.summary()
        answer.to_urdf()
        return
    new = "new.csv" if Path("new.csv").exists() else next(iter(Path().glob("*.csv"))).name
    flags = {
        "report": ["report", "out"],
        "json": ["report", "out", "--json"],
        "check": ["check", "out", "--recording", new],
        "plan": ["plan", "out", "-n", "2", "--candidates", "30", "--out", "plan.csv"],
        "export": ["export", "out", "--robot", "robot.urdf", "--out", "new.urdf"],
        "view": ["view", "out", "--html", "page.html"],
    }[verb]
    code = seeds.quietly(*flags)
    assert code in (0, 1, 2), f"exit {code} of {flags}"


def _verb(*flags: str) -> Callable[[Path, random.Random], None]:
    """A whole verb, as numbers that pass every reader may still break a fit."""

    def read(path: Path, rng: random.Random) -> None:
        code = seeds.quietly(*flags, "--out", "fresh")
        assert code in (0, 1, 2), f"exit {code} of {flags}"

    return read


def _places(path: Path, rng: random.Random) -> None:
    """Names that no file has, pipes, folders, links to themselves."""
    from bodyschema.cli.run_file import read_run_file
    from bodyschema.sources.video import Video

    os.mkfifo("pipe.csv")
    os.symlink("loop.csv", "loop.csv")
    stem = rng.choice([*odd.TEXTS, "pipe", "loop", "data"])
    ending = rng.choice(["", ".csv", ".parquet", ".urdf", ".toml", ".json", ".mcap", ".bag",
                         ".mp4", "/", ".png", "_{row}.png", ".xacro", "#/topic"])  # fmt: skip
    name = stem + ending
    if stem in ("pipe", "loop") and ending.startswith("."):
        os.rename(f"{stem}.csv", name)
    readers: list[Callable[[str], Any]] = [
        bs.open_recording, bs.Body.from_urdf, bs.Body.from_dh, bs.Body.from_arrangement, bs.load,
        lambda n: read_run_file(Path(n)), lambda n: list(Video.open(n).frames()),
        lambda n: seeds.quietly("calibrate", n), lambda n: seeds.quietly("report", n),
        lambda n: seeds.quietly("calibrate", "--robot", n, "--recording", n),
        lambda n: seeds.quietly("find-body", n, "--encoders", n),
        lambda n: seeds.quietly("hand-eye", "--robot-poses", n, "--seen-poses", n),
        lambda n: seeds.quietly("export", "out", "--robot", n),
        lambda n: seeds.quietly("check", "out", "--recording", n),
        lambda n: seeds.quietly("plan", "out", "--seed", "-1"),
    ]  # fmt: skip
    rng.choice(readers)(name)


ANSWER = {"out/answer.json": "json", "out/a*.json": "json", "out/run.json": "json",
          "out/*.json": "json", "out/*.urdf": "xml", "out/*.yaml": "text"}  # fmt: skip
"""Files of a result folder; the answer is what most is computed from."""

READERS: dict[str, Reader] = {
    "urdf": Reader(seeds.described, {"boxes.urdf": "xml"}, _urdf, 3),
    "xacro": Reader(
        seeds.described, {"arm.xacro": "xml"}, lambda p, _: _body(bs.Body.from_urdf(p)), 0.1
    ),
    "dh": Reader(
        seeds.described, {"dh.toml": "toml", "dh.json": "json"},
        lambda p, _: _body(bs.Body.from_dh(p)), 2,
    ),
    "mjcf": Reader(forms.robots, {"arm.xml": "xml"}, _mjcf, 2),
    "joint tables": Reader(
        forms.robots, {"branches.toml": "toml", "space.toml": "toml", "body.toml": "toml",
                       "cell.toml": "toml"}, lambda p, _: _body(bs.Body.from_file(p)), 2,
    ),
    "lenses": Reader(
        forms.lenses, {"ros.yaml": "yaml", "kalibr.yaml": "yaml", "marked.yml": "yaml",
                       "opencv.xml": "xml", "lens.json": "json"}, _lens, 2,
    ),
    "motors": Reader(forms.motors, {"motors.json": "json"}, _motors, 1),
    "cut bags": Reader(forms.cut_bags, {"*.mcap": "cut"}, _cut, 1),
    "arrangement": Reader(
        seeds.described, {"arm.toml": "toml"}, lambda p, _: _body(bs.Body.from_arrangement(p)), 1
    ),
    "mesh": Reader(
        seeds.described, {"part.stl": "bytes", "part.obj": "text", "part.dae": "xml",
                          "part.ply": "bytes"}, _mesh, 2,
    ),
    "calibrate run": Reader(
        seeds.arm, {"run.toml": "toml", "data.csv": "csv", "robot.urdf": "xml"}, _calibrate, 4
    ),
    "payload run": Reader(
        lambda f: seeds.wrist(f, True), {"run.toml": "toml", "log.csv": "csv"}, _payload, 2
    ),
    "hand-eye run": Reader(seeds.pairs, {"run.toml": "toml", "pairs.csv": "csv"}, _hand_eye, 2),
    "track run": Reader(
        seeds.pictured, {"run.toml": "toml", "joints.csv": "csv", "image_000.png": "png",
                         "boxes.urdf": "xml"}, _track, 1,
    ),
    "tables": Reader(
        seeds.tables, {"*.csv": "csv", "data.parquet": "parquet"}, _table, 3
    ),
    "bags": Reader(
        seeds.bags, {"mcap/*.mcap": "bytes", "sqlite/*.db3": "bytes", "one.bag": "bytes",
                     "sqlite/metadata.yaml": "text"}, _bag, 1.5,
    ),
    "lerobot": Reader(
        seeds.lerobot, {"v?/meta/info.json": "json", "v?/data/*/*.parquet": "parquet",
                        "v3/meta/episodes/*/*.parquet": "parquet"}, _lerobot, 1.5, True,
    ),
    "pictures": Reader(
        seeds.seen, {"png/*": "png", "jpg/*": "bytes", "bmp/*": "bytes", "ppm/*": "bytes",
                     "webp/*": "bytes", "tiff/*": "bytes"}, _picture, 2,
    ),
    "videos": Reader(seeds.seen, {"clip.mp4": "bytes", "joints.csv": "csv"}, _video, 1),
    "calibrated": Reader(seeds.calibrated, ANSWER, _answer, 3, True),
    "weighed": Reader(seeds.weighed, ANSWER, _answer, 1.5, True),
    "paired": Reader(seeds.paired, ANSWER, _answer, 1.5, True),
    "calibrate": Reader(
        lambda f: seeds.arm(f, False), {"run.toml": "toml", "data.csv": "csv"},
        _verb("calibrate", "run.toml"), 0.4,
    ),
    "payload": Reader(
        seeds.wrist, {"run.toml": "toml", "log.csv": "csv"}, _verb("payload", "run.toml"), 0.15
    ),
    "touch": Reader(
        lambda f: seeds.wrist(f, True), {"run.toml": "toml", "log.csv": "csv"},
        _verb("touch", "run.toml"), 0.15,
    ),
    "hand-eye": Reader(
        seeds.pairs, {"run.toml": "toml", "pairs.csv": "csv"}, _verb("hand-eye", "run.toml"), 0.2
    ),
    "find-body": Reader(
        seeds.seen, {"clip.mp4": "bytes", "joints.csv": "csv"},
        _verb("find-body", "clip.mp4", "--encoders", "joints.csv"), 0.1,
    ),
    "places": Reader(seeds.calibrated, {"data.csv": "csv"}, _places, 1),
}  # fmt: skip
