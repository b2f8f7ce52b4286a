"""How gently a push is answered: how far ZMP, landing and timing leave the nominal gait.

A method that survives large pushes must not be nervous about small ones. So the same pushes, in all
directions and phases, go to two methods, and what each does with them is compared cell by cell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import Outcome
from surefoot.studies.compare.measure import controller_of
from surefoot.studies.compare.question import Protocol
from surefoot.worlds.point.world import simulate

IMPULSES, LEG_SPEEDS = (5.0, 10.0, 20.0), (3.0, float("inf"))
"""Of the usual table [N s], [m/s]."""

SEEN = 2.5
"""How long after the beginning of a push its answer is watched [s]."""

_PUSH_DURATION, _PHASES = 0.2, 4

NOTICEABLE = 1e-6
"""An answer is larger if it is by more than this [m, s]."""


@dataclass(frozen=True)
class Answer:
    """What a method did about one push.

    Attributes:
        zmp_peak: largest distance of the ZMP from the centre of the foot [m].
        zmp_rms: its root mean square from the push on, for `SEEN` seconds [m].
        landing: largest change of a step vector against the nominal gait [m].
        timing: largest change of a step's duration [s].
        survived: whether it did not fall.
    """

    zmp_peak: float
    zmp_rms: float
    landing: float
    timing: float
    survived: bool


QUANTITIES = tuple(field.name for field in fields(Answer) if field.name != "survived")


@dataclass(frozen=True)
class Gentleness:
    """The answers of two methods to the pushes of one impulse, over directions and phases.

    Attributes:
        leg_speed: limit of the swing foot [m/s].
        impulse: of the pushes [N s].
        answers: by the key of the method, one `Answer` for each cell, in the same order.
    """

    leg_speed: float
    impulse: float
    answers: dict[str, tuple[Answer, ...]]

    def values(self, key: str, quantity: str) -> list[float]:
        """A quantity of `QUANTITIES` in all cells [m, s]."""
        return [getattr(answer, quantity) for answer in self.answers[key]]

    def larger(self, key: str, other: str, quantity: str) -> int:
        """In how many cells the answer of a method is larger than that of another."""
        pairs = zip(self.values(key, quantity), self.values(other, quantity), strict=True)
        return sum(mine > theirs + NOTICEABLE for mine, theirs in pairs)

    def as_numbers(self) -> dict[str, Any]:
        """Mean and largest of every quantity, for a program; an unlimited leg is None."""
        methods = {
            key: {
                quantity: {
                    "mean": float(np.mean(self.values(key, quantity))),
                    "largest": max(self.values(key, quantity)),
                }
                for quantity in QUANTITIES
            }
            for key in self.answers
        }
        first, second = self.answers
        return {
            "leg_speed": self.leg_speed if np.isfinite(self.leg_speed) else None,
            "impulse": self.impulse,
            "cells": len(self.answers[first]),
            "methods": methods,
            f"{first}_larger": {name: self.larger(first, second, name) for name in QUANTITIES},
        }


def gentleness(
    robot: Robot,
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    impulses: Sequence[float] = IMPULSES,
    leg_speeds: Sequence[float] = LEG_SPEEDS,
    methods: tuple[str, str] = ("unified", "hybrid"),
    report: Callable[[int, int], None] | None = None,
) -> list[Gentleness]:
    """The same pushes to two methods: 0.2 s long, four directions, four phases of a step.

    Args:
        robot: who is pushed; its leg speed is replaced.
        velocity: commanded (v_x, v_y) [m/s].
        impulses: [N s].
        leg_speeds: limits of the swing foot; inf for none [m/s].
        methods: keys of `control.registry`.
        report: called with how many walks are done, and of how many.

    Returns:
        One entry for each leg speed and impulse.

    Raises:
        ParameterError: no such method, or a number is out of range.
        VelocityError: the velocity cannot be walked, or not on the slowest of the legs.
    """
    for impulse in impulses:
        check_number("impulse", impulse, 0.0, "N s", above=True)
    protocol = Protocol(
        robot, velocity, methods=methods, phases=_PHASES, leg_speeds=tuple(leg_speeds),
        push_durations=(_PUSH_DURATION,),
    )  # fmt: skip
    total, done = len(impulses) * len(list(protocol.cells())), 0
    found = []
    for leg_speed in protocol.leg_speeds:
        for impulse in impulses:
            answers: dict[str, list[Answer]] = {key: [] for key in methods}
            for cell in protocol.cells():
                if cell.leg_speed != leg_speed:
                    continue
                push = Push.of_impulse(
                    impulse, protocol.direction(cell.angle), protocol.push_start(cell.phase),
                    cell.push_duration,
                )  # fmt: skip
                controller = controller_of(protocol, cell.method, leg_speed)
                answers[cell.method].append(answer(controller, push))
                done += 1
                if report is not None:
                    report(done, total)
            kept = {key: tuple(values) for key, values in answers.items()}
            found.append(Gentleness(leg_speed, impulse, kept))
    return found


def answer(controller: Controller, push: Push) -> Answer:
    """Walk, push, and measure what the controller does about it; the right foot stands first.

    Args:
        controller: what decides.
        push: one push; the walk goes on for `SEEN` seconds after its beginning.
    """
    rollout = simulate(controller, push.start + SEEN, [push], first_support=Side.RIGHT)
    moved = np.hypot(*(rollout.zmp - rollout.support_foot).T)[rollout.time >= push.start]
    gait = controller.gait
    pushed = [step for step in rollout.footsteps if step.start + step.duration > push.start]
    changes = [np.subtract(step.step, gait.step(step.side)) for step in pushed]
    return Answer(
        zmp_peak=float(moved.max()),
        zmp_rms=float(np.sqrt(np.mean(moved**2))),
        landing=max((float(np.hypot(*change)) for change in changes), default=0.0),
        timing=max((abs(step.duration - gait.step_duration) for step in pushed), default=0.0),
        survived=rollout.outcome is not Outcome.FELL,
    )
