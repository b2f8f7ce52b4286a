"""Whatever a controller is given: what it commands is possible, and no robot falls for it."""

from __future__ import annotations

import importlib.util
import math
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.conformance import closed_loop
from surefoot.control.plausibility import Gate, gate_parameters
from surefoot.control.registry import find_method, methods

ROBOT = sf.load_robot("paper-biped")
LEG = ROBOT.with_leg(max_speed=3.0, max_acceleration=60.0)
FAST = [one.key for one in methods() if not one.slow]
COMPILED = [
    key for key in FAST if find_method(key).controller(ROBOT, (0.3, 0.0)).kernel is not None
]
HELD = sf.Status.HELD


def load_fuzz() -> ModuleType:
    """The benchmark, whose folder is on no path."""
    path = Path(__file__).parents[1] / "benchmarks" / "fuzz.py"
    spec = importlib.util.spec_from_file_location("fuzz", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["fuzz"] = module
    spec.loader.exec_module(module)
    return module


FUZZ = load_fuzz()


class Loop:
    """A closed loop between two cycles."""

    def __init__(
        self, controller: Any, begin: sf.Observation | None = None, pushes: Any = ()
    ) -> None:
        self.controller = controller
        self.simulator = sf.LipmSimulator(controller.robot, controller.period, pushes)
        self.observation = controller.first_observation(None) if begin is None else begin
        self.world = self.simulator.start(self.observation)
        self.state = controller.start(self.observation)
        self.statuses: list[sf.Status] = []

    def run(self, until: float, wrong: Any = None) -> Loop:
        """Walk on; `wrong` makes what is measured of what is true."""
        while self.observation.time < until - 1e-9 and not self.fallen:
            seen = self.observation if wrong is None else wrong(self.observation)
            command, self.state = self.controller.step(self.state, seen)
            for name in command.DTYPE.names or ():
                assert np.isfinite(command.array[name]).all(), name
            self.statuses.append(command.status)
            self.observation, self.world = self.simulator.step(self.world, command)
        return self

    @property
    def fallen(self) -> bool:
        return bool(self.world["fallen"][0])

    @property
    def held(self) -> int:
        """Cycles of the whole walk that were held."""
        return sum(HELD in status for status in self.statuses)


def at(times: tuple[float, ...], wrong: Any) -> Any:
    """Wrong in the cycles that begin at these times, or next."""
    left = list(times)

    def shown(observation: sf.Observation) -> sf.Observation:
        if not left or observation.time < left[0] - 1e-9:
            return observation
        left.pop(0)
        return wrong(observation)

    return shown


@cache
def right_walk(key: str, until: float) -> sf.Observation:
    """What is true at the end of a walk with nothing wrong."""
    return Loop(find_method(key).controller(ROBOT, (0.3, 0.0))).run(until).observation


def moved(name: str, *by: float) -> Any:
    """A field that is beside its place."""
    return lambda seen: seen.replace(**{name: np.add(getattr(seen, name), by)})


def elsewhere(seen: sf.Observation, x: float, y: float) -> sf.Observation:
    """The same robot at another place."""
    for name in ("com", "dcm", "support_foot"):
        seen = moved(name, x, y)(seen)
    return moved("swing_foot", x, y, 0.0)(seen)


WRONG: dict[str, Any] = {
    "lean is NaN": lambda seen: seen.replace(trunk_lean=(math.nan, 0.0)),
    "lean is huge": lambda seen: seen.replace(trunk_lean=(1e300, 0.0)),
    "lean velocity is infinite": lambda seen: seen.replace(trunk_lean_velocity=(0.0, math.inf)),
    "elapsed is negative": lambda seen: seen.replace(elapsed=-200.0),
    "elapsed is 0.2 s too large": lambda seen: seen.replace(elapsed=seen.elapsed + 0.2),
    "elapsed is 100 s too large": lambda seen: seen.replace(elapsed=seen.elapsed + 100.0),
    "elapsed begins anew": lambda seen: seen.replace(elapsed=0.0),
    "time goes back": lambda seen: seen.replace(time=seen.time - 0.5),
    "swing foot is 5 m off": moved("swing_foot", 5.0, 0.0, 0.0),
    "support foot is 1 km off": moved("support_foot", 1000.0, 0.0),
    "support foot is 30 cm off": moved("support_foot", 0.3, 0.0),
    "DCM is 1 m off": moved("dcm", 1.0, 0.0),
    "DCM is 30 cm off": moved("dcm", 0.0, 0.3),
    "all is 1 km off": lambda seen: elsewhere(seen, 1000.0, 0.0),
    "the other foot stands": lambda seen: seen.replace(support_side=-seen.support_side),
    "no foot stands": lambda seen: seen.replace(support_side=2),
}


@pytest.mark.parametrize("key", FAST)
@pytest.mark.parametrize("what", WRONG)
def test_one_wrong_cycle_fells_nobody(key: str, what: str) -> None:
    """It is held, early, in the middle and late in a step; and later nothing of it is left."""
    loop = Loop(find_method(key).controller(ROBOT, (0.3, 0.0)))
    loop.run(4.6, at((1.06, 1.8, 2.495), WRONG[what]))
    assert not loop.fallen
    assert loop.held == 3
    right = right_walk(key, 4.6)
    assert loop.observation.dcm == pytest.approx(right.dcm, abs=0.02)
    assert loop.observation.support_side is right.support_side


@pytest.mark.parametrize("key", FAST)
@pytest.mark.parametrize("what", ["DCM is 1 m off", "elapsed is negative", "lean is NaN"])
def test_two_hundred_wrong_cycles_leave_nothing_behind(key: str, what: str) -> None:
    """Through touchdowns too: the model walks on for what cannot be seen."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))
    begin, end = 1.02, 1.02 + 200 * controller.period
    inner = WRONG[what]

    def wrong(seen: sf.Observation) -> sf.Observation:
        return inner(seen) if begin <= seen.time < end else seen

    loop = Loop(controller).run(end + 3.0, wrong)
    assert not loop.fallen
    assert loop.held >= 199
    assert HELD not in loop.statuses[-1]


@pytest.mark.parametrize("key", COMPILED)
def test_a_clock_is_not_accepted_beside_feet_that_are_not(key: str) -> None:
    """Set back, and yet a step that is older: nothing that happens to a robot does both."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))

    def wrong(seen: sf.Observation) -> sf.Observation:
        if not 1.714 <= seen.time < 1.914:
            return seen
        seen = moved("swing_foot", 0.0, 0.0, 5.0)(seen)
        return seen.replace(time=seen.time - 0.34, elapsed=seen.elapsed + 0.11)

    loop = Loop(controller).run(1.9, wrong)
    assert loop.state["validated"]["observation"]["elapsed"][0] == pytest.approx(
        loop.observation.elapsed - controller.period, abs=1e-9
    )


@pytest.mark.parametrize("key", COMPILED)
def test_a_velocity_that_stands_still_is_not_accepted_beside_a_dcm_that_does_not(key: str) -> None:
    """A blow changes both."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))

    def wrong(seen: sf.Observation) -> sf.Observation:
        if not 1.774 <= seen.time < 1.974:
            return seen
        return seen.replace(com_velocity=(-0.5, seen.com_velocity[1]))

    loop = Loop(controller).run(1.97, wrong)
    accepted = loop.state["validated"]["observation"][0]["com_velocity"]
    assert accepted == pytest.approx(loop.observation.com_velocity, abs=0.05)
    assert not loop.run(5.0).fallen
    assert HELD not in loop.statuses[-1]


@pytest.mark.parametrize("key", FAST)
def test_a_robot_without_sensors_walks_on(key: str) -> None:
    """No number at all for two seconds: nothing pushes, so the prediction is what happens."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))

    def blind(seen: sf.Observation) -> sf.Observation:
        array = seen.array.copy()
        array.view(np.float64)[:] = math.nan
        return sf.Observation.of(array) if 1.02 <= seen.time < 3.02 else seen

    loop, right = Loop(controller).run(5.0, blind), right_walk(key, 5.0)
    assert not loop.fallen
    assert loop.observation.support_foot == pytest.approx(right.support_foot, abs=0.01)
    assert HELD not in loop.statuses[-1]


@pytest.mark.parametrize("key", FAST)
@pytest.mark.parametrize("epoch", [0.9999999e9, 1.8e9])
def test_a_clock_may_count_from_any_epoch(key: str, epoch: float) -> None:
    """Unix time; and a clock that passes 1e9 s is not held."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))
    begin = controller.first_observation(None)
    loop, here = (
        Loop(controller, begin.replace(time=start), [sf.Push(start + 1.1, 0.1, (100.0, 40.0))]).run(
            start + 2.5
        )
        for start in (epoch, 0.0)
    )
    assert loop.held == 0
    assert loop.fallen == here.fallen
    if not here.fallen:
        # A double resolves these times to 0.2 us, and a push of 0.1 s to 2e-6 of it.
        assert loop.observation.dcm == pytest.approx(here.observation.dcm, abs=1e-3)


def test_the_push_observer_does_not_take_the_rounding_of_a_clock_for_a_push() -> None:
    controller = sf.UnifiedController(ROBOT, (0.3, 0.0))
    begin = controller.first_observation(None)

    def largest(epoch: float) -> float:
        walk = closed_loop(
            controller, begin, 900, measured=lambda _, true: true.replace(time=epoch + true.time)
        )
        return max(np.abs(state["observer"]["estimate"]).max() for _, _, state in walk)

    assert largest(1.8e9) < largest(0.0) + 1e-6


def test_a_foot_that_does_not_come_down_has_to_end_the_step() -> None:
    """The clock of the step goes on to any age, and that is accepted."""
    for key in ("hybrid", "step-timing", "unified", "capture-point", "foot-placement-mpc"):
        controller = find_method(key).controller(ROBOT, (0.3, 0.0))
        observation = controller.first_observation(None)
        state, command = controller.start(observation), None
        cycles = round(1.2 / controller.period)
        for cycle in range(cycles):
            time = cycle * controller.period
            command, state = controller.step(state, observation.replace(time=time, elapsed=time))
        assert command is not None
        assert sf.Status.NO_TIME_LEFT in command.status
        assert HELD not in command.status
        assert command.step_duration == pytest.approx((cycles - 1) * controller.period)


LEGITIMATE: dict[str, dict[str, Any]] = {
    "noise": {"disturbance": sf.Disturbance(dcm_noise=0.005, velocity_noise=0.03)},
    "delay": {"disturbance": sf.Disturbance(delay=0.02)},
    "offset": {"disturbance": sf.Disturbance(com_offset=(0.02, -0.02))},
    "landing error": {"disturbance": sf.Disturbance(landing_error=0.03)},
    "early ground": {"disturbance": sf.Disturbance(touchdown_shift=-0.06)},
    "late ground": {"disturbance": sf.Disturbance(touchdown_shift=0.03)},
    "taller plant": {"plant": ROBOT.replace(com_height=0.92)},
    "slow plant": {"plant": ROBOT.with_leg(max_speed=1.5, max_acceleration=40.0)},
    "paper's push, long": {"pushes": [sf.Push(1.1, 0.8, (411.0, 0.0))]},
    "paper's push, short": {"pushes": [sf.Push(1.1, 0.005, (411.0, 0.0))]},
    "a blow": {"pushes": [sf.Push(1.1, 0.005, (20000.0, 0.0))]},
    "a blow aside": {"pushes": [sf.Push(1.25, 0.005, (0.0, 8000.0))]},
}


@pytest.mark.parametrize("key", COMPILED)
@pytest.mark.parametrize("case", LEGITIMATE)
def test_what_can_be_true_is_accepted(key: str, case: str) -> None:
    """No cycle of a walk is held whose sensors work, as long as the robot is up."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))
    walk = sf.simulate(controller, 3.0, **LEGITIMATE[case])
    down = np.hypot(*(walk.dcm - walk.support_foot).T) > 1.0
    up = len(walk.time) if not down.any() else int(np.argmax(down))
    held = (walk.commands["status"][:up] & int(HELD)) != 0
    assert up > 1000
    assert not held.any(), np.flatnonzero(held)[:5]


@pytest.mark.parametrize("length", [0.1, 1.0, 10.0])
def test_the_bounds_grow_with_the_robot(length: float) -> None:
    """Dynamic similarity: lengths by as much, times by the root of it, numbers not at all."""
    time = math.sqrt(length)
    robot = ROBOT.replace(body=None, swing=sf.Swing(max_speed=3.0))
    here = gate_parameters(robot, 0.001).array[0]
    there = gate_parameters(robot.scaled(length=length), 0.001 * time).array[0]
    lengths = ("jump", "reach", "max_dcm_offset", "max_swing")
    times = ("slack", "soonest", "longest", "period")
    for name in lengths:
        assert there[name] == pytest.approx(length * here[name], rel=1e-12), name
    for name in times:
        assert there[name] == pytest.approx(time * here[name], rel=1e-12), name
    assert there["omega"] == pytest.approx(here["omega"] / time)
    assert there["confirm"] == here["confirm"]
    own = {*lengths, *times, "omega", "confirm", "weight", "inertia", "max_lean"}
    assert own == set(Gate.FIELDS)


@pytest.mark.parametrize("key", COMPILED)
@pytest.mark.parametrize("length", [0.1, 10.0])
def test_small_and_large_robots_far_away_are_accepted(key: str, length: float) -> None:
    time = math.sqrt(length)
    robot = ROBOT.replace(body=None, swing=sf.Swing()).scaled(length=length)
    controller = find_method(key).controller(robot, (0.3 * time, 0.0), period=0.001 * time)
    begin = elsewhere(controller.first_observation(None), 1e5 * length, -3e5 * length)
    loop = Loop(controller, begin).run(3.0 * time)
    assert not loop.fallen
    assert loop.held == 0


@pytest.mark.parametrize("key", COMPILED)
def test_another_origin_is_accepted_after_a_few_cycles(key: str) -> None:
    """The whole world is measured elsewhere, and stays there; so is a clock that was set."""
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))
    loop = Loop(controller).run(1.2)
    begun = loop.observation.time
    loop.observation = elsewhere(loop.observation, 0.4, -0.3).replace(time=begun - 1.0)
    loop.world["observation"] = loop.observation.array
    loop.world["step_start"] -= 1.0
    before = loop.held
    loop.run(begun)
    assert 1 <= loop.held - before <= 3
    assert HELD not in loop.statuses[-1]


