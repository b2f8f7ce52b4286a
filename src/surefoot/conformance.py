"""What every controller must do, whatever its method: a suite of tests that anybody can run.

    pytest --pyargs surefoot.conformance

runs it over every control method that is installed. The environment variable SUREFOOT_METHODS names
those to run it over instead, with commas between them: keys of methods, or `module:Class`.
"""

from __future__ import annotations

import math
import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest

from surefoot.control.cycle import is_usable
from surefoot.control.registry import Method, find_method, methods
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError, VelocityError
from surefoot.interface import Command, Controller, Mode, Observation, Status
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot, load_robot
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.simulate import simulate

VARIABLE = "SUREFOOT_METHODS"
"""The environment variable that names the methods."""

ROBOT = load_robot("paper-biped")
LEG_SPEED = 3.0
"""Limit of the swing foot of the robot that walks [m/s]."""

Make = Callable[[tuple[float, float]], Controller]

EXACT = 1e-9
"""How near to its nominal gait a method walks undisturbed, if it says nothing else [m]."""

OWN_PLAN = 1e-6
"""How near to its own plan a method walks that follows the nominal gait less exactly [m]."""

PUSH = Push(1.1, 0.2, (60.0, 30.0))
VELOCITIES = [(0.5, 0.0), (-0.3, 0.0), (0.0, 0.0), (0.0, 0.2), (0.3, -0.15)]


@dataclass(frozen=True)
class Case:
    """A controller to be tested.

    Attributes:
        name: of the test.
        make: the controller for a velocity [m/s].
        nearness: see `control.registry.Method` [m].
        zmp_trace: likewise [m].
        given_footsteps: likewise.
    """

    name: str
    make: Make
    nearness: float = EXACT
    zmp_trace: float = 1e-12
    given_footsteps: bool = False

    @classmethod
    def of(cls, method: Method, robot: Robot) -> Case:
        """A method on a robot."""
        return cls(
            method.key,
            lambda velocity: method.controller(robot, velocity),
            method.nearness,
            method.zmp_trace,
            method.given_footsteps,
        )


def cases() -> list[Case]:
    """Those that the environment names, or every method that is installed."""
    named = [key for key in os.environ.get(VARIABLE, "").split(",") if key]
    chosen = [find_method(key) for key in named] if named else methods()
    robot = ROBOT.with_leg(max_speed=LEG_SPEED)
    return [Case.of(one, robot) for one in chosen]


@pytest.fixture(params=cases(), ids=lambda case: case.name)
def case(request: pytest.FixtureRequest) -> Case:
    """One controller after the other."""
    return request.param


def cycles(controller: Controller, seconds: float) -> int:
    """How many control periods these seconds are."""
    return round(seconds / controller.period)


def mirrored(rollout: Rollout, name: str) -> np.ndarray:
    """A time-first array of vectors as seen in the mirror y -> -y."""
    values = np.array(getattr(rollout, name))
    values[:, 1] *= -1.0
    return values


def test_it_is_a_controller(case: Case) -> None:
    controller = case.make((0.5, 0.0))
    assert isinstance(controller, Controller)
    with pytest.raises(AttributeError):
        controller.period = 0.002  # type: ignore[misc]


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_undisturbed_it_walks_the_nominal_gait(case: Case, velocity) -> None:
    rollout = simulate(case.make(velocity), 4.0)
    assert rollout.outcome is Outcome.WALKED
    gait, near = nominal_gait(ROBOT, velocity), case.nearness
    own = OWN_PLAN if case.nearness > EXACT else EXACT
    for step in rollout.footsteps:
        assert step.duration == pytest.approx(gait.step_duration, abs=1e-9)
        assert step.step == pytest.approx(gait.step(step.side), abs=near)
        assert step.dcm_offset == pytest.approx(gait.dcm_offset(step.side), abs=near)
    assert rollout.final_velocity == pytest.approx(velocity, abs=own)
    assert np.abs(rollout.dcm_error).max() < own


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_the_mirror_image_of_a_walk_is_the_walk_of_the_mirror_image(case: Case, velocity) -> None:
    v_x, v_y = velocity
    force_x, force_y = PUSH.force
    here = simulate(case.make(velocity), 3.0, [PUSH], first_support=Side.RIGHT)
    there = simulate(
        case.make((v_x, -v_y)),
        3.0,
        [replace(PUSH, force=(force_x, -force_y))],
        first_support=Side.LEFT,
    )
    assert here.time == pytest.approx(there.time, abs=1e-9)
    for name in ("com", "dcm", "zmp", "dcm_plan", "support_foot", "swing_foot"):
        assert mirrored(here, name) == pytest.approx(getattr(there, name), abs=1e-9), name
    assert here.support_side.tolist() == (-there.support_side).tolist()


