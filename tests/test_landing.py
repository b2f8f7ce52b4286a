"""The landing problem is solved exactly, whatever the situation; and what its flags say is true.

Against a general solver, sequential quadratic programs. Everything but the leg's reach is a
quadratic program once each |.|+ has a variable of its own and the pieces of Z are rows; ln(tau)
enters by its tangent at the last answer, and by its curvature. Nothing here knows how the package
solves it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
import quadprog
from numpy.typing import NDArray

import surefoot as sf
from surefoot.compiled import njit, record_entry_point
from surefoot.control.unified.anticipation import anticipate
from surefoot.control.unified.problem import (
    Decision,
    LandingParameters,
    Situation,
    landing_parameters,
)
from surefoot.control.unified.solver import TAU_EVALUATIONS, decide_landing
from surefoot.record import new_array
from surefoot.robot.robot import Robot

SETTLED = 1e-10
"""The tangent is the right one when the answer moves no further [m]."""

ROUNDS = 60
BIG = 1e30
# Variables: X_x, X_y, tau, then for each axis the error, and both sides' lost and short.
X, TAU, ERROR, LOST, SHORT = (0, 1), 2, (3, 8), ((4, 5), (9, 10)), ((6, 7), (11, 12))
EAGER, SIZE = ((13, 14), (15, 16)), 17


@dataclass
class Program:
    """Rows A x <= high of a quadratic program with a diagonal Hessian."""

    rows: list[np.ndarray] = field(default_factory=list)
    high: list[float] = field(default_factory=list)

    def at_most(self, coefficients: dict[int, float], bound: float) -> None:
        row = np.zeros(SIZE)
        for index, value in coefficients.items():
            row[index] += value
        self.rows.append(row)
        self.high.append(bound)


def solve_by_programs(parameters: np.ndarray, situation: np.ndarray) -> tuple[np.ndarray, float]:
    """The landing and tau of least cost."""
    p, s = parameters[0], situation[0]
    omega, shrink = float(p["omega"]), math.exp(-float(p["omega"]) * float(s["elapsed"]))
    weight = np.zeros(SIZE)
    center = np.zeros(SIZE)
    weight[TAU], center[TAU] = p["tau_weight"], s["tau_ref"]
    program = Program()
    bounds_low, bounds_high = np.full(SIZE, -BIG), np.full(SIZE, BIG)
    bounds_low[TAU], bounds_high[TAU] = s["tau_min"], s["tau_max"]
    for i in range(2):
        weight[X[i]], center[X[i]] = p["step_weight"][i], s["step_ref"][i]
        weight[ERROR[i]] = p["offset_weight"][i]
        bounds_low[X[i]], bounds_high[X[i]] = p["step_min"][i], p["step_max"][i]
        bounds_low[ERROR[i]] = 0.0
        gentle, left = p["gentle_zmp"][i], p["gentle_offset"][i]
        for sign in (1.0, -1.0):
            # sign (e k - d - X) - c_g (k - 1) - delta <= error
            program.at_most(
                {TAU: (sign * s["offset"][i] - gentle) * shrink, X[i]: -sign, ERROR[i]: -1.0},
                sign * s["offset_ref"][i] - gentle + left,
            )
        for k in range(2):
            weight[LOST[i][k]], weight[SHORT[i][k]] = p["lost_weight"], p["reserve_weight"]
            weight[EAGER[i][k]] = p["gentle_weight"]
            bounds_low[LOST[i][k]] = bounds_low[SHORT[i][k]] = bounds_low[EAGER[i][k]] = 0.0
    place, tau = np.array(s["step_ref"], float), float(np.clip(s["tau_ref"], *bounds(s)))
    pieces: set[tuple[int, int, int]] = set()
    curvature = 0.0
    for _ in range(ROUNDS):
        pieces |= {piece for i in range(2) for piece in pieces_near(p, i, place[i])}
        together = Program(list(program.rows), list(program.high))
        for piece in sorted(pieces):
            tangent_of_saved(together, p, s, shrink, *piece)
        tangents = len(together.rows)
        for i in range(2):
            tangent_of_reach(together, p, s, omega, i, tau)
        # Newton's method on the Lagrangian: a reach that binds bends with its multiplier.
        heavier, shifted = weight.copy(), center.copy()
        heavier[TAU] += curvature
        shifted[TAU] = (weight[TAU] * center[TAU] + curvature * tau) / heavier[TAU]
        answer, multipliers = quadratic_program(together, heavier, shifted, bounds_low, bounds_high)
        moved = max(*np.abs(answer[:2] - place), abs(answer[TAU] - tau))
        place, tau = answer[:2], float(answer[TAU])
        if moved < SETTLED:
            return place, tau
        if math.isfinite(p["max_speed"]):
            bend = float(p["max_speed"]) / (omega * tau * tau)
            curvature = bend * float(np.sum(multipliers[tangents:]))
    raise AssertionError("the quadratic programs did not converge")


def bounds(s: np.void) -> tuple[float, float]:
    return float(s["tau_min"]), float(s["tau_max"])


def tangent_of_reach(program, p, s, omega, axis, tau):
    """|X - foot| <= V (ln(tau) / omega - t), by the tangent at a tau."""
    speed = float(p["max_speed"])
    if not math.isfinite(speed):
        return
    slope, level = speed / (omega * tau), speed * (math.log(tau) / omega - float(s["elapsed"]))
    foot = float(s["foot"][axis])
    program.at_most({X[axis]: 1.0, TAU: -slope}, foot + level - slope * tau)
    program.at_most({X[axis]: -1.0, TAU: -slope}, -foot + level - slope * tau)


def pieces_near(p, axis, place):
    """The pieces of Z around a place, for both sides."""
    last = p["saved"].shape[2] - 2
    cell = int((place - p["step_min"][axis]) / p["spacing"][axis])
    for node in (cell - 1, cell, cell + 1):
        for k in range(2):
            yield axis, k, min(max(node, 0), last)


def tangent_of_saved(program, p, s, shrink, axis, k, node):
    """v of one side with one piece of Z, as a lower bound on both of its variables."""
    spacing, start = float(p["spacing"][axis]), float(p["step_min"][axis])
    table = p["saved"][axis, k]
    sign = 1.0 - 2.0 * k
    reach = float(p["zmp_reach"][axis])
    slope = (table[node + 1] - table[node]) / spacing
    level = table[node] - slope * (start + node * spacing)
    # v = (sign a - c) k + sign b - sign X - (level + slope X)
    tau = (sign * float(s["rate"][axis, k]) - reach) * shrink
    shift = sign * float(s["shift"][axis, k])
    rows = {TAU: tau, X[axis]: -sign - slope}
    program.at_most({**rows, LOST[axis][k]: -1.0}, level - shift)
    program.at_most({**rows, SHORT[axis][k]: -1.0}, level - shift - float(p["reserve"][axis]))
    # ... + (c - c_g)(k - 1)
    spare = reach - float(p["gentle_zmp"][axis])
    program.at_most(
        {TAU: tau + spare * shrink, X[axis]: -sign - slope, EAGER[axis][k]: -1.0},
        level - shift - float(p["reserve"][axis]) + spare,
    )


def quadratic_program(program, weight, center, low, high):
    """By the dual method of Goldfarb and Idnani, in variables scaled to unit weight.

    Returns the answer and the multipliers of the program's rows.
    """
    scale = 1.0 / np.sqrt(weight)
    bounded = [(k, low[k], -1.0) for k in range(SIZE) if low[k] > -BIG]
    bounded += [(k, high[k], 1.0) for k in range(SIZE) if high[k] < BIG]
    rows = np.zeros((len(bounded), SIZE))
    for row, (index, _, sign) in zip(rows, bounded, strict=True):
        row[index] = sign
    rows = np.vstack([rows, program.rows]) * scale
    limits = np.array([sign * bound for _, bound, sign in bounded] + program.high)
    norms = np.linalg.norm(rows, axis=1)
    found = quadprog.solve_qp(
        np.eye(SIZE), center / scale, -(rows / norms[:, None]).T, -limits / norms
    )
    return found[0] * scale, (found[4] / norms)[len(bounded) :]


def cost(parameters: np.ndarray, situation: np.ndarray, place: np.ndarray, tau: float) -> float:
    """The cost as it is written in `control.unified.problem`."""
    p, s = parameters[0], situation[0]
    total = 0.5 * p["tau_weight"] * (tau - s["tau_ref"]) ** 2
    return float(total + sum(axis_cost(p, s, i, place[i], tau) for i in range(2)))


def axis_cost(p: np.void, s: np.void, i: int, place, tau: float):
    """The part of one axis, of a place or of many."""
    k = tau * math.exp(-float(p["omega"]) * float(s["elapsed"]))
    nodes = p["step_min"][i] + p["spacing"][i] * np.arange(p["saved"].shape[2])
    error = np.abs(s["offset"][i] * k - s["offset_ref"][i] - place)
    error = error - p["gentle_zmp"][i] * (k - 1.0) - p["gentle_offset"][i]
    total = 0.5 * p["step_weight"][i] * (place - s["step_ref"][i]) ** 2
    total = total + 0.5 * p["offset_weight"][i] * np.maximum(error, 0.0) ** 2
    for row, sign in enumerate((1.0, -1.0)):
        v = (sign * s["rate"][i, row] - p["zmp_reach"][i]) * k + sign * s["shift"][i, row]
        v = v - sign * place - np.interp(place, nodes, p["saved"][i, row])
        total = total + 0.5 * p["lost_weight"] * np.maximum(v, 0.0) ** 2
        total = total + 0.5 * p["reserve_weight"] * np.maximum(v + p["reserve"][i], 0.0) ** 2
        spare = (p["zmp_reach"][i] - p["gentle_zmp"][i]) * (k - 1.0)
        eager = np.maximum(v + spare + p["reserve"][i], 0.0)
        total = total + 0.5 * p["gentle_weight"] * eager**2
    return total


def random_parameters(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    """The parameters of a robot, with an ankle or without."""
    ankle = rng.random() < 0.6
    reach = np.array(robot.foot.half) if ankle else np.zeros(2)
    gentle = np.minimum(reach, 0.045)
    left = np.minimum(0.024, 0.8 * reach)
    return landing_parameters(
        robot, tuple(reach), tuple(gentle), tuple(left),
        room=float(rng.uniform(0.05, 0.3)), tau_ref=float(rng.uniform(3.0, 10.0)),
        reserve=0.02, commitment=float(rng.choice((0.0, 0.003))),
    ).array  # fmt: skip


def random_situation(parameters: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A situation from quiet to hopeless, in which the leg can be in the step box."""
    p = parameters[0]
    situation = new_array(Situation.DTYPE)
    s = situation[0]
    omega = float(p["omega"])
    elapsed = float(rng.uniform(0.0, 0.7))
    s["elapsed"] = elapsed
    soonest = max(float(p["shortest"]), elapsed + float(rng.choice([0.0, 0.01, 0.05])))
    s["tau_min"] = math.exp(omega * soonest)
    s["tau_max"] = math.exp(omega * max(float(p["longest"]), soonest))
    s["tau_ref"] = math.exp(omega * rng.uniform(0.3, 0.7))
    low, high = np.array(p["step_min"]), np.array(p["step_max"])
    s["foot"] = rng.uniform(low, high)
    s["step_ref"] = rng.uniform(low, high)
    s["offset_ref"] = rng.uniform((-0.1, -0.1), (0.1, 0.05))
    size = float(rng.choice([0.0, 0.02, 0.2, 0.5]))
    s["offset"] = (s["step_ref"] + s["offset_ref"]) / s["tau_ref"] * math.exp(omega * elapsed)
    s["offset"] += size * rng.standard_normal(2)
    s["force"] = rng.choice([0.0, 0.1, 0.4]) * rng.standard_normal(2)
    anticipate(p, s, *(rng.uniform(0.0, 1.0) * s["force"]))
    return situation


