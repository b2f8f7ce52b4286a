"""The floor of a body in physics, how soft contacts are, and what can touch what."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.robot.own_units import OwnUnits

TIME_STEP = 0.001
"""Of the physics, and of control [s]. It is that of the loops of robots, whatever their size, and
does not follow from the robot: omega times it is 0.0035 for the paper's biped."""

BOARD_DEPTH = 0.1
"""How far boards reach into the floor: a sole is pushed up out of them, not through. The boards are
of the world, and as thick for every robot [m]."""

FLOOR_TIME, SOLE_TIME, FLOOR_WIDTH = 0.07, 0.021, 0.00125
"""How soft contacts of the floor and of soles are: time constants in 1 / omega, and the depth over
which MuJoCo's impedance rises in heights of the CoM. Hard floors do not differ from robot to robot,
but a simulated one yields by about g times its time constant squared, which is to be as little to
each. Where soles meet the floor it is the floor's that counts. MuJoCo lets no contact be faster
than two periods, so that 1 ms of physics keeps the law down to a CoM height of 1 cm there."""

FLOOR, SOLE, LEFT_LEG, RIGHT_LEG = 1, 2, 4, 8
LEG_BIT = (LEFT_LEG, RIGHT_LEG)
"""What collides, in bits: the floor, soles, and the legs with each other."""


def add_world(spec: mujoco.MjSpec, gravity: float, boards: NDArray[np.void], own: OwnUnits) -> None:
    """Put a floor with boards under a robot, and say how physics is computed.

    Args:
        spec: of the robot's model, changed.
        gravity: [m/s^2].
        boards: records of `robot.bumps.BOARD`.
        own: units of the robot.
    """
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    _add_floor(spec, "floor", plane, FLOOR, own, size=(0.0, 0.0, 1.0))
    half_depth = 0.5 * BOARD_DEPTH
    for index, board in enumerate(boards):
        heading = 0.5 * float(board["heading"])
        _add_floor(
            spec,
            f"board_{index}",
            mujoco.mjtGeom.mjGEOM_BOX,
            # A shank may end lower over its sole than a board is high; the floor stops it.
            0,
            own,
            size=(*board["half"], half_depth),
            pos=(*board["place"], board["height"] - half_depth),
            quat=(math.cos(heading), 0.0, 0.0, math.sin(heading)),
        )
    spec.option.gravity = (0.0, 0.0, -gravity)
    spec.option.timestep = TIME_STEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def _add_floor(
    spec: mujoco.MjSpec, name: str, kind: mujoco.mjtGeom, stops: int, own: OwnUnits, **shape: Any
) -> None:
    part = spec.worldbody.add_geom(
        name=name,
        type=kind,
        contype=stops,
        conaffinity=SOLE,
        condim=3,
        friction=(0.8, 0.005, 0.0001),
        solref=(FLOOR_TIME * own.time, 1.0),
        solimp=(0.9, 0.95, FLOOR_WIDTH * own.length, 0.5, 2.0),
        **shape,
    )
    part.priority = 1
