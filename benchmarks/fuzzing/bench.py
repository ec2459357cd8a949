"""Mutants through readers in processes of their own: what became of each.

A worker is a fork of a process that has compiled everything, with a limit on its memory and on the
files that it may write. It tells which mutant it begins, so that whoever watches knows which one
killed it or did not come back. What it opens, moves or starts is seen by an audit hook.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import random
import resource
import shutil
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from bodyschema.errors import InputError, MissingExtraError
from fuzzing.mutations import MUTATIONS
from fuzzing.readers import READERS, Reader

LIMIT, PATIENCE = 10.0, 60.0
"""s of computing for one mutant, and s on the clock, for one that waits or a busy machine."""

MEMORY = 3 << 30
"""Bytes of addresses beyond those of the process that is forked."""

LARGEST_FILE = 256 << 20
"""Bytes of any file that is written."""

RUNS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "socket.connect", "pty.spawn")
CHANGES = ("os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.chmod",
           "os.truncate", "os.chown", "shutil.rmtree", "shutil.move")  # fmt: skip


@dataclass
class Tally:
    """What became of the mutants of one reader."""

    reader: str
    mutants: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    """"read", "refused", or the kind of a failure."""
    failures: dict[str, list[int]] = field(default_factory=dict)
    """What happened and where -> numbers of the mutants."""
    seconds: float = 0.0

    @property
    def failed(self) -> int:
        """How many mutants were neither read nor refused."""
        return sum(map(len, self.failures.values()))

    def take(self, number: int, kind: str, detail: str) -> None:
        """Count one mutant."""
        self.mutants += 1
        self.outcomes[kind] += 1
        if kind not in ("read", "refused"):
            self.failures.setdefault(detail, []).append(number)


def fuzz(name: str, count: int, seed: int, place: Path, first: int = 0) -> Tally:
    """Run the mutants `first` to `first + count` of one reader below a folder."""
    reader, tally, begin = READERS[name], Tally(name), time.perf_counter()
    home = place / name.replace(" ", "_")
    whole, outside = home / "whole", home / "outside"
    for folder in (whole, outside, home / "inside"):
        folder.mkdir(parents=True)
    (outside / "secret.txt").write_text("nobody reads this")
    reader.make(whole)
    before = _hash(outside), _hash(whole)
    at = first
    while at < first + count:
        for number, kind, detail in _work(name, at, first + count, seed, home):
            tally.take(number, kind, detail)
            at = number + 1
    if (_hash(outside), _hash(whole)) != before:
        tally.take(-1, "outside", "files outside of the folder were changed")
    tally.seconds = time.perf_counter() - begin
    shutil.rmtree(home)
    return tally


def _hash(folder: Path) -> str:
    whole = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        whole.update(str(path).encode() + (path.read_bytes() if path.is_file() else b""))
    return whole.hexdigest()


def _work(
    name: str, first: int, last: int, seed: int, home: Path
) -> Iterator[tuple[int, str, str]]:
    """Outcomes of mutants until all are done or one has taken its process with it."""
    context: Any = multiprocessing.get_context("fork")
    mine, its = context.Pipe(duplex=False)
    process = context.Process(target=_worker, args=(name, first, last, seed, home, its))
    process.start()
    its.close()
    number = first
    try:
        while True:
            if not _heard(mine, process.pid):
                process.kill()
                process.join()
                yield number, "hang", f"no end within {LIMIT:.0f} s"
                return
            try:
                number, kind, detail = mine.recv()
            except EOFError:
                process.join()
                if process.exitcode:
                    yield number, "crash", _ended(process.exitcode)
                return
            if kind != "begin":
                yield number, kind, detail
    finally:
        mine.close()
        process.join()


def _heard(pipe: Connection, pid: int) -> bool:
    """Whether a worker says something before its time is over."""
    begin = _computed(pid)
    for _ in range(int(PATIENCE / LIMIT)):
        if pipe.poll(LIMIT):
            return True
        if _computed(pid) - begin > LIMIT:
            return False
    return False


def _computed(pid: int) -> float:
    """s that a process has computed; 0 for one that has ended."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def _ended(code: int) -> str:
    return signal.Signals(-code).name if code < 0 else f"exit {code}"


def _worker(name: str, first: int, last: int, seed: int, home: Path, pipe: Connection) -> None:
    """Read mutants one after the other, and say of each how it went."""
    reader, inside = READERS[name], home / "inside"
    with (home / "said.txt").open("ab") as said:  # decoders speak to the terminal themselves
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
    touched = _watch(inside, home / "outside" if reader.confined else None)
    _restrain()
    os.environ["MPLCONFIGDIR"] = str(inside / "drawing")  # it makes a folder where it is imported
    warnings.simplefilter("ignore")
    for number in range(first, last):
        pipe.send((number, "begin", ""))
        folder = inside / "work"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(home / "whole", folder)
        os.chdir(folder)
        rng = random.Random(f"{seed}:{name}:{number}")
        path = mutate(reader, folder, rng)
        touched.clear()
        kind, detail = _outcome(reader, path, rng)
        if touched:
            kind, detail = "outside", touched[0]
        pipe.send((number, kind, detail))
    pipe.close()


def mutate(reader: Reader, folder: Path, rng: random.Random) -> Path:
    """Mutate one file of a folder; returns its path from there."""
    found = {pattern: sorted(folder.glob(pattern)) for pattern in sorted(reader.kinds)}
    pattern = rng.choice([pattern for pattern, paths in found.items() if paths])
    path, kind = rng.choice(found[pattern]), reader.kinds[pattern]
    path.write_bytes(MUTATIONS[kind](path.read_bytes(), rng))
    return path.relative_to(folder)


def _outcome(reader: Reader, path: Path, rng: random.Random) -> tuple[str, str]:
    try:
        reader.read(path, rng)
    except (InputError, MissingExtraError) as error:
        said = str(error)
        return ("refused", "") if said.strip() else ("mute", "a refusal without a word")
    except BaseException as error:
        return "traceback", _where(error)
    return "read", ""


def _where(error: BaseException) -> str:
    """Kind of an error, its words, and the last lines of ours that it came through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "bodyschema" in f.filename] or frames
    place = " < ".join(f"{Path(f.filename).name}:{f.lineno}" for f in reversed(ours[-2:]))
    return f"{type(error).__name__} at {place}"


def _restrain() -> None:
    with open("/proc/self/statm", encoding="ascii") as file:
        taken = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _watch(inside: Path, forbidden: Path | None) -> list[str]:
    """Collect what is run, or written or changed outside of a folder, from now on."""
    touched: list[str] = []
    home, closed = str(inside), str(forbidden) if forbidden else ""

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "subprocess.Popen" and "bodyschema.model.xacro_process" in str(arguments[1]):
            return  # the one process that a reader starts, which has limits of its own
        if event in RUNS:
            touched.append(f"{event} {str(arguments)[:80]}")
        elif event == "open":
            path, _, flags = arguments
            if isinstance(path, str | bytes | os.PathLike):
                place = os.path.abspath(os.fsdecode(path))
                writing = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
                if (writing and not allowed(place)) or (closed and place.startswith(closed)):
                    touched.append(f"open {Path(place).name} {'to write' if writing else ''}")
        elif event in CHANGES and isinstance(arguments[0], str | os.PathLike):
            place = os.path.abspath(os.fsdecode(arguments[0]))
            if not allowed(place):
                touched.append(f"{event} {place}")

    def allowed(place: str) -> bool:
        return place.startswith(home) or place == os.devnull or "__pycache__" in place

    sys.addaudithook(hook)
    return touched
