"""The step problem for a leg that takes its time: in reach, and the best there is."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.dcm.leg import furthest, reachable_interval
from surefoot.dcm.step_in_reach import (
    HALVINGS,
    LOST_WEIGHT,
    PARTS,
    saved_by,
    solve_step_in_reach,
)
from surefoot.dcm.step_problem import StepProblem, StepSolution
from surefoot.dcm.step_solver import MAX_ITERATIONS
from surefoot.record import new_array

PAPER = sf.load_robot("paper-biped").replace(mass=70.0)
LEGS = {"3 m/s": (3.0, math.inf), "1.5 m/s": (1.5, math.inf), "60 m/s^2": (4.0, 60.0)}


@pytest.fixture(params=LEGS, scope="module")
def robot(request) -> sf.Robot:
    speed, acceleration = LEGS[request.param]
    return PAPER.with_leg(max_speed=speed, max_acceleration=acceleration)


class Moment:
    """A pushed robot in the middle of a step, and the problem that it has there."""

    def __init__(self, robot: sf.Robot, rng: np.random.Generator) -> None:
        self.robot, self.omega = robot, robot.omega
        controller = sf.StepTiming(robot, (0.4, 0.1))
        self.side = sf.Side(rng.choice([-1, 1]))
        self.now = rng.uniform(0.0, 0.6)
        self.foot = (
            rng.uniform(-0.4, 0.4),
            self.side * rng.uniform(0.05, 0.4),
            *(rng.uniform(-0.5, 0.5, 2) * robot.swing.max_speed),
        )
        start = np.array(controller.gait.start_offset(self.side))
        self.growth = start + rng.normal(scale=0.08, size=2)
        self.problem: StepProblem = controller.step_problem(self.side, tuple(self.growth), 0.0)
        self.leg = (robot.swing.max_speed, robot.swing.max_acceleration, self.omega)

    def solve(self) -> np.void:
        solution = new_array(StepSolution.DTYPE)
        solve_step_in_reach(
            self.problem.array[0], saved_by(self.robot).array[0], float(self.side),
            tuple(self.growth), self.now, self.foot, self.leg, solution[0],
        )  # fmt: skip
        return solution[0]

    def box(self, time: float) -> list[tuple[float, float]]:
        """What is in reach of step box and leg when the step has lasted so long."""
        left, boxes = max(time - self.now, 0.0), []
        for i in range(2):
            low, high, _, _ = reachable_interval(
                self.problem.step_min[i], self.problem.step_max[i], self.foot[i],
                self.foot[2 + i], left, *self.leg[:2], 0.0,
            )  # fmt: skip
            boxes.append((low, high))
        return boxes

    def cost(self, time: float, step) -> float:
        """Of a landing, term by term, beside what the solver's own code says."""
        p, tau = self.problem, math.exp(self.omega * time)
        total, tables = p.tau_weight * (tau - p.nominal_tau) ** 2, saved_by(self.robot)
        for i in range(2):
            d = self.growth[i] * tau - step[i]
            total += p.step_weight[i] * (step[i] - p.nominal_step[i]) ** 2
            total += p.offset_weight[i] * (d - p.nominal_offset[i]) ** 2
            outside = max(0.0, p.offset_min[i] - d, d - p.offset_max[i])
            total += p.offset_penalty * outside**2
            sign = 1 if i == 0 else int(self.side)
            nodes = tables.low[i] + tables.spacing[i] * np.arange(101)
            for way in (1, -1):
                # Across, ahead of this step is inward of the next one.
                row = {(0, 1): 0, (0, -1): 1, (1, 1): 1, (1, -1): 0}[i, way]
                saved = float(np.interp(sign * step[i], nodes, tables.values[i, row]))
                saved = max(saved, way * sign * p.nominal_offset[i])
                lost = max(0.0, way * sign * d - saved)
                heavy = LOST_WEIGHT * max(p.offset_penalty, p.offset_weight[i])
                total += heavy * lost**2
        return 0.5 * total


def test_what_is_in_reach_is_what_the_leg_says() -> None:
    low, high, low_rate, high_rate = reachable_interval(-0.5, 0.5, 0.1, 0.4, 0.05, 3.0, 60.0, 0.0)
    assert high == pytest.approx(0.1 + furthest(0.4, 0.05, 3.0, 60.0))
    assert low == pytest.approx(0.1 - furthest(-0.4, 0.05, 3.0, 60.0))
    longer = reachable_interval(-0.5, 0.5, 0.1, 0.4, 0.05 + 1e-7, 3.0, 60.0, 0.0)
    assert (longer[0] - low) / 1e-7 == pytest.approx(low_rate, abs=1e-4)
    assert (longer[1] - high) / 1e-7 == pytest.approx(high_rate, abs=1e-4)
    everything = reachable_interval(-0.5, 0.5, 0.1, 0.0, 9.0, 3.0, 60.0, 0.0)
    assert everything == (-0.5, 0.5, 0.0, 0.0)
    # Out of the box and out of reach of it: the nearest place.
    nearest = reachable_interval(0.0, 0.5, -0.4, 0.0, 0.1, 3.0, math.inf, 0.0)
    assert nearest[:2] == pytest.approx((-0.1, -0.1))


