"""The before-and-after picture: what the left eye sees, and what the robot expects to see.

Grey is the real arm, as MuJoCo says it stands; colour is the arm as a body imagines it, drawn for
the same encoder readings. A third panel shows the hand's error in every test posture.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes

from bodyschema.errors import MissingExtraError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.report.figure import AFTER, BEFORE, GREY, INK
from bodyschema.simulation import eyes, icub
from bodyschema.simulation.postures import FAR, NEAR
from bodyschema.simulation.rendering import SCALE, read_stl, render
from bodyschema.simulation.scoring import HandErrors, Truth, hand_error, readings_for
from bodyschema.simulation.world import real_icub

Array = NDArray[np.float64]

SHOWN = ("r_upper_arm", "r_elbow_1", "r_forearm", "r_wrist_1", "r_hand")
"""Links that are drawn."""
PAPER, SCENE = "#ffffff", "#f3f1ec"


def draw_before_after(before: Body, after: Body, truth: Truth, path: str | Path) -> Path:
    """Draw the picture into a .png, .svg or .pdf file and return its path.

    Args:
        before: the body that the robot believed.
        after: the body after calibration; both need the frame `left_eye`.
        truth: from `load_truth`.
        path: file to write.

    Raises:
        MissingExtraError: matplotlib, MuJoCo or icub-models is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "sim", "the before-and-after picture") from None
    errors = hand_error(before, truth), hand_error(after, truth)
    posture = telling_posture(before, truth)
    figure = Figure(figsize=(15.6, 5.45), facecolor=PAPER)
    FigureCanvasAgg(figure)
    _write_legend(figure, truth)
    scene = real_view(truth, posture)
    looks = [("before", before, errors[0], BEFORE), ("after", after, errors[1], AFTER)]
    for (word, body, error, colour), left in zip(looks, (0.012, 0.368), strict=True):
        axes = figure.add_axes((left, 0.04, 0.344, 0.738))
        _draw_view(axes, scene, imagined_view(body, truth, posture), colour)
        title = f"{word}: hand imagined {_length(error.position[posture])} off"
        axes.set_title(title, color=colour, fontsize=14, fontweight="bold", loc="left")
    _draw_errors(figure.add_axes((0.775, 0.125, 0.205, 0.653)), errors, posture)
    target = Path(path)
    figure.savefig(target, dpi=130, facecolor=PAPER)
    return target


def telling_posture(before: Body, truth: Truth) -> int:
    """The test posture that shows the hand broadest and in the middle of the image."""
    imagined = relative_pose(before, readings_for(before, truth.hand), icub.LEFT_EYE, icub.HAND)
    seen, thought = _marks(truth.hand.T_left_eye_hand), _marks(imagined)
    inside = eyes.in_view(np.concatenate([seen, thought], axis=1), NEAR, FAR).all(axis=1)
    pixels = eyes.project(seen)
    across, along = pixels[:, 1] - pixels[:, 3], pixels[:, 2] - pixels[:, 0]
    area = np.abs(across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0])
    size = hand_error(before, truth).position
    middling = np.abs(size - np.median(size)) < np.std(size)
    off_centre = np.linalg.norm(pixels.mean(axis=1) - eyes.CENTRE, axis=-1)
    return int(np.argmax(area / (1 + (off_centre / 50) ** 2) * (0.01 + inside) * (0.01 + middling)))


def _marks(T_left_eye_hand: Array) -> Array:
    """Landmarks in the left eye, (*batch, n_landmarks, 3) m."""
    T, marks = T_left_eye_hand, np.array(list(icub.LANDMARKS.values()))
    return np.asarray(marks @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3])


def real_view(truth: Truth, posture: int) -> tuple[Array, Array]:
    """Links (n_triangles, 3, 3) and landmarks (n, 3) as they truly are in the left eye."""
    robot = real_icub(truth.settings, truth.hand.joints)
    q = truth.hand.q[posture]
    poses = robot.poses(q, icub.LEFT_EYE, [*SHOWN, *icub.LANDMARKS])[0]
    return _placed(poses[: len(SHOWN)]), poses[len(SHOWN) :, :3, 3]


def imagined_view(body: Body, truth: Truth, posture: int) -> tuple[Array, Array]:
    """The same as the body imagines them."""
    q = readings_for(body, truth.hand)[posture]
    poses = np.array([relative_pose(body, q, icub.LEFT_EYE, link) for link in SHOWN])
    return _placed(poses), _marks(poses[SHOWN.index(icub.HAND)])


