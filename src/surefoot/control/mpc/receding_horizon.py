"""The cycle of linear MPC: one quadratic program per axis about the nominal gait.

All unknowns are deviations from the nominal gait, so the program of an undisturbed robot has the
solution 0 and every limit is a bound: on the ZMP relative to its foot, on the step vectors, on the
hip torque. What differs among the methods is which of these are free. The program is solved by DAQP
([Arnstrom2022]); here it is only put together.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, optional_module
from surefoot.control.cycle import side_index
from surefoot.control.dcm_tracking import (
    NO_GAIN,
    check_tracking,
    first_plan,
    tracking_parameters,
)
from surefoot.control.defaults import natural_length
from surefoot.control.mpc.lipm_horizon import Horizon, horizon
from surefoot.control.mpc.receding_cycle import (
    DUE,
    HELD,
    MPC,
    MPC_STATE,
    SOLVE,
    act,
    decide,
    prepare,
)
from surefoot.control.push_observer import observing
from surefoot.dcm.landing_schedule import evenly_timed
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.errors import ParameterError
from surefoot.interface import Command, Observation
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

VELOCITY_WEIGHT = 12.26
"""Default weight of the CoM velocity over omega, beside a weight of 1 on a ZMP [1/m^2]."""

MOVED = 1.25e-4
"""A landing further than this from the planned one is another one, as a fraction of the height of
the CoM."""

_SOLVED, _SOFT = 1, 8
"""DAQP's words for an answer, and for a bound that may be violated."""


@dataclass(frozen=True)
class Programs:
    """The quadratic program of every control cycle of a step, but for the robot's deviation.

        minimise y' hessian y / 2 + (gain deviation)' y
        subject to lower <= (y, rows y + row_state deviation) <= upper

    Attributes:
        hessian: shape (cycles, n, n).
        gain: shape (cycles, n, m), for the deviation of the DCM (m = 1), and of a push as well
            (m = 2), with the trunk's lean and its rate between them (m = 4).
        rows: shape (cycles, r, n); r may be 0.
        row_state: shape (cycles, r, m).
    """

    hessian: NDArray[np.float64]
    gain: NDArray[np.float64]
    rows: NDArray[np.float64]
    row_state: NDArray[np.float64]


def check_receding(
    robot: Robot, period: float, solve_period: float | None, sample: float | None, samples: int
) -> None:
    """Refuse what no receding horizon can work with; load its solver.

    Raises:
        ParameterError: a number is out of range.
        MissingExtraError: DAQP is not installed.
    """
    check_tracking(robot, None, 0.0, period)
    if sample is not None:
        check_number("sample", sample, 0.0, "s", above=True)
    if solve_period is not None:
        check_number("solve_period", solve_period, period, "s", endless=True)
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 1:
        raise ParameterError(
            "`samples` as a whole number of at least 1", repr(samples), "the paper has 16"
        )
    _solver()


@cache
def _solver() -> Callable[..., Any]:
    return optional_module("daqp", "model predictive control", "mpc").solve


def check_optional(value: float | None, name: str, unit: str) -> None:
    """Refuse a parameter that is given, but is no number of at least 0.

    Raises:
        ParameterError: it is.
    """
    if value is not None:
        check_number(name, value, 0.0, unit)


def receding_defaults(
    robot: Robot, gait: NominalGait, period: float, samples_per_step: int
) -> dict[str, float]:
    """What every linear MPC is given where it leaves something out."""
    return {
        "sample": gait.step_duration / samples_per_step,
        "velocity_weight": VELOCITY_WEIGHT / robot.omega**2,
        "solve_period": period,
    }


def default_push_horizon(gait: NominalGait, period: float, solve_period: float | None) -> float:
    """How much longer a push is expected to go on [s].

    A step as long as what was decided for it is taken back in the cycle in which it ends.
    """
    return gait.step_duration if solve_period is None or solve_period <= period else 0.0


def samples_in(gait: NominalGait, sample: float) -> int:
    """How many samples a step gets: it is divided evenly, so that touchdowns are nodes."""
    return max(1, round(gait.step_duration / sample))


def steps_ahead(gait: NominalGait, sample: float, samples: int) -> int:
    """The most touchdowns inside a horizon."""
    per_step = samples_in(gait, sample)
    return (per_step - 1 + samples - 1) // per_step