def min_cost(parameters: np.ndarray, situation: np.ndarray) -> float:
    """The least cost of a fine grid of landings and times, for tables that are not concave."""
    p, s = parameters[0], situation[0]
    omega, speed = float(p["omega"]), float(p["max_speed"])
    best = math.inf
    for tau in np.geomspace(*bounds(s), 241):
        left = math.log(tau) / omega - float(s["elapsed"])
        total = 0.0
        for i in range(2):
            low, high = float(p["step_min"][i]), float(p["step_max"][i])
            if math.isfinite(speed):
                low = max(low, float(s["foot"][i]) - speed * left)
                high = min(high, float(s["foot"][i]) + speed * left)
            places = np.linspace(low, high, 401)
            total += axis_cost(p, s, i, places, tau).min()
        best = min(best, 0.5 * p["tau_weight"] * (tau - s["tau_ref"]) ** 2 + total)
    return best


ROBOT = sf.load_robot("paper-biped")
LEGS = (2.0, 3.0, 6.0, math.inf)
STATES = 12_000
AGREEMENT, ROUNDING = 1e-7, 1e-14


@njit
def _solve(landing, situation, decision):
    decide_landing(landing, situation, situation.tau_ref, decision)


SOLVE = record_entry_point(_solve, LandingParameters, Situation, Decision)


