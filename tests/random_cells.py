"""Random robots and pushes, by seed: robots of no preset, for tests and benchmarks.

Half of the robots have step times drawn in seconds, half in units of 1/omega, so that light and
slow pendulums, large and small growth over a step all occur. A robot that cannot even step in place
is drawn again, and counted; one that cannot walk as fast as was drawn walks more slowly.

A benchmark finds this file by `sys.path.append` of the folder of the tests, behind its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import surefoot as sf
from surefoot.dcm.nominal_gait import NominalGait, gait_room, largest_speed, nominal_gait
from surefoot.dcm.push_limit import PushCase, check_leg
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.errors import SurefootError
from surefoot.robot.gait import GaitLimits
from surefoot.rollout.outcome import recovery_time

DIAGONAL = math.sqrt(0.5)

FASTEST = 0.95
"""Largest share of the largest speed: at the whole of it the box leaves nothing to adapt."""

LEAST_ROOM = 0.01
"""A gait of less room than this, as a share of the CoM height, is none to be pushed in."""

LATEST = 0.95
"""Largest phase of a push, as a share of T_nom."""


@dataclass(frozen=True, kw_only=True)
class RandomCell(PushCase):
    """A random robot, how it walks, and what pushes it.

    Attributes:
        seed: by which it is drawn again.
        rejected: how many robots were drawn before this one that cannot walk at all.
    """

    seed: int
    rejected: int

    @property
    def whole_sole(self) -> bool:
        """Whether the ZMP moves inside the sole; False for a point foot."""
        return self.zmp_reach != (0.0, 0.0)

    @property
    def start(self) -> float:
        """When the push begins, in the third step [s]; the first one is on `support_side` too."""
        return 2.0 * self.gait.step_duration + self.elapsed

    def controller(self, **parameters: Any) -> sf.UnifiedController:
        """The unified controller of this cell."""
        return sf.UnifiedController(
            self.robot, self.velocity, ankle=self.whole_sole,
            step_duration=self.step_duration, **parameters,
        )  # fmt: skip

    def settles(
        self,
        controller: sf.Controller,
        shares: Sequence[float] | NDArray[np.float64],
        limit: float,
    ) -> NDArray[np.bool_]:
        """Whether it is back in its gait after pushes of these shares of a limit [N s]."""
        end = self.start + self.duration + recovery_time(controller)
        results = sf.simulate_batch(
            controller,
            [[self.push(share * limit)] for share in shares],
            end,
            stop_when_settled=True,
            first_support=self.support_side,
        )
        return results["settled"]

    def viable_starts(self, count: int, margin: float = 0.05) -> list[sf.Observation]:
        """Touchdowns after any step of the box, with any DCM that can be saved from there.

        Args:
            count: how many.
            margin: part of the width of the viable set that is kept from either end of it.
        """
        rng = np.random.default_rng([self.seed, count])
        tables, gait, reach = viable_displacement(self.robot), self.gait, self.zmp_reach
        starts = []
        for _ in range(count):
            side = sf.Side(int(rng.choice((-1, 1))))
            nominal = gait.observation(side)
            dcm, swing = np.zeros(2), np.zeros(2)
            for axis, (turn, behind) in enumerate(((1.0, -1.0), (float(side), 1.0))):
                width = tables.spacing[axis] * (tables.values.shape[2] - 1)
                step = tables.low[axis] + width * rng.random()
                high = tables.after_step(axis, 1, step) + reach[axis]
                low = -tables.after_step(axis, -1, step) - reach[axis]
                offset = low + (high - low) * rng.uniform(margin, 1.0 - margin)
                dcm[axis] = nominal.support_foot[axis] + turn * offset
                swing[axis] = nominal.support_foot[axis] + turn * behind * step
            # The convergent part of the motion is that of the gait.
            com = 0.5 * (dcm + 2.0 * nominal.com - nominal.dcm)
            starts.append(
                nominal.replace(
                    dcm=dcm,
                    com=com,
                    com_velocity=self.robot.omega * (dcm - com),
                    swing_foot=(*swing, 0.0),
                )
            )
        return starts

    def push(self, impulse: float) -> sf.Push:
        """The push of this cell with so much impulse [N s]."""
        return sf.Push.of_impulse(impulse, self.direction, self.start, self.duration)


def random_cell(seed: int, *, acceleration: bool = False) -> RandomCell:
    """A robot that can walk, its gait and a push.

    Args:
        seed: the same one gives the same cell, whatever was drawn before.
        acceleration: whether the leg is limited in acceleration too, 20-200 m/s^2; one in three is
            then not limited in speed.
    """
    rng = np.random.default_rng([seed, int(acceleration)])
    rejected = 0
    while True:
        robot = random_robot(rng, acceleration=acceleration)
        whole_sole = bool(rng.random() < 0.6)
        walk = _random_walk(rng, robot, whole_sole)
        if walk is not None:
            break
        rejected += 1
    velocity, gait, step_duration = walk
    angle = int(rng.integers(8))
    return RandomCell(
        seed=seed,
        robot=robot,
        velocity=velocity,
        step_duration=step_duration,
        zmp_reach=robot.foot.half if whole_sole else (0.0, 0.0),
        direction=_direction(angle),
        support_side=sf.Side(int(rng.choice((-1, 1)))),
        elapsed=gait.step_duration
        * float(rng.choice((0.0, rng.uniform(0.0, LATEST)), p=(0.2, 0.8))),
        duration=_random_duration(rng, robot),
        rejected=rejected,
    )


def random_robot(rng: np.random.Generator, *, acceleration: bool = False) -> sf.Robot:
    """A robot from 3 kg and 0.25 m to 120 kg and 1.2 m; perhaps one that cannot walk."""
    height, gravity = rng.uniform(0.25, 1.2), 9.81
    omega = math.sqrt(gravity / height)
    hip = height * rng.uniform(0.06, 0.35)
    if rng.random() < 0.5:
        shortest = rng.uniform(0.1, 0.5)
        longest = shortest + rng.uniform(0.1, 1.0)
    else:
        shortest = rng.uniform(0.25, 1.7) / omega
        longest = shortest + rng.uniform(0.3, 3.0) / omega
    speed = math.inf
    if rng.random() < (0.67 if acceleration else 0.7):
        speed = rng.uniform(0.6, 2.0) * math.sqrt(gravity * height)
    return sf.Robot(
        name="random",
        mass=_log_uniform(rng, 3.0, 120.0),
        com_height=height,
        hip=hip,
        foot=sf.Foot(
            length=height * rng.uniform(0.08, 0.35), width=height * rng.uniform(0.03, 0.2)
        ),
        gait=GaitLimits(
            step_duration=(shortest, longest),
            step_x=(-height * rng.uniform(0.2, 0.9), height * rng.uniform(0.25, 0.9)),
            step_y=(-hip * rng.uniform(0.1, 2.0), height * rng.uniform(0.1, 0.6)),
            dcm_offset=(height * rng.uniform(0.02, 0.15), height * rng.uniform(0.02, 0.1)),
        ),
        swing=sf.Swing(
            height=0.06 * height,
            max_speed=speed,
            max_acceleration=_log_uniform(rng, 20.0, 200.0) if acceleration else math.inf,
        ),
        gravity=gravity,
    )  # fmt: skip


def _random_walk(
    rng: np.random.Generator, robot: sf.Robot, whole_sole: bool
) -> tuple[tuple[float, float], NominalGait, float | None] | None:
    """Velocity, gait and T_nom if it is given; None for a robot that cannot even step in place."""
    angle, share = rng.uniform(-math.pi, math.pi), rng.uniform(0.0, FASTEST)
    course, chosen = rng.random(), rng.random()
    x, y = math.cos(angle), math.sin(angle)
    if course < 0.4:
        x, y = 1.0, 0.0
    speed = share * largest_speed(robot, (x, y))
    while True:
        velocity = (speed * x, speed * y)
        gait = nominal_gait(robot, velocity)
        step_duration = None
        if chosen < 0.5:
            # The default is the middle of what is possible; 2 chosen is uniform.
            shortest = robot.gait.step_duration[0]
            step_duration = shortest + 4.0 * chosen * (gait.step_duration - shortest)
            step_duration = min(step_duration, 2.0 * gait.step_duration - shortest)
            gait = nominal_gait(robot, velocity, step_duration)
        try:
            check_leg(robot, gait)
            room = gait_room(robot, gait, robot.foot.half if whole_sole else (0.0, 0.0))
            if room > LEAST_ROOM * robot.com_height:
                return velocity, gait, step_duration
        except SurefootError:
            pass
        # The leg is too weak for this gait; a slower one may do.
        if speed == 0.0:
            return None
        speed = 0.7 * speed if speed > 0.05 * math.sqrt(robot.gravity * robot.com_height) else 0.0


def _random_duration(rng: np.random.Generator, robot: sf.Robot) -> float:
    """Of a push: 5 ms to 0.5 s, or the same for the pendulum of the paper's biped [s]."""
    duration = _log_uniform(rng, 0.005, 0.5)
    return duration if rng.random() < 0.5 else duration * 3.5 / robot.omega


def _direction(eighth: int) -> tuple[float, float]:
    """Unit vector, in eighths of a turn from forward to the left; exact along the axes."""
    parts = (0.0, DIAGONAL, 1.0, DIAGONAL, 0.0, -DIAGONAL, -1.0, -DIAGONAL)
    return parts[(eighth + 2) % 8], parts[eighth]


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))
