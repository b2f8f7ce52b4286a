"""A robot as a mechanism: the MuJoCo model that is plant and controller model alike.

Built from the `[body]` table of a robot: its model is loaded, stripped of contacts and actuators,
locked joints are welded, and then every robot gets the same: box soles, capsules along the legs
that must not touch each other, one motor for each joint, and a floor.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import RobotError
from surefoot.robot.body import Body
from surefoot.robot.feet import FEET
from surefoot.robot.floor import NO_BOARDS
from surefoot.robot.model_spec import (
    FLOOR,
    LEG_BIT,
    SOLE,
    SOLE_TIME,
    ModelSpec,
    add_world,
    by_pattern,
    find_body,
    read_model,
)
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Robot

SOLE_THICKNESS = 0.025
"""Of the boxes that touch the ground, in heights of the CoM."""

SENSOR_MARGIN = 0.0125
"""By how much the region of a touch sensor is larger than its sole, likewise."""

LEG_RADIUS = 0.0625
"""Likewise of the capsules along thigh and shank, of a body that does not say it."""

ROLL_HEIGHT, ROLL_STIFFNESS, ROLL_DAMPING, ROLL_INERTIA = 0.025, 0.01874, 0.003938, 1.149e-4
"""Of a passive ankle roll that the model does not have, in `OwnUnits`: a fiftieth of the stiffness
m g h that would hold the robot up [h, m g h, m g h / omega, m h^2]."""

MAX_MASS_ERROR = 0.05
"""Of the mass in a robot's file, against that of its model [-]."""

_INERTIAL = {
    "gyro": mujoco.mjtSensor.mjSENS_GYRO,
    "accelerometer": mujoco.mjtSensor.mjSENS_ACCELEROMETER,
}


