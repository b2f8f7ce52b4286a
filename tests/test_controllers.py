"""Every method passes the conformance suite of the package; and what only some of them do."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.conformance import *  # noqa: F403 - the tests are run here
from surefoot.conformance import ROBOT, Case, cases, closed_loop
from surefoot.control.fields import declared
from surefoot.control.registry import find_method, methods

LEG = ROBOT.with_leg(max_speed=3.0)
PREVIEW = find_method("preview-control")

CASES = [
    *(Case.of(one, LEG if one.slow else ROBOT) for one in methods()),
    Case("tracking-unprojected", lambda v: sf.DcmTracking(ROBOT, v, project_zmp=False)),
    Case("hybrid-always-adapting", lambda v: sf.HybridController(ROBOT, v, threshold=0.0)),
    Case("hybrid-slow-leg", lambda v: sf.HybridController(LEG, v)),
    Case("capture-point-no-ankle", lambda v: sf.CapturePointStepping(ROBOT, v, ankle=False)),
    Case(
        "preview-published", lambda v: sf.PreviewControl(ROBOT, v, period=0.005),
        0.01, 0.01, PREVIEW.given_footsteps,
    ),
    Case("foot-placement-mpc-20-cycles", lambda v: sf.FootPlacementMpc(ROBOT, v, solve_period=0.1)),
    Case("unified-no-ankle", lambda v: sf.UnifiedController(ROBOT, v, ankle=False)),
    Case("unified-slow-leg", lambda v: sf.UnifiedController(LEG, v)),
]  # fmt: skip


@pytest.fixture(params=CASES, ids=lambda case: case.name)
def case(request: pytest.FixtureRequest) -> Case:
    return request.param


def test_the_suite_of_the_package_has_every_method(monkeypatch: pytest.MonkeyPatch) -> None:
    assert [one.name for one in cases()] == [one.key for one in methods()]
    monkeypatch.setenv("SUREFOOT_METHODS", "hybrid,surefoot.control.tracking:DcmTracking")
    assert [one.name for one in cases()] == ["hybrid", "tracking"]


LIMITED = {
    **{one.key: (one, {}) for one in methods()},
    "capture-point-no-ankle": (find_method("capture-point"), {"ankle": False}),
}


@pytest.mark.parametrize("name", LIMITED)
def test_no_push_takes_it_out_of_its_limits(name: str) -> None:
    """The ZMP stays in the sole and steps in their box; what is not adapted stays as planned."""
    one, arguments = LIMITED[name]
    controller = one.controller(LEG if one.slow else ROBOT, (0.5, 0.0), **arguments)
    moves_zmp = "ZMP" in one.adapts and arguments.get("ankle", True)
    half = np.array(ROBOT.foot.half) if moves_zmp else np.zeros(2)
    shortest, longest = ROBOT.gait.step_duration
    count = 60 if controller.kernel is not None else 2 if one.slow else 8
    for force in np.random.default_rng(11).uniform((-800.0, -400.0), (800.0, 400.0), (count, 2)):
        share = np.random.default_rng(abs(int(force[0]))).uniform(0.0, 1.0)
        push = sf.Push(1.1, 0.2, (share * float(force[0]), share * float(force[1])))
        rollout = sf.simulate(controller, 2.6, [push])
        assert (np.abs(rollout.zmp - rollout.support_foot) <= half + 1e-9).all(), push
        for step in rollout.footsteps:
            low, high = ROBOT.gait.step_box(step.side, ROBOT.hip)
            assert (np.array(step.step) >= np.array(low) - 1e-9).all(), push
            assert (np.array(step.step) <= np.array(high) + 1e-9).all(), push
            assert shortest - 1e-9 <= step.duration <= longest + 1e-9, push
            if "timing" not in one.adapts:
                assert step.duration == pytest.approx(controller.gait.step_duration, abs=1e-9)
            if one.fixed_steps:
                planned = controller.gait.step(step.side)
                assert step.step == pytest.approx(planned, abs=max(one.nearness, 1e-9)), push


@pytest.mark.parametrize("gain", [2.0, 5.0])
def test_tracking_removes_an_error_at_its_rate(gain: float) -> None:
    """K_f is the rate at which the error decays, Eq. (21): fitted over half a step."""
    controller = sf.DcmTracking(ROBOT, (0.3, 0.0), dcm_gain=gain)
    begin = controller.gait.observation(sf.Side.RIGHT)
    off = begin.replace(
        dcm=np.add(begin.dcm, (0.01, -0.008)),
        com_velocity=np.add(begin.com_velocity, np.multiply((0.01, -0.008), ROBOT.omega)),
    )
    walk = list(closed_loop(controller, off, 250))
    errors = [np.hypot(*(o.dcm - c.dcm_plan)) for o, c, _ in walk]
    times = [o.elapsed for o, _, _ in walk]
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


CLASSES = sorted({one.make for one in methods()}, key=lambda make: make.__name__)


@pytest.mark.parametrize("make", CLASSES, ids=lambda make: make.__name__)
def test_every_setting_refuses_what_makes_no_sense(make) -> None:
    """What a field declares is what its class enforces; the class checks what declares no least."""
    for name, known in declared(make).items():
        if known.least is None:
            continue
        assert known.least == 0.0, name
        above, endless = known.excluded, known.endless
        bound = f"`{name}` {'above' if above else 'of at least'} 0 [{known.unit}]"
        bound += "" if endless else " and finite"
        wrong: list[Any] = [-0.001, math.nan, -math.inf, "1"]
        wrong += ([0.0] if above else []) + ([] if endless else [math.inf])
        tried: list[tuple[Any, str]] = [(value, f"{bound}; got {value!r}") for value in wrong]
        if isinstance(make.__dataclass_fields__[name].default, tuple):
            tried = [(pair, text) for value, text in tried for pair in ((value, 1.0), (1.0, value))]
            pair = f"`{name}` as a pair (x, y) [{known.unit}]; got"
            tried += [(value, f"{pair} {value!r}") for value in (1.0, (1.0,))]
        for value, text in tried:
            with pytest.raises(sf.ParameterError, match=re.escape(text)):
                make(ROBOT, (0.5, 0.0), **{name: value})


def test_what_may_not_be_0() -> None:
    """A weight or gain of 0 leaves these without an answer, or divides by it."""
    known = {
        "HybridController": {"period", "dcm_gain"}, "LinearMpc": {"period", "zmp_weight"},
        "FootPlacementMpc": {"period", "sample", "zmp_weight", "step_weight"},
        "UnifiedController": {"period", "dcm_gain", "tau_weight"},
        "PreviewControl": {"error_weight", "input_weight"}, "TimingNlp": {"offset_penalty"},
    }  # fmt: skip
    for make in CLASSES:
        above = {name for name, it in declared(make).items() if it.excluded}
        assert known.get(make.__name__, set()) <= above, make.__name__


@pytest.mark.parametrize("make", CLASSES, ids=lambda make: make.__name__)
def test_a_robot_is_no_name_of_one(make) -> None:
    with pytest.raises(
        sf.ParameterError,
        match=r"a Robot; got 'paper-biped'; load one: surefoot.load_robot",
    ):
        make("paper-biped", (0.5, 0.0))
