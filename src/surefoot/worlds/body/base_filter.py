"""Pose and velocity of the base from an inertial measurement unit and the standing feet.

An extended Kalman filter as in [Bloesch2012]: gyroscope w and accelerometer f carry the state on,

    R <- R exp((w - b) dt),   v <- v + (R f + g) dt,   p <- p + v dt,

and every foot that stands says where the base is, since it stays where it is:

    R^T (d - p) = s(q),   heading of R R_s(q) = h,

with the sole at s, R_s in the frame of the base by the leg's kinematics. State: orientation R,
velocity v, position p, places d and headings h of both soles, offset b of the gyroscope. The
orientation's error is a small turn about the axes of the world. Gravity needs no part of its own:
a base that is thought to lean is thought to accelerate, and the feet say that it does not.

A foot that touches down is put where the kinematics has it, and its height is drawn to the floor's.
Its place is the less certain with time the lighter it stands. A leg that swings turns the other's
sole on the floor, by hundredths of a radian, one way with the left and the other with the right: a
heading that was believed then would pass for an offset of the gyroscope. That is found in a stand,
and while the robot walks the gyroscope is believed more than the headings. Where a foot is off by
more than `TRUSTED` standard deviations it is taken to have slipped: it is made so uncertain that it
is off by just that many. Position and heading in the world are remembered, not measured: they
drift.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.geometry import rotate, rotate_in_world, rotation_matrix
from surefoot.record import Array, Record, Vector2, Vector3, field
from surefoot.robot.robot import STANDARD_GRAVITY

TILT, VELOCITY, POSITION, FEET, HEADINGS, BIAS, ERRORS = 0, 3, 6, 9, 15, 17, 20
"""Where the errors of the state's parts start in the covariance, and how many there are."""


class Base(Record):
    """The state of the base's filter, and what is remembered of its readings."""

    orientation: Array = field("-", "quaternion", shape=4)
    velocity: Vector3 = field("m/s", "in the world")
    position: Vector3 = field("m", "in the world")
    feet: Array = field("m", "soles in the world", shape=(2, 3))
    headings: Vector2 = field("rad", "of the soles in the world")
    bias: Vector3 = field("rad/s", "offset of the gyroscope")
    turning: Vector3 = field("rad/s", "angular velocity in the frame of the base")
    standing: Vector2 = field("s", "for how long each sole has stood, 0 if it does not")
    load: Vector2 = field("N", "force on each sole that noise does not explain")
    evidence: Vector2 = field("N", "how much speaks for one, see `readings`")
    withheld: Array = field(
        "rad/s, m/s^2",
        "sums of what gyroscope and accelerometer measured, over what was expected, in readings in "
        "a row that were left out",
        shape=(2, 3),
    )
    doubts: Array = field(
        "-",
        "readings in a row that were left out: of gyroscope, accelerometer, left and right sole",
        shape=4,
        kind=int,
    )
    covariance: Array = field("", "of the errors", shape=(ERRORS, ERRORS))
    cycles: int = field("-", "how many there were")


class BaseNoise(Record):
    """What the base's filter knows: standard deviations, and what these refer to."""

    encoder: float = field("rad", "of a joint's angle")
    gyro: float = field("rad/s", "of the angular velocity")
    accelerometer: float = field("m/s^2", "of the acceleration")
    gyro_bias: float = field("rad/s", "of the gyroscope's first offset")
    bias_walk: float = field("rad/s^1.5", "random walk of that")
    slip: float = field("m/s^0.5", "random walk of a sole that stands with full weight")
    light_slip: float = field("m/s^0.5", "what is added to it without any")
    landing_slip: float = field("m/s^0.5", "what is added to it at touchdown")
    twist: float = field("rad/s^0.5", "random walk of a sole's heading while both stand")
    swing_twist: float = field("rad/s^0.5", "what is added to it while the other leg swings")
    floor: float = field("m", "of the height of the floor")
    force: float = field("N", "of the force on a sole")
    load: float = field("N", "half of the robot's weight")
    settling: float = field(
        "s", "within which a foot comes to rest after touchdown, but for 1 / e of its motion"
    )
    period: float = field("s", "of control")


class Row(Record):
    """A measurement as a row of the filter."""

    errors: Array = field("", "the sum of the errors that it contains", shape=ERRORS)
    off: float = field("", "by how much it differs from what is expected")
    variance: float = field("", "of that")
    first: int = field("", "of the errors that are made larger if it differs too much")
    last: int = field("", "one behind the last of them")


BASE, ROW = Base.DTYPE, Row.DTYPE

TRUSTED = 3.0
"""Standard deviations beyond which a foot has slipped."""


