"""An earlier result survives a kill at any instant and a full disk; nothing round it is touched.

Here a few kills of `benchmarks/kills.py`, which does hundreds.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bodyschema.answers.answer import load
from bodyschema.atomic.leftovers import aside
from bodyschema.errors import InputError

if os.name != "posix":
    pytest.skip("sends POSIX signals", allow_module_level=True)

from killed_writers import NEW, OLD, PART, SCENES, Scene, save
from kills import begun, forked, kills, others


def test_killed_writers_leave_the_old_or_the_new_result() -> None:
    found = list(kills(random=6, targeted=14, every=False, seed=int(os.environ.get("SEED", "1"))))
    assert len(found) == 20
    assert [kill for kill in found if not kill.held] == []


def test_load_finds_what_a_killed_writer_took_away(tmp_path: Path) -> None:
    place = tmp_path / "result"
    save(place, OLD)
    place.rename(aside(place, ".old"))
    assert load(place).explanation == OLD
    assert [path.name for path in tmp_path.iterdir()] == ["result"]


@pytest.mark.parametrize("scene", SCENES, ids=[scene.name for scene in SCENES])
def test_a_full_disk_leaves_the_old_result(scene: Scene, tmp_path: Path) -> None:
    import resource

    place = begun(scene, tmp_path / "full")
    before = others(place)

    def limited() -> None:
        _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, most))
        with pytest.raises(
            InputError, match=r"^cannot write to '.*' \(File too large\);.*Make room"
        ):
            scene.write(place, NEW)

    assert os.waitpid(forked(limited), 0)[1] == 0
    assert scene.read(place) == (PART if scene.name == "study" else OLD)
    assert others(place) == before
    scene.write(place, NEW)
    assert scene.read(place) == NEW