def shifted(observation: Observation, shift: tuple[float, float], time: float) -> Observation:
    moved = {
        name: getattr(observation, name) + np.array(shift)
        for name in ("com", "dcm", "support_foot")
    }
    foot = observation.swing_foot + np.array([*shift, 0.0])
    return observation.replace(time=observation.time + time, swing_foot=foot, **moved)


class Cycle(NamedTuple):
    """What a controller decided on, and what it decided."""

    observation: Observation
    command: Command
    state: np.ndarray


def closed_loop(
    controller: Controller,
    observation: Observation,
    cycles: int,
    pushes: Sequence[Push] = (),
    measured: Callable[[int, Observation], Observation] = lambda _, true: true,
) -> Iterator[Cycle]:
    """The cycles of a loop of one's own, as a user would write it.

    Args:
        controller: what decides.
        observation: at the start.
        cycles: how many.
        pushes: on the robot.
        measured: what the controller is given in a cycle, of what is true.
    """
    simulator = LipmSimulator(controller.robot, controller.period, pushes)
    world, state = simulator.start(observation), controller.start(measured(0, observation))
    for cycle in range(cycles):
        command, state = controller.step(state, measured(cycle, observation))
        yield Cycle(observation, command, state)
        observation, world = simulator.step(world, command)


@pytest.mark.parametrize(("shift", "time"), [((0.7, -0.4), 0.0), ((0.0, 0.0), 12.5)])
def test_a_walk_elsewhere_or_later_is_the_same_walk(case: Case, shift, time) -> None:
    controller = case.make((0.3, 0.1))
    begin = controller.gait.observation(Side.LEFT)
    count, later = cycles(controller, 1.8), replace(PUSH, start=PUSH.start + time)
    here = closed_loop(controller, begin, count, [PUSH])
    there = closed_loop(controller, shifted(begin, shift, time), count, [later])
    for (true, command, _), (true_there, command_there, _) in zip(here, there, strict=True):
        assert true_there.time - time == pytest.approx(true.time, abs=1e-9)
        assert true_there.dcm - shift == pytest.approx(true.dcm, abs=1e-9)
        assert command_there.zmp - shift == pytest.approx(command.zmp, abs=1e-9)
        assert command_there.step_location - shift == pytest.approx(command.step_location, abs=1e-9)
        assert command_there.step_duration == pytest.approx(command.step_duration, abs=1e-9)
        assert command_there.swing_foot - (*shift, 0.0) == pytest.approx(
            command.swing_foot, abs=1e-9
        )


def test_the_same_walk_twice_has_the_same_bits(case: Case) -> None:
    first, second = (simulate(case.make((0.5, 0.0)), 3.0, [PUSH]) for _ in range(2))
    assert first.observations.tobytes() == second.observations.tobytes()
    assert first.commands.tobytes() == second.commands.tobytes()


def test_it_goes_to_another_process(case: Case) -> None:
    here = case.make((0.5, 0.0))
    there = pickle.loads(pickle.dumps(here))
    assert there == here
    first, second = (simulate(controller, 2.0, [PUSH]) for controller in (here, there))
    assert first.commands.tobytes() == second.commands.tobytes()


