"""A body in physics: motors with limits, a floor, pushes on the trunk."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most, check_seed
from surefoot.compiled import njit
from surefoot.control.fields import check_fields, documented, setting
from surefoot.dcm.pushes import Push, acting_force
from surefoot.robot.feet import FEET
from surefoot.robot.floor import check_height, scattered_boards
from surefoot.robot.motors import motor_torques
from surefoot.robot.multibody import Multibody, load_multibody
from surefoot.worlds.body.interface import JointCommand

STANDS, CROSSED, TOUCHED, TILTED, SUNK = range(5)
"""What has become of a body: on its feet; legs have met; another part than a sole is on the floor;
the trunk leans too far; it is too low."""

MAX_TILT = 0.8
"""Of the trunk, of one that has not fallen [rad]."""

MIN_HEIGHT = 0.65
"""Of the base over the floor, of the nominal one [-]."""


@documented
@dataclass(frozen=True)
class Surroundings:
    """What a body stands on and carries, and how it differs from what its control believes.

    Raises:
        ParameterError: a value is out of range.
    """

    friction: float = setting(0.8, "-", "coefficient of the floor", above=0.0)
    payload: float = setting(
        0.0, "kg", "mass fixed to the base, or to `Body.trunk`, at its centre of mass", least=0.0
    )
    mass_factor: float = setting(1.0, "-", "of all links", above=0.0)
    bumps: float = setting(
        0.0, "m",
        "height of the highest board that lies on the floor, see `robot.floor`; 0 is flat, 0.03 "
        "the most",
    )  # fmt: skip
    seed: int = setting(0, "", "of where the boards lie")

    def __post_init__(self) -> None:
        check_fields(self)
        check_height("bumps", self.bumps)
        check_seed(self.seed)

    @cached_property
    def boards(self) -> NDArray[np.void]:
        """What lies on the floor, records of `robot.floor.Board`."""
        return scattered_boards(self.bumps, self.seed)


@njit
def _state_of(pairs, count, is_floor, is_sole, upright, height, least):
    found = STANDS
    for k in range(count):
        a, b = pairs[k, 0], pairs[k, 1]
        if not (is_floor[a] or is_floor[b]):
            return CROSSED
        if not is_sole[b if is_floor[a] else a]:
            found = TOUCHED
    if found == STANDS and upright < math.cos(MAX_TILT):
        found = TILTED
    if found == STANDS and height < least:
        found = SUNK
    return found


class BodyPlant:
    """The world of one body; its state is MuJoCo's.

    Args:
        multibody: the mechanism.
        surroundings: floor, payload, masses.
        pushes: on the trunk's centre of mass.
        model: of another plant in the same surroundings, made anew if None.

    Raises:
        ParameterError: the payload weighs more than the body.

    Attributes:
        time: [s].
        position, velocity: generalised, of now; views.
        foot_force: vertical, on left and right sole, shape (2,) [N].
        torque: what the motors gave last, shape (n,) [N m].
    """

    def __init__(
        self,
        multibody: Multibody,
        surroundings: Surroundings | None = None,
        pushes: Sequence[Push] = (),
        model: mujoco.MjModel | None = None,
    ) -> None:
        self.multibody, self.surroundings = multibody, surroundings or Surroundings()
        why = "a load above the own mass is a mistake"
        check_most("payload", self.surroundings.payload, multibody.mass, "kg", why)
        self.pushes = tuple(pushes)
        self.model = _changed(multibody, self.surroundings) if model is None else model
        data = self._data = mujoco.MjData(self.model)
        data.qpos[:] = multibody.nominal
        self.position, self.velocity, self._sensed = data.qpos, data.qvel, data.sensordata
        self.torque = np.zeros(len(multibody.motors))
        geoms = [self.model.geom(index).name for index in range(self.model.ngeom)]
        soles = {f"{side}_sole" for side in FEET}
        self._is_sole = np.array([name in soles for name in geoms])
        self._is_floor = self.model.geom_bodyid == 0
        self._upright = data.xmat[multibody.base]
        self._motor_positions, self._dofs = multibody.motor_positions, multibody.motor_dofs
        self._most = np.minimum(multibody.torque, 1e9)
        self._fastest = np.minimum(multibody.speed, 1e9)
        self._force = data.xfrc_applied[multibody.trunk]
        self._touch = np.array([self.model.sensor(f"{side}_touch").adr[0] for side in FEET])
        self.cycle = 0
        mujoco.mj_step1(self.model, data)

    @property
    def data(self) -> mujoco.MjData:
        """Its state, to be read only."""
        return self._data

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.cycle * self.model.opt.timestep

    @property
    def foot_force(self) -> NDArray[np.float64]:
        """Vertical force on left and right sole, as of the last cycle, shape (2,) [N]."""
        return self._sensed[self._touch]

    def state(self) -> int:
        """Whether it stands, or how it fell."""
        data = self._data
        contacts = data.contact.geom
        return int(
            _state_of(
                contacts, len(contacts), self._is_floor, self._is_sole, self._upright[8],
                self.position[2], MIN_HEIGHT * self.multibody.nominal[2],
            )
        )  # fmt: skip

    def act(self, command: JointCommand) -> None:
        """One cycle of physics."""
        model, data = self.model, self._data
        motor_torques(
            (command.torque, command.position, command.velocity),
            (command.stiffness, command.damping),
            (data.qpos[self._motor_positions], data.qvel[self._dofs]),
            (self._most, self._fastest), self.torque,
        )  # fmt: skip
        data.ctrl[:] = self.torque
        self._force[:2] = acting_force(self.pushes, self.time)
        mujoco.mj_step2(model, data)
        self.cycle += 1
        mujoco.mj_step1(model, data)

    def fork(self) -> BodyPlant:
        """Another one in the same state, under the same pushes."""
        other = BodyPlant(self.multibody, self.surroundings, self.pushes, self.model)
        mujoco.mj_copyData(other._data, self.model, self._data)
        other.cycle, other.torque[:] = self.cycle, self.torque
        return other


def _changed(multibody: Multibody, surroundings: Surroundings) -> mujoco.MjModel:
    if len(surroundings.boards):
        # More shapes, the same bodies and joints.
        model = load_multibody(multibody.robot, surroundings.boards).model
    else:
        model = copy.copy(multibody.model)
    model.geom_friction[model.geom_bodyid == 0, 0] = surroundings.friction
    model.body_mass *= surroundings.mass_factor
    model.body_inertia *= surroundings.mass_factor
    model.body_mass[multibody.trunk] += surroundings.payload
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model
