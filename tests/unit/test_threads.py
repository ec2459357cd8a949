"""One BLAS thread within, the user's number without, also where callers overlap."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

import bodyschema as bs
from bodyschema.estimation import solver
from bodyschema.threads import CHOICES, OneThread


def threads() -> set[int]:
    """Of the BLAS libraries of this process."""
    pools = ThreadpoolController().select(user_api="blas").info()
    return {pool["num_threads"] for pool in pools}


@pytest.fixture(autouse=True)
def many(monkeypatch: pytest.MonkeyPatch) -> object:
    """Two threads, which nobody has chosen."""
    for variable in CHOICES:
        monkeypatch.delenv(variable, raising=False)
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        if threads() != {2}:
            pytest.skip("BLAS has one thread here")
        yield


def test_within_and_without() -> None:
    one = OneThread()
    assert threads() == {2}
    with one, one:
        assert threads() == {1}
    assert threads() == {2}
    assert one(threads)() == {1}
    assert threads() == {2}


def test_given_back_after_a_failure() -> None:
    with pytest.raises(ValueError, match="no"), OneThread():
        raise ValueError("no")
    assert threads() == {2}


@pytest.mark.parametrize("variable", CHOICES)
def test_what_the_user_chose_is_kept(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, "2")
    with OneThread():
        assert threads() == {2}


def test_callers_in_several_threads_leave_the_number_as_it_was() -> None:
    one = OneThread()
    entered, leave = threading.Event(), threading.Event()

    def other() -> None:
        with one:
            entered.set()
            leave.wait(10)

    with one:
        caller = threading.Thread(target=other)
        caller.start()
        entered.wait(10)
    leave.set()
    caller.join()
    assert threads() == {2}


def test_what_solves_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[set[int]] = []

    def look(*_: object, **__: object) -> None:
        seen.append(threads())
        raise ZeroDivisionError

    monkeypatch.setattr(solver, "begin", look)
    body = bs.Body.random_chain(2, np.random.default_rng(0)).attach("eye", "base")
    points = bs.Points.make(np.zeros((3, 2)), np.ones((3, 3)), seen_from="eye", seen="tip")
    with pytest.raises(ZeroDivisionError):
        bs.Solver().fit(body, bs.free_joints(body, ["offsets"]), [points])
    assert seen == [{1}]
    assert threads() == {2}


@pytest.mark.parametrize(
    "entry",
    [
        bs.calibrate,
        bs.learn_hand_eye,
        bs.learn_payload,
        bs.learn_skeleton,
        bs.find_touches,
        bs.plan_poses,
        bs.check_stream,
        bs.detect_change,
        bs.solve_hand_eye,
        bs.fit_payload,
        bs.Solver.fit,
        bs.Problem.fit,
    ],
    ids=lambda entry: entry.__qualname__,
)
def test_every_way_in_is_limited(
    entry: Callable[..., object], monkeypatch: pytest.MonkeyPatch
) -> None:
    entered: list[bool] = []
    monkeypatch.setattr(OneThread, "__enter__", lambda _: entered.append(True))
    monkeypatch.setattr(OneThread, "__exit__", lambda *_: None)
    with pytest.raises(TypeError):
        entry()  # nothing given: the limit stands before the arguments
    assert entered == [True]
