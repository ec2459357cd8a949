"""What `bodyschema payload` answers: plain values for programs, and words for people."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.wrist.held_recording import POOR, HeldRecording
from bodyschema.export.payload import controller_forms
from bodyschema.learners.payload.learner import com_covariance
from bodyschema.learners.payload.untold import SIX, moments_covariance, untold
from bodyschema.model.inertia import PHI, Inertia

Array = NDArray[np.float64]

DENSEST = 22600.0
"""kg/m^3, osmium."""


def payload_answer(held: HeldRecording) -> dict[str, Any]:
    """The answer in plain types, SI; masses in kg, moments about the centre of mass."""
    fit = held.fit
    P = fit.solution.covariance
    bias, bias_std = _offset(held)
    turn = np.degrees(lie.log_so3(fit.R))
    moving = [part.means for part in fit.parts]
    return {
        "loads": [_load(held, name) for name in fit.names],
        "sensor": {
            "bias": bias.tolist(),
            "bias_std": bias_std.tolist(),
            "turn_deg": turn.tolist(),
            "turn_std_deg": np.degrees(np.sqrt(np.diag(P)[:3])).tolist(),
            "noise": np.sqrt(fit.solution.levels.variance).tolist(),
            "memory": fit.solution.levels.tau.tolist(),
        },
        "unexplained": float(fit.unexplained.max()),
        "samples": int(sum(len(means) for means in moving)),
        "left_out": int(sum((~kept).sum() for kept in fit.kept)),
        "events": [
            {"time": event.time, "event": event.event, "mass": event.mass} for event in held.events
        ],
        "notes": [*held.notes, *_doubts(held)],
    }


def _offset(held: HeldRecording) -> tuple[Array, Array]:
    """What the sensor adds to its reading, (6,) along its axes and with its sign, and the std."""
    R, b = held.fit.R, held.fit.solution.guess.bias
    sign = 1.0 if held.run.wrench.sign == "on_object" else -1.0
    # R^T b under R <- exp(w) R, b <- b + db; force and torque alike.
    J = np.zeros((6, 9))
    for i in (0, 3):
        J[i : i + 3, :3] = R.T @ lie.skew(b[i : i + 3])
        J[i : i + 3, 3 + i : 6 + i] = R.T
    P = J @ held.fit.solution.covariance[:9, :9] @ J.T
    return sign * (b.reshape(2, 3) @ R).ravel(), np.sqrt(np.diag(P))


def _load(held: HeldRecording, name: str) -> dict[str, Any]:
    """One load, along the sensor's declared axes and along the flange's."""
    load, P = held.fit.loads[name], held.fit.covariance(name)
    T = held.T_flange_mount
    flange = load.in_frame(T)
    spread = np.sqrt(np.diag(com_covariance(load, P)))
    moments = np.sqrt(np.diag(moments_covariance(load, P)))
    open_things = untold(load, P)
    return {
        "name": name,
        "mass": load.mass,
        "mass_std": float(np.sqrt(P[0, 0])),
        "com": load.com.tolist(),
        "com_std": spread.tolist(),
        "inertia": load.moments.tolist(),
        "inertia_std": {
            f"I_{'xyz'[i]}{'xyz'[j]}": float(moments[k]) for k, (i, j) in enumerate(SIX)
        },
        "phi": dict(zip(PHI, load.phi.tolist(), strict=True)),
        "phi_covariance": P.tolist(),
        "physical": load.physical,
        "flange": _plain(flange),
        "controllers": controller_forms(flange),
        "not_told": [{"what": one.what, "sentence": one.sentence} for one in open_things],
    }


def _plain(load: Inertia) -> dict[str, Any]:
    return {"mass": load.mass, "com": load.com.tolist(), "inertia": load.moments.tolist()}


def _doubts(held: HeldRecording) -> list[str]:
    """What looks wrong with the recording or with what was said of it."""
    found = []
    share = float(held.fit.unexplained.max())
    if share > POOR:
        found.append(
            f"the load leaves {100 * share:.0f} % of the wrench unexplained, so do not use it: "
            + (
                f"with {held.hint} it would explain it; check that entry."
                if held.hint
                else "check the frame of the wrench, the layout and inverse of the pose, the "
                'units, [sensor] rpy or known = "no", and which stretch is free of contact.'
            )
        )
    elif held.hint:
        found.append(
            f"the load leaves {100 * share:.0f} % of the wrench unexplained; with {held.hint} it "
            "would be far less: check that entry."
        )
    if any(_too_dense(held, name) for name in held.fit.names):
        found.append("the load would be denser than any metal: check torque_unit and unit.")
    turn = float(np.degrees(np.linalg.norm(lie.log_so3(held.fit.R))))
    if held.run.sensor.known == "roughly" and turn > 15:
        found.append(
            f"the sensor seems turned by {turn:.0f} degrees against what was declared: check "
            '[sensor] rpy and the frames, or set known = "no".'
        )
    total = sum(len(kept) for kept in held.fit.kept)
    wild = sum(int((~kept).sum()) for kept in held.fit.kept)
    if wild > 0.05 * total:
        found.append(
            f"{wild} of {total} samples were left out as wild; something touched the load."
        )
    return found


def _too_dense(held: HeldRecording, name: str) -> bool:
    """Whether its spread, two deviations more, is below that of a ball of the densest metal."""
    load, P = held.fit.loads[name], held.fit.covariance(name)
    radius = (3 * max(load.mass, 0.0) / (4 * np.pi * DENSEST)) ** (1 / 3)
    spread = np.trace(load.moments) + 2 * np.sqrt(moments_covariance(load, P).trace())
    return bool(spread < 3 * 0.4 * load.mass * radius**2)


def told(answer: dict[str, Any]) -> bool:
    """Whether mass and centre of mass of every load are known, and the load explains the wrench."""
    what = [one["what"] for load in answer["loads"] for one in load["not_told"]]
    return "mass" not in what and "com" not in what and answer["unexplained"] < POOR


def describe(answer: dict[str, Any], out: Path) -> str:
    """The answer in words."""
    lines = []
    for load in answer["loads"]:
        lines += _describe_load(load)
    sensor = answer["sensor"]
    bias, std = np.array(sensor["bias"]), np.array(sensor["bias_std"])
    lines.append(
        f"sensor: offset {_vector(bias[:3], std[:3], 1, 'N')}, "
        f"{_vector(bias[3:], std[3:], 1e3, 'mNm')}; turned by "
        f"{_vector(np.array(sensor['turn_deg']), np.array(sensor['turn_std_deg']), 1, 'deg')}"
    )
    lines.append(
        f"{100 * answer['unexplained']:.3g} % of the wrench is left unexplained; "
        f"{answer['samples']} samples, {answer['left_out']} of them left out."
    )
    before = None
    for event in answer["events"]:
        mass = event["mass"]
        now = "" if mass is None else f", now {mass:.3f} kg"
        change = "" if None in (mass, before) else f" ({mass - before:+.3f})"
        lines.append(f"at {event['time']:.2f} s: {event['event']}{now}{change}")
        before = mass
    lines += [f"Note: {note}" for note in answer["notes"]]
    lines.append(f"All numbers, controller settings and the report: {out}")
    return "\n".join(lines)


def _describe_load(load: dict[str, Any]) -> list[str]:
    com, com_std = np.array(load["com"]), np.array(load["com_std"])
    I = np.array(load["inertia"])  # noqa: E741
    untold = {one["what"] for one in load["not_told"]}
    doubt = " (not told)" if "mass" in untold else ""
    lines = [f"{load['name']}: {load['mass']:.4f} ± {load['mass_std']:.4f} kg{doubt}"]
    if "mass" in untold:
        lines.append("  centre of mass  not told")
    else:
        doubt = ", not told in every direction" if "com" in untold else ""
        lines.append(f"  centre of mass  {_vector(com, com_std, 1e3, 'mm')} (sensor's axes{doubt})")
    for name, std in load["inertia_std"].items():
        i, j = ("xyz".index(c) for c in name[2:])
        value = "not told" if name in untold else f"{1e3 * I[i, j]:+.3f} ± {1e3 * std:.3f} g m2"
        lines.append(f"  {name:<15} {value}")
    sentences = dict.fromkeys(one["sentence"] for one in load["not_told"])
    lines += [f"  Not told: {sentence}" for sentence in sentences]
    return lines


def _vector(values: Array, std: Array, factor: float, unit: str) -> str:
    shown = ", ".join(
        f"{factor * v:.2f} ± {factor * s:.2g}" for v, s in zip(values, std, strict=True)
    )
    return f"({shown}) {unit}"
