"""Where the soles are in the frame of the base, and how well encoders of the joints measure it.

A leg is a chain of links from the base to the sole. Each is moved against the one before by a
fixed offset and rotation, then rotated about its hinge; the last one is the sole, without a hinge.
The frame of a sole is that of the base when the robot stands in its nominal pose.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.record import Array, Record, Vector2, Vector3, field
from surefoot.robot.legs import leg_bodies
from surefoot.robot.multibody import Multibody

SOLE = -1
"""Stands for the hinge of a link that has none."""

MAX_HINGES = 16
"""A leg has no more."""


class Link(Record):
    """A link of a leg."""

    leg: int = field("", "0 left, 1 right")
    hinge: int = field("", "index of its hinge among the joints, or `SOLE`")
    rotation: Array = field("-", "against the link before", shape=(3, 3))
    offset: Vector3 = field("m", "likewise")
    anchor: Vector3 = field("m", "a point of the hinge in the link")
    axis: Vector3 = field("-", "direction of the hinge in the link")
    zero: float = field("rad", "angle at which it is not rotated")


class Soles(Record):
    """Both soles in the frame of the base, and how well encoders measure where they are.

    The spread is what an error of 1 rad in every encoder makes, root of the sum of squares.
    """

    position: Array = field("m", "centres", shape=(2, 3))
    rotation: Array = field("-", "their frames", shape=(2, 3, 3))
    spread: Array = field("m", "of the position in each axis", shape=(2, 3))
    turn_spread: Vector2 = field("rad", "of the heading")


LINK, SOLES = Link.DTYPE, Soles.DTYPE
"""The same for kernels, which know no classes."""


@njit
def _step(rotation, position, along, by, sign):
    """Move a frame along one of its own vectors, times `sign`, then rotate it by a matrix."""
    for i in range(3):
        a, b, c = rotation[i, 0], rotation[i, 1], rotation[i, 2]
        position[i] += sign * (a * along[0] + b * along[1] + c * along[2])
        for j in range(3):
            rotation[i, j] = a * by[0, j] + b * by[1, j] + c * by[2, j]


@njit
def _turn_hinge(link, angle, turn):
    """The rotation about the hinge, by the formula of Rodrigues."""
    s, c = math.sin(angle - link.zero), math.cos(angle - link.zero)
    for i in range(3):
        for j in range(3):
            turn[i, j] = (1.0 - c) * link.axis[i] * link.axis[j]
        turn[i, i] += c
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turn[k, j] += s * link.axis[i]
        turn[j, k] -= s * link.axis[i]


@njit
def find_soles(links, angles, soles):
    """Forward kinematics of both legs.

    Args:
        links: of both legs, from the base outwards, records of `Link`.
        angles: of all joints [rad].
        soles: a `Soles` record, changed.
    """
    axes, points = np.empty((MAX_HINGES, 3)), np.empty((MAX_HINGES, 3))
    rotation, position, turn, hinges = np.eye(3), np.zeros(3), np.eye(3), 0
    still = np.eye(3)
    for k in range(links.shape[0]):
        link = links[k]
        _step(rotation, position, link.offset, link.rotation, 1.0)
        if link.hinge != SOLE:
            _step(rotation, position, link.anchor, still, 1.0)
            for i in range(3):
                points[hinges, i], axes[hinges, i] = position[i], 0.0
                for j in range(3):
                    axes[hinges, i] += rotation[i, j] * link.axis[j]
            hinges += 1
            _turn_hinge(link, angles[link.hinge], turn)
            _step(rotation, position, link.anchor, turn, 0.0)
            _step(rotation, position, link.anchor, still, -1.0)
            continue
        _spread(axes, points, hinges, position, soles, link.leg)
        hinges = 0
        for i in range(3):
            soles.position[link.leg, i], position[i] = position[i], 0.0
            for j in range(3):
                soles.rotation[link.leg, i, j] = rotation[i, j]
                rotation[i, j] = still[i, j]


@njit
def _spread(axes, points, hinges, position, soles, leg):
    """How far errors of the hinges, all equally large, move and turn the sole."""
    moved, turn = np.zeros(3), 0.0
    for k in range(hinges):
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            arm_j, arm_m = position[j] - points[k, j], position[m] - points[k, m]
            moved[i] += (axes[k, j] * arm_m - axes[k, m] * arm_j) ** 2
        turn += axes[k, 2] ** 2
    for i in range(3):
        soles.spread[leg, i] = math.sqrt(moved[i])
    soles.turn_spread[leg] = math.sqrt(turn)


def leg_links(multibody: Multibody) -> NDArray[np.void]:
    """The links of both legs of a mechanism, shape (n,), records of `Link`."""
    links = np.concatenate([_leg(multibody, leg) for leg in (0, 1)])
    soles = np.zeros(1, Soles.DTYPE)
    find_soles(links, multibody.nominal[7:], soles[0])
    for leg in (0, 1):
        (last,) = np.flatnonzero((links["leg"] == leg) & (links["hinge"] == SOLE))
        links["rotation"][last] = links["rotation"][last] @ soles["rotation"][0, leg].T
    return links


def _leg(multibody: Multibody, leg: int) -> NDArray[np.void]:
    model = multibody.model
    rows = []
    rotation, offset = np.eye(3), np.zeros(3)
    for body in leg_bodies(multibody, multibody.feet[leg]):
        offset = offset + rotation @ model.body_pos[body]
        rotation = rotation @ _matrix(model.body_quat[body])
        first = int(model.body_jntadr[body])
        for joint in range(first, first + int(model.body_jntnum[body])):
            address = int(model.jnt_qposadr[joint])
            hinge = (model.jnt_pos[joint], model.jnt_axis[joint], model.qpos0[address])
            rows.append((leg, address - 7, rotation, offset, *hinge))
            rotation, offset = np.eye(3), np.zeros(3)
    site = multibody.soles[leg]
    offset = offset + rotation @ model.site_pos[site]
    rotation = rotation @ _matrix(model.site_quat[site])
    rows.append((leg, SOLE, rotation, offset, np.zeros(3), np.zeros(3), 0.0))
    return np.array(rows, Link.DTYPE)


def _matrix(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    w, v = quaternion[0], quaternion[1:]
    cross = np.cross(v, -np.eye(3))
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
