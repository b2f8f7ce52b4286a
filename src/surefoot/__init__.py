"""Surefoot: a biped that keeps walking when it is pushed.

Names are loaded when they are first used, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from surefoot import errors, version

if TYPE_CHECKING:
    from surefoot.control.capture_point import CapturePointStepping
    from surefoot.control.estimator import Estimator
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.control.hybrid import HybridController
    from surefoot.control.mpc.ankle_hip import AnkleHipStepMpc
    from surefoot.control.mpc.linear import LinearMpc
    from surefoot.control.mpc.placement import FootPlacementMpc
    from surefoot.control.preview_control import PreviewControl
    from surefoot.control.settings import load_settings
    from surefoot.control.step_timing import StepTiming
    from surefoot.control.timing_nlp import TimingNlp
    from surefoot.control.tracking import DcmTracking
    from surefoot.control.unified.controller import UnifiedController
    from surefoot.control.unified.problem import Decision, Limit
    from surefoot.dcm.footholds import Foothold, FootholdError, load_footholds
    from surefoot.dcm.nominal_gait import NominalGait, largest_speed, nominal_gait
    from surefoot.dcm.optimality import KktResidual, kkt_residual
    from surefoot.dcm.push_limit import (
        ImpulseLimit,
        causal_push_limit,
        fixed_steps_limit,
        push_limit,
    )
    from surefoot.dcm.pushes import Push
    from surefoot.dcm.step_problem import StepProblem, StepSolution
    from surefoot.dcm.step_solver import solve_step
    from surefoot.dcm.viability import ViableOffsets, viable_offsets
    from surefoot.errors import (
        FileError,
        MissingExtraError,
        ParameterError,
        RobotError,
        StudyError,
        SurefootError,
        VelocityError,
    )
    from surefoot.interface import Command, Controller, Mode, Observation, Status
    from surefoot.robot.feet import Footstep, Side
    from surefoot.robot.multibody import Multibody, load_multibody
    from surefoot.robot.robot import Foot, Robot, Swing, Trunk, load_robot, preset_names
    from surefoot.rollout.decisions import decisions
    from surefoot.rollout.disturbance import Disturbance
    from surefoot.rollout.fall import BodyFall
    from surefoot.rollout.fall_signs import FallCause
    from surefoot.rollout.measures import BodyMeasures, measure_body
    from surefoot.rollout.outcome import Fall, Outcome
    from surefoot.rollout.rollout import Rollout, load_rollout
    from surefoot.rollout.trace import BodyTrace
    from surefoot.show.film import film_walk
    from surefoot.studies.engine.scan import PushLimit, smallest_failing_push
    from surefoot.worlds.body.controller import BodyControl
    from surefoot.worlds.body.estimator import BodyEstimator
    from surefoot.worlds.body.gait import body_control, body_controller, walking_robot
    from surefoot.worlds.body.inverse_dynamics import InverseDynamics
    from surefoot.worlds.body.plant import Surroundings
    from surefoot.worlds.body.sensors import BodyNoise
    from surefoot.worlds.body.world import simulate_body
    from surefoot.worlds.point.batch import simulate_batch
    from surefoot.worlds.point.plant import LipmSimulator
    from surefoot.worlds.point.simulate import simulate
    from surefoot.worlds.point.walks import Walks
    from surefoot.worlds.steering import Steering

__version__ = version.VERSION

_HOMES = {
    "control.mpc.ankle_hip": ("AnkleHipStepMpc",),
    "control.mpc.placement": ("FootPlacementMpc",),
    "control.mpc.linear": ("LinearMpc",),
    "worlds.body.controller": ("BodyControl",),
    "worlds.body.gait": ("body_control", "body_controller", "walking_robot"),
    "control.capture_point": ("CapturePointStepping",),
    "control.tracking": ("DcmTracking",),
    "control.foothold_tracking": ("FootholdTracking",),
    "control.hybrid": ("HybridController",),
    "worlds.body.inverse_dynamics": ("InverseDynamics",),
    "control.preview_control": ("PreviewControl",),
    "control.settings": ("load_settings",),
    "control.step_timing": ("StepTiming",),
    "control.timing_nlp": ("TimingNlp",),
    "control.unified.controller": ("UnifiedController",),
    "errors": (
        "FileError",
        "MissingExtraError",
        "ParameterError",
        "RobotError",
        "StudyError",
        "SurefootError",
        "VelocityError",
    ),
    "worlds.body.estimator": ("BodyEstimator",),
    "control.estimator": ("Estimator",),
    "dcm.footholds": ("Foothold", "FootholdError", "load_footholds"),
    "robot.feet": ("Footstep", "Side"),
    "interface": ("Command", "Controller", "Mode", "Observation", "Status"),
    "robot.multibody": ("Multibody", "load_multibody"),
    "dcm.pushes": ("Push",),
    "robot.robot": ("Foot", "Robot", "Swing", "Trunk", "load_robot", "preset_names"),
    "worlds.steering": ("Steering",),
    "dcm.viability": ("ViableOffsets", "viable_offsets"),
    "control.unified.problem": ("Decision", "Limit"),
    "dcm.nominal_gait": ("NominalGait", "largest_speed", "nominal_gait"),
    "dcm.optimality": ("KktResidual", "kkt_residual"),
    "dcm.push_limit": (
        "ImpulseLimit",
        "causal_push_limit",
        "fixed_steps_limit",
        "push_limit",
    ),
    "dcm.step_solver": ("solve_step",),
    "dcm.step_problem": ("StepProblem", "StepSolution"),
    "worlds.point.batch": ("simulate_batch",),
    "rollout.fall": ("BodyFall",),
    "rollout.measures": ("BodyMeasures", "measure_body"),
    "worlds.body.sensors": ("BodyNoise",),
    "worlds.body.plant": ("Surroundings",),
    "worlds.body.world": ("simulate_body",),
    "rollout.trace": ("BodyTrace",),
    "rollout.decisions": ("decisions",),
    "rollout.disturbance": ("Disturbance",),
    "rollout.fall_signs": ("FallCause",),
    "worlds.point.plant": ("LipmSimulator",),
    "rollout.outcome": ("Fall", "Outcome"),
    "rollout.rollout": ("Rollout", "load_rollout"),
    "worlds.point.simulate": ("simulate",),
    "worlds.point.walks": ("Walks",),
    "studies.engine.scan": ("PushLimit", "smallest_failing_push"),
    "show.film": ("film_walk",),
}
_EXTRAS = {
    "mujoco": ("a body in physics", "mujoco"),
    "imageio_ffmpeg": ("films", "video"),
    "matplotlib": ("films", "video"),
    "PIL": ("films", "video"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "AnkleHipStepMpc",
    "BodyControl",
    "BodyEstimator",
    "BodyFall",
    "BodyMeasures",
    "BodyNoise",
    "BodyTrace",
    "CapturePointStepping",
    "Command",
    "Controller",
    "DcmTracking",
    "Decision",
    "Disturbance",
    "Estimator",
    "Fall",
    "FallCause",
    "FileError",
    "Foot",
    "FootPlacementMpc",
    "Foothold",
    "FootholdError",
    "FootholdTracking",
    "Footstep",
    "HybridController",
    "ImpulseLimit",
    "InverseDynamics",
    "KktResidual",
    "Limit",
    "LinearMpc",
    "LipmSimulator",
    "MissingExtraError",
    "Mode",
    "Multibody",
    "NominalGait",
    "Observation",
    "Outcome",
    "ParameterError",
    "PreviewControl",
    "Push",
    "PushLimit",
    "Robot",
    "RobotError",
    "Rollout",
    "Side",
    "Status",
    "Steering",
    "StepProblem",
    "StepSolution",
    "StepTiming",
    "StudyError",
    "SurefootError",
    "Surroundings",
    "Swing",
    "TimingNlp",
    "Trunk",
    "UnifiedController",
    "VelocityError",
    "ViableOffsets",
    "Walks",
    "__version__",
    "body_control",
    "body_controller",
    "causal_push_limit",
    "decisions",
    "film_walk",
    "fixed_steps_limit",
    "kkt_residual",
    "largest_speed",
    "load_footholds",
    "load_multibody",
    "load_robot",
    "load_rollout",
    "load_settings",
    "measure_body",
    "nominal_gait",
    "preset_names",
    "push_limit",
    "simulate",
    "simulate_batch",
    "simulate_body",
    "smallest_failing_push",
    "solve_step",
    "viable_offsets",
    "walking_robot",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'surefoot' has no attribute {name!r}")
    try:
        home = import_module(f"surefoot.{_HOME_OF[name]}")
    except ModuleNotFoundError as error:
        if error.name not in _EXTRAS:
            raise
        raise errors.MissingExtraError(*_EXTRAS[error.name]) from error
    value = getattr(home, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
