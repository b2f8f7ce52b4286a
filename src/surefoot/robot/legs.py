"""Geometry of a mechanism's legs, found in its model, and how it stands in its nominal pose.

Hips, knees and ankles are the joints that pitch; of the pose it says where the soles are, and what
legs carry and reach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import RobotError
from surefoot.robot.multibody import Multibody

MOSTLY = 0.8
"""An axis with more than this part along y pitches."""

JOINTS_THAT_PITCH = 3


class Legs(NamedTuple):
    """Geometry of the legs.

    Attributes:
        hip: lateral distance of the hip joints [m].
        thigh, shank: lengths from joint to joint [m].
        ankle: height over the sole [m].
        over_com, ahead_of_com: where the middle of the hips is in the nominal pose, from the CoM
            [m].
    """

    hip: float
    thigh: float
    shank: float
    ankle: float
    over_com: float
    ahead_of_com: float

    def length(self, knee: float) -> float:
        """From hip to ankle with the knee bent by an angle [rad]."""
        product = 2.0 * self.thigh * self.shank * math.cos(knee)
        return math.sqrt(self.thigh**2 + self.shank**2 + product)


def find_knees(multibody: Multibody) -> tuple[int, int]:
    """The motors that bend the legs, left and right: of each leg the one that is bent most."""
    angles, found = multibody.nominal[multibody.motor_positions], []
    for foot in multibody.feet:
        legs = [multibody.motors.tolist().index(joint) for joint in leg_joints(multibody, foot)]
        found.append(max(legs, key=lambda i: abs(angles[i])))
    return found[0], found[1]


def find_legs(multibody: Multibody) -> Legs:
    """The legs' geometry in the nominal pose, from the pitch axes of hip, knee and ankle.

    Raises:
        RobotError: a leg has not these three.
    """
    data, legs = multibody.data(), []
    for side, foot in enumerate(multibody.feet):
        pitch = _pitch_joints(multibody, data, foot)
        if len(pitch) != JOINTS_THAT_PITCH:
            raise RobotError(
                "legs whose hip, knee and ankle pitch",
                f"{len(pitch)} such joints down to {multibody.body.feet[side]!r}",
                "name another foot, or lock the joints that are not of the leg",
            )
        legs.append(data.xanchor[pitch])
    hips, knees, ankles = (np.array([leg[k] for leg in legs]) for k in range(JOINTS_THAT_PITCH))
    middle, com = hips.mean(axis=0), data.subtree_com[multibody.base]
    return Legs(
        hip=float(abs(hips[0, 1] - hips[1, 1])),
        thigh=float(np.hypot(*(hips[0] - knees[0])[[0, 2]])),
        shank=float(np.hypot(*(knees[0] - ankles[0])[[0, 2]])),
        ankle=float(ankles[0, 2]),
        over_com=float(middle[2] - com[2]),
        ahead_of_com=float(middle[0] - com[0]),
    )


def leg_limits(multibody: Multibody) -> tuple[float, float]:
    """How fast the hips can move a foot below them, and how hard they can accelerate it.

    Of a leg in its nominal pose, moved as a whole by its pitch or its roll, whichever is weaker:
    v = w d and a = d tau / I, with the inertia I of all that the joint carries and the height d of
    its axis over the ground.

    Args:
        multibody: the mechanism; a motor without a limit limits nothing.

    Returns:
        Speed [m/s] and acceleration [m/s^2].
    """
    model, data = multibody.model, multibody.data()
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    speeds, accelerations = [math.inf], [math.inf]
    order = {int(joint): row for row, joint in enumerate(multibody.motors)}
    for foot in multibody.feet:
        joints = leg_joints(multibody, foot)
        for axis in (0, 1):
            along = [joint for joint in joints if abs(data.xaxis[joint][axis]) > MOSTLY]
            if along:
                row, dof = order[along[0]], int(model.jnt_dofadr[along[0]])
                distance = float(data.xanchor[along[0]][2])
                speeds.append(distance * float(multibody.speed[row]))
                torque = float(multibody.torque[row])
                accelerations.append(distance * torque / float(inertia[dof, dof]))
    return min(speeds), min(accelerations)


def leg_bodies(multibody: Multibody, foot: int) -> list[int]:
    """The bodies from below the base down to a foot."""
    links, parents = [foot], multibody.model.body_parentid
    while (parent := int(parents[links[0]])) not in (0, multibody.base):
        links.insert(0, parent)
    return links


def leg_joints(multibody: Multibody, foot: int) -> list[int]:
    """The joints with a motor from the base down to a foot."""
    motors, owners = set(multibody.motors.tolist()), multibody.model.jnt_bodyid
    links = leg_bodies(multibody, foot)
    return [
        joint
        for link in links
        for joint in np.flatnonzero(owners == link).tolist()
        if joint in motors
    ]


def _pitch_joints(multibody: Multibody, data: mujoco.MjData, foot: int) -> list[int]:
    return [joint for joint in leg_joints(multibody, foot) if abs(data.xaxis[joint, 1]) > MOSTLY]


@dataclass(frozen=True)
class Leg:
    """One leg, from the hip down.

    Attributes:
        joints: names of its motors' joints.
        links: indices of its bodies, the foot last.
        knee: joint between hip pitch and ankle pitch; empty if there are not just three joints that
            turn about y.
        ankle: the joint that turns about y below the knee; empty without a knee.
        sole_ahead: how far the centre of the sole lies ahead of the ankle [m], nan without one.
        straight: thigh and shank together [m], nan without a knee.
        length: distance of hip and ankle in the nominal pose [m].
    """

    joints: tuple[str, ...]
    links: tuple[int, ...]
    knee: str
    ankle: str
    sole_ahead: float
    straight: float
    length: float

    @property
    def step_reach(self) -> float:
        """Longest step with the hip midway between the ankles at its nominal height [m]."""
        return 2.0 * float(np.sqrt(max(self.straight**2 - self.length**2, 0.0)))


@dataclass(frozen=True)
class NominalPose:
    """What a mechanism's nominal pose is like; the middle of the soles is the origin.

    Attributes:
        com: centre of mass (x, y, z) [m].
        soles: centres of the soles, a row for each foot [m].
        axes: axes of the soles, for each foot in columns.
        legs: left and right.
        foot_shapes: points of each foot's surface in the frame of its sole [m]; none if the model
            has no shapes.
        load: largest torque of each motor with the weight on one foot or the other [N m].
    """

    com: NDArray[np.float64]
    soles: NDArray[np.float64]
    axes: NDArray[np.float64]
    legs: tuple[Leg, Leg]
    foot_shapes: tuple[NDArray[np.float64], NDArray[np.float64]] = field(repr=False)
    load: NDArray[np.float64]

    @property
    def spacing(self) -> float:
        """Lateral distance of the soles, left minus right [m]."""
        return float(self.soles[0, 1] - self.soles[1, 1])


def measure_pose(mechanism: Multibody) -> NominalPose:
    """Measure a mechanism in its nominal pose."""
    data = mechanism.data()
    sites = list(mechanism.soles)
    return NominalPose(
        com=data.subtree_com[mechanism.base].copy(),
        soles=data.site_xpos[sites].copy(),
        axes=data.site_xmat[sites].reshape(2, 3, 3).copy(),
        legs=(_leg(mechanism, data, 0), _leg(mechanism, data, 1)),
        foot_shapes=(_foot_shape(mechanism, data, 0), _foot_shape(mechanism, data, 1)),
        load=np.max([np.abs(one_foot_torque(mechanism, foot)) for foot in (0, 1)], axis=0),
    )


def one_foot_torque(mechanism: Multibody, foot: int) -> NDArray[np.float64]:
    """Torques that carry the nominal pose on one foot, as in the middle of a slow step.

    The ZMP rests at the centre of the sole, the force from there goes through the CoM, so that the
    robot does not turn: f = m g (c - p) / c_z, and every link accelerates by g (c - p) / c_z
    sideways, as the LIPM does. Inverse dynamics then asks nothing of the base.

    Args:
        mechanism: whose torques.
        foot: that carries the weight, 0 left, 1 right.

    Returns:
        Of each motor [N m].
    """
    model, data = mechanism.model, mechanism.data()
    site = mechanism.soles[foot]
    lever = data.subtree_com[mechanism.base] - data.site_xpos[site]
    slope = mechanism.robot.gravity * lever / lever[2]
    data.qvel[:] = data.qacc[:] = 0.0
    data.qacc[mechanism.base_dof : mechanism.base_dof + 2] = slope[:2]
    forces, jacobian = np.zeros(model.nv), np.zeros((3, model.nv))
    mujoco.mj_rne(model, data, 1, forces)
    mujoco.mj_jacSite(model, data, jacobian, None, site)
    return (forces - jacobian.T @ (mechanism.mass * slope))[mechanism.motor_dofs]


def _leg(mechanism: Multibody, data: mujoco.MjData, foot: int) -> Leg:
    model, end = mechanism.model, mechanism.feet[foot]
    links = tuple(leg_bodies(mechanism, end))
    names = tuple(model.joint(joint).name for joint in leg_joints(mechanism, end))
    pitch = _pitch_joints(mechanism, data, end)
    if len(pitch) != JOINTS_THAT_PITCH:
        return Leg(names, links, "", "", np.nan, np.nan, np.nan)
    hip, knee, ankle = data.xanchor[pitch]
    return Leg(
        joints=names,
        links=links,
        knee=model.joint(pitch[1]).name,
        ankle=model.joint(pitch[2]).name,
        sole_ahead=float(data.site_xpos[mechanism.soles[foot], 0] - ankle[0]),
        straight=float(np.linalg.norm(hip - knee) + np.linalg.norm(knee - ankle)),
        length=float(np.linalg.norm(hip - ankle)),
    )


def _foot_shape(mechanism: Multibody, data: mujoco.MjData, foot: int) -> NDArray[np.float64]:
    model = mechanism.model
    body, site = mechanism.feet[foot], mechanism.soles[foot]
    points = [
        data.geom_xpos[geom] + _surface(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T
        for geom in range(model.ngeom)
        if _carries(model, body, model.geom_bodyid[geom]) and not model.geom_contype[geom]
    ]
    if not points:
        return np.zeros((0, 3))
    return (np.vstack(points) - data.site_xpos[site]) @ data.site_xmat[site].reshape(3, 3)


def _carries(model: mujoco.MjModel, body: int, other: int) -> bool:
    """Whether a body is the other one, or the other one is fixed to it."""
    while other != body and other and not model.body_jntnum[other]:
        other = int(model.body_parentid[other])
    return other == body


def _surface(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """Points on a shape, in its own frame [m]; the corners of its box where it is round."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        start = model.mesh_vertadr[mesh]
        return model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8).T
    return centre + corners * half