def test_the_landing_is_in_reach_and_none_is_better(robot: sf.Robot) -> None:
    """Against a fine search over time, with the best step of each."""
    rng, held_back = np.random.default_rng(5), 0
    for _ in range(60):
        moment = Moment(robot, rng)
        found = moment.solve()
        time = math.log(found["tau"]) / moment.omega
        shortest, longest = robot.gait.step_duration
        assert max(shortest, moment.now) - 1e-12 <= time <= max(longest, moment.now) + 1e-12
        boxes = moment.box(time)
        for step, (low, high) in zip(found["step"], boxes, strict=True):
            assert low - 1e-8 <= step <= high + 1e-8
        free = sf.solve_step(
            moment.problem.replace(
                tau_min=max(moment.problem.tau_min, math.exp(moment.omega * moment.now))
            )
        )
        assert found["iterations"] <= MAX_ITERATIONS + PARTS + HALVINGS + 3
        if found["tau"] == free.tau:
            continue
        held_back += 1
        best = moment.cost(time, found["step"])
        for other in np.linspace(max(shortest, moment.now), max(longest, moment.now), 400):
            box = moment.box(other)
            if any(low == high for low, high in box) and other > moment.now:
                continue  # not yet over the box of steps
            r = moment.growth * math.exp(moment.omega * other)
            step = [_best_step(moment.problem, i, r[i], *box[i]) for i in range(2)]
            assert moment.cost(other, step) >= best * (1.0 - 1e-3) - 1e-6
    assert held_back > 15


def _best_step(problem: StepProblem, i: int, r: float, low: float, high: float) -> float:
    """The best step of one axis for r = A tau, by a golden search: the cost is convex in it."""

    def cost(step: float) -> float:
        d = r - step
        outside = max(0.0, problem.offset_min[i] - d, d - problem.offset_max[i])
        return (
            problem.step_weight[i] * (step - problem.nominal_step[i]) ** 2
            + problem.offset_weight[i] * (d - problem.nominal_offset[i]) ** 2
            + problem.offset_penalty * outside**2
        )

    part = 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(60):
        one, two = high - part * (high - low), low + part * (high - low)
        low, high = (low, two) if cost(one) < cost(two) else (one, high)
    return 0.5 * (low + high)


def test_without_limits_there_is_nothing_to_know() -> None:
    push = [sf.Push(1.1, 0.2, (300.0, 120.0))]
    rollouts = [
        sf.simulate(sf.StepTiming(PAPER, (0.5, 0.0), knows_leg=knows), 3.0, push)
        for knows in (False, True)
    ]
    assert rollouts[0].commands.tobytes() == rollouts[1].commands.tobytes()


INWARD = {3.0: (62.0, 92.0), 4.0: (64.0, 96.0), 6.0: (66.0, 100.0)}
"""Pushed inward 0.2 s into a step: what fails as published, and what an independent version that
knows the leg reaches [N s], by the speed of the leg [m/s]."""


@pytest.mark.parametrize("speed", INWARD)
@pytest.mark.parametrize("make", [sf.StepTiming, sf.HybridController])
def test_a_leg_that_is_known_gains_half_as_much_again(make, speed: float) -> None:
    published, least = INWARD[speed]
    robot = PAPER.with_leg(max_speed=speed)
    limits = [
        sf.smallest_failing_push(
            make(robot, (0.5, 0.0), knows_leg=knows), (0.0, -1.0), start=1.2, step=2.0, workers=1
        ).impulse
        for knows in (False, True)
    ]
    assert limits[0] == pytest.approx(published, abs=4.0)
    assert limits[1] >= least


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
def test_to_know_the_leg_costs_little_anywhere(direction) -> None:
    """Nowhere more than a twentieth, where as published the foot lands early by luck."""
    robot = PAPER.with_leg(max_speed=3.0)
    for phase in (0.0, 0.1, 0.2, 0.3, 0.4):
        published, known = (
            sf.smallest_failing_push(
                sf.StepTiming(robot, (0.5, 0.0), knows_leg=knows), direction, start=1.0 + phase,
                step=2.0, workers=1,
            ).impulse
            for knows in (False, True)
        )  # fmt: skip
        assert known >= 0.95 * published - 2.0
