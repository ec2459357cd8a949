"""Recordings that are declared otherwise than they were made: are they named, and is any believed?

    python benchmarks/wrong_declarations.py [--json] [--seeds 20] [--good 200]

Every fault of `FAULTS` is made on points and on poses, of a marker that a tracker sees and of a
board that a camera on the hand sees, by a different arm each seed; all joint zeros are wrong by 3
degrees (one standard deviation), frames are anywhere. For each fault:

named    share that is named rightly: of neighbours, or by a reader that refuses the file
silent   contradicted, without a name
wrong    another name
green    an answer that says nothing at all (`calibrate` is asked only where no name was found)

Good recordings, with outliers, coarse noise, few rows, locked joints, small motions, zeros off by 8
degrees or smooth paths, must get no name: `false`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import arms
import bodyschema as bs
from bodyschema import lie
from bodyschema.answers.calibrate import calibrate
from bodyschema.answers.lookout import Lookout
from bodyschema.errors import InputError
from bodyschema.estimation.problem import Problem, check_problem
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.layouts import poses_from_columns
from bodyschema.senses.sense import Sense
from bodyschema.trust.neighbours import Neighbour

NOISE = (1e-3, 5e-3)
"""m and rad."""

ZEROS = 0.05
"""rad."""

FRAMES = {"tracker": "no", "marker": "no"}


@dataclass(frozen=True)
class Bed:
    """A robot as modelled with two unknown frames, and the joints between them."""

    body: bs.Body
    joints: tuple[str, ...]


@dataclass(frozen=True)
class Made:
    """A recording, as its columns hold it and as it is declared."""

    q: np.ndarray
    values: np.ndarray
    """(n, 3) or (n, columns of the layout) in m and rad unless a fault has changed them."""
    layout: str
    """"xyz" for points."""

    def sense(self) -> Sense:
        """As `calibrate` gets it."""
        if self.layout == "xyz":
            return bs.Points.make(self.q, self.values, "tracker", "marker")
        pose = poses_from_columns(self.values, self.layout, 1.0)
        return bs.Poses.make(self.q, pose, "tracker", "marker")


def bed(seed: int) -> Bed:
    """One of six arms."""
    rng = np.random.default_rng([seed, 0])
    k = seed % 6
    if k < 3:
        body = bs.Body.random_chain(5 + k, rng).attach("tracker", "base").attach("marker", "tip")
        return Bed(body, body.joints)
    arm = arms.ARMS[k - 3]
    return Bed(arm.body, arm.joints)


def postures(bed: Bed, n: int, rng: np.random.Generator, smooth: bool = False) -> np.ndarray:
    """(n, n_joints) within the limits; joints that do not count stand still."""
    low, high = np.maximum(bed.body.lower, -2.0), np.minimum(bed.body.upper, 2.0)
    q = rng.uniform(low, high, (n, len(low)))
    if smooth:
        t, pace = np.linspace(0, 2 * np.pi, n)[:, None], rng.uniform(0.5, 2.5, len(low))
        q = (low + high) / 2 + (high - low) / 2 * np.sin(pace * t + rng.uniform(0, 6, len(low)))
    still = [j for j, name in enumerate(bed.body.joints) if name not in bed.joints]
    q[:, still] = 0.0
    return q


def record(
    bed: Bed,
    layout: str,
    rng: np.random.Generator,
    n: int = 48,
    zeros: float = ZEROS,
    noise: tuple[float, float] = NOISE,
    outliers: float = 0.0,
    smooth: bool = False,
    still: int = 0,
    reach: float = 1.0,
    mount: bool = False,
) -> Made:
    """What a tracker sees of a marker, or with `mount` the marker of the tracker."""
    body = bed.body
    for frame, far in (("tracker", 1.0), ("marker", 0.1)):
        T = lie.transform(lie.exp_so3(0.7 * rng.normal(size=3)), far * rng.normal(size=3))
        body = body.with_placement(frame, T)
    free = bs.free_joints(body, ("offsets",), bed.joints)
    body = body.with_variables(free, zeros * rng.normal(size=len(free)))
    q = reach * postures(bed, n, rng, smooth)
    for j in range(still):
        q[:, bed.body.joints.index(bed.joints[1 + j])] = 0.3
    ends = ("marker", "tracker") if mount else ("tracker", "marker")
    T = relative_pose(body, q, *ends).copy()
    T[:, :3, 3] += noise[0] * rng.normal(size=(n, 3))
    T[:, :3, :3] = lie.exp_so3(noise[1] * rng.normal(size=(n, 3))) @ T[:, :3, :3]
    bad = rng.random(n) < outliers
    T[bad, :3, 3] += rng.uniform(-0.2, 0.2, (int(bad.sum()), 3))
    T[bad, :3, :3] = lie.exp_so3(0.5 * rng.normal(size=(int(bad.sum()), 3))) @ T[bad, :3, :3]
    return Made(q, columns(T, layout), layout)


def columns(T: np.ndarray, layout: str) -> np.ndarray:
    """Poses as a layout writes them."""
    p, R = T[:, :3, 3], T[:, :3, :3]
    if layout == "xyz":
        return p.copy()
    if layout == "xyz_rpy":
        return np.hstack([p, lie.rpy_from_rotation(R)])
    if layout == "xyz_rotvec":
        return np.hstack([p, lie.log_so3(R)])
    if layout == "matrix3x4":
        return T[:, :3].reshape(-1, 12).copy()
    x, y, z, w = lie.quaternion_xyzw(R).T
    parts = (x, y, z, w) if layout == "xyz_xyzw" else (w, x, y, z)
    return np.hstack([p, np.stack(parts, axis=1)])


Right = Callable[[str, str], bool]
"""Whether a neighbour of some key and words is what was made."""


def _key(key: str, *words: str) -> Right:
    return lambda k, w: k == key and all(word in w for word in words)


def _lengths(factor: float) -> Callable[[Made], Made]:
    def made(m: Made) -> Made:
        values = m.values.copy()
        values[:, [3, 7, 11] if m.layout == "matrix3x4" else [0, 1, 2]] *= factor
        return replace(m, values=values)

    return made


def _angles(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Made], Made]:
    return lambda m: replace(m, values=np.hstack([m.values[:, :3], change(m.values[:, 3:])]))


def _relaid(layout: str) -> Callable[[Made], Made]:
    return lambda m: replace(m, layout=layout)


def _positions(P: np.ndarray) -> Callable[[Made], Made]:
    def made(m: Made) -> Made:
        places = [3, 7, 11] if m.layout == "matrix3x4" else [0, 1, 2]
        values = m.values.copy()
        values[:, places] = values[:, places] @ np.asarray(P, dtype=float).T
        return replace(m, values=values)

    return made


def _transposed(m: Made) -> Made:
    T = np.tile(np.eye(4), (len(m.values), 1, 1))
    T[:, :3] = m.values.reshape(-1, 3, 4)
    T[:, :3, :3] = np.swapaxes(T[:, :3, :3], 1, 2)
    return replace(m, values=T[:, :3].reshape(-1, 12))


def _late(k: int) -> Callable[[Made], Made]:
    if k > 0:
        return lambda m: replace(m, q=m.q[k:], values=m.values[:-k])
    return lambda m: replace(m, q=m.q[:k], values=m.values[-k:])


def _euler(m: Made) -> Made:
    """Angles about x, y, z that turn as Rx Ry Rz, declared as roll, pitch, yaw."""
    R = lie.rotation_from_rpy(m.values[:, 3:])
    b = np.arcsin(np.clip(R[:, 0, 2], -1, 1))
    a, c = np.arctan2(-R[:, 1, 2], R[:, 2, 2]), np.arctan2(-R[:, 0, 1], R[:, 0, 0])
    return replace(m, values=np.hstack([m.values[:, :3], np.stack([a, b, c], axis=1)]))


def faults(bed: Bed, rng: np.random.Generator) -> dict[str, tuple[str, dict, Callable, Right]]:
    """Name -> layouts that it applies to, options of the recording, what is done, what is right."""
    a, b = rng.choice(len(bed.joints), 2, replace=False)
    first, second = bed.body.joint_index(bed.joints[a]), bed.body.joint_index(bed.joints[b])
    size = float(rng.choice([0.7, 0.8, 0.9, 1.1, 1.25, 1.4]))
    gear = float(rng.choice([0.6, 0.8, 1.25, 1.6]))

    def joint(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Made], Made]:
        return lambda m: replace(m, q=change(m.q.copy()))

    def swap(q: np.ndarray) -> np.ndarray:
        q[:, [first, second]] = q[:, [second, first]]
        return q

    def times(factor: float, columns: list[int]) -> Callable[[np.ndarray], np.ndarray]:
        def change(q: np.ndarray) -> np.ndarray:
            q[:, columns] *= factor
            return q

        return change

    every = "xyz matrix3x4"
    turning = [bed.body.joint_index(j) for j in bed.joints]
    said = f"'{bed.body.joints[first]}'"
    swapped = _key(f"swap {min(first, second)} {max(first, second)}")
    return {
        "inverse": ("matrix3x4 xyz", {"mount": True}, lambda m: m, _key("mount")),
        "wxyz for xyzw": ("xyz_wxyz", {}, _relaid("xyz_xyzw"), _key("layout", "w, x, y, z")),
        "xyzw for wxyz": ("xyz_xyzw", {}, _relaid("xyz_wxyz"), _key("layout", "x, y, z, w")),
        "transposed": ("matrix3x4", {}, _transposed, _key("transposed")),
        "mm": (every, {}, _lengths(1e3), _key("unit", '"mm"')),
        "cm": (every, {}, _lengths(1e2), _key("unit", '"cm"')),
        "inches": (every, {}, _lengths(1 / 0.0254), _key("unit", '"in"')),
        "m for mm": (every, {}, _lengths(1e-3), _key("scale")),
        "joints in degrees": (every, {}, joint(times(180 / np.pi, turning)), _key("joint unit")),
        "joints in rad for deg": (
            every,
            {},
            joint(times(np.pi / 180, turning)),
            _key("joint unit"),
        ),
        "rpy in degrees": ("xyz_rpy", {}, _angles(np.rad2deg), _key("angle_unit")),
        "rotvec in degrees": ("xyz_rotvec", {}, _angles(np.rad2deg), _key("angle_unit")),
        "rpy reversed": ("xyz_rpy", {}, _angles(lambda c: c[:, ::-1]), _key("layout", "reverse")),
        "Rx Ry Rz": ("xyz_rpy", {}, _euler, _key("layout", "about x, y, z", "Rx Ry Rz")),
        "one row late": (every, {}, _late(1), _key("rows", "one row late")),
        "one row early": (every, {}, _late(-1), _key("rows", "one row early")),
        "3 rows late, smooth": (every, {"smooth": True, "n": 120}, _late(3), _key("rows", "late")),
        "4 rows early, smooth": (
            every,
            {"smooth": True, "n": 120},
            _late(-4),
            _key("rows", "early"),
        ),
        "joint columns swapped": (every, {}, joint(swap), swapped),
        "joint sign": (
            every,
            {},
            joint(times(-1, [first])),
            _key(f"joint {first}", "the other way"),
        ),
        "gear": (every, {}, joint(times(gear, [first])), _key(f"joint {first}", said, "gear")),
        "target's scale": (every, {}, _lengths(size), _key("scale")),
        "mirrored": (every, {}, _positions(np.diag([1, -1, 1])), _key("axes")),
        "axes swapped": (every, {}, _positions(np.eye(3)[[1, 0, 2]]), _key("axes")),
    }


GOOD = {
    "clean": {},
    "outliers": {"outliers": 0.2},
    "many outliers": {"outliers": 0.35},
    "coarse": {"noise": (1e-2, 2e-2)},
    "zeros off 8 deg": {"zeros": np.deg2rad(8)},
    "one joint stands": {"still": 1},
    "15 rows": {"n": 15},
    "10 rows": {"n": 10},
    "small motion": {"reach": 0.1, "zeros": 0.01},
    "smooth": {"smooth": True, "n": 120},
}


def seen_good(seed: int, kind: str, layout: str) -> tuple[Neighbour, ...]:
    """The name that a good recording gets; it should get none."""
    rng = np.random.default_rng([seed, len(kind), 1])
    bed_ = bed(seed)
    made = record(bed_, layout, rng, **GOOD[kind])
    return look(bed_, made.sense(), layout, "rad").named[:1]


def look(bed: Bed, sense: Sense, layout: str, joint_unit: str) -> Lookout:
    """What `calibrate` sees of a recording before it fits it."""
    kind = "poses" if isinstance(sense, bs.Poses) else "points"
    entry = {"kind": kind, "layout": layout, "seen_from": "tracker", "seen": "marker"}
    entry |= {"unit": "m", "angle_unit": "rad"}
    problem = Problem(bed.body, (sense,), FRAMES, bed.joints)
    return Lookout.at(problem, {"senses": [entry], "joints": {"unit": joint_unit}}, True)


def outcome(seed: int, fault: str, layout: str) -> str:
    """named, silent, wrong or green."""
    rng = np.random.default_rng([seed, 2])
    bed_ = bed(seed)
    _, options, change, right = faults(bed_, rng)[fault]
    made = change(record(bed_, layout, rng, **options))
    unit = "deg" if fault == "joints in rad for deg" else "rad"
    try:
        sense = made.sense()
        check_problem(Problem(bed_.body, (sense,), FRAMES, bed_.joints), (), 5)
        found = look(bed_, sense, made.layout, unit).named
    except InputError as error:
        named = 'unit = "deg"' in str(error) or right("unit", str(error))
        return "named" if named else f"wrong ({error})"
    if found:
        best = found[0].declaration
        named = any(right(n.declaration.key, n.declaration.words) for n in found)
        return "named" if named else f"wrong ({best.key}: {best.words[:40]})"
    answer = calibrate(bed_.body, [sense], FRAMES, joints=bed_.joints)
    return "silent" if answer.verdict in ("contradicted", "refused") else "green"


def main() -> None:
    """Print the table, or with --json one object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--good", type=int, default=200)
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    table: dict[str, dict[str, int]] = {}
    names: list[str] = []
    for fault, (layouts, *_) in faults(bed(0), np.random.default_rng(0)).items():
        if asked.only not in fault:
            continue
        for layout in layouts.split():
            form = "points" if layout == "xyz" else "poses"
            row = table.setdefault(f"{fault} ({form})", dict.fromkeys(OUTCOMES, 0))
            for seed in range(asked.seeds):
                found = outcome(seed, fault, layout)
                row[found.split(" ")[0]] += 1
                if found.split(" ")[0] != "named":
                    names.append(f"{fault} {form} {seed}: {found}")
            if not asked.json:
                print(
                    f"{fault + ' (' + form + ')':34}",
                    *(f"{row[k]:4}" for k in OUTCOMES),
                    flush=True,
                )
    kinds, per = list(GOOD), -(-asked.good // (2 * len(GOOD)))
    false = dict.fromkeys(kinds if asked.good else (), 0)
    for kind in false:
        for seed in range(per):
            for form in ("xyz", "matrix3x4"):
                for neighbour in seen_good(seed, kind, form):
                    false[kind] += 1
                    words = f"{neighbour.words[:50]} {neighbour.factor:.1f}"
                    names.append(f"good {kind} {form} {seed}: {words}")
    total = {k: sum(row[k] for row in table.values()) for k in OUTCOMES}
    if asked.json:
        print(
            json.dumps(
                {"by_fault": table, "all": total, "good": 2 * per * len(kinds), "false": false}
            )
        )
        return
    print(f"{'all':34}", *(f"{total[k]:4}" for k in OUTCOMES))
    print(f"good runs {2 * per * len(kinds)}: false {false}")
    print("\n".join(names))


OUTCOMES = ("named", "silent", "wrong", "green")

if __name__ == "__main__":
    main()