def test_nothing_that_goes_in_is_changed(case: Case) -> None:
    controller = case.make((0.5, 0.0))
    observation = controller.gait.observation(Side.RIGHT)
    observation = observation.replace(dcm=np.add(observation.dcm, (0.03, -0.02)))
    state = controller.start(observation)
    before = (state.tobytes(), observation.array.tobytes(), controller.parameters.tobytes())
    command, next_state = controller.step(state, observation)
    assert (state.tobytes(), observation.array.tobytes(), controller.parameters.tobytes()) == before
    assert next_state.tobytes() != state.tobytes()
    again, _ = controller.step(state, observation)
    assert again == command  # the state is a value: the past can be asked again
    with pytest.raises(ValueError, match="read-only"):
        command.zmp[0] = 1.0


BROKEN = [
    ("dcm", (math.nan, 0.0)),
    ("dcm", (0.0, math.inf)),
    ("com", (math.nan, 0.0)),
    ("com_velocity", (0.0, -math.inf)),
    ("support_foot", (math.nan, math.nan)),
    ("swing_foot", (0.0, 0.0, math.nan)),
    ("swing_foot_velocity", (math.nan, 0.0, 0.0)),
    ("elapsed", math.nan),
    ("time", math.nan),
    ("support_yaw", math.nan),
    ("dcm", (1e300, 0.0)),
    ("support_side", 0),
]


@pytest.mark.parametrize(("name", "value"), BROKEN)
def test_a_broken_observation_holds_the_last_command_and_says_so(case: Case, name, value) -> None:
    controller = case.make((0.5, 0.0))
    lost = cycles(controller, 0.1)
    walk = list(closed_loop(controller, controller.first_observation(None), lost + 2))
    _, safe, state = walk[lost - 1]
    true, after = walk[lost].observation, walk[lost + 1].observation
    broken = true.replace(**{name: value})
    held, next_state = controller.step(state, broken)
    assert Status(held.status) == Status.HELD
    assert held.replace(status=safe.status) == safe
    # One bad cycle leaves no trace in the next good one, but for the swing foot's lost period.
    command, _ = controller.step(next_state, after)
    clean, _ = controller.step(walk[lost].state, after)
    for field in ("dcm_plan", "step_location", "step_duration", "dcm_offset", "status"):
        assert command.array[field] == pytest.approx(clean.array[field], abs=1e-12), field
    assert command.zmp == pytest.approx(clean.zmp, abs=case.zmp_trace)
    assert command.swing_foot == pytest.approx(clean.swing_foot, abs=controller.period)
    assert not is_usable(broken.array[0])


def test_a_touchdown_in_a_dropout_does_not_leave_the_zmp_behind(case: Case) -> None:
    """The DCM is lost while the foot lands: the ZMP goes under the foot that stands now."""
    controller = case.make((0.5, 0.0))
    begin = controller.first_observation(None)
    walk = list(closed_loop(controller, begin, cycles(controller, 0.55)))
    touchdown = next(
        k for k, cycle in enumerate(walk) if cycle.observation.support_side is Side.LEFT
    )
    state = walk[touchdown - 6].state
    for observation, _, _ in walk[touchdown - 5 : touchdown + 5]:
        held, state = controller.step(state, observation.replace(dcm=(math.nan, 0.0)))
        assert held.status == Status.HELD
        under_the_foot = np.array(ROBOT.foot.half) + 1e-9
        assert (np.abs(held.zmp - observation.support_foot) <= under_the_foot).all()
    after, _ = controller.step(state, walk[touchdown + 5].observation)
    expected = walk[touchdown + 5].command.step_location
    assert after.step_location == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("elapsed", [-1e-9, -0.1, -1.0])
def test_a_clock_that_is_a_little_early_raises_nothing(case: Case, elapsed: float) -> None:
    controller = case.make((0.5, 0.0))
    observation = controller.gait.observation(Side.RIGHT)
    command, _ = controller.step(
        controller.start(observation), observation.replace(elapsed=elapsed)
    )
    assert np.isfinite(command.zmp).all()
    assert np.isfinite(command.step_location).all()


