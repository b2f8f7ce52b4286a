"""The conformance suite: what every controller must do, whatever its method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.control.cycle import is_usable

ROBOT = sf.load_robot("paper-biped")
Make = Callable[[tuple[float, float]], sf.Controller]

CONTROLLERS: dict[str, Make] = {
    "tracking": lambda velocity: sf.DcmTracking(ROBOT, velocity),
    "tracking-unprojected": lambda velocity: sf.DcmTracking(ROBOT, velocity, project_zmp=False),
    "hybrid": lambda velocity: sf.HybridController(ROBOT, velocity),
    "hybrid-always-adapting": lambda velocity: sf.HybridController(ROBOT, velocity, threshold=0.0),
    "hybrid-slow-leg": lambda velocity: sf.HybridController(
        ROBOT.replace(swing=type(ROBOT.swing)(max_speed=3.0)), velocity
    ),
    "capture-point": lambda velocity: sf.CapturePointStepping(ROBOT, velocity),
    "capture-point-no-ankle": lambda velocity: sf.CapturePointStepping(
        ROBOT, velocity, ankle=False
    ),
    "step-timing": lambda velocity: sf.StepTiming(ROBOT, velocity),
    "preview": lambda velocity: sf.PreviewControl(ROBOT, velocity),
    "preview-published": lambda velocity: sf.PreviewControl(ROBOT, velocity, period=0.005),
    "timing-nlp": lambda velocity: sf.TimingNlp(
        ROBOT.replace(swing=type(ROBOT.swing)(max_speed=3.0)), velocity
    ),
    "linear-mpc": lambda velocity: sf.LinearMpc(ROBOT, velocity),
    "foot-placement-mpc": lambda velocity: sf.FootPlacementMpc(ROBOT, velocity),
    "foot-placement-mpc-published": lambda velocity: sf.FootPlacementMpc(
        ROBOT, velocity, solve_period=0.1
    ),
    "ankle-hip-step-mpc": lambda velocity: sf.AnkleHipStepMpc(ROBOT, velocity),
    "unified": lambda velocity: sf.UnifiedController(ROBOT, velocity),
    "unified-no-ankle": lambda velocity: sf.UnifiedController(ROBOT, velocity, ankle=False),
    "unified-slow-leg": lambda velocity: sf.UnifiedController(
        ROBOT.replace(swing=type(ROBOT.swing)(max_speed=3.0)), velocity
    ),
}
NEARNESS = {"preview": 0.005, "preview-published": 0.01}
"""How near to the nominal gait a method walks undisturbed, where that is not exact [m]: it follows
a reference smoothly, and its DCM plan is the periodic gait that comes of it."""

OWN_PLAN = 1e-6
"""Such a method keeps to its own plan as well as this [m]."""

ZMP_TRACE = {"preview": 0.002, "preview-published": 0.01}
"""How much of a lost cycle may be left in the ZMP of the next one, where the ZMP moves on from
where it was [m]: what did not move for a period lags by it."""

GIVEN_FOOTSTEPS = {"preview", "preview-published"}
"""Methods whose footsteps are given, the one under way too. A new velocity begins with the step
after it, so that the offset is that of the new gait only when a preview has passed."""
PUSH = sf.Push(1.1, 0.2, (60.0, 30.0))
VELOCITIES = [(0.5, 0.0), (-0.3, 0.0), (0.0, 0.0), (0.0, 0.2), (0.3, -0.15)]


@pytest.fixture(params=CONTROLLERS)
def method(request) -> str:
    return request.param


@pytest.fixture
def make(method: str) -> Make:
    return CONTROLLERS[method]


def cycles(controller: sf.Controller, seconds: float) -> int:
    """How many control periods these seconds are."""
    return round(seconds / controller.period)


def mirrored(rollout: sf.Rollout, name: str) -> np.ndarray:
    """A time-first array of vectors as seen in the mirror y -> -y."""
    values = np.array(getattr(rollout, name))
    values[:, 1] *= -1.0
    return values


def test_it_is_a_controller(make: Make) -> None:
    controller = make((0.5, 0.0))
    assert isinstance(controller, sf.Controller)
    with pytest.raises(FrozenInstanceError):
        controller.period = 0.002  # type: ignore[misc]


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_undisturbed_it_walks_the_nominal_gait(method: str, make: Make, velocity) -> None:
    rollout = sf.simulate(make(velocity), 4.0)
    assert rollout.outcome is sf.Outcome.WALKED
    gait, near = sf.nominal_gait(ROBOT, velocity), NEARNESS.get(method, 1e-9)
    own = OWN_PLAN if method in NEARNESS else 1e-9
    for step in rollout.footsteps:
        assert step.duration == pytest.approx(gait.step_duration, abs=1e-9)
        assert step.step == pytest.approx(gait.step(step.side), abs=near)
        assert step.dcm_offset == pytest.approx(gait.dcm_offset(step.side), abs=near)
    assert rollout.final_velocity == pytest.approx(velocity, abs=own)
    assert np.abs(rollout.dcm_error).max() < own


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_the_mirror_image_of_a_walk_is_the_walk_of_the_mirror_image(make: Make, velocity) -> None:
    v_x, v_y = velocity
    force_x, force_y = PUSH.force
    here = sf.simulate(make(velocity), 3.0, [PUSH], first_support=sf.Side.RIGHT)
    there = sf.simulate(
        make((v_x, -v_y)),
        3.0,
        [replace(PUSH, force=(force_x, -force_y))],
        first_support=sf.Side.LEFT,
    )
    assert here.time == pytest.approx(there.time, abs=1e-9)
    for name in ("com", "dcm", "zmp", "dcm_plan", "support_foot", "swing_foot"):
        assert mirrored(here, name) == pytest.approx(getattr(there, name), abs=1e-9), name
    assert here.support_side.tolist() == (-there.support_side).tolist()


def shifted(observation: sf.Observation, shift: tuple[float, float], time: float) -> sf.Observation:
    moved = {
        name: getattr(observation, name) + np.array(shift)
        for name in ("com", "dcm", "support_foot")
    }
    foot = observation.swing_foot + np.array([*shift, 0.0])
    return observation.replace(time=observation.time + time, swing_foot=foot, **moved)


def closed_loop(controller, observation, pushes, cycles: int):
    """Observations and commands of a loop of one's own, as a user would write it."""
    simulator = sf.LipmSimulator(controller.robot, controller.period, pushes)
    world, state = simulator.start(observation), controller.start(observation)
    seen = []
    for _ in range(cycles):
        command, state = controller.step(state, observation)
        seen.append((observation, command))
        observation, world = simulator.step(world, command)
    return seen


