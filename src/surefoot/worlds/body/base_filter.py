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
from surefoot.robot.robot import STANDARD_GRAVITY

TILT, VELOCITY, POSITION, FEET, HEADINGS, BIAS, ERRORS = 0, 3, 6, 9, 15, 17, 20
"""Where the errors of the state's parts start in the covariance, and how many there are."""

BASE = np.dtype(
    [
        ("orientation", "f8", (4,)),
        ("velocity", "f8", (3,)),
        ("position", "f8", (3,)),
        ("feet", "f8", (2, 3)),
        ("headings", "f8", (2,)),
        ("bias", "f8", (3,)),
        ("turning", "f8", (3,)),
        ("standing", "f8", (2,)),
        ("load", "f8", (2,)),
        ("evidence", "f8", (2,)),
        ("withheld", "f8", (2, 3)),
        ("doubts", "i8", (4,)),
        ("covariance", "f8", (ERRORS, ERRORS)),
        ("cycles", "i8"),
    ]
)
"""Quaternion; velocity [m/s], position [m], soles [m] and their headings [rad] in the world; offset
of the gyroscope and angular velocity in the frame of the base [rad/s]; for how long each sole has
stood, 0 if it does not [s]; force on each sole that noise does not explain, and how much speaks for
one, see `estimator` [N]; sums of what gyroscope and accelerometer said in readings in a row
that were not believed, over what was expected [rad/s, m/s^2], and how many there were: of
gyroscope, accelerometer, left and right sole; covariance of the errors; how many cycles there
were."""

BASE_NOISE = np.dtype(
    [
        ("encoder", "f8"),
        ("gyro", "f8"),
        ("accelerometer", "f8"),
        ("bias", "f8"),
        ("bias_walk", "f8"),
        ("slip", "f8"),
        ("light_slip", "f8"),
        ("landing_slip", "f8"),
        ("twist", "f8"),
        ("swing_twist", "f8"),
        ("floor", "f8"),
        ("force", "f8"),
        ("load", "f8"),
        ("settling", "f8"),
        ("period", "f8"),
    ]
)
"""Standard deviations: encoder [rad], gyroscope [rad/s], accelerometer [m/s^2], first offset of the
gyroscope [rad/s] and its random walk [rad/s^1.5]; random walk of a sole that stands with full
weight, what is added to it with none and at touchdown [m/s^0.5]; of its heading while both stand,
and what is added to it while the other leg swings [rad/s^0.5]; height of the floor [m]; forces on
the soles [N]. Half of the robot's weight [N]; within which a foot comes to rest after touchdown,
but for 1 / e of its motion, and the period [s]."""

ROW = np.dtype(
    [
        ("of", "f8", (ERRORS,)),
        ("off", "f8"),
        ("variance", "f8"),
        ("first", "i8"),
        ("last", "i8"),
    ]
)
"""A measurement: the sum of the errors that it contains, by how much it is off, its variance, and
which errors, from the first to before the last, are to blame if that is too much."""

TRUSTED = 3.0
"""Standard deviations beyond which a foot has slipped."""


