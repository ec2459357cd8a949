"""Ten bodies and motions of which something cannot be told, and what must be said of each.

A case is named when every expected set of parameters stands together in one sentence. Of 100
well-excited arms with all frames known, nothing may be said to be open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import bodyschema as bs
from bodyschema.estimation.identifiability import Identifiability, identifiability
from bodyschema.estimation.solver import Solver
from bodyschema.model.kinematics import relative_pose

Chain = tuple[str, str]
"""Kind of the joint (r or p) and its axis (x, y or z), base to tip."""

ARM: tuple[Chain, ...] = (("r", "z"), ("r", "y"), ("r", "z"), ("r", "y"), ("r", "z"), ("r", "y"))
LIFT: tuple[Chain, ...] = (("p", "z"), *ARM[:5])
AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}


@dataclass(frozen=True)
class Case:
    """What is free, what moves, and what must be named together."""

    name: str
    expected: tuple[frozenset[str], ...]
    chain: tuple[Chain, ...] = ARM
    groups: tuple[str, ...] = ("offsets",)
    free_frames: tuple[str, ...] = ()
    locked: tuple[int, ...] = ()
    point: tuple[float, float, float] = (0.05, 0.03, 0.1)
    """m: of the marker in the last link."""
    sense: str = "points"
    joints: tuple[str, ...] | None = None
    at: float = 0.4
    """rad: where locked joints stand."""


def together(*names: str) -> frozenset[str]:
    """Variables that one sentence must name."""
    return frozenset(names)


CASES = (
    Case("locked joint: zero or scale",
         (together("joint_3.offset", "joint_3.gear"),),
         groups=("offsets", "gears"), locked=(2,)),
    Case("base yaw with joint 1",
         (together("joint_1.offset", "tracker.turn_z"),), free_frames=("tracker",)),
    Case("tool point on the last axis",
         (together("joint_6.offset"),), point=(0.0, 0.08, 0.0)),
    Case("turned flange, seen as a pose",
         (together("joint_6.offset", "marker.turn_y"),), free_frames=("marker",), sense="poses"),
    Case("unknown tool point with the last joint",
         (together("joint_6.offset", "marker.link_x", "marker.link_z"),), free_frames=("marker",)),
    Case("planar arm of which only the base turns",
         (together("joint_2.offset", "joint_4.offset", "joint_6.offset"),),
         locked=(1, 2, 3, 4, 5), joints=("joint_2", "joint_4", "joint_6"), at=0.0),
    Case("zero of a lift with the tracker's height",
         (together("joint_1.offset", "tracker.link_z"),), chain=LIFT, free_frames=("tracker",)),
    Case("zero of a lift with its own placement",
         (together("joint_1.offset", "joint_1.link_z"),), chain=LIFT, groups=("offsets", "links"),
         joints=("joint_1",)),
    Case("length along parallel axes",
         (together("joint_1.link_z", "joint_2.link_z"),),
         chain=(("r", "z"), ("r", "z"), *ARM[1:5]), groups=("links",),
         joints=("joint_1", "joint_2")),
    Case("placement of joint 1 with the tracker",
         (together("joint_1.link_x", "tracker.link_x"),
          together("joint_1.link_y", "tracker.link_y"),
          together("joint_1.link_z", "tracker.link_z")),
         groups=("links",), free_frames=("tracker",), joints=("joint_1",)),
)  # fmt: skip


def build(chain: Sequence[Chain], point: Sequence[float]) -> bs.Body:
    """An arm with links of 0.2 m along z, and a tracker at its base."""
    n = len(chain)
    step = np.tile(np.eye(4), (n + 1, 1, 1))
    step[1:, 2, 3] = 0.2
    step[1, 2, 3] = 0.1
    body = bs.Body.build(
        name="case",
        frames=["base", *(f"link_{i + 1}" for i in range(n))],
        carriers=["", *(f"joint_{i + 1}" for i in range(n))],
        parent=range(-1, n),
        kind=[0, *(1 if kind == "r" else 2 for kind, _ in chain)],
        axis=[AXES["z"], *(AXES[axis] for _, axis in chain)],
        placement=step,
    )
    body = replace(body, lower=np.full(n, -2.0), upper=np.full(n, 2.0))
    T = np.eye(4)
    T[:3, 3] = point
    return body.attach("tracker", "base").attach("marker", f"link_{n}", T)


def judge(case: Case, seed: int = 0) -> Identifiability:
    """Record the case with noise, fit it, and ask what is open."""
    rng = np.random.default_rng(seed)
    body = build(case.chain, case.point)
    q = rng.uniform(-1.5, 1.5, size=(80, len(case.chain)))
    q[:, list(case.locked)] = case.at
    T = relative_pose(body, q, "tracker", "marker")
    T[:, :3, 3] += 1e-3 * rng.normal(size=(80, 3))
    make: Callable[..., bs.Points | bs.Poses] = bs.Poses.make
    seen = make(q, T, "tracker", "marker")
    if case.sense == "points":
        seen = bs.Points.make(q, T[:, :3, 3], "tracker", "marker")
    frames = [
        bs.free_frame(body, f, turn_std=1.0 if f == "tracker" or case.sense == "poses" else None)
        for f in case.free_frames
    ]
    variables = bs.join(bs.free_joints(body, case.groups, case.joints), *frames)
    return identifiability(Solver().fit(body, variables, [seen]), [seen])


def measure(well_excited: int = 100) -> dict[str, object]:
    """Sentences of the cases, which are missed, and how many are invented without a case."""
    said, missed = {}, []
    for case in CASES:
        found = judge(case)
        said[case.name] = list(found.sentences)
        groups = [set(direction.members) for direction in found.directions]
        missed += [
            f"{case.name}: {' + '.join(sorted(expected))}"
            for expected in case.expected
            if not any(expected <= members for members in groups)
        ]
    invented = sum(len(judge(Case("plain", ()), seed).directions) for seed in range(well_excited))
    return {"named": len(CASES) - len({m.split(":")[0] for m in missed}), "of": len(CASES),
            "missed": missed, "invented": invented, "sentences": said}  # fmt: skip
