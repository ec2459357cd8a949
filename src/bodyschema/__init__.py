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
    from bodyschema.answers.answer import Answer, load
    from bodyschema.answers.calibrate import calibrate
    from bodyschema.answers.hand_eye import learn_hand_eye
    from bodyschema.answers.payload import learn_payload
    from bodyschema.answers.skeleton import learn_skeleton
    from bodyschema.answers.touch import find_touches
    from bodyschema.attention.body_in_view import BodyInView
    from bodyschema.attention.finder import BodyFinder
    from bodyschema.attention.frames import Frame
    from bodyschema.attention.onsets import OnsetCoincidence
    from bodyschema.errors import BodyschemaError, InputError, MissingExtraError
    from bodyschema.estimation.certificate import Tolerance
    from bodyschema.estimation.determinable import determinable
    from bodyschema.estimation.estimate import Estimate
    from bodyschema.estimation.solver import Solver
    from bodyschema.learners.filter import Filter
    from bodyschema.learners.hand_eye.full_poses import HandEye, solve_hand_eye
    from bodyschema.learners.hand_eye.points import HandEyePoints
    from bodyschema.learners.hand_eye.pose_streams import JoinedStreams, join_streams
    from bodyschema.learners.hand_eye.stereo_points import Stereo, StereoPoints
    from bodyschema.learners.images.contour_tracker import ContourTracker
    from bodyschema.learners.images.doubts import Doubts
    from bodyschema.learners.images.markerless import Markerless
    from bodyschema.learners.payload.learner import LoadLearner
    from bodyschema.learners.payload.recorded import fit_payload
    from bodyschema.learners.published.linear_relation import PaperRelation
    from bodyschema.learners.published.online_gradient import OnlineGradient
    from bodyschema.learners.published.paper_payload import PaperPayload
    from bodyschema.learners.published.particle_filter import ParticleFilter
    from bodyschema.learners.skeletons.pool import Pool
    from bodyschema.learners.skeletons.replay import Replay
    from bodyschema.learners.skeletons.shortest_links import with_shortest_links
    from bodyschema.learners.smoother import Smoother
    from bodyschema.learners.touch.finder import TouchFinder
    from bodyschema.learners.touch.known_load import KnownLoad
    from bodyschema.learners.touch.search import TouchSearch
    from bodyschema.learners.watched_body import WatchedBody
    from bodyschema.learners.watched_images import WatchedImages
    from bodyschema.learners.watched_smoother import Block, WatchedSmoother
    from bodyschema.model.camera import Camera
    from bodyschema.model.inertia import Inertia
    from bodyschema.model.kinematics import frame_jacobian, relative_pose
    from bodyschema.model.parts import Part
    from bodyschema.model.solid import Solid
    from bodyschema.model.tree import Body
    from bodyschema.model.variables import (
        Variables,
        free_frame,
        free_joints,
        free_part,
        free_skeleton,
        join,
    )
    from bodyschema.monitoring.change import detect_change
    from bodyschema.monitoring.monitor import Monitor
    from bodyschema.monitoring.stream_check import check_stream
    from bodyschema.senses.images import Images
    from bodyschema.senses.points import Points
    from bodyschema.senses.poses import Poses
    from bodyschema.senses.sense import Sense
    from bodyschema.senses.touches import Touches
    from bodyschema.senses.wrench_stream import WrenchStream
    from bodyschema.senses.wrenches import Wrenches
    from bodyschema.senses.wrist_columns import WristTable
    from bodyschema.senses.wrist_declaration import WristDeclaration
    from bodyschema.senses.wrist_samples import WristSamples
    from bodyschema.sources.recording import Recording
    from bodyschema.sources.tables import open_recording
    from bodyschema.vision.corners import CornerTracker
    from bodyschema.vision.surface import Surface

