"""Random step problems, realistic and nasty, and the same problem as a general QP."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

KINDS = (
    "plain",
    "fixed step",
    "fixed timing",
    "fixed offset",
    "crossed offset bounds",
    "no time left",
    "no step left",
    "no growth in one axis",
    "step weights zero",
    "one offset weight zero",
    "timing weight zero",
    "far out",
    "everything at once",
)
UNIQUE = frozenset(KINDS) - {
    "step weights zero",
    "one offset weight zero",
    "timing weight zero",
    "everything at once",
}
INFINITE = 1e30


def random_problem(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """Arguments of `StepProblem`."""
    omega = rng.uniform(2.5, 5.0)
    shortest = rng.uniform(0.1, 0.4)
    longest = shortest + rng.uniform(0.0, 0.6)
    low = rng.uniform(-0.6, 0.1, 2)
    high = low + rng.uniform(0.0, 0.9, 2)
    d_low = rng.uniform(-0.2, 0.05, 2)
    d_high = d_low + rng.uniform(0.0, 0.25, 2)
    growth = rng.normal(0.0, 0.15, 2)
    step_weight = 10.0 ** rng.uniform(-1.0, 1.0, 2)
    offset_weight = 10.0 ** rng.uniform(0.0, 4.5, 2)
    tau_weight = 10.0 ** rng.uniform(-1.0, 1.0)
    axis = rng.integers(2)
    if kind == "fixed step":
        high = low.copy()
    elif kind == "fixed timing":
        longest = shortest
    elif kind == "fixed offset":
        d_high = d_low.copy()
    elif kind == "crossed offset bounds":
        d_low, d_high = d_high, d_low
    elif kind == "no time left":
        longest = shortest - rng.uniform(0.001, 0.1)
    elif kind == "no step left":
        low, high = high, low
    elif kind == "no growth in one axis":
        growth[axis] = 0.0
    elif kind == "step weights zero":
        step_weight[:] = 0.0
    elif kind == "one offset weight zero":
        offset_weight[axis] = 0.0
    elif kind == "timing weight zero":
        tau_weight = 0.0
    elif kind == "far out":
        growth *= 10.0
    elif kind == "everything at once":
        step_weight, offset_weight = rng.choice((0.0, 1.0, 10.0, 1000.0), (2, 2))
        tau_weight = rng.choice((0.0, 1.0, 10.0))
        for lower, upper in ((low, high), (d_low, d_high)):
            if rng.random() < 0.5:
                upper[axis] = lower[axis] - rng.choice((0.0, 0.1))
        growth[rng.integers(2)] *= rng.choice((0.0, 1.0))
    return {
        "growth": tuple(growth),
        "nominal_step": tuple(rng.uniform(-0.4, 0.4, 2)),
        "nominal_tau": float(np.exp(omega * rng.uniform(0.2, 0.8))),
        "nominal_offset": tuple(rng.uniform(-0.1, 0.1, 2)),
        "step_min": tuple(low),
        "step_max": tuple(high),
        "tau_min": float(np.exp(omega * shortest)),
        "tau_max": float(np.exp(omega * longest)),
        "offset_min": tuple(d_low),
        "offset_max": tuple(d_high),
        "step_weight": tuple(step_weight),
        "tau_weight": float(tau_weight),
        "offset_weight": tuple(offset_weight),
        "offset_penalty": 1e6,
    }


def as_qp(p: dict[str, Any]) -> tuple[NDArray[np.float64], ...]:
    """H, f, A, upper, lower over (X, Y, tau, d_x, d_y, excess above x, y, excess below x, y).

    min 1/2 v H v + f v subject to lower <= (v, A v) <= upper; the two first rows of A are
    equalities. Empty intervals are replaced by what `solve_step` promises for them.
    """
    hessian = np.diag(
        [*p["step_weight"], p["tau_weight"], *p["offset_weight"], *4 * [p["offset_penalty"]]]
    )
    target = np.array([*p["nominal_step"], p["nominal_tau"], *p["nominal_offset"], 0, 0, 0, 0])
    rows = np.zeros((6, 9))
    for i in range(2):
        rows[i, [i, 3 + i, 2]] = 1.0, 1.0, -p["growth"][i]
        rows[2 + i, [3 + i, 5 + i]] = 1.0, -1.0
        rows[4 + i, [3 + i, 7 + i]] = 1.0, 1.0
    low, high = np.array(p["step_min"]), np.array(p["step_max"])
    middle, empty = 0.5 * (low + high), low > high
    low, high = np.where(empty, middle, low), np.where(empty, middle, high)
    free = 6 * [INFINITE]
    lower = [*low, p["tau_min"], *np.negative(free), 0.0, 0.0, -INFINITE, -INFINITE]
    upper = [*high, max(p["tau_min"], p["tau_max"]), *free, 0.0, 0.0, *p["offset_max"]]
    return (
        hessian,
        -hessian @ target,
        rows,
        np.array([*upper, INFINITE, INFINITE]),
        np.array([*lower, *p["offset_min"]]),
    )
