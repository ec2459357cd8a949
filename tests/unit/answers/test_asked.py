"""What `calibrate` refuses of what it is asked, in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.errors import InputError
from bodyschema.model.tree import Body

RNG = np.random.default_rng(0)
ARM = Body.random_chain(3, RNG).attach("board", "base").attach("mark", "tip")
Q, SEEN = RNG.uniform(-1, 1, (20, 3)), RNG.normal(size=(20, 3))


@pytest.mark.parametrize("known", ["No", "rough", "exactly", None])
def test_a_word_that_says_nothing_of_a_frame(known: Any) -> None:
    with pytest.raises(InputError, match="frame 'board' cannot be known") as refused:
        bs.calibrate(ARM, [bs.Points.make(Q, SEEN, "board", "mark")], {"board": known})
    assert "no" in str(refused.value)
    if known == "No":
        assert "did you mean 'no'?" in str(refused.value)


@pytest.mark.parametrize("q", [Q[:, :2], np.hstack([Q, Q])])
def test_readings_of_another_number_of_joints(q: Any) -> None:
    said = r"mark seen from board: joint readings have the shape \(20, \d\), and .* has 3 joints"
    with pytest.raises(InputError, match=said):
        bs.calibrate(ARM, [bs.Points.make(q, SEEN, "board", "mark")], {"board": "no"})