@pytest.mark.parametrize(("shift", "time"), [((0.7, -0.4), 0.0), ((0.0, 0.0), 12.5)])
def test_a_walk_elsewhere_or_later_is_the_same_walk(make: Make, shift, time) -> None:
    controller = make((0.3, 0.1))
    begin = controller.gait.observation(sf.Side.LEFT)
    here = closed_loop(controller, begin, [PUSH], cycles(controller, 1.8))
    later = replace(PUSH, start=PUSH.start + time)
    there = closed_loop(controller, shifted(begin, shift, time), [later], len(here))
    for (seen, command), (seen_there, command_there) in zip(here, there, strict=True):
        assert seen_there.time - time == pytest.approx(seen.time, abs=1e-9)
        assert seen_there.dcm - shift == pytest.approx(seen.dcm, abs=1e-9)
        assert command_there.zmp - shift == pytest.approx(command.zmp, abs=1e-9)
        assert command_there.step_location - shift == pytest.approx(command.step_location, abs=1e-9)
        assert command_there.step_duration == pytest.approx(command.step_duration, abs=1e-9)
        assert command_there.swing_foot - (*shift, 0.0) == pytest.approx(
            command.swing_foot, abs=1e-9
        )


def test_the_same_walk_twice_has_the_same_bits(make: Make) -> None:
    first, second = (sf.simulate(make((0.5, 0.0)), 3.0, [PUSH]) for _ in range(2))
    assert first.observations.tobytes() == second.observations.tobytes()
    assert first.commands.tobytes() == second.commands.tobytes()


def test_nothing_that_goes_in_is_changed(make: Make) -> None:
    controller = make((0.5, 0.0))
    observation = controller.gait.observation(sf.Side.RIGHT)
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
def test_a_broken_observation_holds_the_last_command_and_says_so(
    method: str, make: Make, name, value
) -> None:
    controller = make((0.5, 0.0))
    lost = cycles(controller, 0.1)
    seen = closed_loop(controller, controller.first_observation(None), [], lost + 2)
    state = controller.start(seen[0][0])
    for observation, _ in seen[:lost]:
        safe, state = controller.step(state, observation)
    broken = seen[lost][0].replace(**{name: value})
    held, next_state = controller.step(state, broken)
    assert sf.Status(held.status) == sf.Status.HELD
    assert held.replace(status=safe.status) == safe
    # One bad cycle leaves no trace in the next good one, but for the swing foot's lost period.
    command, _ = controller.step(next_state, seen[lost + 1][0])
    _, without = controller.step(state, seen[lost][0])
    clean, _ = controller.step(without, seen[lost + 1][0])
    for field in ("dcm_plan", "step_location", "step_duration", "dcm_offset", "status"):
        assert command.array[field] == pytest.approx(clean.array[field], abs=1e-12), field
    assert command.zmp == pytest.approx(clean.zmp, abs=ZMP_TRACE.get(method, 1e-12))
    assert command.swing_foot == pytest.approx(clean.swing_foot, abs=controller.period)
    assert not is_usable(broken.array[0])


