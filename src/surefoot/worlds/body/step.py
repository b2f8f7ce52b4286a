"""A step of a body over records: what a controller is given, and what it asks of the body.

A controller walks in a frame that has the heading of the step under way, with the world's origin.
It is given the DCM that goes with the angular momentum L about the sole on the ground,

    xi = c + L x e_z / (m h omega),

since that is what the ZMP moves: the momentum of a heavy leg that swings is in it, and does not
look like a push ([Gong2022]).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from surefoot.compiled import entry_point, njit
from surefoot.dcm.swing_foot import quintic
from surefoot.interface import COMMAND, OBSERVATION
from surefoot.record import Record, Vector3, field
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.mechanics import MOTION

STAND, SHIFT, WALK = 0, 1, 2
"""Phases of a body: on both feet; moving the DCM to where the first step begins; walking."""


class BodyWalk(Record):
    """What evolves in the walk of a body, beside the state of its controller."""

    phase: int = field("", "`STAND`, `SHIFT` or `WALK`")
    support: int = field("", "0 or 1 for the left or right foot on the ground")
    steps: int = field("-", "steps done")
    began: float = field("s", "when phase or step began")
    now: float = field("s", "time of the cycle")
    landed: int = field("", "whether the swinging foot has just landed")
    touched: float = field("N", "sum of its forces since it touched the ground")
    touches: int = field("-", "in how many cycles it did")
    heading: float = field("rad", "of the controller's frame")
    swing_foot: Vector3 = field("m", "reference of the swinging sole, z over the standing one")
    swing_foot_velocity: Vector3 = field("m/s", "likewise")
    swing_foot_acceleration: Vector3 = field("m/s^2", "likewise")
    swing_yaw: float = field("rad", "likewise, its heading")
    swing_yaw_rate: float = field("rad/s", "likewise")


class BodyLimits(Record):
    """What is fixed in the walk of a body."""

    omega: float = field("1/s", "natural frequency of the controller")
    height: float = field("m", "of the CoM")
    hip: float = field("m", "distance of the hips")
    leg: float = field("m", "from hip to ankle at its longest")
    ankle: float = field("m", "height of the ankle over the sole")
    hip_over_com: float = field("m", "middle of the hips over the CoM")
    hip_ahead: float = field("m", "middle of the hips ahead of the CoM")
    settle_time: float = field("s", "standing before the first step")
    shift_time: float = field("s", "moving the DCM to where that begins")
    max_lead: float = field("m", "how far the course goes ahead")
    max_drop: float = field("m", "how far the CoM may sink")
    height_stiffness: float = field("1/s^2", "of its height")
    max_lift: float = field("m/s^2", "largest vertical acceleration")
    touch_force: float = field("N", "smallest force of a landing")
    sink: float = field("m/s", "speed of a foot that waits for the ground")
    mass: float = field("kg", "of the body")
    period: float = field("s", "of control")
    apex: float = field("m", "of the swinging foot")
    landing_velocity: float = field("m/s", "of the foot")
    step_duration: float = field("s", "of a step in which the foot lands at that speed")
    min_distance: float = field("m", "least distance of the soles across")
    braking: float = field("m/s^2", "how hard the foot can brake before it")
    soon_down: float = field("m", "a sole that is higher cannot be landing")
    down: float = field("m", "a sole that is lower is about to land")
    min_rise: float = field("s", "nothing is to be reached sooner after the foot left the ground")
    min_flight: float = field("s", "no sole lands sooner after it left the ground")


BODY_WALK, BODY_LIMITS = BodyWalk.DTYPE, BodyLimits.DTYPE

SOON_DOWN = 0.6
"""Part of its apex above which a sole cannot be landing: a floor that comes up to meet it is no
higher."""

RISE = 0.45
"""Part of a step in which the foot rises."""

NEARLY = 0.8
"""Part of the apex that counts as reached."""

DOWN, UNEXPECTED = 0.2, 5
"""Part of its apex below which a sole is about to land. Higher up, on a bump, it must touch for so
many cycles in a row: a force for a few of them may be the fault of a sensor."""

MIN_RISE, MIN_FLIGHT = 0.15, 0.3
"""Parts of the shortest step: before the first nothing is to be reached, and before the second a
sole that has left the ground does not land."""

SURE = 3.0
"""Forces in a row that mean a landing must add up to this many of the smallest: one that is weak is
noise, one that is strong is not waited for."""


@njit
def pendulum_velocity(limits, com, com_velocity, momentum, foot, velocity):
    """Write L x e_z / (m h), the velocity of a point mass with the same momentum about the foot."""
    x, y, z = com[0] - foot[0], com[1] - foot[1], com[2] - foot[2]
    h = limits.height
    velocity[0] = (momentum[1] / limits.mass + z * com_velocity[0] - x * com_velocity[2]) / h
    velocity[1] = (-momentum[0] / limits.mass + z * com_velocity[1] - y * com_velocity[2]) / h


@njit
def rotate_into(vector, heading, out):
    """Write the horizontal part of a vector of the world in a frame of that heading."""
    cosine, sine = math.cos(heading), math.sin(heading)
    x, y = vector[0], vector[1]
    out[0], out[1] = cosine * x + sine * y, cosine * y - sine * x


@njit
def _yaw(axes):
    return math.atan2(axes[1, 0], axes[0, 0])


@njit
def wrapped(angle):
    """The same angle between -pi and pi."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@njit
