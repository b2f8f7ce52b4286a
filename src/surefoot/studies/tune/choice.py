"""Which trial to take, which of its changes are kept, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from surefoot.errors import ParameterError

NOTICEABLE_SURVIVAL, NOTICEABLE_GENTLENESS = 0.005, 0.01
"""A smaller difference is no reason to change a parameter [-]."""

Objectives = tuple[float, float]
"""Survival, which is to be large, and gentleness, which is to be small."""

Values = Mapping[str, float]

Try = Callable[[Values], Objectives | None]
"""Measures values of the parameters; None if the controller refuses them."""

PREFERENCES: Mapping[str, Callable[[Objectives], tuple[float, float]]] = {
    "survival": lambda of: (of[0], -of[1]),
    "gentleness": lambda of: (-of[1], of[0]),
    "balance": lambda of: (of[0] / of[1] if of[1] > 0.0 else float("inf"), of[0]),
}
"""What is to be largest, by name: of those that are no worse than the default in either."""


@dataclass(frozen=True)
class Tried:
    """One finished trial.

    Attributes:
        number: 0 is the default.
        values: of the parameters.
        objectives: what came out, or None if the controller refused the values.
        told: what else was measured, or why the values were refused.
    """

    number: int
    values: dict[str, float]
    objectives: Objectives | None
    told: dict[str, Any]

    @property
    def reached(self) -> Objectives:
        """The objectives of a trial whose values were not refused.

        Raises:
            ParameterError: they were.
        """
        if self.objectives is None:
            raise ParameterError("a trial that was measured", repr(self), "measure it first")
        return self.objectives


@dataclass(frozen=True)
class Reason:
    """Why a parameter has its value.

    Attributes:
        parameter: its name.
        default: value that it had.
        value: that it has now.
        without: survival and gentleness with this parameter alone set back; None if the controller
            refuses that.
    """

    parameter: str
    default: float
    value: float
    without: Objectives | None


def pareto_front(trials: Sequence[Tried]) -> list[Tried]:
    """The trials that no other one dominates by being as good in both and better in one."""
    good = [one for one in trials if one.objectives is not None]
    return [
        one
        for one in good
        if not any(
            other.reached != one.reached and no_worse(other.reached, one.reached) for other in good
        )
    ]


def choose(trials: Sequence[Tried], prefer: str = "survival") -> Tried:
    """The trial to take: on the front, and no worse than the default in either objective.

    Args:
        trials: the first is the default.
        prefer: a key of `PREFERENCES`.
    """
    able = [one for one in pareto_front(trials) if no_worse(one.reached, trials[0].reached)]
    # Of equals the first: the default, if it is among them.
    return max(able, key=lambda one: PREFERENCES[prefer](one.reached), default=trials[0])


def no_worse(one: Objectives | None, other: Objectives, spare: Objectives = (0.0, 0.0)) -> bool:
    """Whether survival is not smaller and gentleness not larger, but for what may be spared."""
    return one is not None and one[0] >= other[0] - spare[0] and one[1] <= other[1] + spare[1]


def simplest(
    chosen: Tried, defaults: Values, default: Objectives, attempt: Try
) -> dict[str, float]:
    """The chosen values, with every parameter set back that makes no noticeable difference.

    The one that makes the least goes first; then the rest is measured without it, until none goes
    any more. What is lost by all of them together is compared with the chosen trial, so that small
    losses do not add up.

    Args:
        chosen: the trial.
        defaults: of the parameters.
        default: survival and gentleness of these, which must not become worse.
        attempt: measures values.
    """
    best, values = chosen.reached, dict(chosen.values)
    spare = (NOTICEABLE_SURVIVAL, NOTICEABLE_GENTLENESS)

    def lost(name: str) -> float:
        found = attempt({**values, name: defaults[name]})
        if found is None:
            return float("inf")
        return max((best[0] - found[0]) / spare[0], (found[1] - best[1]) / spare[1])

    while True:
        changed = [name for name in values if values[name] != defaults[name]]
        before = values
        for name in sorted(changed, key=lost):
            simpler = {**values, name: defaults[name]}
            found = attempt(simpler)
            if no_worse(found, best, spare) and no_worse(found, default):
                values = simpler
        # What mattered beside another parameter may not matter without it.
        if values == before:
            return values


def reasons(values: Values, defaults: Values, attempt: Try) -> list[Reason]:
    """Why each parameter that was changed has its value: what is lost if it alone is set back."""
    return [
        Reason(name, defaults[name], value, attempt({**values, name: defaults[name]}))
        for name, value in values.items()
        if value != defaults[name]
    ]
