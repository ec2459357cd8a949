"""What hangs on a wrist: its loads and the sensor's offset and turn, with error bars.

    table = bs.WristTable(bs.open_recording("log.csv"))
    answer = bs.learn_payload(table, declared)

The estimate holds turn and offset of the sensor and the roots of each load; `details` has the loads
as people and controllers take them, along the sensor's declared axes.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.answers.answer import Answer
from bodyschema.answers.held_recording import HeldRecording, hold
from bodyschema.answers.load_trust import centre_95, load_trust
from bodyschema.estimation.held_out import Errors
from bodyschema.export.load_entry import load_entry, vector
from bodyschema.export.payload import controller_forms
from bodyschema.judging.accuracy import Accuracy, in_words
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.wrist_declarations import POOR
from bodyschema.learners.payload.belief import (
    WristFrames,
    load_estimate,
    load_identifiability,
)
from bodyschema.model.inertia import Inertia
from bodyschema.model.tree import Body
from bodyschema.report.payload import Controllers, Explained
from bodyschema.senses.wrist_columns import WristTable
from bodyschema.senses.wrist_declaration import (
    LoadSegments,
    MotionReading,
    WristDeclaration,
)
from bodyschema.threads import one_thread

Array = NDArray[np.float64]


@one_thread
def learn_payload(
    table: WristTable,
    declared: WristDeclaration,
    motion: MotionReading | None = None,
    segments: LoadSegments | None = None,
    empty: WristTable | None = None,
    described: Body | None = None,
    run: Mapping[str, Any] | None = None,
) -> Answer:
    """Find mass, centre of mass and inertia of what a wrist carries.

    Args:
        table: the recording.
        declared: what its columns hold.
        motion: how it is read.
        segments: which times carry the gripper alone, and which an object too.
        empty: another recording with the same columns, of the gripper alone.
        described: the robot as described, if there is one.
        run: what was asked, to be kept with the answer.

    Raises:
        InputError: anything that cannot be used, in one sentence.
    """
    begin = time.perf_counter()
    held = hold(table, declared, motion, segments, empty)
    return load_answer(held, described, run, begin)


def load_answer(
    held: HeldRecording,
    described: Body | None = None,
    run: Mapping[str, Any] | None = None,
    begin: float | None = None,
    **more: Any,
) -> Answer:
    """The answer of a recording whose loads are fitted.

    Args:
        held: the recording.
        described: the robot; None if there is no description.
        run: what was asked.
        begin: of the work, by `time.perf_counter`.
        more: fields that another verb fills in.
    """
    fit = held.fit
    frames = WristFrames.on(described, held.declared.sensor.link, held.T_link_mount)
    estimate = load_estimate(fit, frames, held.learner)
    details = load_details(held)
    nominal, held_out = _accuracy(held, held.read_wrenches), _accuracy(held, held.held_out())
    known = is_known(details)
    found = Calibration(
        verdict="known" if known else "not known",
        explanation=_explanation(details, nominal, held_out, known),
        fit=estimate,
        nominal=nominal,
        held_out=held_out,
        identifiability=load_identifiability(fit, estimate),
        outliers=_outliers(held),
        n_rows=len(held.kept),
        seconds=0.0 if begin is None else time.perf_counter() - begin,
        corrects=False,
        compared=("without load", "load taken off"),
        findings=_findings(details),
        notes=tuple(details["notes"]),
        details=details,
        predicted_95=max(one["com_95"] for one in details["loads"]),
    ).believed(load_trust(held))
    body = frames.body if described is None else described
    sections = (Explained(fit, details), Controllers(details))
    fields = {"verb": "payload", "sections": sections, **more}
    return Answer.of(found, (), body, run, **fields)


def load_details(held: HeldRecording) -> dict[str, Any]:
    """Everything found, SI; masses in kg, moments about the centre of mass, sensor's axes."""
    fit, P = held.fit, held.fit.solution.covariance
    bias, bias_std = _offset(held)
    return {
        "loads": [_load(held, name) for name in fit.names],
        "sensor": {
            "bias": bias.tolist(),
            "bias_std": bias_std.tolist(),
            "turn_deg": np.degrees(lie.log_so3(fit.R)).tolist(),
            "turn_std_deg": np.degrees(np.sqrt(np.diag(P)[:3])).tolist(),
            "noise": np.sqrt(fit.solution.levels.variance).tolist(),
            "memory": fit.solution.levels.tau.tolist(),
            "link": held.declared.sensor.link,
        },
        "last": list(fit.parts[-1].loads),
        "unexplained": float(fit.unexplained.max()),
        "samples": len(held.kept),
        "left_out": int((~held.kept).sum()),
        "events": [
            {"time": event.time, "event": event.event, "mass": event.mass} for event in held.events
        ],
        "notes": list(held.notes),
    }