def _observe(limits, walk, motion, observation):
    """Write what the controller is given."""
    stance, heading = walk.support, walk.heading
    places, axes = motion.sole_position, motion.sole_axes
    velocity = np.empty(2)
    observation.time, observation.elapsed = walk.now, walk.now - walk.began
    pendulum_velocity(
        limits, motion.com, motion.com_velocity, motion.angular_momentum, places[stance], velocity
    )
    rotate_into(velocity, heading, observation.com_velocity)
    rotate_into(motion.com, heading, observation.com)
    for i in range(2):
        observation.dcm[i] = observation.com[i] + observation.com_velocity[i] / limits.omega
    rotate_into(places[stance], heading, observation.support_foot)
    rotate_into(walk.swing_foot, heading, observation.swing_foot)
    rotate_into(walk.swing_foot_velocity, heading, observation.swing_foot_velocity)
    observation.swing_foot[2] = max(walk.swing_foot[2], 0.0)
    observation.swing_foot_velocity[2] = walk.swing_foot_velocity[2]
    observation.support_yaw = wrapped(_yaw(axes[stance]) - heading)
    observation.swing_yaw = wrapped(walk.swing_yaw - heading)
    observation.support_side = 2 * stance - 1


@njit
def _has_landed(limits, walk, command, motion, forces):
    """Whether the swinging foot is on the ground: early, in time or late."""
    swing = 1 - walk.support
    elapsed = walk.now - walk.began
    if elapsed < limits.min_flight or elapsed < 0.5 * command.step_duration:
        return False
    height = motion.sole_position[swing, 2] - motion.sole_position[walk.support, 2]
    if not (height < limits.soon_down and forces[swing] > limits.touch_force):
        walk.touched, walk.touches = 0.0, 0
        return False
    walk.touched += forces[swing]
    walk.touches += 1
    expected = height < limits.down or walk.touches >= UNEXPECTED
    return expected and walk.touched >= SURE * limits.touch_force


@njit
def _measure(limits, walk, motion, command, forces, observation):
    w = walk[0]
    w.landed = 1 if _has_landed(limits[0], w, command[0], motion[0], forces) else 0
    if w.landed == 0:
        _observe(limits[0], w, motion[0], observation[0])


@njit
def _begin_step(walk, support, motion):
    """The other foot carries: its fellow leaves the ground from where it is."""
    swing = 1 - support
    walk.support, walk.began = support, walk.now
    walk.touched, walk.touches = 0.0, 0
    walk.steps += 1
    for i in range(3):
        walk.swing_foot[i] = motion.sole_position[swing, i]
        walk.swing_foot_velocity[i] = walk.swing_foot_acceleration[i] = 0.0
    walk.swing_foot[2] = 0.0
    walk.swing_yaw, walk.swing_yaw_rate = _yaw(motion.sole_axes[swing]), 0.0


