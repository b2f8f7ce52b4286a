"""Whether an observation can be true: what a robot can do between two cycles, in its own lengths.

All bounds follow from the robot: natural frequency, hip, sole, box of steps and their times.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.dcm.viability import fall_distance
from surefoot.record import Record, field
from surefoot.robot.robot import Robot


class Gate(Record):
    """What a robot can do between two cycles, and what it is predicted with."""

    omega: float = field("1/s", "natural frequency")
    period: float = field("s", "control period")
    jump: float = field("m", "how far anything moves unexpectedly in a cycle")
    reach: float = field("m", "how far the feet can be apart")
    max_dcm_offset: float = field("m", "how far the DCM can be from the foot that carries")
    max_swing: float = field("m", "how far the swing foot moves between two valid cycles")
    slack: float = field("s", "by how much a clock may be wrong or late")
    soonest: float = field("s", "from a touchdown to the next one, at least")
    longest: float = field("s", "duration of a step")
    weight: float = field("N", "of the robot")
    inertia: float = field("kg m^2", "of its trunk", default=0.0)
    max_lean: float = field("rad", "of its trunk", default=0.0)
    confirm: int = field("", "after how many cycles more what is consistent is accepted")


JUMP_PART = 0.25
"""Of the length that steps make up for: what moves further unexpectedly in one cycle waits to
be confirmed. A push of 5 ms that is just survived moves the DCM by a fifth of it in 1 ms."""

MAX_SPANS = 4.0
"""Half the width of the box of steps, so many times: a sequence of steps makes up for that much."""

SLACK_PART, SLACK_PERIODS = 0.1, 4.0
"""Part of the shortest step, or periods if that is more, by which a clock may be wrong: a landing
that is off by as much is survived."""

SOONEST_PART = 0.25
"""Of the shortest step: so soon after a touchdown another one is a contact that bounces."""

CONFIRM_GROWTH, MAX_CONFIRM = 0.01, 3
"""A blow is answered no later than after a growth of the DCM by this part, but one cycle has to
confirm it; at most so many do."""

OUT_OF_REACH = 1.25
"""A DCM this many times further than any that can still be saved is that of a fallen robot."""

SAME_TIME = 1e-6
"""Times that differ by less than this fraction of a period are the same."""

HALF_TURN = math.pi
"""No trunk leans further, or turns by more than a radian in a period [rad]."""


def gate_parameters(robot: Robot, period: float) -> Gate:
    """The gate of a robot and a control period [s]."""
    gait = robot.gait
    shortest, longest = gait.step_duration
    growth = math.exp(min(robot.omega * shortest, 30.0))
    outer = robot.hip + gait.step_y[1]
    ahead = max(-gait.step_x[0], gait.step_x[1])
    spans = 0.5 * (gait.step_x[1] - gait.step_x[0]), 0.5 * (gait.step_y[1] - gait.step_y[0])
    # What steps make up for, as the DCM at the end of a step; of very short ones not all of it.
    part = min(1.0 / (growth - 1.0), MAX_SPANS)
    mended = (robot.foot.half[i] + part * spans[i] for i in range(2))
    jump = JUMP_PART * max(robot.hip, *mended)
    slack = max(SLACK_PART * shortest, SLACK_PERIODS * period)
    cycles = round(CONFIRM_GROWTH / (robot.omega * period))
    gate = Gate(
        omega=robot.omega,
        period=period,
        jump=jump,
        reach=math.hypot(ahead, outer) + jump,
        max_dcm_offset=OUT_OF_REACH * fall_distance(robot),
        max_swing=robot.swing.max_speed * slack + jump,
        slack=slack,
        soonest=SOONEST_PART * shortest,
        longest=longest,
        weight=robot.mass * robot.gravity,
        confirm=min(max(cycles, 1), MAX_CONFIRM),
    )
    if robot.trunk is None:
        return gate
    return gate.replace(inertia=robot.trunk.inertia, max_lean=robot.trunk.max_lean)


@njit(forceinline=True)
def is_near(value: float, other: float, most: float) -> bool:
    """Whether two numbers differ by no more than this."""
    # A comparison with a NaN is false.
    return abs(value - other) <= most


@njit
def is_slightly_rotated(yaw: float, before: float) -> bool:
    """Whether two headings differ by no more than a radian."""
    turn = yaw - before
    if not abs(turn) < 1e6:
        return False
    return abs(turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)) <= 1.0


@njit(forceinline=True)
def is_in_reach(gate, now) -> bool:
    """Whether the feet are not too far from each other."""
    away_x = now.swing_foot[0] - now.support_foot[0]
    away_y = now.swing_foot[1] - now.support_foot[1]
    return away_x * away_x + away_y * away_y <= gate.reach * gate.reach


@njit(forceinline=True)
def feet_fit(gate, jump, last, command, now) -> bool:
    """Whether the feet can have come from where they were."""
    same = now.support_side == last.support_side
    fit = is_in_reach(gate, now)
    if not fit and same:
        # A leg without limits may have been sent anywhere on its way.
        fit = True
        for i in range(2):
            fit = fit and is_near(now.swing_foot[i], command.swing_foot[i], jump)
    fit = fit and abs(now.swing_foot[2]) <= gate.reach
    # Landings in one period are as fast as feet get.
    fastest = 4.0 * gate.reach / gate.period
    for i in range(3):
        fit = fit and abs(now.swing_foot_velocity[i]) <= fastest
    if same:
        for i in range(2):
            fit = fit and is_near(now.support_foot[i], last.support_foot[i], jump)
            fit = fit and is_near(now.swing_foot[i], last.swing_foot[i], gate.max_swing)
        if now.support_yaw != last.support_yaw:
            fit = fit and is_slightly_rotated(now.support_yaw, last.support_yaw)
        if now.swing_yaw != last.swing_yaw:
            fit = fit and is_slightly_rotated(now.swing_yaw, last.swing_yaw)
        return fit
    # A touchdown: the feet change places.
    fit = fit and now.support_side == -last.support_side and last.elapsed >= gate.soonest
    for i in range(2):
        fit = fit and is_near(now.swing_foot[i], last.support_foot[i], jump)
        fit = fit and is_near(now.support_foot[i], last.swing_foot[i], gate.max_swing)
        fit = fit and is_near(now.support_foot[i], last.support_foot[i], gate.reach)
    fit = fit and is_slightly_rotated(now.support_yaw, last.swing_yaw)
    return fit and is_slightly_rotated(now.swing_yaw, last.support_yaw)


@njit(forceinline=True)
def clock_fits(gate, time, began, now, landed) -> bool:
    """Whether clock and time since touchdown have gone on since `time`, and fit each other."""
    passed, elapsed = now.time - time, now.elapsed
    fit = passed >= 0.0 and passed <= gate.slack
    fit = fit and elapsed >= -gate.period * (1.0 + SAME_TIME)
    if landed:
        return fit and elapsed <= passed + gate.slack
    return fit and is_near(now.time - elapsed, began, gate.slack)


@njit(forceinline=True)
def pendulum_fits(gate, jump, last, zmp, now, passed) -> bool:
    """Whether the pendulum can have come from where it was, about this ZMP."""
    turn = gate.omega * passed
    turn *= 1.0 + 0.5 * turn
    fit = True
    for i in range(2):
        dcm = last.dcm[i] + turn * (last.dcm[i] - zmp[i])
        fit = fit and is_near(now.dcm[i], dcm, jump)
        fit = fit and is_near(now.com[i], last.com[i] + passed * last.com_velocity[i], jump)
        fit = fit and is_near(now.com_velocity[i], last.com_velocity[i], gate.omega * jump)
    return fit


@njit(forceinline=True)
def is_upright(gate, now, foot) -> bool:
    """Whether the DCM is where a robot on this foot can have it; further off it has fallen."""
    far_x, far_y = now.dcm[0] - foot[0], now.dcm[1] - foot[1]
    return far_x * far_x + far_y * far_y <= gate.max_dcm_offset * gate.max_dcm_offset


@njit(forceinline=True)
def trunk_fits(gate, now) -> bool:
    """Whether a trunk can lean and turn like this."""
    fit = True
    for i in range(2):
        fit = fit and abs(now.trunk_lean[i]) <= HALF_TURN
        fit = fit and abs(now.trunk_lean_velocity[i]) * gate.period <= 1.0
    return fit