@njit
def carry_on(base, noise, acceleration):
    """Move the state on by one period: `base.turning` after it, `acceleration` in the world.

    Args:
        base: a `BASE` record, changed.
        noise: a `BASE_NOISE` record.
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
    _turn_over(c)
    _carry_rows(c, force, R, dt)
    _even_out(c)
    for i in range(3):
        c[TILT + i, TILT + i] += (noise.gyro * dt) ** 2
        c[VELOCITY + i, VELOCITY + i] += (noise.accelerometer * dt) ** 2
        c[BIAS + i, BIAS + i] += noise.bias_walk**2 * dt


@njit
def _even_out(c):
    """Keep rounding from making a symmetric matrix less so, cycle after cycle."""
    for i in range(ERRORS):
        for j in range(i):
            c[i, j] = c[j, i] = 0.5 * (c[i, j] + c[j, i])


@njit
def _turn_over(c):
    """Make columns of rows, to do with them what has been done with the rows."""
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
def _loosen_foot(base, noise, foot, load, alone):
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
        base: a `BASE` record, changed.
        noise: a `BASE_NOISE` record.
        soles: a `SOLES` record.
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
    _turn_over(c)
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
def _look_at_foot(base, noise, soles, foot, rows, first):
    """What the kinematics says of a standing foot: its place and heading, four rows."""
    R = np.empty((3, 3))
    rotation_matrix(base.orientation, R)
    dx = base.feet[foot, 0] - base.position[0]
    dy = base.feet[foot, 1] - base.position[1]
    dz = base.feet[foot, 2] - base.position[2]
    here, turn = FEET + 3 * foot, HEADINGS + foot
    for k in range(3):
        ex, ey, ez = R[0, k], R[1, k], R[2, k]
        row = rows[first + k]
        of = row.of
        of[TILT], of[TILT + 1], of[TILT + 2] = (
            ey * dz - ez * dy,
            ez * dx - ex * dz,
            ex * dy - ey * dx,
        )
        for i in range(3):
            of[POSITION + i], of[here + i] = -R[i, k], R[i, k]
        row.off = soles.position[foot, k] - (ex * dx + ey * dy + ez * dz)
        row.variance = (noise.encoder * soles.spread[foot, k]) ** 2
        row.first, row.last = here, here + 3
    row = rows[first + 3]
    row.of[TILT + 2], row.of[turn] = -1.0, 1.0
    off = _heading(R, soles.rotation[foot]) - base.headings[foot]
    row.off = off - 2.0 * math.pi * round(off / (2.0 * math.pi))
    row.variance = (noise.encoder * soles.turn_spread[foot]) ** 2
    row.first, row.last = turn, turn + 1


@njit
def _look_at_floor(base, noise, foot, row):
    """A foot that has just touched down is about as high as the floor."""
    row.of[FEET + 3 * foot + 2] = 1.0
    row.off, row.variance = -base.feet[foot, 2], noise.floor**2
    row.first = row.last = 0


@njit
def _blame(c, row):
    """Lay what is off by more than `TRUSTED` deviations to the foot, whose errors are named.

    They are seen in directions at right angles to each other, so it matters not which comes first.
    """
    spread = row.variance
    for i in range(ERRORS):
        if row.of[i] != 0.0:
            for j in range(ERRORS):
                spread += row.of[i] * c[i, j] * row.of[j]
    excess = (row.off / TRUSTED) ** 2 - spread
    if excess > 0.0:
        for i in range(row.first, row.last):
            for j in range(row.first, row.last):
                c[i, j] += excess * row.of[i] * row.of[j]


@njit
def _take(c, found, row):
    """Correct the covariance, and the errors `found` so far, by one measurement."""
    g, spread, off = np.zeros(ERRORS), row.variance, row.off
    for i in range(ERRORS):
        if row.of[i] != 0.0:
            for j in range(ERRORS):
                g[j] += c[i, j] * row.of[i]
            off -= row.of[i] * found[i]
    for i in range(ERRORS):
        spread += row.of[i] * g[i]
    scale = 1.0 / math.sqrt(spread)
    for i in range(ERRORS):
        g[i] *= scale
        found[i] += g[i] * scale * off
    for i in range(ERRORS):
        for j in range(ERRORS):
            c[i, j] -= g[i] * g[j]


@njit
def listen_to_feet(base, noise, soles, feet, force):
    """Correct the state by the feet that stand.

    Args:
        base: a `BASE` record, changed.
        noise: a `BASE_NOISE` record.
        soles: a `SOLES` record.
        feet: (2,) which soles stand, 1 or 0.
        force: (2,) on the soles [N].
    """
    rows, count = np.zeros(8, ROW), 0
    for foot in range(2):
        if feet[foot] == 0:
            base.standing[foot] = 0.0
        elif base.standing[foot] == 0.0:
            put_foot(base, noise, soles, foot)
            _look_at_floor(base, noise, foot, rows[count])
            count += 1
        else:
            _loosen_foot(base, noise, foot, force[foot], feet[1 - foot] == 0)
            _look_at_foot(base, noise, soles, foot, rows, count)
            count += 4
    found = np.zeros(ERRORS)
    for k in range(count):
        _blame(base.covariance, rows[k])
    for k in range(count):
        _take(base.covariance, found, rows[k])
    _mend(base, found)


@njit
def _mend(base, found):
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
