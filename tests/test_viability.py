from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf

ROBOT = sf.load_robot("paper-biped")


def test_the_bounds_of_table_2() -> None:
    wide = sf.viable_offsets(ROBOT, sf.Side.RIGHT)
    assert wide.upper == pytest.approx((0.4929, 0.1635), abs=5e-5)
    assert wide.lower == pytest.approx((-0.4929, -0.3294), abs=5e-5)
    narrow = sf.viable_offsets(ROBOT.replace(hip=0.1), sf.Side.LEFT)
    assert (narrow.lower[1], narrow.upper[1]) == pytest.approx((-0.1967, 0.2962), abs=5e-5)


def test_left_mirrors_right() -> None:
    right, left = (sf.viable_offsets(ROBOT, side) for side in sf.Side)
    assert left.lower[1] == -right.upper[1]
    assert left.upper[1] == -right.lower[1]
    assert (left.lower[0], left.upper[0]) == (right.lower[0], right.upper[0])


def test_a_finite_foot_widens_both_ends() -> None:
    point = sf.viable_offsets(ROBOT, sf.Side.LEFT)
    finite = sf.viable_offsets(ROBOT, sf.Side.LEFT, ROBOT.foot.half)
    assert np.subtract(finite.upper, point.upper) == pytest.approx(ROBOT.foot.half)
    assert np.subtract(point.lower, finite.lower) == pytest.approx(ROBOT.foot.half)


def test_margin_counts_inside_and_outside() -> None:
    viable = sf.ViableOffsets((-1.0, -2.0), (1.0, 2.0))
    assert viable.margin((0.0, 0.0)) == 1.0
    assert viable.margin((0.9, 1.95)) == pytest.approx(0.05)
    assert viable.margin((0.0, 2.5)) == pytest.approx(-0.5)


@pytest.mark.parametrize("hip", [0.01, 0.1, 0.2])
@pytest.mark.parametrize("reach", [0.0, 0.055])
@pytest.mark.parametrize("step_y", [(-0.2, 0.3), (-0.02, 0.05), (0.0, 0.01), (-0.1, 0.0)])
def test_the_lateral_bounds_are_the_fixed_point_of_what_steps_can_do(hip, reach, step_y) -> None:
    """Independent: iterate the one-step map of intervals instead of the closed form.

    In the frame of the standing foot, positive towards its swing side, an offset e grows to
    E e -+ reach (E - 1), and a step of width w turns it into w - e' for the next foot. The time
    of the step may be any between the limits.
    """
    limits = structs.replace(ROBOT.gait, step_y=step_y)
    robot = ROBOT.replace(hip=hip, gait=limits)
    growth = np.exp(robot.omega * np.linspace(*limits.step_duration, 7))
    inner, outer = hip + step_y[0], hip + step_y[1]
    low, high = -10.0, 10.0
    for _ in range(400):
        # Savable now: some w in [inner, outer] and some zmp bring w - (grown e) into [low, high].
        low, high = (
            ((inner - high - reach * (growth - 1.0)) / growth).min(),
            ((outer - low + reach * (growth - 1.0)) / growth).max(),
        )
    viable = sf.viable_offsets(robot, sf.Side.LEFT, (reach, reach))
    assert (low, high) == pytest.approx((viable.lower[1], viable.upper[1]), abs=1e-12)


def test_the_forward_bound_is_what_the_longest_fastest_steps_hold() -> None:
    growth = math.exp(ROBOT.omega * ROBOT.gait.step_duration[0])
    bound = sf.viable_offsets(ROBOT, sf.Side.LEFT).upper[0]
    inside, outside = bound - 1e-6, bound + 1e-6
    for _ in range(30):
        inside = inside * growth - ROBOT.gait.step_x[1]
        outside = outside * growth - ROBOT.gait.step_x[1]
    assert inside < -1.0  # it gets ahead of the robot, which could now take shorter steps
    assert outside > 1.0


def test_a_narrow_lateral_range_still_holds_its_nominal_gait() -> None:
    """A robot that can hardly change its step width waits instead: no false alarm."""
    narrow = ROBOT.replace(gait=structs.replace(ROBOT.gait, step_y=(-0.02, 0.05)))
    for velocity in ((0.5, 0.0), (0.0, 0.0), (-0.3, 0.02)):
        gait = sf.nominal_gait(narrow, velocity)
        assert sf.viable_offsets(narrow, sf.Side.RIGHT).margin(gait.dcm_offset(sf.Side.RIGHT)) > 0.0


def test_a_side_may_be_given_as_its_number() -> None:
    """An observation holds a number; the sign must not get lost on the way."""
    gait = sf.nominal_gait(ROBOT, (0.3, 0.1))
    for side in sf.Side:
        assert sf.viable_offsets(ROBOT, int(side)) == sf.viable_offsets(ROBOT, side)  # type: ignore[arg-type]
        assert ROBOT.gait.step_box(int(side), 0.2) == ROBOT.gait.step_box(side, 0.2)  # type: ignore[arg-type]
        assert gait.dcm_offset(int(side)) == gait.dcm_offset(side)  # type: ignore[arg-type]
        assert gait.observation(side).support_side is side
