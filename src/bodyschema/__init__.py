"""bodyschema keeps a robot's model of its own body true while the robot works.

Its public names come in three layers: what everybody needs, the building blocks of senses, learners
and monitors of one's own, and the published methods as printed.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bodyschema.acting.candidates import Candidates
    from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics, Reached
    from bodyschema.acting.next_poses import Plan, plan_poses
    from bodyschema.acting.reaching import reach
    from bodyschema.acting.robot import Robot
    from bodyschema.acting.servoing import Servoing, ServoStep
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
    from bodyschema.estimation.certificate import Certificate, Tolerance
    from bodyschema.estimation.clock import ClockCheck
    from bodyschema.estimation.determinable import Determinable, determinable
    from bodyschema.estimation.discrepancy import Discrepancy, Field
    from bodyschema.estimation.estimate import Estimate
    from bodyschema.estimation.held_out import Errors
    from bodyschema.estimation.identifiability import Identifiability, OpenDirection
    from bodyschema.estimation.loss import Loss
    from bodyschema.estimation.prediction import PredictedError
    from bodyschema.estimation.problem import Problem
    from bodyschema.estimation.solver import Solver
    from bodyschema.judging.accuracy import Accuracy
    from bodyschema.judging.calibration import Calibration
    from bodyschema.learners.filter import Filter
    from bodyschema.learners.hand_eye.full_poses import HandEye, solve_hand_eye
    from bodyschema.learners.hand_eye.points import HandEyePoints
    from bodyschema.learners.hand_eye.pose_streams import JoinedStreams, join_streams
    from bodyschema.learners.hand_eye.stereo_points import Stereo, StereoPoints
    from bodyschema.learners.images.contour_tracker import ContourTracker
    from bodyschema.learners.images.doubts import Doubts
    from bodyschema.learners.images.markerless import Markerless
    from bodyschema.learners.learner import Learner
    from bodyschema.learners.payload.learner import LoadLearner
    from bodyschema.learners.payload.recorded import fit_payload
    from bodyschema.learners.published.linear_relation import PaperRelation
    from bodyschema.learners.published.online_gradient import OnlineGradient
    from bodyschema.learners.published.paper_payload import PaperPayload
    from bodyschema.learners.published.particle_filter import ParticleFilter
    from bodyschema.learners.replay import Replay
    from bodyschema.learners.skeletons.pool import Pool
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
    from bodyschema.model.tree import Body, Visual
    from bodyschema.model.variables import (
        Variables,
        free_frame,
        free_joints,
        free_part,
        free_skeleton,
        join,
    )
    from bodyschema.monitoring.change import ChangeTest, detect_change
    from bodyschema.monitoring.monitor import Monitor
    from bodyschema.monitoring.moved_part import Suspect
    from bodyschema.monitoring.stream_check import Change, StreamCheck, check_stream
    from bodyschema.report.section import Section
    from bodyschema.senses.distances import Distances
    from bodyschema.senses.gravity import Gravity
    from bodyschema.senses.images import Images
    from bodyschema.senses.mean_wrenches import MeanWrenches
    from bodyschema.senses.outlines import Outlines
    from bodyschema.senses.pixels import Pixels
    from bodyschema.senses.planes import Planes
    from bodyschema.senses.points import Points
    from bodyschema.senses.poses import Poses
    from bodyschema.senses.sense import Linearized, Sense
    from bodyschema.senses.torques import Torques
    from bodyschema.senses.touches import Touches
    from bodyschema.senses.wrench_stream import WrenchStream
    from bodyschema.senses.wrenches import Wrenches
    from bodyschema.senses.wrist_columns import WristTable
    from bodyschema.senses.wrist_declaration import WristDeclaration
    from bodyschema.senses.wrist_samples import WristSamples
    from bodyschema.senses.wrist_wrenches import WristWrenches
    from bodyschema.sources.opened import open
    from bodyschema.sources.recording import Recording
    from bodyschema.sources.tables import open_recording
    from bodyschema.vision.corners import CornerTracker
    from bodyschema.vision.surface import Surface

EVERYDAY = {
    "Answer": "answers.answer",
    "Body": "model.tree",
    "BodyFinder": "attention.finder",
    "BodyschemaError": "errors",
    "Camera": "model.camera",
    "Distances": "senses.distances",
    "Gravity": "senses.gravity",
    "Images": "senses.images",
    "Inertia": "model.inertia",
    "InputError": "errors",
    "Markerless": "learners.images.markerless",
    "MissingExtraError": "errors",
    "Outlines": "senses.outlines",
    "Pixels": "senses.pixels",
    "Planes": "senses.planes",
    "Points": "senses.points",
    "Poses": "senses.poses",
    "Recording": "sources.recording",
    "Robot": "acting.robot",
    "Sense": "senses.sense",
    "Torques": "senses.torques",
    "Touches": "senses.touches",
    "WristDeclaration": "senses.wrist_declaration",
    "WristTable": "senses.wrist_columns",
    "WristWrenches": "senses.wrist_wrenches",
    "calibrate": "answers.calibrate",
    "check_stream": "monitoring.stream_check",
    "detect_change": "monitoring.change",
    "find_touches": "answers.touch",
    "free_frame": "model.variables",
    "free_joints": "model.variables",
    "free_part": "model.variables",
    "join": "model.variables",
    "join_streams": "learners.hand_eye.pose_streams",
    "learn_hand_eye": "answers.hand_eye",
    "learn_payload": "answers.payload",
    "learn_skeleton": "answers.skeleton",
    "load": "answers.answer",
    "open": "sources.opened",
    "open_recording": "sources.tables",
    "plan_poses": "acting.next_poses",
    "reach": "acting.reaching",
    "relative_pose": "model.kinematics",
    "solve_hand_eye": "learners.hand_eye.full_poses",
}
"""What a calibration, a check, a plan and an answer need."""

BUILDING_BLOCKS = {
    "Accuracy": "judging.accuracy",
    "Aim": "acting.inverse_kinematics",
    "Block": "learners.watched_smoother",
    "BodyInView": "attention.body_in_view",
    "Calibration": "judging.calibration",
    "Candidates": "acting.candidates",
    "Certificate": "estimation.certificate",
    "Change": "monitoring.stream_check",
    "ChangeTest": "monitoring.change",
    "ClockCheck": "estimation.clock",
    "ContourTracker": "learners.images.contour_tracker",
    "CornerTracker": "vision.corners",
    "Determinable": "estimation.determinable",
    "Discrepancy": "estimation.discrepancy",
    "Doubts": "learners.images.doubts",
    "Errors": "estimation.held_out",
    "Estimate": "estimation.estimate",
    "Field": "estimation.discrepancy",
    "Filter": "learners.filter",
    "Frame": "attention.frames",
    "HandEye": "learners.hand_eye.full_poses",
    "HandEyePoints": "learners.hand_eye.points",
    "Identifiability": "estimation.identifiability",
    "InverseKinematics": "acting.inverse_kinematics",
    "JoinedStreams": "learners.hand_eye.pose_streams",
    "KnownLoad": "learners.touch.known_load",
    "Learner": "learners.learner",
    "Linearized": "senses.sense",
    "LoadLearner": "learners.payload.learner",
    "Loss": "estimation.loss",
    "MeanWrenches": "senses.mean_wrenches",
    "Monitor": "monitoring.monitor",
    "OpenDirection": "estimation.identifiability",
    "Part": "model.parts",
    "Plan": "acting.next_poses",
    "Pool": "learners.skeletons.pool",
    "PredictedError": "estimation.prediction",
    "Problem": "estimation.problem",
    "Reached": "acting.inverse_kinematics",
    "Section": "report.section",
    "ServoStep": "acting.servoing",
    "Servoing": "acting.servoing",
    "Smoother": "learners.smoother",
    "Solid": "model.solid",
    "Solver": "estimation.solver",
    "Stereo": "learners.hand_eye.stereo_points",
    "StereoPoints": "learners.hand_eye.stereo_points",
    "StreamCheck": "monitoring.stream_check",
    "Surface": "vision.surface",
    "Suspect": "monitoring.moved_part",
    "Tolerance": "estimation.certificate",
    "TouchFinder": "learners.touch.finder",
    "TouchSearch": "learners.touch.search",
    "Variables": "model.variables",
    "Visual": "model.tree",
    "WatchedBody": "learners.watched_body",
    "WatchedImages": "learners.watched_images",
    "WatchedSmoother": "learners.watched_smoother",
    "WrenchStream": "senses.wrench_stream",
    "Wrenches": "senses.wrenches",
    "WristSamples": "senses.wrist_samples",
    "determinable": "estimation.determinable",
    "fit_payload": "learners.payload.recorded",
    "frame_jacobian": "model.kinematics",
    "free_skeleton": "model.variables",
    "with_shortest_links": "learners.skeletons.shortest_links",
}
"""For senses, learners and monitors of one's own, and the types that answers are made of."""

