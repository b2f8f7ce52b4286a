"""Surefoot: a biped that keeps walking when it is pushed.

Names are loaded when they are first used, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from surefoot import version

if TYPE_CHECKING:
    from surefoot.control.ankle_hip_step_mpc import AnkleHipStepMpc
    from surefoot.control.capture_point import CapturePointStepping
    from surefoot.control.dcm_tracking import DcmTracking
    from surefoot.control.foot_placement_mpc import FootPlacementMpc
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.control.hybrid import HybridController
    from surefoot.control.linear_mpc import LinearMpc
    from surefoot.control.preview_control import PreviewControl
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
    from surefoot.models.estimator import Estimator
    from surefoot.models.footholds import Foothold, FootholdError, load_footholds
    from surefoot.models.footsteps import Footstep, Side
    from surefoot.models.interfaces import Command, Controller, Mode, Observation, Status
    from surefoot.models.pushes import Push
    from surefoot.models.robot import Foot, Robot, Swing, Trunk, load_robot, preset_names
    from surefoot.models.viability import ViableOffsets, viable_offsets
    from surefoot.planning.landing_problem import Decision, Limit
    from surefoot.planning.nominal_gait import NominalGait, largest_speed, nominal_gait
    from surefoot.planning.optimality import KktResidual, kkt_residual
    from surefoot.planning.push_limit import ImpulseLimit, fixed_steps_limit, push_limit
    from surefoot.planning.step_adaptation import solve_step
    from surefoot.planning.step_problem import StepProblem, StepSolution
    from surefoot.simulation.decisions import decisions
    from surefoot.simulation.disturbance import Disturbance
    from surefoot.simulation.lipm_simulator import LipmSimulator
    from surefoot.simulation.outcome import Fall, Outcome
    from surefoot.simulation.rollout import Rollout, load_rollout
    from surefoot.simulation.simulate import simulate
    from surefoot.studies.push_recovery import PushLimit, smallest_failing_push

__version__ = version.VERSION

_HOMES = {
    "control.ankle_hip_step_mpc": ("AnkleHipStepMpc",),
    "control.foot_placement_mpc": ("FootPlacementMpc",),
    "control.linear_mpc": ("LinearMpc",),
    "control.capture_point": ("CapturePointStepping",),
    "control.dcm_tracking": ("DcmTracking",),
    "control.foothold_tracking": ("FootholdTracking",),
    "control.hybrid": ("HybridController",),
    "control.preview_control": ("PreviewControl",),
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
    "models.estimator": ("Estimator",),
    "models.footholds": ("Foothold", "FootholdError", "load_footholds"),
    "models.footsteps": ("Footstep", "Side"),
    "models.interfaces": ("Command", "Controller", "Mode", "Observation", "Status"),
    "models.pushes": ("Push",),
    "models.robot": ("Foot", "Robot", "Swing", "Trunk", "load_robot", "preset_names"),
    "models.viability": ("ViableOffsets", "viable_offsets"),
    "planning.landing_problem": ("Decision", "Limit"),
    "planning.nominal_gait": ("NominalGait", "largest_speed", "nominal_gait"),
    "planning.optimality": ("KktResidual", "kkt_residual"),
    "planning.push_limit": ("ImpulseLimit", "fixed_steps_limit", "push_limit"),
    "planning.step_adaptation": ("solve_step",),
    "planning.step_problem": ("StepProblem", "StepSolution"),
    "simulation.decisions": ("decisions",),
    "simulation.disturbance": ("Disturbance",),
    "simulation.lipm_simulator": ("LipmSimulator",),
    "simulation.outcome": ("Fall", "Outcome"),
    "simulation.rollout": ("Rollout", "load_rollout"),
    "simulation.simulate": ("simulate",),
    "studies.push_recovery": ("PushLimit", "smallest_failing_push"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "AnkleHipStepMpc",
    "CapturePointStepping",
    "Command",
    "Controller",
    "DcmTracking",
    "Decision",
    "Disturbance",
    "Estimator",
    "Fall",
    "FileError",
    "Foot",
    "FootPlacementMpc",
    "Foothold",
    "FootholdError",
    "FootholdTracking",
    "Footstep",
    "HybridController",
    "ImpulseLimit",
    "KktResidual",
    "Limit",
    "LinearMpc",
    "LipmSimulator",
    "MissingExtraError",
    "Mode",
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
    "StepProblem",
    "StepSolution",
    "StepTiming",
    "StudyError",
    "SurefootError",
    "Swing",
    "TimingNlp",
    "Trunk",
    "UnifiedController",
    "VelocityError",
    "ViableOffsets",
    "__version__",
    "decisions",
    "fixed_steps_limit",
    "kkt_residual",
    "largest_speed",
    "load_footholds",
    "load_robot",
    "load_rollout",
    "nominal_gait",
    "preset_names",
    "push_limit",
    "simulate",
    "smallest_failing_push",
    "solve_step",
    "viable_offsets",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'surefoot' has no attribute {name!r}")
    value = getattr(import_module(f"surefoot.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