def test_a_touchdown_in_a_dropout_does_not_leave_the_zmp_behind(make: Make) -> None:
    """The DCM is lost while the foot lands: the ZMP goes under the foot that stands now."""
    controller = make((0.5, 0.0))
    begin = controller.first_observation(None)
    seen = closed_loop(controller, begin, [], cycles(controller, 0.55))
    touchdown = next(k for k, (o, _) in enumerate(seen) if o.support_side is sf.Side.LEFT)
    state = controller.start(begin)
    for observation, _ in seen[: touchdown - 5]:
        _, state = controller.step(state, observation)
    for observation, _ in seen[touchdown - 5 : touchdown + 5]:
        held, state = controller.step(state, observation.replace(dcm=(math.nan, 0.0)))
        assert held.status == sf.Status.HELD
        under_the_foot = np.array(ROBOT.foot.half) + 1e-9
        assert (np.abs(held.zmp - observation.support_foot) <= under_the_foot).all()
    after, _ = controller.step(state, seen[touchdown + 5][0])
    assert after.step_location == pytest.approx(seen[touchdown + 5][1].step_location, abs=1e-9)


@pytest.mark.parametrize("elapsed", [-1e-9, -0.1, -1.0])
def test_a_clock_that_is_a_little_early_raises_nothing(make: Make, elapsed: float) -> None:
    controller = make((0.5, 0.0))
    observation = controller.gait.observation(sf.Side.RIGHT)
    command, _ = controller.step(
        controller.start(observation), observation.replace(elapsed=elapsed)
    )
    assert np.isfinite(command.zmp).all()
    assert np.isfinite(command.step_location).all()


def test_a_walk_with_dropouts_goes_on(make: Make) -> None:
    """Every tenth observation is lost: the robot still walks."""
    controller = make((0.5, 0.0))
    simulator = sf.LipmSimulator(controller.robot, controller.period)
    observation = controller.gait.observation(sf.Side.RIGHT)
    world, state = simulator.start(observation), controller.start(observation)
    for cycle in range(cycles(controller, 4.0)):
        lost = cycle % 10 == 9
        seen = observation.replace(dcm=(math.nan, math.nan)) if lost else observation
        command, state = controller.step(state, seen)
        assert (sf.Status.HELD in sf.Status(command.status)) == lost
        observation, world = simulator.step(world, command)
    assert not world["fallen"][0]
    assert np.hypot(*(observation.dcm - observation.support_foot)) < 0.5


def test_it_does_not_start_on_a_broken_observation(make: Make) -> None:
    controller = make((0.5, 0.0))
    observation = controller.gait.observation(sf.Side.RIGHT)
    with pytest.raises(sf.ParameterError, match="first observation of finite numbers"):
        controller.start(observation.replace(dcm=(math.nan, 0.0)))
    with pytest.raises(sf.ParameterError, match="and a Side"):
        controller.start(observation.replace(support_side=0))


def test_a_new_velocity_does_not_make_the_plan_jump(method: str, make: Make) -> None:
    """The step under way ends with the new offset; the planned DCM is continuous through it all."""
    changes = [(0.73, (0.2, 0.1)), (2.2, (0.0, 0.0)), (3.9, (-0.3, -0.1)), (5.1, (0.5, 0.0))]
    controller = make((0.5, 0.0))
    rollout = sf.simulate(controller, 8.0, velocity_changes=changes)
    assert rollout.outcome is sf.Outcome.WALKED
    assert rollout.velocities == ((0.0, (0.5, 0.0)), *changes)
    speed = np.abs(rollout.dcm - rollout.support_foot).max() * ROBOT.omega
    steps = np.abs(np.diff(rollout.dcm_plan, axis=0)).max(axis=1)
    assert steps.max() < 1.5 * speed * controller.period
    for time, velocity in changes:
        under_way = next(s for s in rollout.footsteps if s.start < time < s.start + s.duration)
        later = 1 if method in GIVEN_FOOTSTEPS else 0
        step = rollout.footsteps[under_way.index + later]
        assert step.dcm_offset == pytest.approx(
            sf.nominal_gait(ROBOT, velocity).dcm_offset(step.side), abs=NEARNESS.get(method, 1e-4)
        )


