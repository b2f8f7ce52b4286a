"""Any controller of the point mass, walking a body: standing, first step, steps, and a stand again.

Each cycle: the state of the mechanism, what the controller is given, its command, a reference
for the body, and the motors. Steps end when the foot meets the ground, early, in time or late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import (
    check_fields,
    declared,
    described,
    documented,
    fill_shares,
    setting,
)
from surefoot.errors import VelocityError
from surefoot.geometry import rotated
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation
from surefoot.record import copy_array, new_array
from surefoot.robot.feet import Side
from surefoot.robot.legs import find_legs
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.course import Course, CourseController, VelocityCorrection
from surefoot.worlds.body.interface import (
    BODY_REFERENCE,
    JointCommand,
    JointMapping,
    JointMemory,
)
from surefoot.worlds.body.mechanics import Mechanics
from surefoot.worlds.body.step import (
    BODY_WALK,
    DOWN,
    MIN_FLIGHT,
    MIN_RISE,
    SHIFT,
    SOON_DOWN,
    STAND,
    WALK,
    BodyKernels,
    BodyLimits,
    body_kernels,
)
from surefoot.worlds.steering import Steering

STAND_GAIN = 1.0
"""How far beyond the DCM the ZMP goes, per distance from the middle of the feet [-]."""

MAX_BRAKING = 4.08
"""Of a foot that comes near to its fellow, in g: its leg may have no limit."""

TOUCH_FORCE = 0.03
"""Part of the weight from which on a force may be that of a landing."""

FIRST_STEPS = 2
"""Steps in place before the commanded velocity, and before a stand."""

CORRECTED = (1.0, 0.5, 0.25, 0.0)
"""Parts of a correction that are tried, until one can be walked."""


@dataclass(frozen=True)
class BodyState:
    """What evolves: a value, but for the mechanics' workspace, which only holds the present.

    Attributes:
        walk: a `BodyWalk` as an array, shape (1,).
        controller: at the velocity that it is given now.
        memory: the controller's own state.
        observation, command: of the last cycle.
        joints: what the mapping remembers.
        course: where the robot should be.
        correction: what is added to the velocity to take it there.
        slow_steps: how many in a row, up to now, were to stay on the spot.
    """

    walk: NDArray[np.void]
    controller: Controller
    memory: NDArray[np.void] | None
    observation: Observation
    command: Command
    joints: JointMemory
    course: Course
    correction: VelocityCorrection
    slow_steps: int = 0


@documented
@dataclass(frozen=True)
class BodyControl:
    """Walks a body with a controller of the point mass."""

    controller: Controller = field(
        metadata=described(
            "of a robot as `walking_robot` makes it from the multibody's; any method"
        )
    )
    multibody: Multibody = field(metadata=described("the mechanism as the control believes it"))
    mapping: JointMapping = field(metadata=described("from reference to motors"))
    first_support: Side = field(
        default=Side.RIGHT, metadata=described("the foot that carries in the first step")
    )
    settle_time: float = setting(None, "s", "standing before the first step", share=1.05)
    shift_time: float = setting(
        None, "s", "in which the DCM is moved to where that begins", share=2.1, above=0.0
    )
    place_rate: float = setting(
        None, "1/s", "rate at which an error of place is removed; 0 holds no place", share=0.143
    )
    max_correction: float = setting(None, "m/s", "of the velocity, to either side", share=0.0535)
    max_change: float = setting(
        None, "m/s^2", "of that correction; 0 never corrects", share=0.00306
    )
    max_lead: float = setting(
        None, "m", "the course waits for a robot that is this far from it", share=0.375
    )
    knee_bend: float = setting(
        0.3, "rad", "least one of a leg, sets the CoM's height in long steps", least=0.0
    )
    max_drop: float = setting(None, "m", "of the CoM", share=0.15)
    height_stiffness: float = setting(None, "1/s^2", "of the CoM's height", share=3.26, above=0.0)
    max_lift: float = setting(
        None, "m/s^2", "largest vertical acceleration", share=0.816, above=0.0
    )
    sink: float = setting(None, "m/s", "speed of a foot that waits for the ground", share=0.178)
    mechanics: Mechanics = field(init=False, repr=False, compare=False)
    limits: NDArray[np.void] = field(init=False, repr=False, compare=False)
    kernels: BodyKernels = field(init=False, repr=False, compare=False)
    course_controller: CourseController = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        fill_shares(self, self.controller.robot)
        check_fields(self)
        object.__setattr__(self, "mechanics", Mechanics(self.multibody))
        object.__setattr__(self, "limits", self._limits())
        object.__setattr__(self, "kernels", body_kernels())
        course = CourseController(self.place_rate, self.max_correction, self.max_change)
        object.__setattr__(self, "course_controller", course)

    def _limits(self) -> NDArray[np.void]:
        robot, multibody, legs = self.controller.robot, self.multibody, find_legs(self.multibody)
        shortest = robot.gait.step_duration[0]
        shared = BodyLimits.FIELDS.keys() & declared(self).keys()
        return BodyLimits(
            omega=robot.omega,
            height=robot.com_height,
            hip=legs.hip,
            leg=legs.length(self.knee_bend),
            ankle=legs.ankle,
            hip_over_com=legs.over_com,
            hip_ahead=legs.ahead_of_com,
            mass=multibody.mass,
            period=self.controller.period,
            apex=robot.swing.height,
            landing_velocity=robot.swing.landing_velocity,
            step_duration=self.controller.gait.step_duration,
            min_distance=robot.hip + robot.gait.step_y[0],
            braking=min(robot.swing.max_acceleration, MAX_BRAKING * robot.gravity),
            touch_force=TOUCH_FORCE * multibody.mass * robot.gravity,
            soon_down=SOON_DOWN * robot.swing.height,
            down=DOWN * robot.swing.height,
            min_rise=MIN_RISE * shortest,
            min_flight=MIN_FLIGHT * shortest,
            **{name: getattr(self, name) for name in shared},
        ).array

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing, and room of its own to work in."""
        return replace(self, mapping=self.mapping.fresh())

    @cached_property
    def in_place(self) -> Controller:
        """The controller for the first and the last steps."""
        return self.controller.with_velocity((0.0, 0.0))

    def start(self) -> BodyState:
        """The state of a body that stands on both feet, in its nominal pose, at the origin."""
        walk = new_array(BODY_WALK)
        walk["phase"] = STAND
        observation = self.in_place.first_observation(self.first_support)
        return BodyState(
            walk=walk,
            controller=self.in_place,
            memory=None,
            observation=observation,
            command=Command.of(new_array(COMMAND)),
            joints=self.mapping.start(),
            course=Course((0.0, 0.0), 0.0, 0.0),
            correction=VelocityCorrection(),
        )

    def step(
        self,
        state: BodyState,
        time: float,
        position: NDArray[np.float64],
        velocity: NDArray[np.float64],
        forces: NDArray[np.float64],
        steering: Steering,
    ) -> tuple[JointCommand, BodyState]:
        """One cycle; never raises.

        Args:
            state, time: of the last cycle, and now [s].
            position, velocity: generalised, as estimated; shapes (nq,), (nv,).
            forces: vertical, on left and right sole, shape (2,) [N].
            steering: where to go.
        """
        self.mechanics.update(position, velocity)
        walk, reference = copy_array(state.walk), new_array(BODY_REFERENCE)
        walk["now"], phase = time, int(walk["phase"][0])
        if phase != WALK:
            state = self._stand(replace(state, walk=walk), steering, reference)
            phase = int(walk["phase"][0])
        if phase == WALK:
            state = self._walk(state, walk, forces, steering, reference)
        command, joints = self.mapping.joints(self.mechanics, reference, forces, state.joints)
        return command, replace(state, joints=joints)

    def _stand(
        self, state: BodyState, steering: Steering, reference: NDArray[np.void]
    ) -> BodyState:
        """Hold the DCM between the feet, or move it to where the first step begins."""
        walk, mechanics, omega = state.walk, self.mechanics, self.limits["omega"][0]
        dcm = mechanics.com[:2] + mechanics.com_velocity[:2] / omega
        left, right = mechanics.sole_position[:, :2]
        zmp = dcm + STAND_GAIN * (dcm - 0.5 * (left + right))
        since = float(walk["now"][0] - walk["began"][0])
        heading = walk["heading"] = self._heading()
        if (
            walk["phase"][0] == STAND
            and not steering.standing
            and since >= self.limits["settle_time"][0]
        ):
            walk["phase"], walk["began"], since = SHIFT, walk["now"], 0.0
        if walk["phase"][0] == SHIFT:
            rest = float(self.limits["shift_time"][0]) - since
            if rest < 1e-9:
                return self._first_step(state)
            growth = math.exp(omega * rest)
            begin = mechanics.sole_position[self._first, :2] + rotated(self._first_dcm, heading)
            zmp = (begin - dcm * growth) / (1.0 - growth)
        zmp = self._between_feet(zmp, heading)
        self.kernels.stand(self.limits, walk, mechanics.motion, zmp, reference)
        walk["swing_foot"] = mechanics.sole_position[1 - walk["support"][0]]
        state.command.array["zmp"][0] = zmp
        return state

    @property
    def _first(self) -> int:
        """The foot that carries first, as a row of tables with a row for each foot."""
        return 0 if self.first_support is Side.LEFT else 1

    @cached_property
    def _first_dcm(self) -> tuple[float, float]:
        """Where the DCM is when the first step begins, from the foot that carries [m]."""
        begin = self.in_place.first_observation(self.first_support)
        x, y = begin.dcm - begin.support_foot
        return float(x), float(y)

    def _heading(self) -> float:
        (left, right), yaws = self.mechanics.sole_axes, []
        for axes in (left, right):
            yaws.append(math.atan2(axes[1, 0], axes[0, 0]))
        first, second = yaws
        return math.atan2(
            0.5 * (math.sin(first) + math.sin(second)), 0.5 * (math.cos(first) + math.cos(second))
        )

    def _between_feet(self, zmp: NDArray[np.float64], heading: float) -> NDArray[np.float64]:
        """The nearest point on the line between the ankles, give or take half a sole."""
        left, right = self.mechanics.sole_position[:, :2]
        half = 0.8 * self.multibody.robot.foot.half[0]
        forward = np.array(rotated((1.0, 0.0), heading))
        across, away = left - right, zmp - right
        part = min(max(float(away @ across) / float(across @ across), 0.05), 0.95)
        ahead = float((away - part * across) @ forward)
        return right + part * across + min(max(ahead, -half), half) * forward

    def _first_step(self, state: BodyState) -> BodyState:
        walk, mechanics = state.walk, self.mechanics
        walk["phase"], walk["steps"] = WALK, 0
        self.kernels.begin(walk, np.array([self._first]), mechanics.motion)
        x, y = mechanics.sole_position[:, :2].mean(axis=0)
        course = Course((float(x), float(y)), float(walk["heading"][0]), float(walk["now"][0]))
        return replace(
            state, controller=self.in_place, course=course, correction=VelocityCorrection(),
            slow_steps=0, memory=None,
        )  # fmt: skip

    def _walk(
        self,
        state: BodyState,
        walk: NDArray[np.void],
        forces: NDArray[np.float64],
        steering: Steering,
        reference: NDArray[np.void],
    ) -> BodyState:
        mechanics, kernels, limits = self.mechanics, self.kernels, self.limits
        motion, command, memory = mechanics.motion, state.command, state.memory
        observation = Observation.of(new_array(OBSERVATION))
        kernels.measure(limits, walk, motion, command.array, forces, observation.array)
        if walk["landed"][0]:
            state = replace(state, walk=walk)
            if steering.standing and state.slow_steps >= FIRST_STEPS:
                walk["phase"], walk["began"] = STAND, walk["now"]
                return replace(self._stand(state, steering, reference), memory=None)
            state = self._next_step(state, steering)
            memory = state.memory
            kernels.measure(limits, walk, motion, command.array, forces, observation.array)
        if memory is None:
            memory = state.controller.start(observation)
        command, memory = state.controller.step(memory, observation)
        kernels.refer(limits, walk, motion, observation.array, command.array, reference)
        return replace(state, walk=walk, memory=memory, observation=observation, command=command)

    def _next_step(self, state: BodyState, steering: Steering) -> BodyState:
        """Touchdown: the feet change, and the controller is given a velocity anew."""
        walk, mechanics, time = state.walk, self.mechanics, float(state.walk["now"][0])
        self.kernels.begin(walk, 1 - walk["support"], mechanics.motion)
        if steering.standing:
            steering = Steering()
        slow = steering.velocity == (0.0, 0.0) and steering.turning == 0.0
        slow_steps = state.slow_steps + 1 if slow else 0
        walking = walk["steps"][0] > FIRST_STEPS
        if not walking:
            steering = Steering()
        x, y = mechanics.sole_position[:, :2].mean(axis=0)
        place = (float(x), float(y))
        course = state.course.moved(steering, time).waiting_for(
            place, float(self.limits["max_lead"][0])
        )
        turn = steering.turning * state.controller.gait.step_duration
        memory = state.memory
        heading = course.heading + turn
        if heading != walk["heading"][0]:
            # Its memory is of another frame; at a touchdown it holds little that is needed.
            walk["heading"], memory = heading, None
        controller, correction = state.controller, state.correction
        if walking:
            elapsed, error = time - state.course.time, course.error(place, heading)
            wanted = self.course_controller.correction(correction, error, elapsed, steering.turning)
            controller, correction = self._towards(controller, correction, wanted, steering)
        return replace(
            state,
            controller=controller,
            course=course,
            correction=correction,
            memory=memory,
            slow_steps=slow_steps,
        )

    @staticmethod
    def _towards(
        controller: Controller,
        before: VelocityCorrection,
        correction: VelocityCorrection,
        steering: Steering,
    ) -> tuple[Controller, VelocityCorrection]:
        """The controller for the velocity of the steering and what holds the place.

        A velocity at the edge of what can be walked leaves less room to correct it, or none: then
        nothing is integrated, and the next correction starts from the one that was used.
        """
        (x, y), (vx, vy) = correction.total, steering.velocity
        for part in CORRECTED:
            wanted = (vx + part * x, vy + part * y)
            if part < 1.0:
                back = (part * x - before.drift[0], part * y - before.drift[1])
                correction = VelocityCorrection(before.drift, back)
            if wanted == controller.gait.velocity:
                return controller, correction
            try:
                return controller.with_velocity(wanted), correction
            except VelocityError:
                continue
        return controller, correction
