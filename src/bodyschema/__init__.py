"""bodyschema keeps a robot's model of its own body true while the robot works."""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

# One BLAS thread a process: threading slows the small matrices of kinematics many times over.
# Only what the user has not chosen is set, and only numpy's later import heeds it.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

if TYPE_CHECKING:
    from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics
    from bodyschema.acting.next_poses import plan_poses
    from bodyschema.acting.reaching import reach
    from bodyschema.acting.robot import Robot
    from bodyschema.acting.servoing import Servoing
    from bodyschema.attention.body_in_view import BodyInView
    from bodyschema.attention.corners import CornerTracker
    from bodyschema.attention.finder import BodyFinder
    from bodyschema.attention.onsets import OnsetCoincidence
    from bodyschema.body.camera import Camera
    from bodyschema.body.inertia import Inertia
    from bodyschema.body.parameters import (
        Parameters,
        free_frame,
        free_joints,
        free_skeleton,
        join,
    )
    from bodyschema.body.solid import Solid
    from bodyschema.body.tree import Body
    from bodyschema.errors import BodyschemaError, InputError, MissingExtraError
    from bodyschema.imagination.surface import Surface
    from bodyschema.learning.batch import LevenbergMarquardt
    from bodyschema.learning.calibrate import calibrate
    from bodyschema.learning.calibration import Calibration
    from bodyschema.learning.determinable import determinable
    from bodyschema.learning.estimate import Estimate
    from bodyschema.learning.gauss_newton import GaussNewton
    from bodyschema.learning.hand_eye.full_poses import HandEye, solve_hand_eye
    from bodyschema.learning.hand_eye.points import HandEyePoints
    from bodyschema.learning.hand_eye.pose_streams import JoinedStreams, join_streams
    from bodyschema.learning.hand_eye.stereo_points import Stereo, StereoPoints
    from bodyschema.learning.images.contour_tracker import ContourTracker
    from bodyschema.learning.images.doubts import Doubts
    from bodyschema.learning.images.markerless import Markerless
    from bodyschema.learning.images.particle_filter import ParticleFilter
    from bodyschema.learning.linear_relation import PaperRelation
    from bodyschema.learning.payload.learner import LoadLearner
    from bodyschema.learning.payload.paper_form import PaperPayload
    from bodyschema.learning.payload.recorded import fit_payload
    from bodyschema.learning.skeletons.online_gradient import OnlineGradient
    from bodyschema.learning.skeletons.pool import Pool
    from bodyschema.learning.skeletons.problem import learn_skeleton
    from bodyschema.learning.skeletons.replay import Replay
    from bodyschema.learning.skeletons.shortest_links import with_shortest_links
    from bodyschema.learning.smoother import Smoother
    from bodyschema.learning.touch.finder import TouchFinder
    from bodyschema.learning.touch.known_load import KnownLoad
    from bodyschema.learning.touch.search import TouchSearch
    from bodyschema.learning.watched_body import WatchedBody
    from bodyschema.learning.watched_images import WatchedImages
    from bodyschema.monitoring.change import detect_change
    from bodyschema.monitoring.held_load import LoadWatch
    from bodyschema.monitoring.innovations import Candidate
    from bodyschema.monitoring.link_change import LinkMonitor
    from bodyschema.monitoring.machine import Machine
    from bodyschema.monitoring.stream_check import check_stream
    from bodyschema.recording.recording import Recording
    from bodyschema.senses.images import Images
    from bodyschema.senses.points import Points
    from bodyschema.senses.poses import Poses
    from bodyschema.senses.touches import Touches
    from bodyschema.senses.wrench_stream import WrenchStream
    from bodyschema.senses.wrenches import Wrenches
    from bodyschema.senses.wrist_samples import WristSamples

