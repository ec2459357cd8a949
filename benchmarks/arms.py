"""Simulated arms with wrong joint zeros, an unknown tracker and an unknown marker, for studies."""

from __future__ import annotations

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem, moved_joints
from bodyschema.model.kinematics import relative_pose

NOISE = (1e-3, 5e-3)
"""m and rad: of the poses seen."""

ZEROS = 0.05
"""rad: standard deviation of the wrong joint zeros."""

WRONG_MATCH = 0.1
"""m: an outlier moves each coordinate by up to this."""

WIDEST = 2.5
"""rad: joints with wider limits are used within this."""


def robots() -> Path:
    """Folder of the robots that the package example-robot-data ships."""
    for file in importlib.metadata.files("example-robot-data") or []:
        if file.name == "panda.urdf":
            return Path(str(file.locate())).resolve().parents[2]
    raise SystemExit("install example-robot-data for this benchmark")


@dataclass(frozen=True)
class Arm:
    """One robot, its base and the link that carries the marker."""

    name: str
    file: str
    base: str
    hand: str

    @property
    def body(self) -> bs.Body:
        """As modelled, tracker and marker at their parents' origins."""
        body = bs.Body.from_urdf(robots() / self.file)
        return body.attach("tracker", self.base).attach("marker", self.hand)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints between base and hand."""
        body = self.body
        blank = bs.Points.make(
            np.zeros((1, len(body.joints))), np.zeros((1, 3)), "tracker", "marker"
        )
        return moved_joints(body, [blank])

    def truth(self, rng: np.random.Generator) -> bs.Body:
        """A real robot: frames anywhere, every joint's zero wrong."""
        body = self.body
        for frame, reach in (("tracker", 1.0), ("marker", 0.1)):
            T = lie.transform(lie.exp_so3(0.7 * rng.normal(size=3)), reach * rng.normal(size=3))
            body = body.with_placement(frame, T)
        offsets = bs.free_joints(body, ("offsets",), self.joints)
        return body.with_variables(offsets, ZEROS * rng.normal(size=len(offsets)))

    def postures(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Random postures within the limits, (count, n_joints)."""
        body = self.body
        low, high = np.maximum(body.lower, -WIDEST), np.minimum(body.upper, WIDEST)
        return rng.uniform(low, high, size=(count, len(body.joints)))

    def record(
        self, truth: bs.Body, count: int, outliers: float, rng: np.random.Generator
    ) -> bs.Poses:
        """What the tracker sees of the marker, with noise and wrong matches."""
        q = self.postures(count, rng)
        T = relative_pose(truth, q, "tracker", "marker").copy()
        T[:, :3, 3] += NOISE[0] * rng.normal(size=(count, 3))
        T[:, :3, :3] = lie.exp_so3(NOISE[1] * rng.normal(size=(count, 3))) @ T[:, :3, :3]
        wrong = rng.random(count) < outliers
        T[wrong, :3, 3] += rng.uniform(-WRONG_MATCH, WRONG_MATCH, size=(int(wrong.sum()), 3))
        return bs.Poses.make(q, T, "tracker", "marker")

    def fit(self, seen: bs.Poses) -> Estimate:
        """Joint offsets from nothing but the nominal robot and what was seen."""
        problem = Problem(self.body, (seen,), {"tracker": "no", "marker": "no"}, self.joints)
        return problem.fit(problem.variables(("offsets",)), [seen])

    def error(self, body: bs.Body, truth: bs.Body, q: np.ndarray) -> np.ndarray:
        """Error of the marker's position in the tracker's frame, (n,) m."""
        there = relative_pose(body, q, "tracker", "marker")[:, :3, 3]
        return np.linalg.norm(
            there - relative_pose(truth, q, "tracker", "marker")[:, :3, 3], axis=1
        )


ARMS = (
    Arm("icub", "icub_description/robots/icub.urdf", "chest", "r_hand"),
    Arm("ur5", "ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    Arm("panda", "panda_description/urdf/panda.urdf", "panda_link0", "panda_link8"),
)