@dataclass(frozen=True)
class Multibody:
    """A robot's mechanism, compiled.

    Attributes:
        robot: what it is the mechanism of.
        model: the compiled model: floor, soles, legs, motors.
        base: index of the body with the free joint.
        trunk: index of the body that pushes and payloads act on.
        soles: indices of the sites at the centres of the soles, left and right.
        feet: indices of the bodies of the feet.
        motors: index of the joint that each actuator turns.
        torque: limit of each actuator [N m].
        speed: likewise of its joint [rad/s].
        nominal: generalised positions in the nominal pose, soles on the ground.
        unseen: meshes of the model that cannot be drawn.
    """

    robot: Robot
    model: mujoco.MjModel = field(repr=False, compare=False)
    base: int
    trunk: int
    soles: tuple[int, int]
    feet: tuple[int, int]
    motors: NDArray[np.int64] = field(repr=False, compare=False)
    torque: NDArray[np.float64] = field(repr=False, compare=False)
    speed: NDArray[np.float64] = field(repr=False, compare=False)
    nominal: NDArray[np.float64] = field(repr=False, compare=False)
    unseen: tuple[str, ...] = ()

    @property
    def body(self) -> Body:
        """The table that it was made from."""
        return assert_body(self.robot)

    @cached_property
    def mass(self) -> float:
        """Of all links [kg]."""
        return float(self.model.body_mass.sum())

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Of the motors, in order."""
        return tuple(self.model.joint(int(joint)).name for joint in self.motors)

    @cached_property
    def motor_dofs(self) -> NDArray[np.int64]:
        """Index of each motor's degree of freedom."""
        return self.model.jnt_dofadr[self.motors].astype(np.int64)

    @cached_property
    def motor_positions(self) -> NDArray[np.int64]:
        """Index of each motor's joint angle among the generalised positions."""
        return self.model.jnt_qposadr[self.motors].astype(np.int64)

    @cached_property
    def base_dof(self) -> int:
        """The first of the base's six degrees of freedom."""
        return int(self.model.jnt_dofadr[self.model.body_jntadr[self.base]])

    @cached_property
    def passive_dofs(self) -> NDArray[np.int64]:
        """Degrees of freedom that no motor moves, those of the base first."""
        return np.setdiff1d(np.arange(self.model.nv), self.motor_dofs)

    def data(self) -> mujoco.MjData:
        """A state of the mechanism in its nominal pose, kinematics computed."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.nominal
        mujoco.mj_forward(self.model, data)
        return data


def assert_body(robot: Robot) -> Body:
    """The body of a robot, refusing one that is a point mass only.

    Raises:
        RobotError: it has no `[body]`.
    """
    if robot.body is None:
        raise RobotError(
            "a robot with a [body] table for the physics simulator",
            f"{robot.name!r}, which is a point mass only",
            "choose another one (`surefoot robots`), or describe its body: docs/robots.md",
        )
    return robot.body


def load_multibody(
    robot: Robot, boards: NDArray[np.void] = NO_BOARDS, *, any_mass: bool = False
) -> Multibody:
    """Make the mechanism of a robot.

    Args:
        robot: with a `[body]`.
        boards: that lie on the floor, see `robot.floor`.
        any_mass: whether the model may weigh something else than the robot's file says; for those
            who look for what is wrong.

    Raises:
        RobotError: there is no `[body]`, its model is missing or cannot be read, a name in it is
            not in the model (the message says which are), or the model weighs something else.
    """
    body = assert_body(robot)
    source = read_model(robot, body)
    spec = source.spec
    if body.trunk:
        find_body(spec, body.trunk)
    _free(spec, body.base)
    own = OwnUnits.of(robot)
    passive = [
        joint
        for side, name, sign in zip(FEET, body.feet, (1.0, -1.0), strict=True)
        for joint in _add_sole(find_body(spec, name), side, sign, robot, body, own)
    ]
    _add_legs(spec, body, own)
    _add_motors(source, body, passive)
    _add_sensors(spec, find_body(spec, body.base), own)
    add_world(spec, robot.gravity, boards, own)
    try:
        model = spec.compile()
    except ValueError as error:
        raise RobotError(
            "a model that MuJoCo can compile",
            f"{body.model}: {' '.join(str(error).split())}",
            "repair the model",
        ) from error
    mechanism = _index(robot, body, model, source)
    if not any_mass:
        _check_mass(mechanism)
    return mechanism


def _check_mass(mechanism: Multibody) -> None:
    mass, robot = mechanism.mass, mechanism.robot
    if abs(robot.mass - mass) > MAX_MASS_ERROR * mass:
        raise RobotError(
            f"the mass of the model, {mass:.4g} kg, to {100.0 * MAX_MASS_ERROR:g} %",
            f"mass = {robot.mass:g} kg in the file of {robot.name!r}",
            f"write mass = {mass:.4g}, or mend the model; `surefoot robots check` tells more",
        )


def _free(spec: mujoco.MjSpec, name: str) -> None:
    base = find_body(spec, name)
    if base.parent.name != "world":
        outermost = base
        while outermost.parent.name != "world":
            outermost = outermost.parent
        raise RobotError(
            "`base` to be the outermost body of the model, which can move freely",
            f"{name!r}, inside {outermost.name!r}",
            f'write base = "{outermost.name}"',
        )
    if not any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in base.joints):
        base.add_freejoint(name="base")


def _add_sole(
    foot: mujoco.MjsBody, side: str, sign: float, robot: Robot, body: Body, own: OwnUnits
) -> list[str]:
    """Put a sole under a foot; returns the names of joints that no motor turns."""
    x, y, z = body.sole
    where = (x, sign * y, z)
    rolls = [joint.name for joint in foot.joints if abs(joint.axis[0]) > 0.9]
    if body.ankle_roll == "passive" and not rolls:
        rolls = [f"{side}_ankle_roll"]
        hinge = foot.add_joint(
            name=rolls[0],
            axis=(1.0, 0.0, 0.0),
            pos=(x, sign * y, z + ROLL_HEIGHT * own.length),
            range=(-0.6, 0.6),
            armature=ROLL_INERTIA * own.inertia,
        )
        # Numbers up to MuJoCo 3, polynomials from 4 on.
        polynomial = np.ndim(hinge.stiffness) > 0
        stiffness = ROLL_STIFFNESS * own.torque
        damping = ROLL_DAMPING * own.torque * own.time
        hinge.stiffness = (stiffness, 0.0, 0.0) if polynomial else stiffness
        hinge.damping = (damping, 0.0, 0.0) if polynomial else damping
    thickness = SOLE_THICKNESS * own.length
    foot.add_site(name=f"{side}_sole", pos=where)
    foot.add_geom(
        name=f"{side}_sole",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=(robot.foot.length / 2, robot.foot.width / 2, thickness / 2),
        pos=(where[0], where[1], where[2] + thickness / 2),
        mass=0.0,
        group=3,
        condim=3,
        contype=SOLE | LEG_BIT[FEET.index(side)],
        conaffinity=FLOOR | LEG_BIT[1 - FEET.index(side)],
        solref=(SOLE_TIME * own.time, 1.0),
        rgba=(0.9, 0.5, 0.2, 1.0),
    )
    return rolls if body.ankle_roll == "passive" else []


def _chain(spec: mujoco.MjSpec, foot: str, base: str) -> list[mujoco.MjsBody]:
    """The links from below the base to the foot."""
    links = [find_body(spec, foot)]
    while links[0].parent is not None and links[0].parent.name not in (base, "world"):
        links.insert(0, links[0].parent)
    return links


def _add_legs(spec: mujoco.MjSpec, body: Body, own: OwnUnits) -> None:
    """Capsules from joint to joint: where links are long, they are thighs and shanks. The end of a
    shank is thicker than an ankle is high: only the thigh, with the knee, touches the floor."""
    radius = LEG_RADIUS * own.length if body.leg_radius is None else body.leg_radius
    for index, foot in enumerate(body.feet):
        links = pairwise(_chain(spec, foot, body.base))
        ends = [(upper, np.array(lower.pos)) for upper, lower in links]
        long = [one for one in ends if np.linalg.norm(one[1]) >= 3.0 * radius]
        for place, (upper, end) in enumerate(long):
            floor = 0 if 0 < place == len(long) - 1 else FLOOR
            upper.add_geom(
                name=f"{FEET[index]}_{upper.name}_leg",
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=(0.0, 0.0, 0.0, *end),
                size=(radius, 0.0, 0.0),
                mass=0.0,
                group=3,
                condim=1,
                contype=LEG_BIT[index],
                conaffinity=floor | LEG_BIT[1 - index],
                rgba=(0.5, 0.5, 0.5, 0.3),
            )


def _add_motors(source: ModelSpec, body: Body, passive: list[str]) -> None:
    driven = {
        joint.name: joint
        for joint in source.spec.joints
        if joint.type != mujoco.mjtJoint.mjJNT_FREE and joint.name not in passive
    }
    for name in driven:
        motor = source.spec.add_actuator(name=name, target=name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_motor()
    inertias = by_pattern("armature", body.armature, driven, source.locked)
    for name, inertia in inertias.items():
        driven[name].armature = inertia


def _add_sensors(spec: mujoco.MjSpec, base: mujoco.MjsBody, own: OwnUnits) -> None:
    """An inertial measurement unit at the base's origin, and the load on each sole."""
    base.add_site(name="base_imu")
    for name, kind in _INERTIAL.items():
        _add_sensor(spec, name, kind, "base_imu")
    for side in FEET:
        sole = spec.geom(f"{side}_sole")
        sole.parent.add_site(
            name=f"{side}_touch",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=sole.pos,
            # A little larger than the sole: contacts lie on its faces, or under them.
            size=sole.size + SENSOR_MARGIN * own.length,
            group=4,
        )
        _add_sensor(spec, f"{side}_touch", mujoco.mjtSensor.mjSENS_TOUCH, f"{side}_touch")


