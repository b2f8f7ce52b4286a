"""Surefoot: a biped that keeps walking when it is pushed.

Names are loaded when they are first used, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from surefoot import errors, version

if TYPE_CHECKING:
    from surefoot.control.ankle_hip_step_mpc import AnkleHipStepMpc
    from surefoot.control.body_control import BodyControl
    from surefoot.control.body_gait import body_control, body_controller, walking_robot
    from surefoot.control.capture_point import CapturePointStepping
    from surefoot.control.dcm_tracking import DcmTracking
    from surefoot.control.foot_placement_mpc import FootPlacementMpc
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.control.hybrid import HybridController
    from surefoot.control.inverse_dynamics import InverseDynamics
    from surefoot.control.linear_mpc import LinearMpc
    from surefoot.control.preview_control import PreviewControl
    from surefoot.control.settings import load_settings
    from surefoot.control.step_timing import StepTiming
    from surefoot.control.timing_nlp import TimingNlp
    from surefoot.control.unified import UnifiedController
    from surefoot.errors import (
        FileError,
        MissingExtraError,
        ParameterError,
        RobotError,
        StudyError,
        SurefootError,
        VelocityError,
    )
    from surefoot.models.body_state import BodyEstimator
    from surefoot.models.estimator import Estimator
    from surefoot.models.footholds import Foothold, FootholdError, load_footholds
    from surefoot.models.footsteps import Footstep, Side
    from surefoot.models.interfaces import Command, Controller, Mode, Observation, Status
    from surefoot.models.multibody import Multibody, load_multibody
    from surefoot.models.pushes import Push
    from surefoot.models.robot import Foot, Robot, Swing, Trunk, load_robot, preset_names
    from surefoot.models.steering import Steering
    from surefoot.models.viability import ViableOffsets, viable_offsets
    from surefoot.planning.causal_limit import causal_push_limit
    from surefoot.planning.landing_problem import Decision, Limit
    from surefoot.planning.nominal_gait import NominalGait, largest_speed, nominal_gait
    from surefoot.planning.optimality import KktResidual, kkt_residual
    from surefoot.planning.push_limit import ImpulseLimit, fixed_steps_limit, push_limit
    from surefoot.planning.step_adaptation import solve_step
    from surefoot.planning.step_problem import StepProblem, StepSolution
    from surefoot.simulation.batch import simulate_batch
    from surefoot.simulation.body_fall import BodyFall
    from surefoot.simulation.body_measures import BodyMeasures, measure_body
    from surefoot.simulation.body_noise import BodyNoise
    from surefoot.simulation.body_plant import Surroundings
    from surefoot.simulation.body_simulate import simulate_body
    from surefoot.simulation.body_trace import BodyTrace
    from surefoot.simulation.decisions import decisions
    from surefoot.simulation.disturbance import Disturbance
    from surefoot.simulation.fall_signs import FallCause
    from surefoot.simulation.lipm_simulator import LipmSimulator
    from surefoot.simulation.outcome import Fall, Outcome
    from surefoot.simulation.rollout import Rollout, load_rollout
    from surefoot.simulation.simulate import simulate
    from surefoot.simulation.walks import Walks
    from surefoot.studies.push_recovery import PushLimit, smallest_failing_push
    from surefoot.viewers.body_video import film_walk

__version__ = version.VERSION

_HOMES = {
    "control.ankle_hip_step_mpc": ("AnkleHipStepMpc",),
    "control.foot_placement_mpc": ("FootPlacementMpc",),
    "control.linear_mpc": ("LinearMpc",),
    "control.body_control": ("BodyControl",),
    "control.body_gait": ("body_control", "body_controller", "walking_robot"),
    "control.capture_point": ("CapturePointStepping",),
    "control.dcm_tracking": ("DcmTracking",),
    "control.foothold_tracking": ("FootholdTracking",),
    "control.hybrid": ("HybridController",),
    "control.inverse_dynamics": ("InverseDynamics",),
    "control.preview_control": ("PreviewControl",),
    "control.settings": ("load_settings",),
    "control.step_timing": ("StepTiming",),
    "control.timing_nlp": ("TimingNlp",),
    "control.unified": ("UnifiedController",),
    "errors": (
        "FileError",
        "MissingExtraError",
        "ParameterError",
        "RobotError",
        "StudyError",
        "SurefootError",
        "VelocityError",
    ),
    "models.body_state": ("BodyEstimator",),
    "models.estimator": ("Estimator",),
    "models.footholds": ("Foothold", "FootholdError", "load_footholds"),
    "models.footsteps": ("Footstep", "Side"),
    "models.interfaces": ("Command", "Controller", "Mode", "Observation", "Status"),
    "models.multibody": ("Multibody", "load_multibody"),
    "models.pushes": ("Push",),
    "models.robot": ("Foot", "Robot", "Swing", "Trunk", "load_robot", "preset_names"),
    "models.steering": ("Steering",),
    "models.viability": ("ViableOffsets", "viable_offsets"),
    "planning.causal_limit": ("causal_push_limit",),
    "planning.landing_problem": ("Decision", "Limit"),
    "planning.nominal_gait": ("NominalGait", "largest_speed", "nominal_gait"),
    "planning.optimality": ("KktResidual", "kkt_residual"),
    "planning.push_limit": ("ImpulseLimit", "fixed_steps_limit", "push_limit"),
    "planning.step_adaptation": ("solve_step",),
    "planning.step_problem": ("StepProblem", "StepSolution"),
    "simulation.batch": ("simulate_batch",),
    "simulation.body_fall": ("BodyFall",),
    "simulation.body_measures": ("BodyMeasures", "measure_body"),
    "simulation.body_noise": ("BodyNoise",),
    "simulation.body_plant": ("Surroundings",),
    "simulation.body_simulate": ("simulate_body",),
    "simulation.body_trace": ("BodyTrace",),
    "simulation.decisions": ("decisions",),
    "simulation.disturbance": ("Disturbance",),
    "simulation.fall_signs": ("FallCause",),
    "simulation.lipm_simulator": ("LipmSimulator",),
    "simulation.outcome": ("Fall", "Outcome"),
    "simulation.rollout": ("Rollout", "load_rollout"),
    "simulation.simulate": ("simulate",),
    "simulation.walks": ("Walks",),
    "studies.push_recovery": ("PushLimit", "smallest_failing_push"),
    "viewers.body_video": ("film_walk",),
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