@njit
def carry_on(base, noise, acceleration):
    """Move the state on by one period: `base.turning` after it, `acceleration` in the world.

    Args:
        base: a `Base`, changed.
        noise: a `BaseNoise`.
        acceleration: (3,) of the base during the period, gravity included [m/s^2].
    """
    dt, c = noise.period, base.covariance
    R = np.empty((3, 3))
    rotation_matrix(base.orientation, R)
    force, turn = np.empty(3), np.empty(3)
    for i in range(3):
        force[i] = acceleration[i] + (STANDARD_GRAVITY if i == 2 else 0.0)
        turn[i] = base.turning[i] * dt
        base.velocity[i] += acceleration[i] * dt
        base.position[i] += base.velocity[i] * dt
    rotate(base.orientation, turn, base.orientation)
    _carry_rows(c, force, R, dt)
    _transpose(c)
    _carry_rows(c, force, R, dt)
    _symmetrise(c)
    for i in range(3):
        c[TILT + i, TILT + i] += (noise.gyro * dt) ** 2
        c[VELOCITY + i, VELOCITY + i] += (noise.accelerometer * dt) ** 2
        c[BIAS + i, BIAS + i] += noise.bias_walk**2 * dt


@njit
def _symmetrise(c):
    """Keep rounding from making a symmetric matrix less so, cycle after cycle."""
    for i in range(ERRORS):
        for j in range(i):
            c[i, j] = c[j, i] = 0.5 * (c[i, j] + c[j, i])


@njit
def _transpose(c):
    """Exchange rows and columns, to do with these what has been done with those."""
    for i in range(ERRORS):
        for j in range(i):
            c[i, j], c[j, i] = c[j, i], c[i, j]


@njit
def _carry_rows(c, force, R, dt):
    """Errors after a period, of rows of the covariance; `force` is R f."""
    for j in range(ERRORS):
        x, y, z = c[TILT, j], c[TILT + 1, j], c[TILT + 2, j]
        c[VELOCITY, j] += dt * (y * force[2] - z * force[1])
        c[VELOCITY + 1, j] += dt * (z * force[0] - x * force[2])
        c[VELOCITY + 2, j] += dt * (x * force[1] - y * force[0])
        for i in range(3):
            c[POSITION + i, j] += dt * c[VELOCITY + i, j]
            for k in range(3):
                c[TILT + i, j] -= dt * R[i, k] * c[BIAS + k, j]


@njit
def landing(base, noise, foot) -> float:
    """How much of a touchdown is left: 1 when a foot touches down, then less; 0 in the air."""
    return math.exp(-base.standing[foot] / noise.settling) if base.standing[foot] > 0.0 else 0.0


@njit
def _widen_foot(base, noise, foot, load, alone):
    """A standing sole is less certain after a period: the lighter it is, and if it is `alone`."""
    light = 1.0 - min(max(load / noise.load, 0.0), 1.0) if math.isfinite(load) else 1.0
    fresh = landing(base, noise, foot)
    slip = noise.slip**2 + (light * noise.light_slip) ** 2 + (fresh * noise.landing_slip) ** 2
    twist = noise.twist**2 + (noise.swing_twist**2 if alone else 0.0)
    base.standing[foot] += noise.period
    for i in range(3):
        here = FEET + 3 * foot + i
        base.covariance[here, here] += slip * noise.period
    here = HEADINGS + foot
    base.covariance[here, here] += twist * noise.period


@njit
def _heading(R, sole):
    """Of a sole, from the rotation of the base in the world and of the sole in the base [rad]."""
    x = R[0, 0] * sole[0, 0] + R[0, 1] * sole[1, 0] + R[0, 2] * sole[2, 0]
    y = R[1, 0] * sole[0, 0] + R[1, 1] * sole[1, 0] + R[1, 2] * sole[2, 0]
    return math.atan2(y, x)


@njit
def put_foot(base, noise, soles, foot):
    """Put a foot that has touched down where the kinematics says, and forget where it stood.

    Args:
        base: a `Base`, changed.
        noise: a `BaseNoise`.
        soles: a `Soles`.
        foot: 0 left, 1 right.
    """
    R, c = np.empty((3, 3)), base.covariance
    rotation_matrix(base.orientation, R)
    arm = np.zeros(3)
    for i in range(3):
        for k in range(3):
            arm[i] += R[i, k] * soles.position[foot, k]
    here, turn = FEET + 3 * foot, HEADINGS + foot
    base.headings[foot] = _heading(R, soles.rotation[foot])
    for i in range(3):
        base.feet[foot, i] = base.position[i] + arm[i]
    _put_rows(c, arm, here, turn)
    _transpose(c)
    _put_rows(c, arm, here, turn)
    for k in range(3):
        spread = (noise.encoder * soles.spread[foot, k]) ** 2
        for i in range(3):
            for j in range(3):
                c[here + i, here + j] += R[i, k] * spread * R[j, k]
    c[turn, turn] += (noise.encoder * soles.turn_spread[foot]) ** 2
    base.standing[foot] = noise.period


@njit
def _put_rows(c, arm, here, turn):
    """Errors of a foot put at `arm` from the base, as rows of the covariance."""
    for j in range(ERRORS):
        x, y, z = c[TILT, j], c[TILT + 1, j], c[TILT + 2, j]
        c[here, j] = c[POSITION, j] + y * arm[2] - z * arm[1]
        c[here + 1, j] = c[POSITION + 1, j] + z * arm[0] - x * arm[2]
        c[here + 2, j] = c[POSITION + 2, j] + x * arm[1] - y * arm[0]
        c[turn, j] = z


