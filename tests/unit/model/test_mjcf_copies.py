"""An MJCF of one line that becomes a million bodies is refused before it is compiled."""

from __future__ import annotations

from pathlib import Path

import pytest

from bodyschema.errors import InputError
from bodyschema.model.mjcf_copies import refuse_copies
from bodyschema.model.tree import Body

ARM = (
    '<mujoco><worldbody><body name="b"><joint name="j"/><geom size="1"/></body>{}'
    "</worldbody></mujoco>"
)
MANY = '<replicate count="1000"><replicate count="1000"><geom size="1"/></replicate></replicate>'
GRID = '<flexcomp name="f" type="grid" count="300 300 300" spacing=".1 .1 .1"/>'


@pytest.mark.parametrize(("made", "word"), [(MANY, "1e\\+06 copies by <replicate>"),
                                            (GRID, "2.7e\\+07 copies by <flexcomp>")])  # fmt: skip
def test_a_million_copies(made: str, word: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(ARM.format(made))
    with pytest.raises(InputError, match=f"'arm.xml' makes {word}, and at most 10000 are read"):
        Body.from_file(tmp_path / "arm.xml")
    (tmp_path / "whole.xml").write_text(ARM.format('<include file="arm.xml"/>'))
    with pytest.raises(InputError, match=r"'arm\.xml' makes"):
        refuse_copies(tmp_path / "whole.xml")


def test_some_copies_are_read(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    few = '<replicate count="30" offset="1 0 0"><geom size="0.1"/></replicate>'
    (tmp_path / "arm.xml").write_text(ARM.format(few))
    assert Body.from_file(tmp_path / "arm.xml").joints == ("j",)


def test_files_that_include_one_another_end(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(
        '<mujoco><include file="b.xml"/><include file="b.xml"/></mujoco>'
    )
    (tmp_path / "b.xml").write_text(
        '<mujoco><include file="a.xml"/><include file="c.xml"/></mujoco>'
    )
    refuse_copies(tmp_path / "a.xml")
