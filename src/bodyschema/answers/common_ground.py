"""Two beliefs of one robot on common ground: how far their bodies differ, in numbers of one chart.

Two fits start their frames from different places, and one may have been made with the URDF that
another corrected. So the numbers of two bodies are compared as they stand, not as deviations from
two references, first order in what differs:

    offset  d = a . log(R_A^T R_B) + o_B - o_A      R the placements' rotations, a the axis
    axis    d = Tangents_A^T (R_A^T R_B a_B)
    link    d = l_B - l_A                            less what slides along a sliding joint
    turn    d = log(R_A^T R_B)
    gear, numbers of parts: their difference
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kernels import AXIS, GEAR, LINK, OFFSET, PRISMATIC, TURN
from bodyschema.model.tree import Body
from bodyschema.model.variables import GROUPS, Variables, free_joints, join

Array = NDArray[np.float64]

FRAME = "frame:"
"""Of the group of a frame that was freed: its prior lies wherever the fit began."""


@dataclass(frozen=True)
class CommonGround:
    """What two beliefs say of the same numbers."""

    variables: Variables
    """As the first has them."""
    difference: Array
    """(n,) second less first."""
    covariance: Array
    """(n, n) of the difference, if nothing has changed. Where priors say more than the data it is
    too wide: both beliefs were drawn to the same prior."""
    response: Array
    """(n, n) how the second belief answers to a change of the robot: columns of I - P Lambda."""
    first_only: tuple[str, ...]
    """Joints of which the first has numbers free that the second holds as described."""
    second_only: tuple[str, ...]

    @classmethod
    def of(cls, first: Estimate, second: Estimate) -> CommonGround:
        """Both beliefs, each as wide as it is to be believed."""
        variables = _spoken(first, second)
        both = _Block.of(first, variables), _Block.of(second, variables)
        C = [block.covariance(other) for block, other in zip(both, both[::-1], strict=True)]
        return cls(
            variables,
            _differences(first.body, second.body, variables),
            C[0] + C[1],
            both[1].response(variables),
            _parts_of(variables, both[1].held),
            _parts_of(variables, both[0].held),
        )

    @property
    def parts(self) -> Mapping[str, list[int]]:
        """Rows of each joint, frame and part."""
        found: dict[str, list[int]] = {}
        for i, name in enumerate(self.variables.names):
            found.setdefault(name.rpartition(".")[0], []).append(i)
        return found


@dataclass(frozen=True)
class _Block:
    """One belief, spread over the variables of both."""

    own: Array
    """(n, n) its covariance; zero where it holds a number as described."""
    held: NDArray[np.bool_]
    """(n,)"""
    prior: Array
    """(n,) information; 0 of what it holds."""

    @classmethod
    def of(cls, belief: Estimate, variables: Variables) -> _Block:
        names = belief.variables.names
        free = np.array([name in names for name in variables.names], dtype=bool)
        rows = [names.index(name) for name in variables.names if name in names]
        own, prior = np.zeros((len(variables), len(variables))), np.zeros(len(variables))
        own[np.ix_(free, free)] = belief.covariance[np.ix_(rows, rows)]
        prior[free] = belief.variables.prior_std[rows] ** -2.0
        return cls(own, ~free, prior)

    def covariance(self, other: _Block) -> Array:
        """(n, n); what it holds as described may be as wrong as the other has found it uncertain.

        It was held because freeing it did not help, which is no proof that it is right.
        """
        between = np.outer(self.held, self.held)
        return np.asarray(self.own + np.where(between, other.own, 0.0))

    def response(self, variables: Variables) -> Array:
        """(n, n), see `CommonGround`; what is held is what somebody wrote into the description."""
        frame = np.array([group.startswith(FRAME) for group in variables.groups])
        return np.asarray(np.eye(len(variables)) - self.own * np.where(frame, 0.0, self.prior))


def _spoken(first: Estimate, second: Estimate) -> Variables:
    """What both have free, and the joints' numbers that either has."""
    own, other = first.variables, second.variables
    rows = [
        i for i, (name, group) in enumerate(zip(own.names, own.groups, strict=True))
        if name in other.names or group in GROUPS
    ]  # fmt: skip
    added = [
        name for name, group in zip(other.names, other.groups, strict=True)
        if name not in own.names and group in GROUPS
    ]  # fmt: skip
    joints = free_joints(first.reference)
    return join(own.take(rows), joints.take([joints.names.index(name) for name in added]))


def _parts_of(variables: Variables, chosen: NDArray[np.bool_]) -> tuple[str, ...]:
    names = (name for name, one in zip(variables.names, chosen, strict=True) if one)
    return tuple(dict.fromkeys(name.rpartition(".")[0] for name in names))


def _differences(first: Body, second: Body, variables: Variables) -> Array:
    """The numbers of the module's text, (n,)."""
    found = np.zeros(len(variables))
    for i, code in enumerate(variables.code):
        index, component = int(variables.index[i]), int(variables.component[i])
        if code == OFFSET:
            found[i] = _offset(first, second, index)
        elif code == GEAR:
            there = second.joint_index(first.joints[index])
            found[i] = second.gear[there] - first.gear[index]
        elif code in (AXIS, LINK, TURN):
            found[i] = _of_frame(first, second, index, int(code), component)
        else:
            name = variables.groups[i].partition(":")[2]
            found[i] = second.part(name).values[component] - first.part(name).values[component]
    return found


def _offset(first: Body, second: Body, joint: int) -> float:
    """How far a joint's zero differs, what the placement of its frame holds of it included."""
    there = second.joint_index(first.joints[joint])
    apart = float(second.offset[there] - first.offset[joint])
    k = next(k for k in range(len(first.frames)) if first.driver[k] == joint)
    turn, slide = _placed(first, second, k)
    moved = slide if first.kind[k] == PRISMATIC else turn
    return apart + float(first.axis[k] @ moved) / float(first.rate[k])


def _of_frame(first: Body, second: Body, k: int, code: int, component: int) -> float:
    there = second.frame_index(first.frames[k])
    turn, slide = _placed(first, second, k)
    if code == TURN:
        return float(turn[component])
    if code == AXIS:
        own = first.axis[k]
        turned = lie.exp_so3(turn - own * (own @ turn)) @ second.axis[there]
        return float(first.tangents[k][:, component] @ turned)
    moved = slide - first.axis[k] * (first.axis[k] @ slide) * (first.kind[k] == PRISMATIC)
    return float((first.placement[k, :3, :3] @ moved)[component])


def _placed(first: Body, second: Body, k: int) -> tuple[Array, Array]:
    """How a frame's placement differs, in the first one's axes: turn (3,) rad and slide (3,) m."""
    A, B = first.placement[k], second.placement[second.frame_index(first.frames[k])]
    turn = lie.log_so3(A[:3, :3].T @ B[:3, :3])
    return turn, np.asarray(A[:3, :3].T @ (B[:3, 3] - A[:3, 3]))