def horizons(gait: NominalGait, period: float, sample: float, samples: int) -> list[Horizon]:
    """The horizon seen from each control cycle of a step."""
    per_step = samples_in(gait, sample)
    cycles = max(1, math.ceil(gait.step_duration / period - DUE))
    node = gait.step_duration / per_step
    return [horizon(cycle * period, node, samples, per_step) for cycle in range(cycles)]


def receding_parameters(
    robot: Robot, gait: NominalGait, period: float, solve_period: float, sample: float, samples: int
) -> NDArray[np.void]:
    """The `MPC` record of a robot and a gait with fixed steps and no trunk, shape (1,)."""
    parameters = new_array(MPC)
    parameters["tracking"] = tracking_parameters(robot, gait, NO_GAIN, True, 0.0, period)
    for side in Side:
        row = side_index.py_func(side)
        parameters["nominal_step"][0, row] = gait.step(side)
    parameters["solve_period"] = solve_period
    parameters["samples_per_step"] = samples_in(gait, sample)
    parameters["sample"] = gait.step_duration / samples_in(gait, sample)
    parameters["samples"] = samples
    parameters["unit"] = robot.com_height
    parameters["moved"] = MOVED * robot.com_height
    room = natural_length(robot, gait)
    parameters["observing"] = observing(robot.omega, period, room)
    return parameters


def free_steps(
    parameters: NDArray[np.void], robot: Robot, gait: NominalGait, sample: float, samples: int
) -> None:
    """Complete an `MPC` record for a method that places its steps, at the times of the gait.

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    own = viable_displacement(robot)
    parameters["steps"] = steps_ahead(gait, sample, samples)
    parameters["worth"] = evenly_timed(robot, gait.step_duration)
    parameters["low"], parameters["spacing"] = own.low, own.spacing


def receding_step(
    parameters: NDArray[np.void],
    programs: Programs,
    state: NDArray[np.void],
    observation: Observation,
) -> tuple[Command, NDArray[np.void]]:
    """One control cycle; it solves a program if one is due, and keeps to the last one if not.

    Should the solver fail, the robot stands on the centre of its foot and steps as planned, with
    `Status.NOT_CONVERGED`.
    """
    next_state = new_array(MPC_STATE)
    unknowns, rows = programs.gain.shape[1], programs.rows.shape[1]
    deviation = np.empty((2, programs.gain.shape[2]))
    gradient, solution = np.empty((2, unknowns)), np.zeros((2, unknowns))
    lower, upper = np.empty((2, unknowns + rows)), np.empty((2, unknowns + rows))
    task, cycle = prepare(
        parameters, programs.gain, programs.row_state, state, observation.array, next_state,
        deviation, gradient, lower, upper,
    )  # fmt: skip
    if task == SOLVE:
        # The solver has tolerances of its own: in units of the robot they are the robot's.
        unit = float(parameters["unit"][0])
        gradient /= unit
        lower[:, :unknowns] /= unit
        upper[:, :unknowns] /= unit
        sides = unit * programs.rows[cycle]
        kinds = np.zeros(unknowns + rows, np.int32)
        kinds[unknowns:] = _SOFT
        solved = True
        for i in range(2):
            answer, _, flag, _ = _solver()(
                programs.hessian[cycle], gradient[i], sides, upper[i], lower[i], kinds.copy()
            )  # fmt: skip
            if flag >= _SOLVED:
                # The solver keeps bounds to its own tolerance only.
                solution[i] = np.clip(answer, lower[i, :unknowns], upper[i, :unknowns]) * unit
            else:
                solved = False
        decide(parameters, deviation, solution, cycle, solved, next_state)
    if task != HELD:
        act(parameters, state, next_state)
    return Command.of(next_state["command"]), next_state


@dataclass(frozen=True)
class RecedingHorizon:
    """What every linear MPC does with its programs; what they are is the subclass's own.

    A subclass has the fields of a controller, see `interface.Controller`, and `programs`.
    """

    @property
    def kernel(self) -> None:
        """None: a library solves its programs, so it walks alone and not in a compiled batch."""
        return

    def first_observation(self: Any, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self: Any, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle: a program is due.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(MPC_STATE)
        first_plan(self.gait, observation, state)
        state["decision"]["until"] = -math.inf
        return state

    def step(
        self: Any, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        return receding_step(self.parameters, self.programs, state, observation)

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)  # type: ignore[call-arg]
