"""Does an earlier result survive a kill at any instant, and is nothing else ever touched?

    python benchmarks/kills.py [--random N] [--targeted N | --every] [--scene WORD] [--seed N]

A process writes a result over an earlier one, between other people's files, and is killed: at a
random time, or just before or after one of its calls to the system (--every: each of them).
Afterwards the old result or the new one must be there, whole; `bodyschema.load` must find it; the
next run must end as if nothing had been, and leave no temporary name; and everything round it must
be what it was. What is written:

calibrate   an answer over another, `save(overwrite=True)`
two steps   the same as on systems where two names cannot change places in one step
simulate    a simulation over another
export      a corrected robot description over another
study       a study that goes on; no task that was acknowledged may be lost
anew        a study that is begun anew over another
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import signal
import stat
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from io import FileIO, IOBase
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from bodyschema.atomic.swap import swapped
from killed_writers import NEW, OLD, PART, SCENES, Scene

SYSTEM = {
    *("open", "close", "fsync", "mkdir", "rename", "replace", "link", "unlink", "remove"),
    *("rmdir", "chmod", "truncate", "ftruncate", "flock", "flush", "__exit__"),
}
"""Functions of the system, and of open files, that change something on the disk."""

FAILED = 3
"""Exit code of a writer that did not end well."""

NAME = "result"

WHOLE = (OLD, PART, NEW)


class Kill(NamedTuple):
    """One kill and what came of it."""

    scene: str
    at: str
    """Step, or time."""
    found: str
    """"old", "new", "part" of a study, or what is wrong."""
    wrong: str = ""
    """What else is wrong: the next run, names left over, things touched."""

    @property
    def held(self) -> bool:
        """Whether all was as it must be."""
        return self.found in WHOLE and not self.wrong


def forked(work: Callable[[], object]) -> int:
    """Begin a process that does some work, quietly; returns its number."""
    with warnings.catch_warnings():
        # The child takes no lock that a thread of this process may hold.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child:
        return child
    code = FAILED
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        work()
        code = 0
    except BaseException as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
    finally:
        os._exit(code)


def stepped(work: Callable[[], object], act: Callable[[int], object]) -> None:
    """Do some work; before and after each call to the system `act` is told how many there were."""
    count = 0

    def profile(frame: Any, event: str, what: Any) -> None:
        nonlocal count
        on = getattr(what, "__self__", None)
        known = isinstance(on, ModuleType | IOBase) and what.__name__ in SYSTEM
        call = event.startswith("c_") and (known or isinstance(on, FileIO))
        if call or frame.f_code is swapped.__code__:
            count += 1
            act(count)

    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(None)


def kill_at(step: int, count: int) -> None:
    """End this process at a step."""
    if count == step:
        os.kill(os.getpid(), signal.SIGKILL)


def undisturbed(scene: Scene, steps: mmap.mmap | None = None) -> float:
    """How long a writer takes, s; counts its steps in shared memory where that is given."""

    def tell(count: int) -> None:
        if steps is not None:
            steps[:8] = count.to_bytes(8, "big")

    with tempfile.TemporaryDirectory() as name:
        place = begun(scene, Path(name) / "whole")
        begin = time.monotonic()
        child = forked(writer(scene, place, tell if steps else None))
        if os.waitpid(child, 0)[1]:
            raise RuntimeError(f"'{scene.name}' does not end when it is let alone.")
        return time.monotonic() - begin


def steps_of(scene: Scene) -> int:
    """How many steps a writer takes."""
    with mmap.mmap(-1, 8) as shared:
        undisturbed(scene, shared)
        return int.from_bytes(shared[:8], "big")


def writer(scene: Scene, place: Path, act: Callable[[int], object] | None) -> Callable[[], object]:
    """What a child does: write the new result, with `act` told each step."""
    write = partial(scene.write, place, NEW)
    return write if act is None else partial(stepped, write, act)


def begun(scene: Scene, folder: Path) -> Path:
    """Make a folder with an earlier result and other people's things; where the result is."""
    folder.mkdir()
    place = folder / NAME
    scene.write(place, OLD)
    for name in (
        "notes.txt",
        f"{NAME}.txt",
        f".{NAME}",
        f".{NAME}.swp",
        f".{NAME}.bodyschema-1.new",
    ):
        (folder / name).write_text(f"{name}, mine")
    for name in ("src", ".git", f".{NAME}.bak", f"{NAME}.old"):
        (folder / name).mkdir()
        (folder / name / "deep.txt").write_text("mine")
    (folder / "link").symlink_to("src")
    os.mkfifo(folder / "pipe")
    if os.geteuid() == 0:
        # A device like /dev/null, in this folder and nowhere else.
        os.mknod(folder / "device", stat.S_IFCHR | 0o600, os.makedev(1, 3))
    return place


