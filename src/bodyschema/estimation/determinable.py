"""What any number of samples could determine, counted: the objective part of a body schema.

J stacks the derivatives of all that is seen at many random postures, in units of the noise, each
column in units of its parameter's prior. With J = U S V^T,

    rank        number of singular values above CUT times the largest
    condition   largest over smallest of these
    open        the other rows of V^T: changes of the body that no posture shows

Along an open direction two bodies differ, yet everything seen is predicted alike: one subjective
body schema, many objective ones (Hersch et al. 2008, section 4.5.3 and Fig. 8). It is a property of
the tree and of what is looked at; it holds for nearly every geometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.identifiability import (
    OpenDirection,
    named_directions,
    random_postures,
)
from bodyschema.estimation.normal_equations import whiten
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

CUT = 1e-9
"""A singular value below this share of the largest is zero."""


@dataclass(frozen=True)
class Determinable:
    """What could be learned about a body from certain senses, and what could not."""

    singular_values: Array
    """(n_parameters,) falling, of the scaled Jacobian."""
    directions: tuple[OpenDirection, ...]
    """Changes of the body that no posture shows, one for each singular value that is zero."""

    @property
    def variables(self) -> int:
        """How many there are."""
        return len(self.singular_values)

    @property
    def rank(self) -> int:
        """How many combinations of them can be determined."""
        return self.variables - len(self.directions)

    @property
    def condition(self) -> float:
        """Best over worst determined combination, in units of the prior."""
        values = self.singular_values[: self.rank]
        return float(values[0] / values[-1]) if len(values) else 1.0


def determinable(
    body: Body,
    variables: Variables,
    senses: Sequence[Sense],
    postures: int = 300,
    seed: int = 0,
) -> Determinable:
    """Count and name what the senses can tell of the parameters.

    Args:
        body: round which it is asked; its joint limits bound the postures.
        variables: what may be wrong, with priors that make radians and metres comparable.
        senses: who looks at what; their samples, if any, are not used.
        postures: random ones at which everything is seen.
        seed: of the postures.
    """
    q = random_postures(body, postures, np.random.default_rng(seed))
    n = len(variables)
    x = np.zeros(n)
    parts = [whiten(sense.imagined(body, q), body, variables, x).jacobian for sense in senses]
    # Rows of zeros change nothing and let the decomposition return all n directions.
    J = np.concatenate([*(part.reshape(-1, n) for part in parts), np.zeros((n, n))])
    J *= variables.scale
    _, s, Vt = np.linalg.svd(J, full_matrices=False)
    null = Vt[s <= CUT * s.max(initial=0.0)]
    effect = np.linalg.norm(J, axis=0)
    return Determinable(s, tuple(named_directions(body, variables, null, effect)))
