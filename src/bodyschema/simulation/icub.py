"""The iCub as it believes itself to be: its URDF, two cameras in the head, four marks on a hand.

The model iCubGazeboV2_7 has no eye joints and a hand in one piece; the eyes are therefore two
cameras fixed to the head link, and what is seen of the hand are four points of its mesh.

In the head link x points to the robot's left, y up and z forward (read from the mesh of the face,
whose nose is at +z). An optical frame has x right, y down and z forward, hence the base rotation
diag(-1, -1, 1); then the eye looks down by EYE_TILT and inward by EYE_TOE_IN, so that the two
axes meet 39 cm before the face, where the hand works.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import MissingExtraError
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

MODEL = "iCubGazeboV2_7"

TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
NECK = ("neck_pitch", "neck_roll", "neck_yaw")
RIGHT_ARM = (
    "r_shoulder_pitch",
    "r_shoulder_roll",
    "r_shoulder_yaw",
    "r_elbow",
    "r_wrist_prosup",
    "r_wrist_pitch",
    "r_wrist_yaw",
)
LEFT_ARM = tuple(name.replace("r_", "l_", 1) for name in RIGHT_ARM)
"""With the same readings as the right arm it stands as in a mirror."""
MOVED = (*TORSO, *NECK, *RIGHT_ARM)
"""The joints that a recording moves; all others stand still."""

HEAD, HAND, LEFT_HAND = "head", "r_hand", "l_hand"
LEFT_EYE, RIGHT_EYE = "left_eye", "right_eye"

BASELINE = 0.068
"""m between the eyes (Vicente, Jamone, Bernardino 2016)."""
EYE_HEIGHT, EYE_DEPTH = 0.1075, 0.066
"""m up and forward in the head link: the eyeballs of the face mesh."""
EYE_TILT, EYE_TOE_IN = np.deg2rad(15.0), np.deg2rad(5.0)
"""rad down and inward."""

LANDMARKS = {
    "hand_1": (-0.0530, -0.0105, 0.1090),  # tip of the thumb
    "hand_2": (-0.1360, 0.0060, 0.0660),  # tip of the index finger
    "hand_3": (-0.1390, 0.0045, 0.0055),  # tip of the little finger
    "hand_4": (-0.0240, 0.0100, -0.0220),  # outer edge of the wrist
}
"""m in the hand link, on the outline of its mesh, so that they show from either side."""


def urdf_path() -> Path:
    """The URDF of the iCub that comes with the package icub-models."""
    try:
        import icub_models
    except ImportError:
        raise MissingExtraError("icub_models", "sim", "the simulated iCub") from None
    return Path(icub_models.get_model_file(MODEL))


def bare_icub() -> Body:
    """The body of the URDF alone, without eyes and marks."""
    return Body.from_urdf(urdf_path())


def nominal_icub() -> Body:
    """What the robot believes: its URDF, both eyes where they should be, the marks on the hand."""
    body = bare_icub()
    for frame, (parent, placement) in nominal_frames().items():
        body = body.attach(frame, parent, placement)
    return body


def nominal_frames() -> dict[str, tuple[str, Array]]:
    """Parent and (4, 4) T_parent_frame of the frames that the URDF does not have."""
    frames = {eye: (HEAD, eye_mounting(eye)) for eye in (LEFT_EYE, RIGHT_EYE)}
    marks = {name: (HAND, lie.transform(np.eye(3), at)) for name, at in LANDMARKS.items()}
    return frames | marks


def eye_mounting(eye: str) -> Array:
    """(4, 4) T_head_eye as designed; the optical frame of LEFT_EYE or RIGHT_EYE."""
    side = 1.0 if eye == LEFT_EYE else -1.0
    down = lie.exp_so3([-EYE_TILT, 0.0, 0.0])
    inward = lie.exp_so3([0.0, side * EYE_TOE_IN, 0.0])
    rotation = np.diag([-1.0, -1.0, 1.0]) @ down @ inward
    return lie.transform(rotation, [side * BASELINE / 2, EYE_HEIGHT, EYE_DEPTH])