@njit
def _foot_rows(base, noise, soles, foot, rows, first):
    """Place and heading of a standing foot by the kinematics, four rows."""
    R = np.empty((3, 3))
    rotation_matrix(base.orientation, R)
    dx = base.feet[foot, 0] - base.position[0]
    dy = base.feet[foot, 1] - base.position[1]
    dz = base.feet[foot, 2] - base.position[2]
    here, turn = FEET + 3 * foot, HEADINGS + foot
    for k in range(3):
        ex, ey, ez = R[0, k], R[1, k], R[2, k]
        row = rows[first + k]
        errors = row.errors
        errors[TILT], errors[TILT + 1], errors[TILT + 2] = (
            ey * dz - ez * dy,
            ez * dx - ex * dz,
            ex * dy - ey * dx,
        )
        for i in range(3):
            errors[POSITION + i], errors[here + i] = -R[i, k], R[i, k]
        row.off = soles.position[foot, k] - (ex * dx + ey * dy + ez * dz)
        row.variance = (noise.encoder * soles.spread[foot, k]) ** 2
        row.first, row.last = here, here + 3
    row = rows[first + 3]
    row.errors[TILT + 2], row.errors[turn] = -1.0, 1.0
    off = _heading(R, soles.rotation[foot]) - base.headings[foot]
    row.off = off - 2.0 * math.pi * round(off / (2.0 * math.pi))
    row.variance = (noise.encoder * soles.turn_spread[foot]) ** 2
    row.first, row.last = turn, turn + 1


@njit
def _floor_row(base, noise, foot, row):
    """A foot that has just touched down is about as high as the floor."""
    row.errors[FEET + 3 * foot + 2] = 1.0
    row.off, row.variance = -base.feet[foot, 2], noise.floor**2
    row.first = row.last = 0


@njit
def _allow_slip(c, row):
    """Make a foot that is off by over `TRUSTED` deviations so uncertain that it is off by them.

    Its errors are measured along perpendicular directions, so the order does not matter.
    """
    spread = row.variance
    for i in range(ERRORS):
        if row.errors[i] != 0.0:
            for j in range(ERRORS):
                spread += row.errors[i] * c[i, j] * row.errors[j]
    excess = (row.off / TRUSTED) ** 2 - spread
    if excess > 0.0:
        for i in range(row.first, row.last):
            for j in range(row.first, row.last):
                c[i, j] += excess * row.errors[i] * row.errors[j]


@njit
def _correct(c, found, row):
    """Correct the covariance, and the errors `found` so far, by one measurement."""
    g, spread, off = np.zeros(ERRORS), row.variance, row.off
    for i in range(ERRORS):
        if row.errors[i] != 0.0:
            for j in range(ERRORS):
                g[j] += c[i, j] * row.errors[i]
            off -= row.errors[i] * found[i]
    for i in range(ERRORS):
        spread += row.errors[i] * g[i]
    scale = 1.0 / math.sqrt(spread)
    for i in range(ERRORS):
        g[i] *= scale
        found[i] += g[i] * scale * off
    for i in range(ERRORS):
        for j in range(ERRORS):
            c[i, j] -= g[i] * g[j]


@njit
def correct_by_feet(base, noise, soles, feet, force):
    """Correct the state by the feet that stand.

    Args:
        base: a `Base`, changed.
        noise: a `BaseNoise`.
        soles: a `Soles`.
        feet: (2,) which soles stand, 1 or 0.
        force: (2,) on the soles [N].
    """
    rows, count = np.zeros(8, ROW), 0
    for foot in range(2):
        if feet[foot] == 0:
            base.standing[foot] = 0.0
        elif base.standing[foot] == 0.0:
            put_foot(base, noise, soles, foot)
            _floor_row(base, noise, foot, rows[count])
            count += 1
        else:
            _widen_foot(base, noise, foot, force[foot], feet[1 - foot] == 0)
            _foot_rows(base, noise, soles, foot, rows, count)
            count += 4
    found = np.zeros(ERRORS)
    for k in range(count):
        _allow_slip(base.covariance, rows[k])
    for k in range(count):
        _correct(base.covariance, found, rows[k])
    _add_errors(base, found)


@njit
def _add_errors(base, found):
    """Take the errors that were found out of the state."""
    turn = np.empty(3)
    for i in range(3):
        turn[i] = found[TILT + i]
        base.velocity[i] += found[VELOCITY + i]
        base.position[i] += found[POSITION + i]
        base.bias[i] += found[BIAS + i]
        base.turning[i] -= found[BIAS + i]
        for foot in range(2):
            base.feet[foot, i] += found[FEET + 3 * foot + i]
    for foot in range(2):
        base.headings[foot] += found[HEADINGS + foot]
    rotate_in_world(base.orientation, turn, base.orientation)