def _placed(poses: Array) -> Array:
    """Triangles of the drawn links at their poses in the eye, (n, 3, 3) m."""
    visuals = {visual.frame: visual for visual in icub.bare_icub().visuals}
    parts = []
    for link, T_eye_link in zip(SHOWN, poses, strict=True):
        T = T_eye_link @ visuals[link].placement
        corners = read_stl(visuals[link].mesh) * visuals[link].size
        parts.append(corners @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(parts)


def _draw_view(axes: Any, real: tuple[Array, Array], imagined: tuple[Array, Array], c: str) -> None:
    """One camera image: the real arm in grey, the imagined one in colour, marks joined."""
    extent = (-0.5, eyes.WIDTH - 0.5, eyes.HEIGHT - 0.5, -0.5)
    nearness, shade = render(real[0])
    grey = np.full((*shade.shape, 4), 0.0)
    grey[..., :3] = (0.25 + 0.6 * shade)[..., None]
    grey[..., 3] = nearness > 0
    axes.set_facecolor(SCENE)
    axes.imshow(grey, extent=extent, interpolation="antialiased", zorder=1)
    mask = binary_fill_holes(render(imagined[0])[0] > 0).astype(np.float64)
    u = (np.arange(mask.shape[1]) + 0.5) / SCALE - 0.5
    v = (np.arange(mask.shape[0]) + 0.5) / SCALE - 0.5
    axes.contourf(u, v, mask, levels=[0.5, 2], colors=[c], alpha=0.25, zorder=2)
    axes.contour(u, v, mask, levels=[0.5], colors=[c], linewidths=1.8, zorder=3)
    true, thought = eyes.project(real[1]), eyes.project(imagined[1])
    for start, end in zip(true, thought, strict=True):
        axes.plot(*np.transpose([start, end]), color=INK, lw=1.2, zorder=4)
    axes.scatter(*true.T, s=46, color=INK, edgecolor="white", linewidth=1.0, zorder=5)
    axes.scatter(*thought.T, s=46, color="white", edgecolor=c, linewidth=2.0, zorder=6)
    axes.set(xlim=extent[:2], ylim=extent[2:], xticks=[], yticks=[], aspect="equal")
    for spine in axes.spines.values():
        spine.set(color="#c9c5bc", linewidth=1.0)


def _draw_errors(axes: Any, errors: tuple[HandErrors, HandErrors], posture: int) -> None:
    """Error of each test posture, sorted, on a logarithmic axis."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    n = len(errors[0].position)
    share = 100 * (np.arange(n) + 0.5) / n
    for error, colour, word in zip(errors, (BEFORE, AFTER), ("before", "after"), strict=True):
        # A body that is exactly right would fall off a logarithmic axis.
        value = np.maximum(1000 * np.sort(error.position), 1e-3)
        axes.plot(share, value, color=colour, lw=2.6, solid_capstyle="round")
        text = f"{word}: {_length(error.position.mean())} on average"
        axes.annotate(
            text, (99, value[-1]), xytext=(0, 9), textcoords="offset points", ha="right",
            color=colour, fontsize=12, fontweight="bold",
        )  # fmt: skip
        rank = int(np.searchsorted(np.sort(error.position), error.position[posture]))
        axes.plot(share[rank], value[rank], "o", ms=8, mfc="white", mec=colour, mew=2)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set(ylim=(low / 1.3, high * 2.5), xlim=(0, 100), xticks=[0, 25, 50, 75, 100])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} mm"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} %"))
    axes.set_title("hand error", color=INK, fontsize=14, fontweight="bold", loc="left")
    axes.set_xlabel(f"share of {n} unseen postures with less error", color=INK, fontsize=10)
    axes.tick_params(which="both", colors=INK, labelsize=10, length=0)
    axes.grid(color="#e4e1da", linewidth=0.8)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _write_legend(figure: Any, truth: Truth) -> None:
    """Headline and, in the colours that it explains, the legend below it."""
    figure.text(
        0.012, 0.925, "The robot looks at its right hand", fontsize=20, fontweight="bold", color=INK
    )
    legend = [
        ("grey: what the left eye truly sees", GREY),
        ("orange: what it expected", BEFORE),
        (
            f"green: what it expects after calibrating from {truth.settings.n_samples} postures",
            AFTER,
        ),
    ]
    left = 0.012
    for text, colour in legend:
        written = figure.text(left, 0.872, text, fontsize=12.5, color=colour)
        # Where one text ends the next begins; only the drawn text knows its width.
        left = figure.transFigure.inverted().transform(written.get_window_extent())[1, 0] + 0.014


def _length(metres: float) -> str:
    """Millimetres with two significant digits or so."""
    mm = 1000 * float(metres)
    return f"{mm:.0f} mm" if mm >= 10 else f"{mm:.1f} mm" if mm >= 1 else f"{mm:.2f} mm"
