"""Linear MPC for walking: one quadratic program per axis about the nominal gait.

On a horizon of intervals with constant ZMP, as in [Wieber2006] and [Herdt2010], but with the ZMP
itself as the input: with the CoM's jerk as the input the ZMP cannot jump from foot to foot, so
between the samples around a touchdown it would lie where no foot is.

All unknowns are deviations from the nominal gait, so the program of an undisturbed robot has the
solution 0 and every limit is a bound: on the ZMP relative to its foot, on the step vectors, on the
hip torque. What differs among the methods is which of these are free. The program is solved by DAQP
([Arnstrom2022]); here it is only put together.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache, lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, optional_module
from surefoot.control.base import GaitController, control_period
from surefoot.control.defaults import natural_length
from surefoot.control.fields import filled, setting, weight
from surefoot.control.mpc.cycle import (
    DUE,
    HELD,
    SOLVE,
    MpcParameters,
    MpcState,
    Work,
    act,
    decide,
    prepare,
)
from surefoot.control.push_observer import observing
from surefoot.control.tracking import tracking_parameters
from surefoot.errors import ParameterError
from surefoot.interface import Command, Observation
from surefoot.record import new_array
from surefoot.robot.feet import Side

VELOCITY_WEIGHT = 12.26
"""Default weight of the CoM velocity over omega, beside a weight of 1 on a ZMP [1/m^2]."""

MOVED = 1.25e-4
"""A landing further than this from the planned one is another one, as a fraction of the height of
the CoM."""

_SOLVED, _SOFT = 1, 8
"""DAQP's words for an answer, and for a bound that may be violated."""

ON_ZMP = "on the distance of the ZMP from the centre of the foot"
"""The words of its weight."""

NEXT_NODE = 1e-9
"""A node this fraction of a sample ahead is now."""


@dataclass(frozen=True)
class Horizon:
    """Intervals of a horizon, from one moment of a step on.

    Nodes lie at multiples of the sample since touchdown, so a touchdown is one of them; only the
    first interval is shorter.

    Attributes:
        lengths: of the intervals [s], shape (n,).
        feet: which foot stands in each: 0 the present one, 1 the next one, ..., shape (n,).
    """

    lengths: NDArray[np.float64]
    feet: NDArray[np.int64]


