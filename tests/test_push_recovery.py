"""Golden numbers of the step-and-timing adaptation, and the protocol that finds them.

Reference: v = (0.5, 0) m/s, 0.2 s from 1.1 s, 70 kg, hip 0.2 m, unlimited leg, no ZMP motion,
weights (1, 1, 1, 1000, 1000). All limits were found by independent prototypes.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import surefoot as sf
from surefoot.robot.robot import Swing

DIRECTIONS = {
    "forward": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "towards the swing foot": (0.0, 1.0),
    "away from it": (0.0, -1.0),
}


def always_adapting(robot: sf.Robot) -> sf.HybridController:
    return sf.HybridController(robot, (0.5, 0.0), threshold=0.0, offset_weight=(1000.0, 1000.0))


Row = tuple[Callable[[sf.Robot], sf.Controller], tuple[float, ...], float, tuple[float, float]]

REFERENCES: dict[str, Row] = {
    "tracking": (lambda robot: sf.DcmTracking(robot, (0.5, 0.0)), (28.0, 28.0, 15.0, 15.0), 60.0,
        (-2.0, 2.0)),
    "preview": (
        lambda robot: sf.PreviewControl(robot, (0.5, 0.0)), (33.0, 32.0, 18.0, 18.0), 60.0,
        (0.0, 3.0),
    ),
    "capture point, point foot": (
        lambda robot: sf.CapturePointStepping(robot, (0.5, 0.0), ankle=False),
        (25.0, 76.0, 28.0, 21.0), 150.0, (-2.0, 2.0),
    ),
    "step and timing": (always_adapting, (213.0, 263.0, 131.0, 93.0), 1000.0, (-2.0, 2.0)),
    "step timing": (
        lambda robot: sf.StepTiming(robot, (0.5, 0.0)), (213.0, 264.0, 131.0, 93.0), 1000.0,
        (-9.0, 9.0),
    ),
}  # fmt: skip
"""Controller, limits of a prototype forward, back, towards the swing foot and away from it, the end
of the scan, and how much less or more this one may survive [N s]. From the nominal gait, and with
fixed steps, no ZMP survives 34 / 34 / 19 / 19."""


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("name", REFERENCES)
def test_the_limits_are_those_of_prototypes(
    robot_70kg: sf.Robot, name: str, direction: str
) -> None:
    make, references, largest, (less, more) = REFERENCES[name]
    reference = references[list(DIRECTIONS).index(direction)]
    limit = sf.smallest_failing_push(make(robot_70kg), DIRECTIONS[direction], largest=largest)
    assert less <= limit.impulse - reference <= more
    assert limit.delta_v == pytest.approx(limit.impulse / 70.0)
    assert limit.fell


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_sole_adds_what_it_holds_alone(robot_70kg: sf.Robot, direction: str) -> None:
    """15 N s across and 28 along, by which tracking survives such a push."""
    point, sole = (
        sf.smallest_failing_push(
            sf.CapturePointStepping(robot_70kg, (0.5, 0.0), ankle=ankle),
            DIRECTIONS[direction],
            largest=150.0,
        ).impulse
        for ankle in (False, True)
    )
    assert sole >= point + 15.0


def test_the_limits_scale_with_the_mass(robot: sf.Robot) -> None:
    """Delta v is the robot-independent figure: the mass cancels."""
    light, heavy = (
        sf.smallest_failing_push(
            sf.HybridController(robot.replace(mass=mass), (0.5, 0.0)),
            (0.0, -1.0),
            step=mass / 70.0,
        )
        for mass in (35.0, 140.0)
    )
    assert light.delta_v == pytest.approx(heavy.delta_v)


def test_left_is_right_in_the_mirror(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    here = sf.smallest_failing_push(controller, (0.0, 1.0), first_support=sf.Side.RIGHT)
    there = sf.smallest_failing_push(controller, (0.0, -1.0), first_support=sf.Side.LEFT)
    assert here.impulse == there.impulse


def test_the_limit_is_the_first_failure_not_any(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    limit = sf.smallest_failing_push(controller, (0.0, -1.0), step=5.0)
    for impulse in range(5, int(limit.impulse) + 1, 5):
        push = sf.Push(1.1, 0.2, (0.0, -impulse / 0.2))
        outcome = sf.simulate(controller, 9.3, [push]).outcome
        assert (outcome is sf.Outcome.RECOVERED) == (impulse < limit.impulse)


def test_a_gait_that_does_not_settle_unpushed_is_told_as_zero(robot: sf.Robot) -> None:
    # 0.44 m in 0.4 s are 2.1 m/s at their peak: this leg never gets there.
    crawling = robot.replace(swing=Swing(max_speed=0.3))
    limit = sf.smallest_failing_push(sf.HybridController(crawling, (0.5, 0.0)), (1.0, 0.0))
    assert limit.impulse == 0.0
    tiny = sf.smallest_failing_push(sf.DcmTracking(robot, (0.5, 0.0)), (1.0, 0.0), largest=0.5)
    assert tiny.impulse == math.inf


def test_a_scan_that_finds_no_failure_says_so(robot: sf.Robot) -> None:
    limit = sf.smallest_failing_push(sf.HybridController(robot, (0.5, 0.0)), (1.0, 0.0), largest=20)
    assert limit.impulse == math.inf
    assert limit.scanned == 20.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"direction": (0.0, 0.0)}, r"a direction \(x, y\) of some length"),
        ({"direction": (1.0, 0.0, 0.0)}, r"`direction` as a pair"),
        ({"direction": (math.nan, 0.0)}, "`direction`"),
        ({"direction": (1.0, 0.0), "step": 0.0}, r"`step` above 0 \[N s\]"),
        ({"direction": (1.0, 0.0), "duration": -1.0}, r"`duration` above 0 \[s\]"),
    ],
)
def test_a_scan_that_makes_no_sense(robot: sf.Robot, arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.smallest_failing_push(sf.HybridController(robot, (0.5, 0.0)), **arguments)
