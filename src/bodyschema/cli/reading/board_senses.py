"""A sense of a board from its photographs: corners are found here, and are pixels from then on.

What of a run needs all its pictures stands here too: a lens that nobody knows begins at the one
that the pictures show, and what was found is said.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.entry_types import entry_of
from bodyschema.cli.reading.board_pictures import Photograph, left_out, photographs
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import unstated
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.model.distortion import PLUMB_BOB
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import straight_rays
from bodyschema.model.parts import lens as lens_part
from bodyschema.model.tree import Body
from bodyschema.seeds.pixel_poses import pose_of_points
from bodyschema.seeds.turned_boards import board_turns
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense
from bodyschema.vision.targets.found import Found
from bodyschema.vision.targets.lens_start import begun_lens
from bodyschema.vision.targets.target import Target

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def board(entry: SenseEntry, at: Moments) -> Sense:
    """The corners of a board in the pictures of a recording.

    Raises:
        InputError: no target, a picture that is missing or of another size than the lens, or no
            board in any.
    """
    target, taken = target_of(entry), pictures_of(entry, at)
    size = taken[0].size if taken else (0, 0)
    declared = at.parts[entry.lens].size
    if taken and declared and size != declared:
        raise InputError(
            f"the pictures '{entry.images}' have {size[0]} x {size[1]} pixels, and size = "
            f"{list(declared)} in [parts.{entry.lens}]; give the lens of these pictures: fx, fy, "
            "cx and cy shrink with the size."
        )
    used = [(one.row, one.found) for one in taken if one.used and one.found is not None]
    if taken and not used:
        raise InputError(_nothing(entry, target, taken))
    rows, corners = np.array([row for row, _ in used], dtype=np.int64), [one for _, one in used]
    if used and not target.tagged:
        corners = _unturned(entry, at, target, corners, rows, size)
    counts = [len(one) for one in corners]
    ids = np.concatenate([one.ids for one in corners] or [np.zeros(0, np.int64)])
    image = np.concatenate([one.image for one in corners] or [np.zeros((0, 2))])
    each = np.repeat(rows, counts)
    more = {
        "target": target.corners[ids],
        "scale": entry.scale,
        "size": size,
        **at.more(entry, each, [1.0]),
    }
    return Pixels.make(at.q[each], image, entry.seen_from, entry.seen, entry.lens, **more)


def pictures_of(entry: SenseEntry, at: Moments) -> tuple[Photograph, ...]:
    """The photographs of a sense, those that are left out among them. Raises InputError."""
    if len(entry.columns) > 1:
        raise InputError("a sense of a board has one column, the number in the picture's name.")
    numbers, rows = at.read(entry.columns)
    names = numbers[:, 0].astype(np.int64) if entry.columns else rows
    return photographs(entry, target_of(entry), names, rows)


def target_of(entry: SenseEntry) -> Target:
    """The target that an entry describes. Raises InputError."""
    where = f"target of the board '{entry.seen}'"
    if not isinstance(entry.target, Mapping):
        raise InputError(
            f'{where} is a table, such as target = {{ kind = "charuco", columns = 7, rows = 5, '
            'square_m = 0.03, marker_m = 0.022, dictionary = "4X4_50" }.'
        )
    target = entry_of(Target, entry.target, where)
    target.check(where)
    return target


def with_begun_lenses(run: RunFile, body: Body, senses: Sequence[Sense]) -> Body:
    """The body with lenses of which the run file has no focal length as the pictures show them.

    Raises:
        InputError: they are too few for that.
    """
    for name, part in run.parts.items():
        if not unstated(part):
            continue
        mine = [sense for sense in senses if isinstance(sense, Pixels) and sense.lens == name]
        pictures = [one for sense in mine for one in _pictures(sense)]
        if not pictures:
            continue
        width, height = part.size
        places, images = [p for p, _ in pictures], [i for _, i in pictures]
        lens = begun_lens(places, images, width, height, part.model or PLUMB_BOB)
        if lens is None:
            raise InputError(
                f"[parts.{name}] has no fx, and three pictures of a board with six corners or more "
                "are needed to find it; give fx or fov_deg, or take more pictures."
            )
        old, begun = body.part(name), lens_part(lens)
        body = body.with_part(name, replace(old, values=begun.values))
    return body


def photographs_of(
    run: RunFile, opened: Mapping[Any, Moments]
) -> dict[str, tuple[Photograph, ...]]:
    """The photographs of each board and camera by the label of their sense, rows numbered through.

    Args:
        run: with the entries.
        opened: the recordings by their files and column of times.
    """
    taken = dict[str, tuple[Photograph, ...]]()
    for entry in run.senses:
        if entry.kind == "board":
            at = opened[_source(run, entry)].only(entry.where)
            mine = tuple(replace(one, row=one.row + at.first) for one in pictures_of(entry, at))
            taken[_label(entry)] = taken.get(_label(entry), ()) + mine
    return {label: mine for label, mine in taken.items() if mine}


def board_remarks(
    run: RunFile, taken: Mapping[str, Sequence[Photograph]], senses: Sequence[Sense]
) -> list[str]:
    """What was found in the pictures, a sentence for each board and camera.

    Args:
        run: with the entries.
        taken: their photographs; see `photographs_of`.
        senses: that were read from them.
    """
    targets = {_label(e): target_of(e) for e in run.senses if e.kind == "board"}
    said = []
    for sense in senses:
        if sense.label not in taken or not len(sense):
            continue
        rows, counts = np.unique(sense.rows, return_counts=True)
        said.append(
            f"The board '{sense.seen}' was found by '{sense.seen_from}' in {len(rows)} of "
            f"{len(taken[sense.label])} pictures: {len(sense)} corners, in the middle picture "
            f"{int(np.median(counts))} of {len(targets[sense.label].corners)}."
        )
        said += left_out(taken[sense.label])
    return said


def _source(run: RunFile, entry: SenseEntry) -> tuple[tuple[str, ...], str | None]:
    return entry.recording or run.recording, run.time if entry.time is None else entry.time


def _label(entry: SenseEntry) -> str:
    return f"pixels of {entry.seen} in {entry.seen_from}"


def _pictures(sense: Pixels) -> list[tuple[Array, Array]]:
    """Corners on the board (m, 3) and pixels (m, 2) of each picture."""
    order = np.unique(sense.rows)
    return [(sense.target[sense.rows == row], sense.observed[sense.rows == row]) for row in order]


def _nothing(entry: SenseEntry, target: Target, taken: Sequence[Photograph]) -> str:
    """That no picture shows the board, and what it may be."""
    count, drawn_over = len(taken), " ".join(left_out([one for one in taken if one.found]))
    what = f"{target.kind} of {target.columns} x {target.rows}"
    count_of = "inner corners, not squares" if target.kind == "chessboard" else f"{target.kind}"
    hint = (
        f"count its {count_of}"
        if target.kind == "chessboard"
        else "check columns, rows" + (", dictionary and legacy" if target.tagged else "")
    )
    return (
        f"no board '{entry.seen}' ({what}) in any of the {count} pictures of '{entry.images}'; "
        f"{hint}, and see that nothing was drawn over it. {drawn_over}".rstrip()
    )


def _unturned(
    entry: SenseEntry,
    at: Moments,
    target: Target,
    corners: Sequence[Found],
    rows: Ints,
    size: tuple[int, int],
) -> list[Found]:
    """Corners renumbered where the pattern looks the same turned round, as the arm tells."""
    turns = target.turns
    if len(turns) < 2:
        return list(corners)
    places = target.corners
    lens = at.body.part(entry.lens).values
    if unstated(at.parts[entry.lens]):
        found = [(places[one.ids], one.image) for one in corners]
        model = at.parts[entry.lens].model or PLUMB_BOB
        begun = begun_lens([p for p, _ in found], [i for _, i in found], *size, model)
        lens = lens if begun is None else lens_part(begun).values
    T = [pose_of_points(places[one.ids], straight_rays(lens, one.image)) for one in corners]
    ends = [_parent(at.body, name) for name in (entry.seen_from, entry.seen)]
    told = [k for k, one in enumerate(T) if one is not None]
    K = relative_pose(at.body, at.q[rows[told]], *ends)
    which = np.zeros(len(corners), dtype=np.int64)
    poses = np.array([one for one in T if one is not None])
    which[told] = board_turns(K, poses, [F for _, F in turns])
    return [one.taken(inverse(turns[k][0])) for k, one in zip(which, corners, strict=True)]


def inverse(order: Ints) -> Ints:
    """The renumbering that takes back another, (n,)."""
    return np.argsort(order)


def _parent(body: Body, frame: str) -> str:
    """The frame that another one is fixed to; itself where it has none."""
    parent = body.parent[body.frame_index(frame)]
    return body.frames[parent] if parent >= 0 else frame