PUBLISHED = {
    "OnlineGradient": "learners.published.online_gradient",
    "OnsetCoincidence": "attention.onsets",
    "PaperPayload": "learners.published.paper_payload",
    "PaperRelation": "learners.published.linear_relation",
    "ParticleFilter": "learners.published.particle_filter",
    "Replay": "learners.replay",
}
"""Published methods, each as printed."""

_HOMES = {**EVERYDAY, **BUILDING_BLOCKS, **PUBLISHED}

__all__ = [
    "Accuracy",
    "Aim",
    "Answer",
    "Block",
    "Body",
    "BodyFinder",
    "BodyInView",
    "BodyschemaError",
    "Calibration",
    "Camera",
    "Candidates",
    "Certificate",
    "Change",
    "ChangeTest",
    "ClockCheck",
    "ContourTracker",
    "CornerTracker",
    "Determinable",
    "Discrepancy",
    "Distances",
    "Doubts",
    "Errors",
    "Estimate",
    "Field",
    "Filter",
    "Frame",
    "Gravity",
    "HandEye",
    "HandEyePoints",
    "Identifiability",
    "Images",
    "Inertia",
    "InputError",
    "InverseKinematics",
    "JoinedStreams",
    "KnownLoad",
    "Learner",
    "Linearized",
    "LoadLearner",
    "Loss",
    "Markerless",
    "MeanWrenches",
    "MissingExtraError",
    "Monitor",
    "OnlineGradient",
    "OnsetCoincidence",
    "OpenDirection",
    "Outlines",
    "PaperPayload",
    "PaperRelation",
    "Part",
    "ParticleFilter",
    "Pixels",
    "Plan",
    "Planes",
    "Points",
    "Pool",
    "Poses",
    "PredictedError",
    "Problem",
    "Reached",
    "Recording",
    "Replay",
    "Robot",
    "Section",
    "Sense",
    "ServoStep",
    "Servoing",
    "Smoother",
    "Solid",
    "Solver",
    "Stereo",
    "StereoPoints",
    "StreamCheck",
    "Surface",
    "Suspect",
    "Tolerance",
    "Torques",
    "TouchFinder",
    "TouchSearch",
    "Touches",
    "Variables",
    "Visual",
    "WatchedBody",
    "WatchedImages",
    "WatchedSmoother",
    "WrenchStream",
    "Wrenches",
    "WristDeclaration",
    "WristSamples",
    "WristTable",
    "WristWrenches",
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
    "open",
    "open_recording",
    "plan_poses",
    "reach",
    "relative_pose",
    "solve_hand_eye",
    "with_shortest_links",
]


def __getattr__(name: str) -> Any:
    """Load a public name at its first use, so that importing the package stays quick."""
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version("bodyschema")
    if name not in _HOMES:
        raise AttributeError(f"module 'bodyschema' has no attribute '{name}'")
    return getattr(importlib.import_module(f"bodyschema.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
