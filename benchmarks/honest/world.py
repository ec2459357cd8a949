"""World: the robot as it really is, with joints that are not where their encoders say.

For readings q at share w of the recording (0 its beginning, 1 its end):

    theta = q + sum of effects(q, dq, w)
    T_a_b = (T_base_a moved(w))^-1  prod_k P_k R(axis_k, theta_k) bend_k  T_tip_b moved(w)

It walks its chain itself: what makes the truth shares no kinematics with what is judged by it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

DOWN = np.array([0.0, 0.0, -1.0])
"""Of gravity, in the base."""


@dataclass(frozen=True)
class Motion:
    """What the encoders read, and when."""

    q: Array
    """(n, n_joints) rad."""
    dq: Array
    """(n, n_joints) rad/s; nought where the robot stands still for every sample."""
    when: Array
    """(n,) share of the recording, 0 to 1."""
    time: Array
    """(n,) s."""

    def __len__(self) -> int:
        return len(self.q)

    def at(self, when: float) -> Motion:
        """The same readings, all at one share of the recording."""
        return Motion(self.q, self.dq, np.full(len(self), when), self.time)


Effect = Callable[[Motion], Array]
"""Further turn of every joint, (n, n_joints) rad."""

Move = Callable[[Motion], Array]
"""How a fixed frame has moved in itself, (n, 4, 4)."""


@dataclass(frozen=True)
class World:
    """A true arm with "tracker" on its base and "tool" on its tip."""

    body: Body
    effects: tuple[Effect, ...] = ()
    tracker: tuple[Move, ...] = ()
    tool: tuple[Move, ...] = ()
    bending: float = 0.0
    """rad/m^2 for one link beyond: slope at the end of a link, over its squared length."""
    growth: float = 0.0
    """Share by which links are longer at the end of the recording."""
    order: tuple[str, str] = field(default=("tracker", "tool"))

    def poses(self, motion: Motion) -> Array:
        """T_tracker_tool, (n, 4, 4)."""
        eye, tool = (self.body.placement[self.body.frame_index(name)] for name in self.order)
        near, far = np.tile(eye, (len(motion), 1, 1)), self.chain(motion)[-1] @ tool
        for move in self.tracker:
            near = near @ move(motion)
        for move in self.tool:
            far = far @ move(motion)
        return np.asarray(lie.inverse(near) @ far)

    def chain(self, motion: Motion) -> list[Array]:
        """Poses of the links and the tip in the base, (n, 4, 4) each."""
        body, n = self.body, len(self.body.joints)
        theta = (1 + body.gear) * motion.q + body.offset
        for effect in self.effects:
            theta = theta + effect(motion)
        T, poses = np.tile(np.eye(4), (len(motion), 1, 1)), []
        for k in range(1, n + 2):
            T = T @ self._link(T, k, motion)
            if k <= n:
                turn = np.tile(np.eye(4), (len(motion), 1, 1))
                turn[:, :3, :3] = lie.exp_so3(theta[:, k - 1, None] * body.axis[k])
                T = T @ turn
            poses.append(T)
        return poses

    def _link(self, T: Array, k: int, motion: Motion) -> Array:
        """The link before frame k, grown with the heat and bent by what it carries."""
        step = np.tile(self.body.placement[k], (len(motion), 1, 1))
        step[:, :3, 3] *= 1 + self.growth * motion.when[:, None]
        if self.bending and k > 1:
            beyond = len(self.body.joints) + 2 - k
            L, down = step[:, :3, 3], np.einsum("nij,i->nj", T[:, :3, :3], DOWN)
            length = np.linalg.norm(L, axis=1, keepdims=True)
            # A cantilever that carries its load at the end: slope F l^2 / 2EI, 2/3 l of it deep.
            slope = self.bending * beyond * length * np.cross(L, down)
            step[:, :3, :3] = lie.exp_so3(slope) @ step[:, :3, :3]
            step[:, :3, 3] += 2 / 3 * np.cross(slope, L)
        return step

    def torques(self, motion: Motion) -> Array:
        """Of one kilogram at the end of every link about every joint, (n, n_joints), over g."""
        poses, n = self.chain(motion), len(self.body.joints)
        at = np.stack([T[:, :3, 3] for T in poses], axis=1)
        about = np.stack([poses[j][:, :3, :3] @ self.body.axis[j + 1] for j in range(n)], axis=1)
        arm = np.stack([(at[:, j + 1 :] - at[:, j, None]).sum(axis=1) for j in range(n)], axis=1)
        return np.einsum("njc,njc->nj", np.cross(arm, DOWN), about)