_HOMES = {
    "Solid": "body.solid",
    "KnownLoad": "learning.touch.known_load",
    "TouchFinder": "learning.touch.finder",
    "TouchSearch": "learning.touch.search",
    "fit_payload": "learning.payload.recorded",
    "PaperPayload": "learning.payload.paper_form",
    "LoadWatch": "monitoring.held_load",
    "LoadLearner": "learning.payload.learner",
    "WrenchStream": "senses.wrench_stream",
    "WristSamples": "senses.wrist_samples",
    "Wrenches": "senses.wrenches",
    "Inertia": "body.inertia",
    "CornerTracker": "attention.corners",
    "PaperRelation": "learning.linear_relation",
    "Machine": "monitoring.machine",
    "WatchedBody": "learning.watched_body",
    "WatchedImages": "learning.watched_images",
    "check_stream": "monitoring.stream_check",
    "StereoPoints": "learning.hand_eye.stereo_points",
    "Stereo": "learning.hand_eye.stereo_points",
    "HandEyePoints": "learning.hand_eye.points",
    "BodyFinder": "attention.finder",
    "BodyInView": "attention.body_in_view",
    "OnsetCoincidence": "attention.onsets",
    "Camera": "body.camera",
    "Surface": "imagination.surface",
    "Body": "body.tree",
    "Parameters": "body.parameters",
    "free_joints": "body.parameters",
    "free_frame": "body.parameters",
    "free_skeleton": "body.parameters",
    "join": "body.parameters",
    "BodyschemaError": "errors",
    "InputError": "errors",
    "MissingExtraError": "errors",
    "Recording": "recording.recording",
    "Images": "senses.images",
    "Points": "senses.points",
    "Poses": "senses.poses",
    "Touches": "senses.touches",
    "Estimate": "learning.estimate",
    "LevenbergMarquardt": "learning.batch",
    "GaussNewton": "learning.gauss_newton",
    "HandEye": "learning.hand_eye.full_poses",
    "solve_hand_eye": "learning.hand_eye.full_poses",
    "JoinedStreams": "learning.hand_eye.pose_streams",
    "join_streams": "learning.hand_eye.pose_streams",
    "OnlineGradient": "learning.skeletons.online_gradient",
    "Doubts": "learning.images.doubts",
    "Markerless": "learning.images.markerless",
    "ContourTracker": "learning.images.contour_tracker",
    "ParticleFilter": "learning.images.particle_filter",
    "Pool": "learning.skeletons.pool",
    "Replay": "learning.skeletons.replay",
    "Calibration": "learning.calibration",
    "calibrate": "learning.calibrate",
    "learn_skeleton": "learning.skeletons.problem",
    "determinable": "learning.determinable",
    "with_shortest_links": "learning.skeletons.shortest_links",
    "Smoother": "learning.smoother",
    "detect_change": "monitoring.change",
    "Candidate": "monitoring.innovations",
    "LinkMonitor": "monitoring.link_change",
    "plan_poses": "acting.next_poses",
    "Aim": "acting.inverse_kinematics",
    "InverseKinematics": "acting.inverse_kinematics",
    "Robot": "acting.robot",
    "reach": "acting.reaching",
    "Servoing": "acting.servoing",
}

__all__ = [
    "Aim",
    "Body",
    "BodyFinder",
    "BodyInView",
    "BodyschemaError",
    "Calibration",
    "Camera",
    "Candidate",
    "ContourTracker",
    "CornerTracker",
    "Doubts",
    "Estimate",
    "GaussNewton",
    "HandEye",
    "HandEyePoints",
    "Images",
    "Inertia",
    "InputError",
    "InverseKinematics",
    "JoinedStreams",
    "KnownLoad",
    "LevenbergMarquardt",
    "LinkMonitor",
    "LoadLearner",
    "LoadWatch",
    "Machine",
    "Markerless",
    "MissingExtraError",
    "OnlineGradient",
    "OnsetCoincidence",
    "PaperPayload",
    "PaperRelation",
    "Parameters",
    "ParticleFilter",
    "Points",
    "Pool",
    "Poses",
    "Recording",
    "Replay",
    "Robot",
    "Servoing",
    "Smoother",
    "Solid",
    "Stereo",
    "StereoPoints",
    "Surface",
    "TouchFinder",
    "TouchSearch",
    "Touches",
    "WatchedBody",
    "WatchedImages",
    "WrenchStream",
    "Wrenches",
    "WristSamples",
    "calibrate",
    "check_stream",
    "detect_change",
    "determinable",
    "fit_payload",
    "free_frame",
    "free_joints",
    "free_skeleton",
    "join",
    "join_streams",
    "learn_skeleton",
    "plan_poses",
    "reach",
    "solve_hand_eye",
    "with_shortest_links",
]


def __getattr__(name: str) -> Any:
    """Load a public name at its first use, so that importing the package stays quick."""
    if name not in _HOMES:
        raise AttributeError(f"module 'bodyschema' has no attribute '{name}'")
    return getattr(importlib.import_module(f"bodyschema.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
