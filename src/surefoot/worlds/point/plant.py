"""The point mass on two feet, moved exactly: the world of the LIPM.

A cycle ends after one control period, or at the exact instant of touchdown if that comes first;
the control clock restarts there, so every step is sampled alike. Pushes begin and end at their
exact instants inside a cycle. A robot with a trunk has a flywheel at the hip, which a controller
may turn: see `dcm.pendulum`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from dataclasses import field as attribute
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import entry_point, njit
from surefoot.dcm.leg import follow
from surefoot.dcm.pendulum import com_flow_by, pushed_pivot, trunk_flow
from surefoot.dcm.pushes import PUSH, Push, force_until_change, push_records
from surefoot.dcm.three_mass import pendulum_omega, three_mass
from surefoot.dcm.viability import fall_distance
from surefoot.geometry import length
from surefoot.interface import COMMAND, Command, Observation
from surefoot.record import Array, Record, Vector2, field, new_array
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance, misplace
from surefoot.worlds.point.heavy_legs import place_zmp, stop_leg, swing_legs

SLIVER = 1e-6
"""Cycles shorter than this fraction of a period are merged into the next."""

OTHER_PENDULUM = 1e-9
"""A DCM this far from what CoM and velocity make it is that of another robot, as a fraction of the
height of the CoM."""


class LipmParameters(Record):
    """A point mass with its legs, trunk and ground."""

    omega: float = field("1/s", "natural frequency")
    mass: float = field("kg", "of the robot")
    period: float = field("s", "of control")
    max_speed: float = field("m/s", "of the swing foot along each axis")
    max_acceleration: float = field("m/s^2", "likewise")
    com_height: float = field("m", "of the CoM")
    inertia: float = field("kg m^2", "of the trunk")
    max_torque: float = field("N m", "at the hip, 0 without a trunk")
    max_lean: float = field("rad", "of the trunk")
    fall_distance: float = field("m", "from the support foot to a DCM that no step can save")
    landing_error: float = field("m", "how far a foot comes to stand from where it lands")
    touchdown_shift: float = field("s", "of the ground, earlier if negative")
    seed: int = field("", "of the landing errors")
    foot_gain: float = field("s^2", "shift of the ZMP that acts like an acceleration of the foot")
    push_gain: float = field("-", "by how much longer than `com_height` the pendulum is, inverse")
    legs_known: bool = field("", "whether the ZMP is moved by what the legs need")
    expected_omega: float = field("1/s", "natural frequency that a robot shows which knows them")
    half_foot: Vector2 = field("m", "half the sole")


class LipmWorld(Record):
    """The state of the world of a point mass."""

    observation: Observation = field("", "what can be observed")
    step_start: float = field("s", "when the step began")
    cycle: int = field("-", "cycles since then")
    steps: int = field("-", "steps finished")
    fallen: int = field("", "whether the robot has fallen")
    due: float = field(
        "s", "since when a foot waits for the ground, after the last touchdown, or 0"
    )
    zmp: Vector2 = field("m", "where the ground pushed in the last cycle")
    legs: Array = field(
        "m, m/s", "shift of the pivot by heavy legs in it, and how it changed, by axis",
        shape=(2, 2),
    )  # fmt: skip


LIPM_PARAMETERS, LIPM_WORLD = LipmParameters.DTYPE, LipmWorld.DTYPE


@njit(forceinline=True)
def _move_com(parameters, zmp, pushes, legs, start, end, observation):
    """Move CoM and DCM from `start` to `end` about a constant ZMP, exactly, push by push.

    `legs` are kappa f'' at the start and how it changes, per axis: a pivot that moves evenly.
    """
    omega = parameters.omega
    time = start
    while time < end:
        force_x, force_y, until = force_until_change(pushes, time, end)
        times = time - start, until - time, math.exp(omega * (until - time))
        _move_axis(parameters, 0, force_x, zmp, legs, times, observation)
        _move_axis(parameters, 1, force_y, zmp, legs, times, observation)
        time = until
    for i in range(2):
        observation.dcm[i] = observation.com[i] + observation.com_velocity[i] / omega


@njit(forceinline=True)
def _move_axis(parameters, axis, force, zmp, legs, times, observation):
    """Move the CoM along an axis about a pivot that moves evenly, which is a solution itself.

    `times` are the time since the start of the cycle, how long to move, and e^(omega t) of that.
    """
    since, duration, growth = times
    pivot = pushed_pivot(zmp[axis], parameters.push_gain * force, parameters.mass, parameters.omega)
    pivot -= legs[axis, 0] + since * legs[axis, 1]
    drift = -legs[axis, 1]
    com, velocity = com_flow_by(
        observation.com[axis], observation.com_velocity[axis] - drift, pivot, parameters.omega,
        growth,
    )  # fmt: skip
    observation.com[axis] = com + drift * duration
    observation.com_velocity[axis] = velocity + drift


@njit(forceinline=True)
def _uses_trunk(parameters, command, observation) -> bool:
    """Whether the trunk turns in this cycle; most methods leave it upright."""
    if parameters.max_torque == 0.0:
        return False
    for i in range(2):
        if command.hip_torque[i] != 0.0 or observation.trunk_lean_velocity[i] != 0.0:
            return True
    return False


@njit
def _move_com_and_trunk(parameters, command, zmp, pushes, legs, start, end, observation):
    """Like `_move_com` with a flywheel, which acts on the CoM until it meets its stop.

    Eight arguments: a record for these, made in every cycle, would only be unpacked again.
    """
    for i in range(2):
        limit = parameters.max_torque
        torque = min(max(command.hip_torque[i], -limit), limit)
        lean, speed, turning, momentum = trunk_flow(
            observation.trunk_lean[i],
            observation.trunk_lean_velocity[i],
            torque,
            parameters.inertia,
            parameters.max_lean,
            end - start,
        )
        observation.trunk_lean[i], observation.trunk_lean_velocity[i] = lean, speed
        time, stop = start, start + turning
        while time < end:
            force_x, force_y, until = force_until_change(pushes, time, end)
            force = force_x if i == 0 else force_y
            if time < stop:
                until = min(until, stop)
                force -= torque / parameters.com_height
            else:
                blow = momentum / (parameters.mass * parameters.com_height)
                observation.com_velocity[i] += parameters.push_gain * blow
                momentum = 0.0
            times = time - start, until - time, math.exp(parameters.omega * (until - time))
            _move_axis(parameters, i, force, zmp, legs, times, observation)
            time = until
        observation.dcm[i] = observation.com[i] + observation.com_velocity[i] / parameters.omega


@njit(forceinline=True)
def _move_foot(parameters, command, duration, observation):
    """Move the swing foot to where the command wants it, as far as the leg can."""
    speed, acceleration = parameters.max_speed, parameters.max_acceleration
    for i in range(2):
        away, velocity = follow(
            command.swing_foot[i] - observation.swing_foot[i],
            command.swing_foot_velocity[i],
            observation.swing_foot_velocity[i],
            duration,
            speed,
            acceleration,
        )
        # Where nothing holds it back it is there to the last bit.
        free = away == command.swing_foot[i] - observation.swing_foot[i]
        moved = observation.swing_foot[i] + away
        observation.swing_foot[i] = command.swing_foot[i] if free else moved
        observation.swing_foot_velocity[i] = velocity
    observation.swing_foot[2] = command.swing_foot[2]
    observation.swing_foot_velocity[2] = command.swing_foot_velocity[2]
    observation.swing_yaw = command.swing_yaw


@njit(forceinline=True)
def _touch_down(observation):
    """The swing foot becomes the support foot, where it is; the other one leaves the ground."""
    for i in range(2):
        landed = observation.swing_foot[i]
        observation.swing_foot[i] = observation.support_foot[i]
        observation.support_foot[i] = landed
    landed_yaw, observation.swing_yaw = observation.swing_yaw, observation.support_yaw
    observation.support_yaw = landed_yaw
    observation.swing_foot[2] = 0.0
    for i in range(3):
        observation.swing_foot_velocity[i] = 0.0
    observation.support_side = -observation.support_side
    observation.elapsed = 0.0


@njit(forceinline=True)
def _time_of_landing(parameters, world, command, end, next_world):
    """When the foot meets the ground, since the last touchdown [s]: as commanded on even ground."""
    elapsed, shift = world.observation.elapsed, parameters.touchdown_shift
    # The foot cannot land in the cycle in which it leaves the ground, whatever is commanded.
    landing = max(command.step_duration + min(shift, 0.0), elapsed, parameters.period)
    next_world.due = world.due
    if shift <= 0.0:
        return landing
    if world.due == 0.0 and landing <= end + SLIVER * parameters.period:
        next_world.due = landing
    # What a controller commands later does not hurry the ground.
    return max(next_world.due + shift, elapsed) if next_world.due > 0.0 else math.inf


@njit(forceinline=True)
def lipm_cycle(parameters, world, command, pushes, next_world):
    """One cycle of the world over records.

    Args:
        parameters: a `LIPM_PARAMETERS` record.
        world: a `LIPM_WORLD` record, not changed.
        command: a `COMMAND` record.
        pushes: array of `PUSH` records.
        next_world: a `LIPM_WORLD` record, written.
    """
    next_world.observation = world.observation
    next_world.step_start, next_world.steps = world.step_start, world.steps
    observation = next_world.observation
    elapsed = observation.elapsed
    end = (world.cycle + 1) * parameters.period
    landing = _time_of_landing(parameters, world, command, end, next_world)
    # A landing a rounding error after the end of the cycle is in it, not in a cycle of its own.
    touchdown = landing <= end + SLIVER * parameters.period
    if touchdown:
        end = landing
    start_time, end_time = observation.time, world.step_start + end
    if world.due == 0.0:
        _move_foot(parameters, command, end - elapsed, observation)
    else:
        observation.swing_foot_velocity[:] = 0.0
    next_world.zmp, next_world.legs = command.zmp, world.legs
    if parameters.foot_gain > 0.0 and end > elapsed:
        before = world.observation
        swing_legs(
            parameters, before.swing_foot, before.swing_foot_velocity, end - elapsed, next_world
        )
        if parameters.legs_known:
            place_zmp(parameters, command, end - elapsed, next_world)
    zmp, legs = next_world.zmp, next_world.legs
    if _uses_trunk(parameters, command, observation):
        _move_com_and_trunk(
            parameters, command, zmp, pushes, legs, start_time, end_time, observation
        )
    else:
        _move_com(parameters, zmp, pushes, legs, start_time, end_time, observation)
    observation.time, observation.elapsed = end_time, end
    next_world.cycle = world.cycle + 1
    if touchdown:
        if parameters.landing_error > 0.0:
            misplace(parameters.landing_error, parameters.seed, world.steps, observation)
        if parameters.foot_gain > 0.0:
            stop_leg(parameters, observation)
        _touch_down(observation)
        next_world.step_start, next_world.cycle, next_world.due = end_time, 0, 0.0
        next_world.steps += 1
    distance = length(
        observation.dcm[0] - observation.support_foot[0],
        observation.dcm[1] - observation.support_foot[1],
    )
    # NaN counts as a fall.
    next_world.fallen = 0 if distance <= parameters.fall_distance else 1


@njit
def _lipm_step(parameters, world, command, pushes, next_world):
    lipm_cycle(parameters[0], world[0], command[0], pushes, next_world[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_lipm_step, LIPM_PARAMETERS, LIPM_WORLD, COMMAND, PUSH, LIPM_WORLD)


@dataclass(frozen=True)
class LipmSimulator:
    """Moves the linear inverted pendulum under commands and pushes.

    Args:
        robot: mass, height, leg speed and trunk of the plant; it may differ from the controller's.
        period: control period [s].
        pushes: forces on the CoM.
        disturbance: of where and when feet land; what is measured is the matter of `PointSensors`.
        believed: the robot of the controller, if it is another one; it has fallen when the DCM is
            further from the support foot than steps of either can save: see
            `dcm.viability.fall_distance`.

    Raises:
        ParameterError: the period is not positive.
    """

    robot: Robot
    period: float = 0.001
    pushes: Sequence[Push] = ()
    disturbance: Disturbance | None = None
    believed: Robot | None = None
    parameters: NDArray[np.void] = attribute(init=False, repr=False, compare=False)
    push_array: NDArray[np.void] = attribute(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_number("period", self.period, 0.0, "s", above=True)
        parameters = new_array(LIPM_PARAMETERS)
        pendulum = three_mass(self.robot)
        parameters["omega"], parameters["mass"] = pendulum_omega(self.robot), self.robot.mass
        parameters["foot_gain"] = pendulum.foot_gain
        parameters["push_gain"] = self.robot.com_height / pendulum.height
        parameters["legs_known"] = self.robot.legs is not None and self.robot.legs.known
        parameters["expected_omega"] = self.robot.omega
        parameters["half_foot"] = self.robot.foot.half
        parameters["period"], parameters["max_speed"] = self.period, self.robot.swing.max_speed
        parameters["max_acceleration"] = self.robot.swing.max_acceleration
        parameters["com_height"] = self.robot.com_height
        moved = self.robot.replace(com_height=pendulum.height, legs=None)
        parameters["fall_distance"] = fall_distance(moved, self.believed)
        trunk = self.robot.trunk
        if trunk is not None:
            parameters["inertia"] = trunk.inertia
            parameters["max_torque"], parameters["max_lean"] = trunk.max_torque, trunk.max_lean
        if self.disturbance is not None:
            for name in ("landing_error", "touchdown_shift", "seed"):
                parameters[name] = getattr(self.disturbance, name)
        object.__setattr__(self, "pushes", tuple(self.pushes))
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "push_array", push_records(self.pushes))

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return lipm_cycle

    def pushed_by(self, records: NDArray[np.void]) -> LipmSimulator:
        """A copy under other pushes, which are `PUSH` records already, shape (pushes,)."""
        other = copy(self)
        object.__setattr__(other, "pushes", ())
        object.__setattr__(other, "push_array", records)
        return other

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The world that looks like this observation; its DCM is that of this robot's pendulum."""
        world = new_array(LIPM_WORLD)
        world["observation"] = observation.array
        dcm = observation.com + observation.com_velocity / pendulum_omega(self.robot)
        if np.abs(dcm - observation.dcm).max() > OTHER_PENDULUM * self.robot.com_height:
            world["observation"]["dcm"] = dcm
        world["step_start"] = observation.time - observation.elapsed
        world["cycle"] = round(observation.elapsed / self.period)
        return world

    def step(
        self, world: NDArray[np.void], command: Command
    ) -> tuple[Observation, NDArray[np.void]]:
        """Move the world by one cycle: what is observed then, and the world then."""
        next_world = new_array(LIPM_WORLD)
        _compiled()(self.parameters, world, command.array, self.push_array, next_world)
        return Observation.of(next_world["observation"]), next_world