def _add_sensor(spec: mujoco.MjSpec, name: str, kind: mujoco.mjtSensor, site: str) -> None:
    spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)


def _index(robot: Robot, body: Body, model: mujoco.MjModel, source: ModelSpec) -> Multibody:
    motors = model.actuator_trnid[:, 0].astype(np.int64)
    names = [model.joint(int(joint)).name for joint in motors]
    limited = model.jnt_actfrclimited[motors].astype(bool)
    own = np.where(limited, model.jnt_actfrcrange[motors, 1], np.inf)
    torques = by_pattern("torque", body.torque, names, source.locked)
    torque = np.array([torques.get(name, limit) for name, limit in zip(names, own, strict=True)])
    speeds = source.speed | by_pattern("speed", body.speed, names, source.locked)
    speed = np.array([speeds.get(name, np.inf) for name in names])
    # The plant keeps the limits of the table, where they are wider than the model's too.
    model.jnt_actfrclimited[motors] = np.isfinite(torque)
    model.jnt_actfrcrange[motors] = np.where(np.isfinite(torque), torque, 0.0)[:, None] * (-1, 1)
    soles = (model.site("left_sole").id, model.site("right_sole").id)
    return Multibody(
        robot=robot,
        model=model,
        base=model.body(body.base).id,
        trunk=model.body(body.trunk or body.base).id,
        soles=soles,
        feet=(model.body(body.feet[0]).id, model.body(body.feet[1]).id),
        motors=motors,
        torque=torque,
        speed=speed,
        nominal=_nominal(body, model, soles, source.locked),
        unseen=source.unseen,
    )


def _nominal(
    body: Body, model: mujoco.MjModel, soles: tuple[int, int], locked: tuple[str, ...]
) -> NDArray[np.float64]:
    """The posture, with the middle of the soles at the origin."""
    nominal = model.qpos0.copy()
    joints = [model.joint(joint).name for joint in range(model.njnt)]
    for name, angle in by_pattern("posture", body.posture, joints, locked).items():
        nominal[model.joint(name).qposadr[0]] = angle
    data = mujoco.MjData(model)
    data.qpos[:] = nominal
    mujoco.mj_kinematics(model, data)
    free = model.jnt_qposadr[model.body(body.base).jntadr[0]]
    nominal[free : free + 3] -= data.site_xpos[list(soles)].mean(axis=0)
    return nominal
