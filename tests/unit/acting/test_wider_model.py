"""A wider belief holds what the recording tells of parameters that were not fitted."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.acting.wider_model import widen
from bodyschema.errors import InputError


def test_wider_belief_agrees_with_the_fit_where_both_know(calibrated) -> None:  # type: ignore[no-untyped-def]
    """The same groups once more: the information is that of the fit, robust weights aside."""
    world = calibrated(n=60)
    again = widen(world.estimate, [world.sense], ("offsets",))
    assert again.variables.names == tuple(
        sorted(world.estimate.variables.names, key=again.variables.names.index)
    )
    np.testing.assert_allclose(again.x, 0.0)
    ratio = np.diag(again.data_information) / np.diag(world.estimate.data_information)
    assert ratio == pytest.approx(1.0, abs=0.25)


def test_wider_belief_has_the_new_parameters_and_the_corrected_body(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    wide = widen(world.estimate, [world.sense], ("offsets", "axes", "links"))
    assert wide.variables.names[:2] == ("joint_1.offset", "joint_1.axis_1")
    assert set(world.estimate.variables.names) < set(wide.variables.names)
    np.testing.assert_allclose(wide.body.placement, world.estimate.body.placement)
    assert len(wide.variables) == 5 * 6 + 6 + 3


def test_unknown_group(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    with pytest.raises(InputError, match="did you mean 'axes'"):
        widen(world.estimate, [world.sense], ("axis",))