def is_known(details: Mapping[str, Any]) -> bool:
    """Whether mass and centre of mass of every load are known, and the load explains the wrench."""
    return all(told(load) for load in details["loads"]) and details["unexplained"] < POOR


def told(load: Mapping[str, Any]) -> bool:
    """Whether mass and centre of mass of an entry are told; the one meaning of the word."""
    return not {"mass", "com"} & {one["what"] for one in load["not_told"]}


def _load(held: HeldRecording, name: str) -> dict[str, Any]:
    """One load, along the sensor's declared axes and along the flange's."""
    load, P = held.fit.loads[name], held.fit.covariance(name)
    flange = load.in_frame(held.T_link_mount)
    entry = load_entry(name, load, P, held.fit.untold(name))
    untold = entry.pop("not_told")
    what = {one["what"] for one in untold}
    return {
        **entry,
        "com_95": centre_95(load, P),
        "flange": _plain(flange),
        "controllers": controller_forms(flange, what),
        "not_told": untold,
    }


def _plain(load: Inertia) -> dict[str, Any]:
    return {"mass": load.mass, "com": load.com.tolist(), "inertia": load.moments.tolist()}


def _offset(held: HeldRecording) -> tuple[Array, Array]:
    """What the sensor adds to its reading, (6,) along its axes and with its sign, and the std."""
    R, b = held.fit.R, held.fit.solution.guess.bias
    sign = 1.0 if held.declared.wrench.sign == "on_object" else -1.0
    # R^T b under R <- exp(w) R, b <- b + db; force and torque alike.
    J = np.zeros((6, 9))
    for i in (0, 3):
        J[i : i + 3, :3] = R.T @ lie.skew(b[i : i + 3])
        J[i : i + 3, 3 + i : 6 + i] = R.T
    P = J @ held.fit.solution.covariance[:9, :9] @ J.T
    return sign * (b.reshape(2, 3) @ R).ravel(), np.sqrt(np.diag(P))


def _accuracy(held: HeldRecording, wrench: Array) -> Accuracy:
    """Lengths of force and torque (n, 6) of the samples that were kept."""
    kept = wrench[held.kept]
    parts = {("force", "N"): kept[:, :3], ("torque", "Nm"): kept[:, 3:]}
    return Accuracy(
        {key: Errors.of(np.linalg.norm(part, axis=1)) for key, part in parts.items()},
        {key: part.size for key, part in parts.items()},
    )


def _outliers(held: HeldRecording) -> tuple[int, ...]:
    """Rows of the recording in the middle of the windows that were left out."""
    times = held.times[~held.kept]
    near = np.searchsorted(held.read.samples.time, times).clip(0, len(held.read.rows) - 1)
    return tuple(sorted({int(row) for row in held.read.rows[near]}))


def _explanation(
    details: Mapping[str, Any], nominal: Accuracy, held_out: Accuracy, known: bool
) -> str:
    share = 100 * details["unexplained"]
    if not known and details["unexplained"] >= POOR:
        return f"No load explains this wrench: {share:.0f} % of it is left over."
    if not known:
        return "The motion does not tell the mass or the centre of mass; see what is not told."
    force, torque = (held_out.errors[key].rms for key in (("force", "N"), ("torque", "Nm")))
    before = nominal.errors["force", "N"].rms
    masses = "; ".join(
        f"{load['name']} {load['mass']:.4f} ± {load['mass_std']:.4f} kg"
        for load in details["loads"]
    )
    return (
        f"{masses}. Of {in_words(before, 'N')} rms of force {in_words(force, 'N')} are left, and "
        f"{in_words(1e3 * torque, 'mNm')} of torque; {share:.3g} % of the wrench is unexplained."
    )


def _findings(details: Mapping[str, Any]) -> tuple[str, ...]:
    """The sensor, and what happened, in words."""
    sensor, before = details["sensor"], None
    bias, std = np.array(sensor["bias"]), np.array(sensor["bias_std"])
    turn = vector(np.array(sensor["turn_deg"]), np.array(sensor["turn_std_deg"]), 1, "deg")
    lines = [
        f"sensor: offset {vector(bias[:3], std[:3], 1, 'N')}, "
        f"{vector(bias[3:], std[3:], 1e3, 'mNm')}; turned by {turn}"
    ]
    for event in details["events"]:
        mass = event["mass"]
        now = "" if mass is None else f", now {mass:.3f} kg"
        change = "" if None in (mass, before) else f" ({mass - before:+.3f})"
        lines.append(f"at {event['time']:.2f} s: {event['event']}{now}{change}")
        before = mass
    return tuple(lines)