def test_a_walk_with_dropouts_goes_on(case: Case) -> None:
    """Every tenth observation is lost: the robot still walks."""
    controller = case.make((0.5, 0.0))

    def lossy(cycle: int, true: Observation) -> Observation:
        return true.replace(dcm=(math.nan, math.nan)) if cycle % 10 == 9 else true

    begin, count = controller.gait.observation(Side.RIGHT), cycles(controller, 4.0)
    walk = closed_loop(controller, begin, count, measured=lossy)
    for cycle, (observation, command, _) in enumerate(walk):
        assert (Status.HELD in command.status) == (cycle % 10 == 9)
        assert np.hypot(*(observation.dcm - observation.support_foot)) < 0.5


def test_it_does_not_start_on_a_broken_observation(case: Case) -> None:
    controller = case.make((0.5, 0.0))
    observation = controller.gait.observation(Side.RIGHT)
    with pytest.raises(ParameterError, match="first observation of finite numbers"):
        controller.start(observation.replace(dcm=(math.nan, 0.0)))
    with pytest.raises(ParameterError, match="and a Side"):
        controller.start(observation.replace(support_side=0))


def test_a_new_velocity_does_not_make_the_plan_jump(case: Case) -> None:
    """The step under way ends with the new offset; the planned DCM is continuous through it all."""
    changes = [(0.73, (0.2, 0.1)), (2.2, (0.0, 0.0)), (3.9, (-0.3, -0.1)), (5.1, (0.5, 0.0))]
    controller = case.make((0.5, 0.0))
    rollout = simulate(controller, 8.0, velocity_changes=changes)
    assert rollout.outcome is Outcome.WALKED
    assert rollout.velocities == ((0.0, (0.5, 0.0)), *changes)
    speed = np.abs(rollout.dcm - rollout.support_foot).max() * ROBOT.omega
    steps = np.abs(np.diff(rollout.dcm_plan, axis=0)).max(axis=1)
    assert steps.max() < 1.5 * speed * controller.period
    for time, velocity in changes:
        under_way = next(s for s in rollout.footsteps if s.start < time < s.start + s.duration)
        later = 1 if case.given_footsteps else 0
        step = rollout.footsteps[under_way.index + later]
        assert step.dcm_offset == pytest.approx(
            nominal_gait(ROBOT, velocity).dcm_offset(step.side), abs=max(case.nearness, 1e-4)
        )


@pytest.mark.parametrize("elapsed", [0.9, 5.0, 250.0, 1e6])
def test_a_step_that_never_ends_gets_finite_commands(case: Case, elapsed: float) -> None:
    """A foot that does not come down, or a robot that just stands: land now, and stay finite."""
    controller = case.make((0.5, 0.0))
    observation = controller.gait.observation(Side.RIGHT)
    command, _ = controller.step(
        controller.start(observation), observation.replace(elapsed=elapsed, time=elapsed)
    )
    for name in command.DTYPE.names or ():
        assert np.isfinite(command.array[name]).all(), name
    if command.mode is Mode.ADAPTING:
        assert Status.NO_TIME_LEFT in command.status
        assert command.step_duration == elapsed


@pytest.mark.parametrize("velocity", [(9.0, 0.0), (math.nan, 0.0)])
def test_a_velocity_that_cannot_be_walked(case: Case, velocity) -> None:
    with pytest.raises(VelocityError):
        case.make(velocity)
    with pytest.raises(VelocityError):
        case.make((0.5, 0.0)).with_velocity(velocity)


def test_a_large_change_of_velocity_keeps_steps_in_their_box(case: Case) -> None:
    rollout = simulate(case.make((1.5, 0.0)), 4.0, velocity_changes=[(0.5, (-1.2, 0.0))])
    for step in rollout.footsteps:
        low, high = ROBOT.gait.step_box(step.side, ROBOT.hip)
        assert (np.array(step.step) >= np.array(low) - 1e-9).all()
        assert (np.array(step.step) <= np.array(high) + 1e-9).all()