def solve_landing(landing: NDArray[np.void], situation: NDArray[np.void]) -> Decision:
    """The decision for one situation; ZMP and margin are not its part."""
    decision = new_array(Decision.DTYPE)
    SOLVE(landing, situation, decision)
    return Decision.of(decision)


def test_it_agrees_with_a_general_solver() -> None:
    """12,000 states of a leg without limits, whose tables are concave: landing and tau to 1e-7.

    Or both cost the same to the last bits: where a state is hopeless the costs are 1e10.
    """
    rng = np.random.default_rng(0)
    even, active = 0, 0
    for _ in range(STATES // 100):
        parameters = random_parameters(ROBOT, rng)
        for _ in range(100):
            situation = random_situation(parameters, rng)
            mine = solve_landing(parameters, situation)
            place, tau = solve_by_programs(parameters, situation)
            if max(*np.abs(mine.step - place), abs(mine.tau - tau)) > AGREEMENT:
                costs = [
                    cost(parameters, situation, *answer)
                    for answer in ((mine.step, mine.tau), (place, tau))
                ]
                assert costs[0] <= costs[1] * (1.0 + ROUNDING)
                even += 1
            active |= int(mine.active)
            assert mine.iterations <= TAU_EVALUATIONS + 2
    assert even <= STATES // 1000
    met = sf.Limit(active)
    assert sf.Limit.STEP_X | sf.Limit.SHORTEST | sf.Limit.LOST in met
    assert sf.Limit.LEG_Y not in met


@pytest.mark.parametrize("speed", LEGS)
def test_nothing_costs_less(speed: float) -> None:
    """Than the decision, of 100,000 landings and times in each of 200 situations of every leg.

    The tables of a slow leg bend up a little; the last part in a thousand of the cost is for that.
    """
    rng = np.random.default_rng(int(10 * min(speed, 10.0)))
    active = 0
    for _ in range(20):
        parameters = random_parameters(ROBOT.with_leg(max_speed=speed), rng)
        for _ in range(10):
            situation = random_situation(parameters, rng)
            mine = solve_landing(parameters, situation)
            found = cost(parameters, situation, mine.step, mine.tau)
            assert found <= min_cost(parameters, situation) * (1.0 + 1e-3) + 1e-9
            active |= int(mine.active)
    assert (sf.Limit.LEG_Y in sf.Limit(active)) == math.isfinite(speed)
