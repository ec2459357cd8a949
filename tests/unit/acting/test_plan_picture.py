"""The picture is drawn, for plans of any length and for senses without samples."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from bodyschema.acting.next_poses import plan_poses
from bodyschema.acting.plan_picture import draw_plan
from bodyschema.errors import MissingExtraError


@pytest.mark.parametrize(("n", "name"), [(1, "plan.png"), (6, "plan.svg")])
def test_picture(calibrated, tmp_path: Path, n: int, name: str) -> None:  # type: ignore[no-untyped-def]
    pytest.importorskip("matplotlib")
    world = calibrated()
    sense = world.sense.take(np.arange(0 if n == 1 else len(world.sense)))
    plan = plan_poses(world.estimate, [sense], n)
    path = draw_plan(plan, world.estimate.body, [sense], tmp_path / name)
    assert path.stat().st_size > 10_000
    if name.endswith(".svg"):
        assert path.read_text().lstrip().startswith("<?xml")


def test_without_matplotlib(calibrated, tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    plan = plan_poses(world.estimate, [world.sense], 1)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match="matplotlib"):
        draw_plan(plan, world.estimate.body, [world.sense], tmp_path / "plan.png")