@njit
def _swing_height(limits, walk, duration):
    """Write height, velocity and acceleration of the foot, one period on.

    Towards the apex in the first part of the step and down in the rest, each along a quintic from
    where it is. A step that is cut short has a lower apex, as the square of its time: a heavy leg
    that is thrown up and down throws the robot. An apex that is near, in place or time, is not
    aimed at any more, since a duration that changes would ask for it at once.
    """
    elapsed, period = walk.now - walk.began, limits.period
    z, v, a = walk.swing_foot[2], walk.swing_foot_velocity[2], walk.swing_foot_acceleration[2]
    part = min(duration / limits.step_duration, 1.0)
    top, end, final = RISE * duration, limits.apex * part * part, 0.0
    if top - elapsed < limits.min_rise or z > NEARLY * end:
        top, end, final = duration, 0.0, -limits.landing_velocity
    left = top - elapsed
    if left > period:
        z, v, a = quintic(z, v, a, end, final, left, period)
    else:
        late = max(elapsed - duration, 0.0)
        z, v, a = -limits.sink * late, -limits.sink, 0.0
    walk.swing_foot[2], walk.swing_foot_velocity[2], walk.swing_foot_acceleration[2] = z, v, a


@njit
def keep_apart(limits, walk, stance, place, velocity, acceleration):
    """Brake a foot that would come too near to its fellow: legs that meet are a fall.

    A swing that is planned anew towards a later landing swings through beyond it. Across the
    heading the foot is never faster than it can be stopped at the least distance, nor beyond that
    unless it was, and then it only moves out. All arguments are in the heading of the step.
    """
    side = 1.0 if walk.support == 1 else -1.0
    room = side * (place[1] - stance) - limits.min_distance
    inward = -side * velocity[1]
    fastest = math.sqrt(2.0 * limits.braking * max(room, 0.0))
    if inward > fastest:
        place[1] += side * (inward - fastest) * limits.period
        velocity[1] = -side * fastest
        acceleration[1] = side * limits.braking if fastest > 0.0 else 0.0


@njit
def _follow_swing(limits, walk, observation, command):
    """Take the foot of the command as reference, one period on; its height is the body's own."""
    period, elapsed = limits.period, walk.now - walk.began
    cosine, sine = math.cos(walk.heading), math.sin(walk.heading)
    late = elapsed - command.step_duration
    place, velocity, acceleration = np.empty(2), np.empty(2), np.empty(2)
    for i in range(2):
        place[i], velocity[i] = command.swing_foot[i], command.swing_foot_velocity[i]
        acceleration[i] = command.swing_foot_acceleration[i]
    keep_apart(limits, walk, observation.support_foot[1], place, velocity, acceleration)
    for out, vector in (
        (walk.swing_foot, place),
        (walk.swing_foot_velocity, velocity),
        (walk.swing_foot_acceleration, acceleration),
    ):
        x, y = vector[0], vector[1]
        out[0], out[1] = cosine * x - sine * y, sine * x + cosine * y
    yaw = wrapped(command.swing_yaw - wrapped(walk.swing_yaw - walk.heading))
    walk.swing_yaw_rate = yaw / period if late < -period else 0.0
    walk.swing_yaw += yaw
    _swing_height(limits, walk, command.step_duration)
    if late > -2.0 * period:
        for i in range(2):
            walk.swing_foot_velocity[i] = walk.swing_foot_acceleration[i] = 0.0


@njit
def _leg_height(limits, foot, com, side):
    """How high the CoM may be for a leg that is not stretched; `side` is half of +1 or -1 [m]."""
    x = foot[0] - com[0] - limits.hip_ahead
    y = foot[1] - com[1] - side * limits.hip
    reach = math.sqrt(max(limits.leg * limits.leg - x * x - y * y, 0.0))
    return limits.ankle + reach - limits.hip_over_com


@njit
def _wanted_height(limits, walk, observation, command):
    """Height of the CoM: as in the gait, less where a leg would be stretched, now or at landing.

    The CoM at landing is that of the pendulum about the ZMP of the command.
    """
    omega, stance = limits.omega, walk.support
    left = max(command.step_duration - observation.elapsed, 0.0)
    grow, fade = math.exp(omega * left), math.exp(-omega * left)
    then = np.empty(2)
    for i in range(2):
        fading = 2.0 * observation.com[i] - observation.dcm[i]
        pivot = command.zmp[i]
        then[i] = pivot + 0.5 * ((observation.dcm[i] - pivot) * grow + (fading - pivot) * fade)
    side = 0.5 if stance == 0 else -0.5
    foot, landing = observation.support_foot, command.step_location
    height = limits.height
    height = min(height, _leg_height(limits, foot, then, side))
    height = min(height, _leg_height(limits, landing, then, -side))
    height = min(height, _leg_height(limits, foot, observation.com, side))
    return max(height, limits.height - limits.max_drop)