def horizon(elapsed: float, sample: float, samples: int, samples_per_step: int) -> Horizon:
    """The horizon from `elapsed` since touchdown on.

    Args:
        elapsed: now, in [0, sample * samples_per_step) [s].
        sample: distance of the nodes [s].
        samples: how many intervals.
        samples_per_step: a step lasts so many samples.
    """
    node = math.floor(elapsed / sample + NEXT_NODE)
    lengths = np.full(samples, sample)
    lengths[0] = (node + 1) * sample - elapsed
    return Horizon(lengths, (node + np.arange(samples)) // samples_per_step)


def com_response(
    omega: float, lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """CoM and its velocity at the end of each interval, for a state whose convergent part is 0.

        (com, velocity) = from_dcm dcm + from_zmp zmp

    by the exact flow of the LIPM, see `dcm.pendulum`; there, com = dcm / 2.

    Args:
        omega: natural frequency [1/s].
        lengths: of the intervals [s], shape (n,).

    Returns:
        from_dcm (2, n) and from_zmp (2, n, n), of the CoM and of its velocity [-, 1/s].
    """
    count = len(lengths)
    inputs, from_zmp = np.zeros((2, count)), np.empty((2, count, count))
    for i, length in enumerate(lengths):
        cosh, sinh = math.cosh(omega * length), math.sinh(omega * length)
        inputs = np.array([[cosh, sinh / omega], [omega * sinh, cosh]]) @ inputs
        inputs[:, i] = 1.0 - cosh, -omega * sinh
        from_zmp[:, i] = inputs
    growth = np.exp(omega * np.cumsum(lengths))
    return np.stack([0.5 * growth, 0.5 * omega * growth]), from_zmp


def velocity_response(
    omega: float, lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The second part of `com_response`: from_dcm (n,) and from_zmp (n, n) [1/s]."""
    from_dcm, from_zmp = com_response(omega, lengths)
    return from_dcm[1], from_zmp[1]


def push_response(
    from_zmp: NDArray[np.float64], lengths: NDArray[np.float64], lasting: float
) -> NDArray[np.float64]:
    """CoM or velocity at the end of each interval under a push that goes on for a time.

    A force F moves the CoM as a ZMP does that is F / (m omega^2) further back.

    Args:
        from_zmp: of `com_response` or `velocity_response`, shape (..., n, n).
        lengths: of the intervals [s], shape (n,).
        lasting: how much longer it pushes [s].

    Returns:
        Per F / (m omega^2), shape (..., n) [-, 1/s].
    """
    begins = np.cumsum(lengths) - lengths
    return -from_zmp @ np.clip((lasting - begins) / lengths, 0.0, 1.0)


def lean_response(
    inertia: float, lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lean of the trunk, and its rate, at the end of each interval under constant hip torques.

        (lean, rate) = from_state (lean, rate) + from_torque torque

    Args:
        inertia: of the trunk [kg m^2].
        lengths: of the intervals [s], shape (n,).

    Returns:
        from_state (n, 2, 2); from_torque (n, 2, n) [rad/(N m)] and [rad/(s N m)].
    """
    count = len(lengths)
    state, inputs = np.eye(2), np.zeros((2, count))
    from_state, from_torque = np.empty((count, 2, 2)), np.empty((count, 2, count))
    for i, length in enumerate(lengths):
        flow = np.array([[1.0, length], [0.0, 1.0]])
        state, inputs = flow @ state, flow @ inputs
        inputs[:, i] = 0.5 * length * length / inertia, length / inertia
        from_state[i], from_torque[i] = state, inputs
    return from_state, from_torque


def placed_feet(feet: NDArray[np.int64], steps: int) -> NDArray[np.float64]:
    """Which step vectors the foot of each interval is the sum of, as zeros and ones (n, steps)."""
    return (feet[:, None] > np.arange(steps)).astype(np.float64)


class Programs(NamedTuple):
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


@cache
def _solver() -> Callable[..., Any]:
    return optional_module("daqp", "model predictive control", "mpc").solve


@dataclass(frozen=True)
class _Asked:
    """What the programs of a controller depend on, and the controller."""

    kind: type
    step_duration: float
    settings: tuple[Any, ...]
    mpc: RecedingHorizon = field(compare=False)


@lru_cache(maxsize=8)
def _programs(asked: _Asked) -> Programs:
    """Made once for all velocities with the same duration of a step: it takes several cycles."""
    mpc = asked.mpc
    made = zip(*map(mpc.make_program, mpc.horizons()), strict=True)
    return Programs(*(np.array(part) for part in made))


@dataclass(frozen=True)
class RecedingHorizon(GaitController):
    """What every linear MPC does with its programs; what they are is the subclass's own.

    A library solves them, so it walks alone and not in a compiled batch.
    """

    STATE = MpcState
    SAMPLES_PER_STEP: ClassVar[int] = 5
    """Intervals of the horizon in a nominal step if `sample` is None."""

    samples: int = setting(16, "", "intervals of the horizon")
    sample: float | None = setting(
        None, "s", "their length; a step is divided evenly, into intervals close to it; T_nom over "
        "`SAMPLES_PER_STEP` if None", above=0.0,
        own=lambda mpc: mpc.gait.step_duration / mpc.SAMPLES_PER_STEP,
    )  # fmt: skip
    velocity_weight: float | None = weight(
        None, "s^2/m^2", "on the deviation of the CoM velocity from the nominal gait; "
        "12.26 / omega^2 if None", own=lambda mpc: VELOCITY_WEIGHT / mpc.robot.omega**2,
    )  # fmt: skip
    zmp_weight: float = weight(1.0, "1/m^2", ON_ZMP, above=0.0)
    solve_period: float | None = setting(
        None, "s", "how often the program is solved, and at every sample; in every cycle if None",
        kw_only=True, own=lambda mpc: mpc.period,
    )  # fmt: skip
    period: float = control_period(0.005)
    programs: Programs = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        names = (of.name for of in fields(self) if of.init and of.name != "velocity")
        settings = tuple(getattr(self, name) for name in names)
        asked = _Asked(type(self), self.gait.step_duration, settings, self)
        object.__setattr__(self, "programs", _programs(asked))

    @property
    def samples_per_step(self) -> int:
        """How many samples a step gets: it is divided evenly, so that touchdowns are nodes."""
        return max(1, round(self.gait.step_duration / filled(self.sample)))

    @property
    def node(self) -> float:
        """From one node to the next [s]."""
        return self.gait.step_duration / self.samples_per_step

    @property
    def steps_ahead(self) -> int:
        """The most touchdowns inside a horizon."""
        return (self.samples_per_step + self.samples - 2) // self.samples_per_step

    def horizons(self) -> list[Horizon]:
        """The horizon from each control cycle of a step on."""
        cycles = max(1, math.ceil(self.gait.step_duration / self.period - DUE))
        return [
            horizon(cycle * self.period, self.node, self.samples, self.samples_per_step)
            for cycle in range(cycles)
        ]

    def check(self) -> None:
        """Refuse what no receding horizon can work with; load its solver.

        Raises:
            ParameterError: a number is out of range.
            MissingExtraError: DAQP is not installed.
        """
        if self.solve_period is not None:
            check_number("solve_period", self.solve_period, self.period, "s", endless=True)
        samples = self.samples
        if isinstance(samples, bool) or not isinstance(samples, int) or samples < 1:
            raise ParameterError(
                "`samples` as a whole number of at least 1", repr(samples), "the paper has 16"
            )
        _solver()

    def make_parameters(self) -> MpcParameters:
        """Those of fixed steps and no trunk."""
        robot, gait = self.robot, self.gait
        return MpcParameters(
            tracking=tracking_parameters(self),
            nominal_step=[gait.step(side) for side in (Side.RIGHT, Side.LEFT)],
            solve_period=filled(self.solve_period),
            sample=self.node,
            samples_per_step=self.samples_per_step,
            samples=self.samples,
            unit=robot.com_height,
            moved=MOVED * robot.com_height,
            observing=observing(robot.omega, self.period, natural_length(robot, gait)),
        )

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle, see `Programs`.

        They may depend on anything but the velocity, whose change at a touchdown takes them over.
        """
        raise NotImplementedError(f"{type(self).__name__}.make_program")

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle: a program is due."""
        state = super().start(observation)
        state["decision"]["until"] = -math.inf
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle; it solves a program if one is due, and keeps to the last one if not.

        Should the solver fail, the robot stands on the centre of its foot and steps as planned,
        with `Status.NOT_CONVERGED`.
        """
        parameters, programs = self.parameters, self.programs
        next_state, work = new_array(MpcState.DTYPE), Work.of(programs)
        deviation, gradient, lower, upper = work
        solution = np.zeros_like(gradient)
        unknowns, rows = programs.gain.shape[1], programs.rows.shape[1]
        task, cycle = prepare(parameters, programs, state, observation.array, next_state, work)
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
