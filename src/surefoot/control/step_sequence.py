"""Where and when the next N feet land: one nonlinear program, after [Kryczka2015].

    minimise    sum over k of  1/2 a |L_k - L_nom|^2 + 1/2 b (e^(omega T_k) - G)^2
                             + 1/2 c |u_k|^2 + 1/2 w_k |d_k - d_nom|^2
                + 1/2 rho (violation of the viable d_N)^2
    subject to  d_k = u_k + (d_(k-1) - u_k) e^(omega T_k) - L_k,
                L_k, T_k, u_k in their intervals,   each axis of the foot's way in reach in T_k

L_k is a step vector, T_k a duration, u_k a ZMP that is held during the step, relative to the foot
that stands, and d_k the DCM at landing relative to the landing foot. For the step under way T_1 is
what is left of it, and d_0 the DCM now. Every step is written in a frame of its own, with y towards
its swing side: so a problem and its mirror image are the same numbers.

The program is in the robot's own units, lengths in heights of the CoM and times in 1 / omega, so
that similar robots have the same one. CasADi gives the derivatives and IPOPT solves; both are
loaded when the first program is built.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.dcm.leg import furthest
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.dcm.viability import viable_offsets
from surefoot.record import Array, Record, field, new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

MAX_HORIZON = 5
"""A decision is about no more steps."""


class PlannedSteps(Record):
    """The next steps, each in its own frame."""

    duration: Array = field("s", "of the first one what is left of it", shape=MAX_HORIZON)
    step: Array = field("m", "step vector", shape=(MAX_HORIZON, 2))
    zmp: Array = field("m", "relative to the support foot", shape=(MAX_HORIZON, 2))
    offset: Array = field("m", "of the DCM at landing", shape=(MAX_HORIZON, 2))


UNLIMITED = (360.0, 1e8)
"""What the program takes for an infinite speed or acceleration of the leg, in its own units."""

ROOM = 1.25e-3
"""What a foot that cannot reach the box in time may lack beyond the least that it must, in heights
of the CoM."""

TOLERANCE = 1e-9
"""To which IPOPT solves, on its unscaled error."""

GRID = 12
"""Decimals that the program sees: the same problem at another place has the same bits."""

_PER_STEP = 7
_NUMBERS = (
    "omega", "growth", "dcm_x", "dcm_y", "foot_x", "foot_y", "foot_velocity_x", "foot_velocity_y",
    "max_speed", "max_acceleration", "lateness_x", "lateness_y",
    "nominal_tau", "nominal_x", "nominal_y", "nominal_y_next",
    "offset_x", "offset_y", "offset_y_next",
    "step_weight_x", "step_weight_y", "tau_weight", "zmp_weight_x", "zmp_weight_y",
    "offset_weight_x", "offset_weight_y", "path_weight_x", "path_weight_y", "penalty",
)  # fmt: skip
"""The parameters of the program, in this order."""


@dataclass(frozen=True)
class SequenceWeights:
    """What deviations from the nominal gait cost.

    Attributes:
        step: of every step vector (x, y) [1/m^2].
        tau: of every e^(omega T) [-].
        zmp: of every ZMP from the centre of its foot (x, y) [1/m^2].
        offset: of the DCM offset at the last landing; it must dominate (x, y) [1/m^2].
        path: of the DCM offsets before (x, y) [1/m^2].
        penalty: of the squared violation of the viable set at the last landing [1/m^2].
    """

    step: tuple[float, float]
    tau: float
    zmp: tuple[float, float]
    offset: tuple[float, float]
    path: tuple[float, float]
    penalty: float


@dataclass(frozen=True)
class StepSequence:
    """The program of one robot and one gait, ready to be solved again and again.

    Args:
        robot: whose limits hold.
        gait: what deviations are measured from.
        horizon: N, number of steps.
        weights: of the deviations.
        zmp_share: how much of the sole the ZMP may use [-].
        max_iterations: of IPOPT; an answer that needs more is none.

    """

    robot: Robot
    gait: NominalGait
    horizon: int
    weights: SequenceWeights
    zmp_share: float
    max_iterations: int

    def __reduce__(self) -> Any:
        # A solver cannot travel to another process: it is built there.
        return StepSequence, (
            self.robot, self.gait, self.horizon, self.weights, self.zmp_share, self.max_iterations,
        )  # fmt: skip

    @cached_property
    def solver(self) -> Any:
        """IPOPT, compiled for this shape of the program."""
        return _build(self.horizon, self.is_limited, self.max_iterations)

    @property
    def is_limited(self) -> bool:
        """Whether the leg limits where the foot can be."""
        return self.robot.swing.is_limited

    @property
    def leg(self) -> tuple[float, float]:
        """V and A as the program takes them, in its own units."""
        swing, speed = self.robot.swing, self.unit * self.gait.omega
        return (
            min(swing.max_speed / speed, UNLIMITED[0]),
            min(swing.max_acceleration / (speed * self.gait.omega), UNLIMITED[1]),
        )

    @property
    def unit(self) -> float:
        """The length in which the program counts [m]."""
        return self.robot.com_height

    @property
    def size(self) -> float:
        """The longer side of the step box [m]."""
        limits = self.robot.gait
        return max(limits.step_x[1] - limits.step_x[0], limits.step_y[1] - limits.step_y[0])

    def nominal(self, side: Side, elapsed: float) -> NDArray[np.void]:
        """The steps of the nominal gait from this support on, a `PlannedSteps` record."""
        plan = new_array(PlannedSteps.DTYPE)
        for k in range(self.horizon):
            own = side if k % 2 == 0 else side.other
            plan["duration"][0, k] = self.gait.step_duration
            plan["step"][0, k] = _in_own_frame(self.gait.step(own), own)
            plan["offset"][0, k] = _in_own_frame(self.gait.dcm_offset(own), own)
        plan["duration"][0, 0] = max(self.gait.step_duration - elapsed, 0.0)
        return plan

    def solve(
        self,
        side: Side,
        elapsed: float,
        dcm: tuple[float, float],
        foot: tuple[float, float],
        guess: NDArray[np.void],
        foot_velocity: tuple[float, float] = (0.0, 0.0),
    ) -> tuple[NDArray[np.void], bool, float]:
        """Decide the next steps.

        Args:
            side: foot on the ground.
            elapsed: since touchdown [s].
            dcm: relative to that foot, in world axes (x, y) [m].
            foot: the swing foot, likewise [m].
            guess: a `PlannedSteps` record to start from.
            foot_velocity: of the swing foot, likewise; it counts where the acceleration is limited
                [m/s].

        Returns:
            The steps as a `PlannedSteps` record, whether IPOPT found them optimal, and by how much
            the DCM offset at the last landing is outside the viable set [m].
        """
        unit, omega = self.unit, self.gait.omega
        elapsed = round(omega * elapsed, GRID)
        start = _on_grid(_in_own_frame(dcm, side), unit)
        way = _on_grid(_in_own_frame(foot, side), unit)
        speed = _on_grid(_in_own_frame(foot_velocity, side), unit * omega)
        longest = omega * self.robot.gait.step_duration[1]
        lower, upper = (bounds.copy() for bounds in self.bounds)
        lower[0], upper[0] = max(lower[0] - elapsed, 0.0), max(upper[0] - elapsed, 0.0)
        numbers = self.fixed | {
            "growth": float(np.exp(min(elapsed, longest))),
            "dcm_x": start[0], "dcm_y": start[1], "foot_x": way[0], "foot_y": way[1],
            "foot_velocity_x": speed[0], "foot_velocity_y": speed[1],
            "nominal_y": _in_own_frame(self.gait.step(side), side)[1] / unit,
            "nominal_y_next": _in_own_frame(self.gait.step(side.other), side.other)[1] / unit,
            "offset_y": _in_own_frame(self.gait.dcm_offset(side), side)[1] / unit,
            "offset_y_next": _in_own_frame(self.gait.dcm_offset(side.other), side.other)[1] / unit,
            **self._least_lateness(way, speed, float(upper[0])),
        }  # fmt: skip
        answer = self.solver(
            x0=np.clip(self._start(start, guess), lower, upper),
            p=[numbers[name] for name in _NUMBERS],
            lbx=lower,
            ubx=upper,
            lbg=self.constraint_bounds[0],
            ubg=self.constraint_bounds[1],
        )
        values = np.clip(np.asarray(answer["x"]).ravel(), lower, upper)
        good = bool(self.solver.stats()["success"]) and bool(np.isfinite(values).all())
        slack = values[_PER_STEP * self.horizon :]
        return self._planned(values), good, unit * float(np.abs(slack).max())

    def _start(self, dcm: tuple[float, float], guess: NDArray[np.void]) -> NDArray[np.float64]:
        """The variables of a guess: its DCM offsets follow from where the DCM is now."""
        offset, variables = np.array(dcm), []
        for k in range(self.horizon):
            time = self.gait.omega * guess["duration"][0, k]
            step, zmp = guess["step"][0, k] / self.unit, guess["zmp"][0, k] / self.unit
            offset = zmp + (offset - zmp) * np.exp(time) - step
            variables += [time, *step, *zmp, *offset]
            # In the next step's own frame y points the other way.
            offset = offset * (1.0, -1.0)
        return np.array([*variables, 0.0, 0.0])

    def _least_lateness(
        self, foot: tuple[float, float], velocity: tuple[float, float], left: float
    ) -> dict[str, float]:
        """What the swing foot lacks to the box of steps even if it takes all the time there is."""
        late, (low, high) = {}, self.bounds
        for i, axis in enumerate("xy"):
            away = min(max(foot[i], low[1 + i]), high[1 + i]) - foot[i]
            lacks = max(
                way - furthest(v, left, *self.leg)
                for way, v in ((away, velocity[i]), (-away, -velocity[i]))
            )
            late[f"lateness_{axis}"] = lacks + ROOM if self.is_limited and lacks > 0.0 else 0.0
        return late

    def _planned(self, values: NDArray[np.float64]) -> NDArray[np.void]:
        plan = new_array(PlannedSteps.DTYPE)
        for k in range(self.horizon):
            of_step = self.unit * values[_PER_STEP * k :][:_PER_STEP]
            plan["duration"][0, k] = values[_PER_STEP * k] / self.gait.omega
            plan["step"][0, k] = of_step[1:3]
            plan["zmp"][0, k], plan["offset"][0, k] = of_step[3:5], of_step[5:7]
        return plan

    @cached_property
    def fixed(self) -> dict[str, float]:
        """The parameters of the program that are the same in all decisions."""
        numbers = {
            "omega": 1.0,
            "max_speed": self.leg[0],
            "max_acceleration": self.leg[1],
            "nominal_tau": self.gait.growth,
            "nominal_x": self.gait.step_length / self.unit,
            "offset_x": self.gait.dcm_offset(Side.RIGHT)[0] / self.unit,
            "tau_weight": self.weights.tau / self.unit**2,
            "penalty": self.weights.penalty,
        }
        for name in ("step", "zmp", "offset", "path"):
            for axis, weight in zip("xy", getattr(self.weights, name), strict=True):
                numbers[f"{name}_weight_{axis}"] = weight
        return numbers

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper ones of the variables, with the whole duration of the first step."""
        limits, free = self.robot.gait, (np.inf, np.inf)
        # Own frames look like the one of right support, whose swing side is the left.
        low, high = np.array(limits.step_box(Side.RIGHT, self.robot.hip)) / self.unit
        reach = self.zmp_share * np.array(self.robot.foot.half) / self.unit
        shortest, longest = self.gait.omega * np.array(limits.step_duration)
        lower = [shortest, *low, *-reach, *np.negative(free)] * self.horizon
        upper = [longest, *high, *reach, *free] * self.horizon
        return np.array([*lower, *np.negative(free)]), np.array([*upper, *free])

    @cached_property
    def constraint_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper ones of the constraints."""
        reach = self.zmp_share * np.array(self.robot.foot.half)
        viable = viable_offsets(self.robot, Side.RIGHT, (float(reach[0]), float(reach[1])))
        flow, late = [0.0] * (2 * self.horizon), 4 * self.horizon if self.is_limited else 0
        return (
            np.array([*flow, *(np.array(viable.lower) / self.unit)] + [-np.inf] * late),
            np.array([*flow, *(np.array(viable.upper) / self.unit)] + [0.0] * late),
        )


def _in_own_frame(vector: tuple[float, float], side: Side) -> tuple[float, float]:
    """A vector with y towards the swing side; the same way back."""
    return vector[0], side * vector[1]


def _on_grid(vector: tuple[float, float], unit: float) -> tuple[float, float]:
    return round(vector[0] / unit, GRID), round(vector[1] / unit, GRID)


@cache
def _build(horizon: int, limited: bool, max_iterations: int) -> Any:
    """The solver, compiled once per process for each shape of the program."""
    ca = optional_module("casadi", "nonlinear step timing", "nlp")
    p = {name: ca.SX.sym(name) for name in _NUMBERS}
    variables = ca.SX.sym("variables", _PER_STEP * horizon + 2)
    slack = variables[_PER_STEP * horizon :]

    def pair(name: str) -> Any:
        return ca.vertcat(p[f"{name}_x"], p[f"{name}_y"])

    cost, flow, reach = 0.5 * p["penalty"] * ca.sumsqr(slack), [], []
    start, came_from, offset = pair("dcm"), pair("foot"), slack
    for k in range(horizon):
        of_step = variables[_PER_STEP * k :][:_PER_STEP]
        time, step, zmp, offset = of_step[0], of_step[1:3], of_step[3:5], of_step[5:7]
        growth, after = ca.exp(p["omega"] * time), "_next" if k % 2 else ""
        flow.append(zmp + (start - zmp) * growth - step - offset)
        tau = growth * p["growth"] if k == 0 else growth
        nominal = ca.vertcat(p["nominal_x"], p[f"nominal_y{after}"])
        nominal_offset = ca.vertcat(p["offset_x"], p[f"offset_y{after}"])
        weight = pair("offset_weight" if k == horizon - 1 else "path_weight")
        cost += 0.5 * ca.dot(pair("step_weight"), (step - nominal) ** 2)
        cost += 0.5 * p["tau_weight"] * (tau - p["nominal_tau"]) ** 2
        cost += 0.5 * ca.dot(pair("zmp_weight"), zmp**2)
        cost += 0.5 * ca.dot(weight, (offset - nominal_offset) ** 2)
        if limited:
            for sign in (1.0, -1.0):
                velocity, late = (pair("foot_velocity"), pair("lateness")) if k == 0 else (0.0, 0.0)
                ahead = _max_way(ca, sign * velocity, time, p["max_speed"], p["max_acceleration"])
                reach.append(sign * (step - came_from) - ahead - late)
        # The next step's own frame has y the other way.
        start = ca.vertcat(offset[0], -offset[1])
        came_from = ca.vertcat(-step[0], step[1])
    program = {
        "x": variables,
        "p": ca.vertcat(*p.values()),
        "f": cost,
        "g": ca.vertcat(*flow, offset - slack, *reach),
    }
    return ca.nlpsol("step_sequence", "ipopt", program, _options(max_iterations))


def _max_way(ca: Any, velocity: Any, time: Any, speed: Any, acceleration: Any) -> Any:
    """`dcm.leg.furthest` as an expression."""
    ramp = (speed - velocity) / acceleration
    ramping = time * (velocity + 0.5 * acceleration * time)
    return ca.if_else(time <= ramp, ramping, speed * time - 0.5 * (speed - velocity) * ramp)


def _options(max_iterations: int) -> dict[str, Any]:
    return {
        "print_time": False,
        "error_on_fail": False,
        "show_eval_warnings": False,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": max_iterations,
            "tol": TOLERANCE,
            # The units suit the problem; IPOPT's own scaling costs it half as many again.
            "nlp_scaling_method": "none",
        },
    }