@njit
def _hold_height(limits, height, ground, motion, reference):
    """Write the vertical acceleration that brings the CoM to a height over the ground."""
    k = limits.height_stiffness
    wanted = k * (height + ground - motion.com[2]) - 2.0 * math.sqrt(k) * motion.com_velocity[2]
    most = limits.max_lift
    reference.com_acceleration[2] = min(max(wanted, -most), most)
    reference.com[2] = height + ground


@njit
def _push_at(limits, motion, reference):
    """Write the CoM, and the acceleration that a pendulum has about the ZMP."""
    square = limits.omega * limits.omega
    for i in range(2):
        reference.com[i], reference.com_velocity[i] = motion.com[i], motion.com_velocity[i]
        reference.com_acceleration[i] = square * (motion.com[i] - reference.zmp[i])


@njit
def _refer_step(limits, walk, observation, command, motion, reference):
    """Write the reference of a body on one foot."""
    stance = walk.support
    reference.stands[stance], reference.stands[1 - stance] = 1, 0
    cosine, sine = math.cos(walk.heading), math.sin(walk.heading)
    zmp, ground = command.zmp, motion.sole_position[stance, 2]
    reference.zmp[0] = cosine * zmp[0] - sine * zmp[1]
    reference.zmp[1] = sine * zmp[0] + cosine * zmp[1]
    _push_at(limits, motion, reference)
    height = _wanted_height(limits, walk, observation, command)
    _hold_height(limits, height, ground, motion, reference)
    reference.swing_foot = walk.swing_foot
    reference.swing_foot_velocity = walk.swing_foot_velocity
    reference.swing_foot_acceleration = walk.swing_foot_acceleration
    reference.swing_foot[2] += ground
    reference.swing_yaw, reference.swing_yaw_rate = walk.swing_yaw, walk.swing_yaw_rate
    reference.trunk[2] = walk.heading


@njit
def _refer(limits, walk, motion, observation, command, reference):
    _follow_swing(limits[0], walk[0], observation[0], command[0])
    _refer_step(limits[0], walk[0], observation[0], command[0], motion[0], reference[0])


@njit
def _stand(limits, walk, motion, zmp, reference):
    out, m = reference[0], motion[0]
    out.stands[0] = out.stands[1] = 1
    out.zmp[0], out.zmp[1] = zmp[0], zmp[1]
    _push_at(limits[0], m, out)
    ground = 0.5 * (m.sole_position[0, 2] + m.sole_position[1, 2])
    _hold_height(limits[0], limits[0].height, ground, m, out)
    out.trunk[2] = walk[0].heading


@njit
def _begin(walk, support, motion):
    _begin_step(walk[0], support[0], motion[0])


class BodyKernels(NamedTuple):
    """The compiled functions of a cycle, over arrays of one record.

    Attributes:
        measure: (limits, walk, motion, command, forces, observation): whether the foot has landed,
            and if not what the controller is given.
        begin: (walk, support, motion): the other foot carries.
        refer: (limits, walk, motion, observation, command, reference): what the body is to do.
        stand: (limits, walk, motion, zmp, reference): likewise on both feet.
    """

    measure: Callable[..., None]
    begin: Callable[..., None]
    refer: Callable[..., None]
    stand: Callable[..., None]


@cache
def body_kernels() -> BodyKernels:
    """Compiled, or loaded from disk, once."""
    real, whole, own = np.dtype(np.float64), np.dtype(np.int64), (BODY_LIMITS, BODY_WALK, MOTION)
    return BodyKernels(
        measure=entry_point(_measure, *own, COMMAND, real, OBSERVATION),
        begin=entry_point(_begin, BODY_WALK, whole, MOTION),
        refer=entry_point(_refer, *own, OBSERVATION, COMMAND, BODY_REFERENCE),
        stand=entry_point(_stand, *own, real, BODY_REFERENCE),
    )
