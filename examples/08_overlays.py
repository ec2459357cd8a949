"""How a robot imagines that it looks, scored against an image and drawn over it.

Without folders it looks at an iCub whose image it makes up. With them it also draws over images of
the recordings that DATA has: red before the joints are corrected, green after; see docs/gallery.md.

python examples/08_overlays.py [PICTURES DATA]    needs the extras sim and vision
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

import bodyschema as bs
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.simulation import icub
from bodyschema.vision.contours import fit_contours, silhouette
from bodyschema.vision.observed import ObservedMask
from bodyschema.vision.overlay import overlay, save_png
from bodyschema.vision.poses import piece_poses

POSTURE = (-40, 25, 10, 70, -20, 0, 0, -25, 0, -15)  # deg, of the arm and of the neck
WRONG = (0, 4, -3, 5, -4, 5, 0)  # deg, added to the joints of the KUKA arm
PINHOLE = np.array([[257.34, 0, 159.5], [0, 257.34, 119.5], [0, 0, 1.0]])


def imagined_icub() -> None:
    """Each joint of the arm 3 deg wrong: what that does to the overlap and to the contour."""
    body, eye = icub.nominal_icub(), bs.Camera("eye", icub.LEFT_EYE, 320, 240, PINHOLE)
    hand = bs.Surface.of(body, ["r_forearm", "r_hand"], {"r_forearm": 600})
    posture = dict(zip((*icub.RIGHT_ARM, *icub.NECK), POSTURE, strict=True))
    q = np.deg2rad([posture.get(joint, 0) for joint in body.joints])
    wrong = [q + np.deg2rad(3) * (np.array(body.joints) == joint) for joint in icub.RIGHT_ARM]
    T = piece_poses(body, [q, *wrong], [eye], hand.frames)
    fit = fit_contours(hand, T, [eye], [ObservedMask.of(silhouette(hand, T[0, 0], eye))])
    print(f"{'3 deg wrong':>20} {'overlap':>10} {'chamfer, px':>12}")
    for row in zip(["nothing", *icub.RIGHT_ARM], fit.jaccard[:, 0], fit.chamfer[:, 0], strict=True):
        print("{:>20} {:10.3f} {:12.2f}".format(*row))


def show(to: Path, seen: list[Path], eye: bs.Camera, skin: bs.Surface, T: np.ndarray) -> None:
    """Draw two bodies, before and after, over an image; its mask tells how well they fit."""
    import cv2  # of the extra vision

    image, mask = cv2.imread(str(seen[0]))[..., ::-1], cv2.imread(str(seen[1]), 0)
    fit = fit_contours(skin, T, [eye], [ObservedMask.of(mask)])
    print("{}: overlap with the mask {:.3f} -> {:.3f}".format(to.stem, *fit.jaccard[:, 0]))
    save_png(overlay(image, eye, skin, T[:, 0], magnify=1800 // eye.width), to)


def med7(data: Path, pictures: Path) -> None:
    """A real KUKA arm in five postures; before: WRONG is added to its joints."""
    body, folder = bs.Body.from_urdf(data / "lbr_med7_r800.urdf"), data / "stereo"
    optical = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
    body = body.attach("left", "lbr_link_0", np.load(folder / "HT_left_dr.npy") @ optical)
    K = np.array([[534.6265, 0, 478.0846], [0, 534.6265, 260.9944], [0, 0, 1]])
    camera, arm = bs.Camera("left", "left", 960, 540, K), bs.Surface.of(body, faces=1500)
    for i in range(5):
        q = np.load(folder / f"joint_states_{i}.npy")
        T = piece_poses(body, q + np.deg2rad([WRONG, np.zeros(7)]), [camera], arm.frames)
        seen = [folder / f"{kind}left_image_{i}.png" for kind in ("", "mask_sam2_")]
        show(pictures / f"med7_{i}.png", seen, camera, arm, T)


def vislab(data: Path, pictures: Path) -> None:
    """The iCub simulator of Vicente et al. 2016; before: its encoders as they are."""
    nodes = json.loads((data / "model/model.json").read_text())["nodes"]
    name, turns = [str(n["id"]) for n in nodes], [n["rotation"] for n in nodes]
    parent, local = [n["parent"] for n in nodes], np.array([n["local"] for n in nodes])
    size = {-1: 1.0}  # the nodes change the scale; a body does not, so the meshes take it
    for i, (k, T) in enumerate(zip(parent, local, strict=True)):
        size[i] = size[k] * np.cbrt(np.linalg.det(T[:3, :3]))
        T[:3, :3], T[:3, 3] = T[:3, :3] * size[k] / size[i], T[:3, 3] * size[k]
    axes = [r["sign"] * np.eye(3)["xyz".index(r["axis"])] if r else (0, 0, 1) for r in turns]
    kinds = [REVOLUTE if r else FIXED for r in turns]
    body = bs.Body.build("icub_sim", name, name, parent, kinds, axes, local)
    body = body.attach("left", "36", np.diag([-1.0, -1.0, 1.0, 1.0]))  # node LeftEyeCam
    camera, shape = bs.Camera("left", "left", 320, 240, PINHOLE), np.load(data / "model/meshes.npz")
    skin = [(k, n) for k, n in enumerate(shape["node"]) if nodes[n]["in_right_arm"]]
    skins = {str(n): (size[n] * shape[f"V{k}"], shape[f"F{k}"]) for k, n in skin}
    surface = bs.Surface.build(skins)
    table = np.genfromtxt(data / "frames.csv", delimiter=",", skip_header=1)[:, 4:]
    offset = np.array([9.97, 10.54, -7.32, 7.1, 0.75, 21.3, -7.7, *np.zeros(15)])
    column = [r["index"] + 16 * (r["source"] == "head") for r in turns if r]
    gain, zero = np.array([(r["gain"], r["zero_deg"]) for r in turns if r]).T
    for i in (0, 40, 80, 120):
        angles = np.append(table[i], [-10, 0, 0, -10, 0, 0])  # of arm and head
        q = np.deg2rad(gain * (np.array([angles, angles + offset])[:, column] - zero))
        T = piece_poses(body, q, [camera], surface.frames)
        seen = [data / f"{kind}/left_{i:03}.png" for kind in ("img", "mask")]
        show(pictures / f"vislab_{i:03}.png", seen, camera, surface, T)


imagined_icub()
for draw, name in ((med7, "roboreg_med7_zed2i"), (vislab, "vislab_icub_sim")):
    if len(sys.argv) > 2 and (Path(sys.argv[2]) / name).is_dir():
        draw(Path(sys.argv[2]) / name, Path(sys.argv[1]))
