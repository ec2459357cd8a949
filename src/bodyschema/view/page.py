"""The page: one HTML file with the scene in it, that fetches nothing and needs nothing else.

Numbers travel as base64 of little-endian arrays inside one JSON block. Whatever users named is text
in that block, and the script writes it by `textContent`; a policy in the page allows its own script
and style by their hashes and nothing more, so that markup in a name could not run either.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from dataclasses import asdict
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bodyschema.view.marks import Marks
from bodyschema.view.scene import Scene

FORCE_LENGTH = 0.25
"""Share of the robot's size that the strongest force is drawn as long as."""


def page_html(scene: Scene) -> str:
    """The whole page; the same scene gives the same bytes."""
    style, script = _asset("view.css"), _asset("view.js")
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    parts = {
        "policy": policy,
        "title": html.escape(scene.title),
        "explanation": html.escape(scene.explanation),
        "style": style,
        "scene": scene_json(scene),
        "script": script,
    }
    pieces = re.split(r"@(\w+)@", _asset("view.html"))
    return "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def scene_json(scene: Scene) -> str:
    """The scene as JSON in which no character opens or closes markup."""
    text = json.dumps(_document(scene), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _document(scene: Scene) -> dict[str, Any]:
    moving, place = scene.moving, {name: k for k, name in enumerate(scene.moving.frames)}
    shift, at = moving.shift
    return {
        "title": scene.title,
        "tone": scene.tone,
        "verdict": scene.verdict,
        "explanation": scene.explanation,
        "trust": list(scene.trust),
        "notes": [*scene.unsure, *scene.notes],
        "rows": scene.recorded.rows.tolist(),
        "frames": list(moving.frames),
        "parent": list(moving.parent),
        "joint": list(moving.joint),
        "corrected": list(moving.corrected),
        "before": _packed(moving.packed(moving.before)) if scene.ghost else None,
        "after": _packed(moving.packed(moving.after)),
        "size": scene.size,
        "words": list(scene.words),
        "shift": {"mm": round(1e3 * shift, 3), "at": at},
        "factors": scene.factors,
        "force_length": _force_length(scene),
        "shapes": [
            {
                "frame": place[shape.frame],
                "vertices": _packed(shape.vertices),
                "faces": _packed(shape.faces, "<u4"),
            }
            for shape in scene.shapes
        ],
        "marks": [_marks(mark) for mark in scene.marks],
        "ellipsoids": [
            {
                "name": e.name,
                "kind": e.kind,
                "true": e.kind == "load" or scene.is_wide(e),
                "centre": _packed(e.centre),
                "axes": _packed(e.axes),
            }
            for e in scene.ellipsoids
            if e.kind == "load" or e.widest < scene.size
        ],
        "forces": [
            {"name": f.name, "start": _packed(f.start), "vector": _packed(f.vector)}
            for f in scene.forces
        ],
        "placed": [asdict(one) for one in scene.placed],
        "named": [place[name] for name in scene.named],
    }


def _marks(mark: Marks) -> dict[str, Any]:
    arrows = None if mark.arrows is None else [_packed(side) for side in mark.arrows]
    return {
        "label": mark.label,
        "unit": mark.unit,
        "rows": mark.rows.tolist(),
        "bad": mark.bad.tolist(),
        "places": _packed(mark.places),
        "before": _packed(mark.before),
        "after": _packed(mark.after),
        "arrows": arrows,
    }


def _force_length(scene: Scene) -> float:
    """m a newton."""
    strongest = max((float(np.linalg.norm(f.vector[0])) for f in scene.forces), default=0.0)
    return FORCE_LENGTH * scene.size / strongest if strongest else 0.0


def _packed(values: ArrayLike, kind: str = "<f4") -> str:
    array = np.nan_to_num(np.asarray(values)).astype(kind)
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()


def _asset(name: str) -> str:
    return (resources.files("bodyschema.view") / "templates" / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
