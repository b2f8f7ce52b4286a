"""A robot's model, reduced to what every robot has: links, joints and looks; and its world."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fnmatch import fnmatch
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import RobotError
from surefoot.robot.body import Body
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.model_file import find_model, read_urdf
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.paper_biped import paper_biped_mjcf
from surefoot.robot.robot import Robot

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


class ModelSpec(NamedTuple):
    """A model without contacts, actuators, locked joints and surroundings.

    Attributes:
        spec: to be completed and compiled.
        speed: velocity limits that the model states, by joint [rad/s].
        locked: joints that it had, and that are held rigid now.
        unseen: meshes that cannot be drawn.
    """

    spec: mujoco.MjSpec
    speed: dict[str, float]
    locked: tuple[str, ...]
    unseen: tuple[str, ...]


def read_model(robot: Robot, body: Body) -> ModelSpec:
    """Read the model of a robot, keep the limits of its motors, and lock what is to be locked.

    Raises:
        RobotError: the model is missing or cannot be read, or a joint that is to be locked is not
            in it.
    """
    speed: dict[str, float] = {}
    unseen: tuple[str, ...] = ()
    origin = body.model
    try:
        if body.is_generated:
            sole = (robot.foot.length, robot.foot.width)
            spec = mujoco.MjSpec.from_string(paper_biped_mjcf(robot.hip, sole))
        else:
            path = find_model(body, robot.name)
            origin = str(path)
            if path.suffix.lower() == ".urdf":
                text, speed, unseen = read_urdf(path)
                spec = mujoco.MjSpec.from_string(text)
                for geom in spec.geoms:
                    geom.mass = 0.0
            else:
                spec = mujoco.MjSpec.from_file(origin)
    except ValueError as error:
        if isinstance(error, RobotError):
            raise
        raise RobotError(
            "a model that MuJoCo can read",
            f"{origin}: {' '.join(str(error).split())}",
            "repair the model",
        ) from error
    _keep_torques(spec)
    _strip(spec)
    _check_names(spec, origin)
    return ModelSpec(spec, speed, _lock(spec, body), unseen)


def _keep_torques(spec: mujoco.MjSpec) -> None:
    """Write what an actuator can give into the joint that it turns."""
    for actuator in spec.actuators:
        joint = spec.joint(actuator.target)
        if actuator.trntype != mujoco.mjtTrn.mjTRN_JOINT or joint is None:
            continue
        limits = [min(abs(bound) for bound in joint.actfrcrange)]
        gear = abs(actuator.gear[0])
        limits.append(gear * min(abs(bound) for bound in actuator.forcerange))
        if actuator.biastype == mujoco.mjtBias.mjBIAS_NONE:
            gain = gear * abs(actuator.gainprm[0])
            limits.append(gain * min(abs(bound) for bound in actuator.ctrlrange))
        # A range of (0, 0) is one that is not given.
        given = [limit for limit in limits if limit > 0.0]
        if given:
            joint.actfrcrange = (-min(given), min(given))


def _strip(spec: mujoco.MjSpec) -> None:
    """Leave nothing but links, joints and looks."""
    for kind in (
        "actuators", "sensors", "keys", "tendons", "equalities", "excludes", "pairs", "sites",
    ):  # fmt: skip
        for element in list(getattr(spec, kind)):
            spec.delete(element)
    for element in (*spec.worldbody.geoms, *spec.lights, *spec.cameras):
        spec.delete(element)
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0


def _check_names(spec: mujoco.MjSpec, origin: str) -> None:
    for joint in spec.joints:
        if not joint.name and joint.type != mujoco.mjtJoint.mjJNT_FREE:
            raise RobotError(
                "a name for every joint of the model",
                f"{origin} with one in {joint.parent.name!r} that has none",
                "name it: motors, limits and posture are given by name",
            )


def find_body(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """A body by its name.

    Raises:
        RobotError: there is none; the message lists those that there are.
    """
    body = spec.body(name)
    if body is None or name == "world":
        names = ", ".join(body.name for body in spec.bodies if body.name != "world")
        raise RobotError(
            f"a body of the model ({names})", repr(name), "correct the name in the [body] table"
        )
    return body


def _matching_joints(key: str, pattern: str, names: Iterable[str]) -> list[str]:
    """The joints that a pattern of the `[body]` table means.

    Raises:
        RobotError: there are none; the message lists all.
    """
    names = list(names)
    matching = [name for name in names if fnmatch(name, pattern)]
    if not matching:
        raise RobotError(
            f"`{key}` to name joints of the model ({', '.join(names)})",
            f"{pattern!r}, which matches none",
            "correct the name; * stands for any characters",
        )
    return matching


def by_pattern(
    key: str, table: dict[str, float], names: Iterable[str], locked: tuple[str, ...]
) -> dict[str, float]:
    """The values of a table of `[body]` by joint; a later pattern wins.

    Args:
        key: of the table.
        table: values by pattern.
        names: of the joints that move.
        locked: those that a pattern may mean too, in vain.

    Raises:
        RobotError: a pattern means no joint.
    """
    values: dict[str, float] = {}
    for pattern, value in table.items():
        values |= dict.fromkeys(_matching_joints(key, pattern, (*names, *locked)), value)
    return {name: value for name, value in values.items() if name not in locked}


def _lock(spec: mujoco.MjSpec, body: Body) -> tuple[str, ...]:
    names = [joint.name for joint in spec.joints if joint.type != mujoco.mjtJoint.mjJNT_FREE]
    locked = {
        name: 0.0 for pattern in body.locked for name in _matching_joints("locked", pattern, names)
    }
    for pattern, angle in body.posture.items():
        locked |= {name: angle for name in locked if fnmatch(name, pattern)}
    for name, angle in locked.items():
        joint = spec.joint(name)
        if angle:
            _turn(spec, joint, angle)
        spec.delete(joint)
    return tuple(locked)


def _turn(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, angle: float) -> None:
    """Move a link to where its joint would."""
    link = joint.parent
    if link.alt.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
        link.quat = mujoco.MjSpec.resolve_orientation(
            degree=bool(spec.compiler.degree),
            sequence=spec.compiler.eulerseq,
            orientation=link.alt,
        )
        link.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
        link.pos = np.array(link.pos) + _rotated(link.quat, angle * axis)
        return
    turn, orientation = np.zeros(4), np.zeros(4)
    mujoco.mju_axisAngle2Quat(turn, axis, angle)
    mujoco.mju_mulQuat(orientation, np.array(link.quat), turn)
    pivot = np.array(joint.pos)
    link.pos = np.array(link.pos) + _rotated(link.quat, pivot) - _rotated(orientation, pivot)
    link.quat = orientation


def _rotated(orientation: np.ndarray, vector: np.ndarray) -> np.ndarray:
    result = np.zeros(3)
    mujoco.mju_rotVecQuat(result, vector, np.array(orientation))
    return result


def add_world(spec: mujoco.MjSpec, gravity: float, boards: NDArray[np.void], own: OwnUnits) -> None:
    """Put a floor with boards under a robot, and say how physics is computed.

    Args:
        spec: of the robot's model, changed.
        gravity: [m/s^2].
        boards: records of `robot.floor.Board`.
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