@pytest.mark.parametrize("elapsed", [0.9, 5.0, 250.0, 1e6])
def test_a_step_that_never_ends_gets_finite_commands(make: Make, elapsed: float) -> None:
    """A foot that does not come down, or a robot that just stands: land now, and stay finite."""
    controller = make((0.5, 0.0))
    observation = controller.gait.observation(sf.Side.RIGHT)
    command, _ = controller.step(
        controller.start(observation), observation.replace(elapsed=elapsed, time=elapsed)
    )
    for name in command.DTYPE.names or ():
        assert np.isfinite(command.array[name]).all(), name
    if command.mode is sf.Mode.ADAPTING:
        assert sf.Status.NO_TIME_LEFT in command.status
        assert command.step_duration == elapsed


@pytest.mark.parametrize("velocity", [(9.0, 0.0), (math.nan, 0.0)])
def test_a_velocity_that_cannot_be_walked(make: Make, velocity) -> None:
    with pytest.raises(sf.VelocityError):
        make(velocity)
    with pytest.raises(sf.VelocityError):
        make((0.5, 0.0)).with_velocity(velocity)


@pytest.mark.parametrize("gain", [2.0, 5.0])
def test_tracking_removes_an_error_at_its_rate(gain: float) -> None:
    """K_f is the rate at which the error decays, Eq. (21): fitted over half a step."""
    controller = sf.DcmTracking(ROBOT, (0.3, 0.0), dcm_gain=gain)
    begin = controller.gait.observation(sf.Side.RIGHT)
    off = begin.replace(
        dcm=np.add(begin.dcm, (0.01, -0.008)),
        com_velocity=np.add(begin.com_velocity, np.multiply((0.01, -0.008), ROBOT.omega)),
    )
    seen = closed_loop(controller, off, [], 250)
    errors = [np.hypot(*(o.dcm - c.dcm_plan)) for o, c in seen]
    times = [o.elapsed for o, _ in seen]
    rate = -np.polyfit(times, np.log(errors), 1)[0]
    # The ZMP is held for a millisecond, which makes the loop a little slower than its law.
    assert rate == pytest.approx(gain, rel=0.01)


def test_a_step_once_given_up_is_not_taken_back() -> None:
    """Hysteresis: a decision persists until a touchdown, even if the error shrinks before."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    pushes = [sf.Push(1.05, 0.05, (250.0, 0.0)), sf.Push(1.1, 0.09, (-170.0, 0.0))]
    rollout = sf.simulate(controller, 3.0, pushes)
    error = np.hypot(*rollout.dcm_error.T)
    third = (rollout.time >= 1.0) & (rollout.time < 1.05 + 0.3)
    given_up = np.flatnonzero(third & rollout.adapting)[0]
    landing = rollout.footsteps[2].start + rollout.footsteps[2].duration
    rest = (np.arange(len(error)) >= given_up) & (rollout.time < landing - 1e-9)
    assert (error[rest] < controller.threshold).any()
    assert rollout.adapting[rest].all()


def test_a_large_change_of_velocity_keeps_steps_in_their_box(make: Make) -> None:
    rollout = sf.simulate(make((1.5, 0.0)), 4.0, velocity_changes=[(0.5, (-1.2, 0.0))])
    for step in rollout.footsteps:
        low, high = ROBOT.gait.step_box(step.side, ROBOT.hip)
        assert (np.array(step.step) >= np.array(low) - 1e-9).all()
        assert (np.array(step.step) <= np.array(high) + 1e-9).all()


@pytest.mark.parametrize("kind", [sf.DcmTracking, sf.HybridController, sf.TimingNlp])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"dcm_gain": 0.0}, r"`dcm_gain` above 0 \[1/s\] and finite; got 0.0"),
        ({"dcm_gain": math.nan}, "`dcm_gain` above 0"),
        ({"dcm_gain": math.inf}, "`dcm_gain` above 0"),
        ({"period": math.inf}, "`period` above 0"),
        ({"period": -0.001}, r"`period` above 0 \[s\]"),
        ({"robot": "paper-biped"}, r"a Robot; got 'paper-biped'; load one: surefoot.load_robot"),
    ],
)
def test_parameters_that_make_no_sense(kind, arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        kind(**({"robot": ROBOT, "velocity": (0.5, 0.0)} | arguments))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"threshold": -0.01}, r"`threshold` of at least 0 \[m\]"),
        ({"step_weight": 1.0}, r"`step_weight` as a pair \(x, y\)"),
        ({"offset_weight": (1000.0, -1.0)}, "`offset_weight` of at least 0"),
        ({"tau_weight": "1"}, "`tau_weight` of at least 0"),
        ({"offset_penalty": math.nan}, "`offset_penalty` of at least 0"),
    ],
)
def test_parameters_of_the_hybrid_that_make_no_sense(arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.HybridController(ROBOT, (0.5, 0.0), **arguments)
