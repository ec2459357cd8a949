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
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import unstated
from bodyschema.cli.reading.pictures import picture_path
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import straight_rays
from bodyschema.model.parts import lens as lens_part
from bodyschema.model.tree import Body
from bodyschema.seeds.pixel_poses import pose_of_points
from bodyschema.seeds.turned_boards import board_turns
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense
from bodyschema.sources.video import read_picture
from bodyschema.vision.targets.detection import find_target
from bodyschema.vision.targets.found import Found
from bodyschema.vision.targets.lens_start import begun_lens
from bodyschema.vision.targets.target import Target

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

RED_GREEN_BLUE = (0.299, 0.587, 0.114)
"""Weights of a grey level, those of OpenCV."""


def board(entry: SenseEntry, at: Moments) -> Sense:
    """The corners of a board in the pictures of a recording.

    Raises:
        InputError: no target, a picture that is missing or of another size than the lens, or no
            board in any.
    """
    target = target_of(entry)
    if len(entry.columns) > 1:
        raise InputError("a sense of a board has one column, the number in the picture's name.")
    numbers, rows = at.read(entry.columns)
    names = numbers[:, 0].astype(np.int64) if entry.columns else rows
    found, size = _found(entry, target, names)
    declared = at.parts[entry.lens].size
    if len(names) and declared and size != declared:
        raise InputError(
            f"the pictures '{entry.images}' have {size[0]} x {size[1]} pixels, and size = "
            f"{list(declared)} in [parts.{entry.lens}]; give the lens of these pictures: fx, fy, "
            "cx and cy shrink with the size."
        )
    seen = [k for k, one in enumerate(found) if one is not None]
    if len(names) and not seen:
        raise InputError(_nothing(entry, target, len(names)))
    corners = [one for one in found if one is not None]
    if seen and not target.tagged:
        corners = _unturned(entry, at, target, corners, rows[seen], size)
    counts = [len(one) for one in corners]
    ids = np.concatenate([one.ids for one in corners] or [np.zeros(0, np.int64)])
    image = np.concatenate([one.image for one in corners] or [np.zeros((0, 2))])
    each = np.repeat(rows[seen], counts)
    more = {"target": target.corners[ids], "scale": entry.scale, **at.more(entry, each, [1.0])}
    return Pixels.make(at.q[each], image, entry.seen_from, entry.seen, entry.lens, **more)


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
        lens = begun_lens([p for p, _ in pictures], [i for _, i in pictures], width, height)
        if lens is None:
            raise InputError(
                f"[parts.{name}] has no fx, and three pictures of a board with six corners or more "
                "are needed to find it; give fx or fov_deg, or take more pictures."
            )
        old, begun = body.part(name), lens_part(lens)
        body = body.with_part(name, replace(old, values=begun.values))
    return body


def board_remarks(
    run: RunFile, opened: Mapping[Any, Moments], senses: Sequence[Sense]
) -> list[str]:
    """What was found in the pictures, a sentence for each board and camera.

    Args:
        run: with the entries.
        opened: the recordings by their files and column of times.
        senses: that were read from them.
    """
    said = []
    for sense in senses:
        mine = [e for e in run.senses if e.kind == "board" and _label(e) == sense.label]
        if not mine or not len(sense):
            continue
        rows, counts = np.unique(sense.rows, return_counts=True)
        sources = {
            (e.recording or run.recording, run.time if e.time is None else e.time) for e in mine
        }
        pictures = sum(len(opened[source]) for source in sources)
        said.append(
            f"The board '{sense.seen}' was found by '{sense.seen_from}' in {len(rows)} of "
            f"{pictures} pictures: {len(sense)} corners, in the middle picture "
            f"{int(np.median(counts))} of {len(target_of(mine[0]).corners)}."
        )
    return said


def _label(entry: SenseEntry) -> str:
    return f"pixels of {entry.seen} in {entry.seen_from}"


def _pictures(sense: Pixels) -> list[tuple[Array, Array]]:
    """Corners on the board (m, 3) and pixels (m, 2) of each picture."""
    order = np.unique(sense.rows)
    return [(sense.target[sense.rows == row], sense.observed[sense.rows == row]) for row in order]


def _found(
    entry: SenseEntry, target: Target, numbers: Ints
) -> tuple[list[Found | None], tuple[int, int]]:
    """The corners of each picture, and the size of all.

    Raises:
        InputError: pictures differ in size.
    """
    found: list[Found | None] = []
    size = (0, 0)
    for number in numbers:
        path = picture_path(entry.images, int(number))
        grey = np.rint(read_picture(path) @ np.array(RED_GREEN_BLUE)).astype(np.uint8)
        own = (grey.shape[1], grey.shape[0])
        if found and own != size:
            raise InputError(
                f"the picture '{path.name}' has {own[0]} x {own[1]} pixels, those before it "
                f"{size[0]} x {size[1]}; a sense has pictures of one camera and one size."
            )
        size = own
        found.append(find_target(target, grey))
    return found, size


def _nothing(entry: SenseEntry, target: Target, count: int) -> str:
    """That no picture shows the board, and what it may be."""
    what = f"{target.kind} of {target.columns} x {target.rows}"
    count_of = "inner corners, not squares" if target.kind == "chessboard" else f"{target.kind}"
    hint = (
        f"count its {count_of}"
        if target.kind == "chessboard"
        else "check columns, rows" + (", dictionary and legacy" if target.tagged else "")
    )
    return (
        f"no board '{entry.seen}' ({what}) in any of the {count} pictures of '{entry.images}'; "
        f"{hint}, and see that nothing was drawn over it."
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
        begun = begun_lens([p for p, _ in found], [i for _, i in found], *size)
        lens = lens if begun is None else lens_part(begun).values
    T = [pose_of_points(places[one.ids], straight_rays(lens, one.image)) for one in corners]
    ends = [_parent(at.body, name) for name in (entry.seen_from, entry.seen)]
    told = [k for k, one in enumerate(T) if one is not None]
    K = relative_pose(at.body, at.q[rows[told]], *ends)
    which = np.zeros(len(corners), dtype=np.int64)
    poses = np.array([one for one in T if one is not None])
    which[told] = board_turns(K, poses, [F for _, F in turns])
    return [
        Found(inverse(turns[k][0])[one.ids], one.image, one.covariance)
        for k, one in zip(which, corners, strict=True)
    ]


def inverse(order: Ints) -> Ints:
    """The renumbering that takes back another, (n,)."""
    return np.argsort(order)


def _parent(body: Body, frame: str) -> str:
    """The frame that another one is fixed to; itself where it has none."""
    parent = body.parent[body.frame_index(frame)]
    return body.frames[parent] if parent >= 0 else frame