PROGRAMS = ["linear-mpc", "foot-placement-mpc", "ankle-hip-step-mpc", "timing-nlp"]


@pytest.mark.parametrize("key", PROGRAMS)
@pytest.mark.parametrize("yaw", [0.4, -1.2, math.pi / 2])
def test_the_zmp_stays_in_a_sole_that_is_rotated(key: str, yaw: float) -> None:
    controller = find_method(key).controller(ROBOT, (0.3, 0.0))
    half = np.array(ROBOT.foot.half)
    turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    outside = 0
    for error in ((0.05, 0.03), (-0.06, 0.02), (0.08, -0.06), (0.0, 0.07)):
        observation = controller.first_observation(None)
        observation = observation.replace(support_yaw=yaw, dcm=np.add(observation.dcm, error))
        command, _ = controller.step(controller.start(observation), observation)
        inside = turn @ (command.zmp - observation.support_foot)
        assert (np.abs(inside) <= half + 1e-9).all()
        outside += bool((np.abs(inside) >= half - 1e-6).any())
    assert outside > 0  # else nothing was asked of the sole


WEIGHTS = [
    (sf.HybridController, {"tau_weight": 1e300}, "`tau_weight` 1e\\+300 beside"),
    (sf.HybridController, {"step_weight": (1.0, 1e300)}, "`step_weight` 1e\\+300 beside"),
    (sf.StepTiming, {"offset_weight": (1e300, 1e5)}, "weights within a factor 1e\\+12"),
    (sf.UnifiedController, {"offset_weight": (1e300, 1e300)}, "bring them together"),
    (sf.LinearMpc, {"zmp_weight": 1e300}, "`zmp_weight` 1e\\+300 beside"),
    (sf.FootPlacementMpc, {"step_weight": 1e300}, "`step_weight` 1e\\+300"),
    (sf.AnkleHipStepMpc, {"lean_weight": 1e300}, "`lean_weight` 1e\\+300"),
    (sf.TimingNlp, {"path_weight": (1e300, 1.0)}, "`path_weight` 1e\\+300"),
    (sf.PreviewControl, {"error_weight": 1e300}, "`error_weight` 1e\\+300"),
]


