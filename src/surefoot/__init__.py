"""Surefoot: a biped that keeps walking when it is pushed.

Names are loaded when they are first used, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot import errors, version

if TYPE_CHECKING:
    # All public names: type checkers read them here, and so does this file itself.
    from surefoot.control.capture_point import CapturePointStepping as CapturePointStepping
    from surefoot.control.estimator import Estimator as Estimator
    from surefoot.control.foothold_tracking import FootholdTracking as FootholdTracking
    from surefoot.control.hybrid import HybridController as HybridController
    from surefoot.control.mpc.ankle_hip import AnkleHipStepMpc as AnkleHipStepMpc
    from surefoot.control.mpc.linear import LinearMpc as LinearMpc
    from surefoot.control.mpc.placement import FootPlacementMpc as FootPlacementMpc
    from surefoot.control.preview_control import PreviewControl as PreviewControl
    from surefoot.control.settings import load_settings as load_settings
    from surefoot.control.step_timing import StepTiming as StepTiming
    from surefoot.control.timing_nlp import TimingNlp as TimingNlp
    from surefoot.control.tracking import DcmTracking as DcmTracking
    from surefoot.control.unified.controller import UnifiedController as UnifiedController
    from surefoot.control.unified.problem import Decision as Decision
    from surefoot.control.unified.problem import Limit as Limit
    from surefoot.dcm.footholds import Foothold as Foothold
    from surefoot.dcm.footholds import FootholdError as FootholdError
    from surefoot.dcm.footholds import load_footholds as load_footholds
    from surefoot.dcm.nominal_gait import NominalGait as NominalGait
    from surefoot.dcm.nominal_gait import largest_speed as largest_speed
    from surefoot.dcm.nominal_gait import nominal_gait as nominal_gait
    from surefoot.dcm.push_limit import ImpulseLimit as ImpulseLimit
    from surefoot.dcm.push_limit import causal_push_limit as causal_push_limit
    from surefoot.dcm.push_limit import fixed_steps_limit as fixed_steps_limit
    from surefoot.dcm.push_limit import push_limit as push_limit
    from surefoot.dcm.pushes import Push as Push
    from surefoot.dcm.step_problem import KktResidual as KktResidual
    from surefoot.dcm.step_problem import StepProblem as StepProblem
    from surefoot.dcm.step_problem import StepSolution as StepSolution
    from surefoot.dcm.step_problem import kkt_residual as kkt_residual
    from surefoot.dcm.step_solver import solve_step as solve_step
    from surefoot.dcm.viability import ViableOffsets as ViableOffsets
    from surefoot.dcm.viability import viable_offsets as viable_offsets
    from surefoot.errors import FileError as FileError
    from surefoot.errors import MissingExtraError as MissingExtraError
    from surefoot.errors import ParameterError as ParameterError
    from surefoot.errors import RobotError as RobotError
    from surefoot.errors import StudyError as StudyError
    from surefoot.errors import SurefootError as SurefootError
    from surefoot.errors import VelocityError as VelocityError
    from surefoot.interface import Command as Command
    from surefoot.interface import Controller as Controller
    from surefoot.interface import Mode as Mode
    from surefoot.interface import Observation as Observation
    from surefoot.interface import Status as Status
    from surefoot.robot.feet import Footstep as Footstep
    from surefoot.robot.feet import Side as Side
    from surefoot.robot.multibody import Multibody as Multibody
    from surefoot.robot.multibody import load_multibody as load_multibody
    from surefoot.robot.robot import Foot as Foot
    from surefoot.robot.robot import Robot as Robot
    from surefoot.robot.robot import Swing as Swing
    from surefoot.robot.robot import Trunk as Trunk
    from surefoot.robot.robot import load_robot as load_robot
    from surefoot.robot.robot import preset_names as preset_names
    from surefoot.rollout.decisions import decisions as decisions
    from surefoot.rollout.disturbance import Disturbance as Disturbance
    from surefoot.rollout.fall import BodyFall as BodyFall
    from surefoot.rollout.fall_signs import FallCause as FallCause
    from surefoot.rollout.measures import BodyMeasures as BodyMeasures
    from surefoot.rollout.measures import measure_body as measure_body
    from surefoot.rollout.outcome import Fall as Fall
    from surefoot.rollout.outcome import Outcome as Outcome
    from surefoot.rollout.rollout import Rollout as Rollout
    from surefoot.rollout.rollout import load_rollout as load_rollout
    from surefoot.rollout.trace import BodyTrace as BodyTrace
    from surefoot.show.film import film_walk as film_walk
    from surefoot.studies.engine.scan import PushLimit as PushLimit
    from surefoot.studies.engine.scan import smallest_failing_push as smallest_failing_push
    from surefoot.worlds.body.controller import BodyControl as BodyControl
    from surefoot.worlds.body.estimator import BodyEstimator as BodyEstimator
    from surefoot.worlds.body.gait import body_control as body_control
    from surefoot.worlds.body.gait import body_controller as body_controller
    from surefoot.worlds.body.gait import walking_robot as walking_robot
    from surefoot.worlds.body.inverse_dynamics import InverseDynamics as InverseDynamics
    from surefoot.worlds.body.plant import Surroundings as Surroundings
    from surefoot.worlds.body.sensors import BodyNoise as BodyNoise
    from surefoot.worlds.body.world import simulate_body as simulate_body
    from surefoot.worlds.point.batch import simulate_batch as simulate_batch
    from surefoot.worlds.point.plant import LipmSimulator as LipmSimulator
    from surefoot.worlds.point.simulate import simulate as simulate
    from surefoot.worlds.point.walks import Walks as Walks
    from surefoot.worlds.steering import Steering as Steering

_EXTRAS = {
    "mujoco": ("a body in physics", "mujoco"),
    "imageio_ffmpeg": ("films", "video"),
    "matplotlib": ("films", "video"),
    "PIL": ("films", "video"),
}

_HOME_OF = {
    alias.name: statement.module or ""
    for guard in ast.parse(Path(__file__).read_text("utf-8")).body
    if isinstance(guard, ast.If)
    for statement in guard.body
    if isinstance(statement, ast.ImportFrom)
    for alias in statement.names
}
__version__ = version.VERSION
__all__ = sorted([*_HOME_OF, "__version__"])  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'surefoot' has no attribute {name!r}")
    try:
        home = import_module(_HOME_OF[name])
    except ModuleNotFoundError as error:
        if error.name not in _EXTRAS:
            raise
        raise errors.MissingExtraError(*_EXTRAS[error.name]) from error
    value = getattr(home, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