def others(place: Path) -> dict[str, tuple[Any, ...]]:
    """What is in the folder besides the result: kind, number, owner and content of each thing."""
    return {
        str(path.relative_to(place.parent)): (
            (seen := path.lstat()).st_mode, seen.st_ino, seen.st_rdev,
            path.read_bytes() if stat.S_ISREG(seen.st_mode) else b"",
        )
        for path in place.parent.rglob("*")
        if path != place and place not in path.parents
    }  # fmt: skip


def killed(scene: Scene, step: int | None, after: float, folder: Path) -> Kill:
    """Kill a writer at a step, or after a time in s, and look."""
    place = begun(scene, folder)
    before = others(place)

    child = forked(writer(scene, place, partial(kill_at, step) if step else None))
    if step is None:
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    at = f"step {step}" if step else f"{1e3 * after:.1f} ms"
    wrong = [] if code in (0, -signal.SIGKILL) else [f"the writer ended with {code}"]
    try:
        found = scene.read(place)
        after_kill = others(place)
        wrong += [f"'{n}' was touched" for n in before if after_kill.get(n) != before[n]]
        scene.write(place, NEW)
        if scene.read(place) != NEW:
            wrong.append(f"the next run leaves: {scene.read(place)}")
        wrong += [f"'{n}' is left over" for n in others(place).keys() - before.keys()]
        wrong += [f"'{n}' was touched" for n in before if others(place).get(n) != before[n]]
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    return Kill(scene.name, at, found, "; ".join(wrong))


def kills(random: int, targeted: int, every: bool, seed: int, only: str = "") -> Iterator[Kill]:
    """Kill writers of all scenes in turn.

    Args:
        random: kills at random times.
        targeted: kills at random steps.
        every: at every step instead.
        seed: of times and steps.
        only: scenes whose name has this word.
    """
    scenes = [scene for scene in SCENES if only in scene.name]
    rng = np.random.default_rng(seed)
    seconds = {scene: undisturbed(scene) for scene in scenes}
    steps = {scene: steps_of(scene) for scene in scenes}
    asked: list[tuple[Scene, int | None, float]] = []
    for n in range(random):
        scene = scenes[n % len(scenes)]
        asked.append((scene, None, rng.uniform(0, 1.05 * seconds[scene])))
    if every:
        asked += [(scene, k + 1, 0.0) for scene in scenes for k in range(steps[scene])]
    else:
        chosen = [scenes[n % len(scenes)] for n in range(targeted)]
        asked += [(scene, int(rng.integers(steps[scene])) + 1, 0.0) for scene in chosen]
    for n, (scene, step, after) in enumerate(asked):
        with tempfile.TemporaryDirectory() as name:
            yield killed(scene, step, after, Path(name) / str(n))


def main() -> None:
    """Print what became of the results; exit 1 if any was lost or anything was touched."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--random", type=int, default=300, help="kills at random times")
    parser.add_argument("--targeted", type=int, default=20, help="kills at random steps")
    parser.add_argument("--every", action="store_true", help="kills at every step instead")
    parser.add_argument("--scene", default="", help="only those whose name has this word")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    begin = os.times()
    found = []
    asked = (options.random, options.targeted, options.every, options.seed, options.scene)
    for kill in kills(*asked):
        found.append(kill)
        if not kill.held:
            print(
                f"{kill.scene}, {kill.at}: {kill.found}; {kill.wrong}", file=sys.stderr, flush=True
            )
    end = os.times()
    failed = [kill for kill in found if not kill.held]
    counts = Counter((one.scene, one.found if one.found in WHOLE else "broken") for one in found)
    answer = {
        "kills": len(found),
        "failed": len(failed),
        "found": {
            scene.name: {what: counts[scene.name, what] for what in (*WHOLE, "broken")}
            for scene in SCENES
        },
        "cpu_s": round(sum(end[:4]) - sum(begin[:4]), 1),
    }
    print(json.dumps(answer) if options.json else json.dumps(answer, indent=2))
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