@pytest.mark.parametrize(("kind", "arguments", "message"), WEIGHTS)
def test_weights_of_which_only_one_counts_are_refused(kind, arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        kind(ROBOT, (0.3, 0.0), **arguments)


@pytest.mark.parametrize("key", [one.key for one in methods()])
def test_a_period_with_which_no_step_can_be_controlled_is_refused(key: str) -> None:
    with pytest.raises(sf.ParameterError, match=r"`period` of at most 0.05 \[s\]: a step lasts"):
        find_method(key).controller(ROBOT, (0.3, 0.0), period=5.0)


def test_a_gain_that_overshoots_in_one_period_is_refused() -> None:
    with pytest.raises(sf.ParameterError, match=r"`dcm_gain` of at most 1000 \[1/s\]"):
        sf.DcmTracking(ROBOT, (0.3, 0.0), dcm_gain=1e6)


@pytest.mark.parametrize("key", [*PROGRAMS[1:], "unified"])
def test_a_leg_that_is_late_in_every_step_is_refused_where_it_is_known(key: str) -> None:
    crawling = ROBOT.with_leg(max_speed=0.001)
    with pytest.raises(sf.SurefootError, match="leg"):
        find_method(key).controller(crawling, (0.3, 0.0))


@pytest.mark.parametrize("name", [*COMPILED, "unified, leg", "hybrid, leg", "footholds"])
def test_garbage_leads_to_nothing_that_must_not_be(name: str) -> None:
    """A few thousand observations and some walks; benchmarks/fuzz.py does a million."""
    (subject,) = FUZZ.subjects([name])
    counts = FUZZ.fuzz(subject, 3000, 14, seed=7)
    assert counts.observations >= 3000
    assert counts.total == 0, counts.examples


@pytest.mark.parametrize("name", ["foot-placement-mpc", "linear-mpc", "timing-nlp"])
def test_garbage_leads_to_nothing_of_the_kind_in_slow_methods(name: str) -> None:
    (subject,) = FUZZ.subjects([name])
    counts = FUZZ.fuzz(subject, 280, 0, seed=7)
    assert counts.total == 0, counts.examples
