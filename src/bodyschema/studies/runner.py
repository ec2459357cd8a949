"""Runs a study: its tasks over a pool of processes, each result kept as soon as it is there."""

from __future__ import annotations

import json
import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, is_dataclass
from importlib.metadata import version
from typing import Any

from bodyschema.studies.ledger import Ledger
from bodyschema.studies.study import Result, Study, Task, source_of
from bodyschema.threads import one_thread

Progress = Callable[[int, int], None]
"""Told how many tasks are finished, and of how many."""


@one_thread
def run_study(
    study: Study, workers: int, ledger: Ledger | None = None, progress: Progress | None = None
) -> dict[str, Result]:
    """Do all tasks of a study that are not finished yet.

    An interruption loses only the tasks under way: with a ledger, the next call goes on.

    Args:
        study: what to do.
        workers: processes; with 1 all is done in this one.
        ledger: where finished tasks are kept; None keeps them in memory alone.
        progress: told after every task.

    Returns:
        Results by key, in the order of the study's tasks.
    """
    tasks = study.tasks()
    found = {} if ledger is None else ledger.finished()
    waiting = [task for task in tasks if task.key not in found]
    if progress:
        progress(len(tasks) - len(waiting), len(tasks))
    alone = min(workers, len(waiting)) <= 1
    for key, result in _here(study, waiting) if alone else _pooled(study, waiting, workers):
        # As read from a file, so that an answer does not depend on where it was stopped.
        found[key] = json.loads(json.dumps(result, allow_nan=False))
        if ledger is not None:
            ledger.add(key, found[key])
        if progress:
            progress(sum(task.key in found for task in tasks), len(tasks))
    return {task.key: found[task.key] for task in tasks}


def settings_of(study: Study) -> dict[str, Any]:
    """What the results of a study depend on, in JSON types: name, settings, version.

    Of studies that share their runs, the name is that of the one whose runs they are.
    """
    if not is_dataclass(study):
        raise TypeError(f"{type(study).__name__} is no dataclass.")
    head = {"paper": study.paper, "figure": source_of(study), "version": version("bodyschema")}
    return dict(json.loads(json.dumps(head | asdict(study))))


def _here(study: Study, tasks: Sequence[Task]) -> Iterator[tuple[str, Result]]:
    return ((task.key, study.work(task)) for task in tasks)


def _pooled(study: Study, tasks: Sequence[Task], workers: int) -> Iterator[tuple[str, Result]]:
    # Spawned processes begin clean on every system: no locks or threads of this one come along.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(tasks)), context, initializer=_prepare)
    try:
        waiting = {pool.submit(study.work, task): task.key for task in tasks}
        for future in as_completed(waiting):
            yield waiting.pop(future), future.result()
    finally:
        # After an interruption: do not begin what has not begun.
        pool.shutdown(cancel_futures=True)


def _prepare() -> None:
    """Let Ctrl-C end a worker without a traceback; its task is done again another time.

    A worker's cores are shared with the other workers: one BLAS thread, for good.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    one_thread.__enter__()