_HOMES = {
    "learn_payload": "answers.payload",
    "learn_hand_eye": "answers.hand_eye",
    "find_touches": "answers.touch",
    "WristTable": "senses.wrist_columns",
    "WristDeclaration": "senses.wrist_declaration",
    "open_recording": "sources.tables",
    "Solid": "model.solid",
    "KnownLoad": "learners.touch.known_load",
    "TouchFinder": "learners.touch.finder",
    "TouchSearch": "learners.touch.search",
    "fit_payload": "learners.payload.recorded",
    "PaperPayload": "learners.published.paper_payload",
    "LoadLearner": "learners.payload.learner",
    "WrenchStream": "senses.wrench_stream",
    "WristSamples": "senses.wrist_samples",
    "Wrenches": "senses.wrenches",
    "Inertia": "model.inertia",
    "CornerTracker": "vision.corners",
    "PaperRelation": "learners.published.linear_relation",
    "Monitor": "monitoring.monitor",
    "Tolerance": "estimation.certificate",
    "WatchedBody": "learners.watched_body",
    "WatchedImages": "learners.watched_images",
    "check_stream": "monitoring.stream_check",
    "StereoPoints": "learners.hand_eye.stereo_points",
    "Stereo": "learners.hand_eye.stereo_points",
    "HandEyePoints": "learners.hand_eye.points",
    "BodyFinder": "attention.finder",
    "Frame": "attention.frames",
    "BodyInView": "attention.body_in_view",
    "OnsetCoincidence": "attention.onsets",
    "Camera": "model.camera",
    "Surface": "vision.surface",
    "Body": "model.tree",
    "Variables": "model.variables",
    "free_joints": "model.variables",
    "free_frame": "model.variables",
    "free_skeleton": "model.variables",
    "join": "model.variables",
    "BodyschemaError": "errors",
    "InputError": "errors",
    "MissingExtraError": "errors",
    "Recording": "sources.recording",
    "Images": "senses.images",
    "Points": "senses.points",
    "Poses": "senses.poses",
    "Touches": "senses.touches",
    "Estimate": "estimation.estimate",
    "Solver": "estimation.solver",
    "Filter": "learners.filter",
    "HandEye": "learners.hand_eye.full_poses",
    "solve_hand_eye": "learners.hand_eye.full_poses",
    "JoinedStreams": "learners.hand_eye.pose_streams",
    "join_streams": "learners.hand_eye.pose_streams",
    "OnlineGradient": "learners.published.online_gradient",
    "Doubts": "learners.images.doubts",
    "Markerless": "learners.images.markerless",
    "ContourTracker": "learners.images.contour_tracker",
    "ParticleFilter": "learners.published.particle_filter",
    "Pool": "learners.skeletons.pool",
    "Replay": "learners.skeletons.replay",
    "Answer": "answers.answer",
    "load": "answers.answer",
    "Sense": "senses.sense",
    "Part": "model.parts",
    "free_part": "model.variables",
    "relative_pose": "model.kinematics",
    "frame_jacobian": "model.kinematics",
    "calibrate": "answers.calibrate",
    "learn_skeleton": "answers.skeleton",
    "determinable": "estimation.determinable",
    "with_shortest_links": "learners.skeletons.shortest_links",
    "Smoother": "learners.smoother",
    "detect_change": "monitoring.change",
    "Block": "learners.watched_smoother",
    "WatchedSmoother": "learners.watched_smoother",
    "plan_poses": "acting.next_poses",
    "Aim": "acting.inverse_kinematics",
    "InverseKinematics": "acting.inverse_kinematics",
    "Robot": "acting.robot",
    "reach": "acting.reaching",
    "Servoing": "acting.servoing",
}

__all__ = [
    "Aim",
    "Answer",
    "Block",
    "Body",
    "BodyFinder",
    "BodyInView",
    "BodyschemaError",
    "Camera",
    "ContourTracker",
    "CornerTracker",
    "Doubts",
    "Estimate",
    "Filter",
    "Frame",
    "HandEye",
    "HandEyePoints",
    "Images",
    "Inertia",
    "InputError",
    "InverseKinematics",
    "JoinedStreams",
    "KnownLoad",
    "LoadLearner",
    "Markerless",
    "MissingExtraError",
    "Monitor",
    "OnlineGradient",
    "OnsetCoincidence",
    "PaperPayload",
    "PaperRelation",
    "Part",
    "ParticleFilter",
    "Points",
    "Pool",
    "Poses",
    "Recording",
    "Replay",
    "Robot",
    "Sense",
    "Servoing",
    "Smoother",
    "Solid",
    "Solver",
    "Stereo",
    "StereoPoints",
    "Surface",
    "Tolerance",
    "TouchFinder",
    "TouchSearch",
    "Touches",
    "Variables",
    "WatchedBody",
    "WatchedImages",
    "WatchedSmoother",
    "WrenchStream",
    "Wrenches",
    "WristDeclaration",
    "WristSamples",
    "WristTable",
    "calibrate",
    "check_stream",
    "detect_change",
    "determinable",
    "find_touches",
    "fit_payload",
    "frame_jacobian",
    "free_frame",
    "free_joints",
    "free_part",
    "free_skeleton",
    "join",
    "join_streams",
    "learn_hand_eye",
    "learn_payload",
    "learn_skeleton",
    "load",
    "open_recording",
    "plan_poses",
    "reach",
    "relative_pose",
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
