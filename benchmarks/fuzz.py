"""Give random observations to every controller of the point mass and count forbidden commands.

    python benchmarks/fuzz.py [--observations 1000000] [--walks 400] [--slow-share 0.005]

Each method is given random observations, one after another, starting from states of an undisturbed
walk, and its commands are checked. Then undisturbed walks are given random observations for one
cycle or for 200 in a row, and must not fall. After 200 cycles only those walks count from which a
controller that starts anew on the true state walks on.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

import surefoot as sf
from surefoot.control.cycle import side_index
from surefoot.control.registry import methods
from surefoot.dcm.support import nearest_supported
from surefoot.interface import OBSERVATION, Status
from surefoot.record import new_array
from surefoot.worlds.point.batch import kernel_pointer
from surefoot.worlds.point.plant import lipm_cycle

KINDS = ("bits", "special", "field", "jump", "jumps", "contact", "elsewhen")
"""All bits at random; NaN, infinities, huge and tiny numbers; one field replaced; one field moved;
every field moved; which foot stands; the observation of another cycle."""

FIELDS = OBSERVATION.itemsize // 8
"""Numbers of an observation; the last one is the side, an integer."""

SPECIAL = np.array(
    [math.nan, math.inf, -math.inf, 1e300, -1e300, 1e-300, 0.0, -1.0, 1e9, -1e9, 1e15, 1e3, -1e3]
)

SETTLING, AFTER, SEQUENCE, LONG = 1.0, 5, 40, 200
"""A walk is corrupted from this time on [s]; it continues for this many longest steps after that;
observations between two starts; corrupted cycles in a row."""

COUNTED = ("not finite", "landing outside", "time outside", "ZMP outside")
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_NO_STEP_LEFT = int(Status.NO_STEP_LEFT)

_LIMITS = np.dtype(
    [
        ("low", "f8", (2, 2)),
        ("high", "f8", (2, 2)),
        ("shortest", "f8"),
        ("longest", "f8"),
        ("half_foot", "f8", (2,)),
    ]
)


@dataclass
class Counts:
    """Results of one method.

    Attributes:
        method: its name.
        observations: that were corrupted.
        violations: number of forbidden commands of each kind in `COUNTED`.
        walks: with one corrupted cycle, and with 200.
        falls: of these.
        lost: walks that could not be continued after 200 cycles; not in `walks`.
        examples: of forbidden commands and falls: kind and cycle.
        gone: of lost walks.
    """

    method: str
    observations: int = 0
    violations: NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(COUNTED), np.int64))
    walks: list[int] = field(default_factory=lambda: [0, 0])
    falls: list[int] = field(default_factory=lambda: [0, 0])
    lost: int = 0
    examples: list[str] = field(default_factory=list)
    gone: list[str] = field(default_factory=list)

    @property
    def total(self) -> int:
        """Everything that must be 0."""
        return int(self.violations.sum()) + sum(self.falls)


@njit
def _is_finite(command):
    """Whether all of a command is."""
    total = command.step_duration + command.swing_yaw
    for i in range(2):
        total += command.zmp[i] + command.dcm_plan[i] + command.step_location[i]
        total += command.dcm_offset[i] + command.hip_torque[i]
    for i in range(3):
        total += command.swing_foot[i] + command.swing_foot_velocity[i]
        total += command.swing_foot_acceleration[i]
    return math.isfinite(total)


@njit
def _judge(limits, command, seen, violations):
    """Count the violations of one command."""
    if not _is_finite(command):
        violations[0] += 1
        return
    row = side_index(seen.support_side)
    for i in range(2):
        foot = seen.support_foot[i]
        step, room = command.step_location[i] - foot, 1e-9 + 1e-15 * abs(foot)
        outside = step < limits.low[row, i] - room or step > limits.high[row, i] + room
        if outside and command.status & _NO_STEP_LEFT == 0:
            violations[1] += 1
            break
    time = command.step_duration
    outside = time < limits.shortest - 1e-9 or time > limits.longest + 1e-9
    if outside and command.status & _NO_TIME_LEFT == 0:
        violations[2] += 1
    if limits.half_foot[0] < math.inf:
        x, y = command.zmp[0] - seen.support_foot[0], command.zmp[1] - seen.support_foot[1]
        shared = command.double_support != 0
        in_x, in_y = nearest_supported(seen, shared, x, y, limits.half_foot[0], limits.half_foot[1])
        if math.hypot(x - in_x, y - in_y) > 1e-9 + 1e-15 * abs(seen.support_foot[0]):
            violations[3] += 1


@njit
def _edit(truth, modes, values, side_mode, side, flat, shown):
    """Write the corrupted observation; `flat` are the numbers of `shown`."""
    shown[0] = truth
    for k in range(modes.shape[0]):
        if modes[k] == 1:
            flat[k] = values[k]
        elif modes[k] == 2:
            flat[k] += values[k]
    if side_mode == 1:
        shown[0].support_side = side
    elif side_mode == 2:
        shown[0].support_side = -shown[0].support_side


@njit
def _show(kernel, parameters, states, truths, edits, shown, flat, limits, violations):
    """One observation after another, whatever the commands are."""
    modes, values, side_modes, sides = edits
    for n in range(truths.shape[0]):
        _edit(truths[n], modes[n], values[n], side_modes[n], sides[n], flat, shown)
        after = states[1 - n % 2]
        kernel(parameters[0], states[n % 2], shown[0], after)
        _judge(limits[0], after.command, after.validated.observation, violations)


@njit
def _walk(kernel, parameters, states, simulator, worlds, pushes, edits, garbage, cycles, extra):
    """A closed loop; the first `garbage` cycles are corrupted. Returns whether it falls."""
    modes, values, side_modes, sides = edits
    shown, flat, limits, violations = extra
    for n in range(cycles):
        now = n % 2
        if n < garbage:
            row = n % modes.shape[0]
            _edit(
                worlds[now].observation, modes[row], values[row], side_modes[row], sides[row],
                flat, shown,
            )  # fmt: skip
            kernel(parameters[0], states[now], shown[0], states[1 - now])
        else:
            kernel(parameters[0], states[now], worlds[now].observation, states[1 - now])
        command = states[1 - now].command
        _judge(limits[0], command, states[1 - now].validated.observation, violations)
        lipm_cycle(simulator[0], worlds[now], command, pushes, worlds[1 - now])
        if worlds[1 - now].fallen:
            return True
    if cycles % 2 == 1:
        states[0], worlds[0] = states[1], worlds[1]
    return False


@njit
def _judge_one(limits, command, seen, violations):
    _judge(limits[0], command[0], seen[0], violations)


class Subject:
    """One controller with an undisturbed walk, and loops that corrupt its observations."""

    def __init__(self, name: str, controller: Any) -> None:
        self.name, self.controller = name, controller
        self.simulator = sf.LipmSimulator(controller.robot, controller.period)
        self.limits = np.zeros(1, _LIMITS)
        robot = controller.robot
        for side in sf.Side:
            row = side_index.py_func(side)
            low, high = robot.gait.step_box(side, robot.hip)
            if isinstance(controller, sf.FootholdTracking):
                # Footholds were checked in the axes of the feet: the box of no heading.
                reach = math.hypot(
                    max(map(abs, robot.gait.step_x)), robot.hip + robot.gait.step_y[1]
                )
                low, high = (-reach, -reach), (reach, reach)
            self.limits["low"][0, row], self.limits["high"][0, row] = low, high
        self.limits["shortest"], self.limits["longest"] = robot.gait.step_duration
        self.limits["half_foot"] = robot.foot.half
        observation = controller.first_observation(None)
        state, world = controller.start(observation), self.simulator.start(observation)
        self.states, self.worlds = [], []
        pace = controller.gait.step_duration
        for _ in range(round((SETTLING + 2.0 * pace) / controller.period)):
            if observation.time >= SETTLING:
                self.states.append(state)
                self.worlds.append(world)
            command, state = controller.step(state, observation)
            observation, world = self.simulator.step(world, command)
        self.truths = np.concatenate([world["observation"] for world in self.worlds])
        self.pointer = None if controller.kernel is None else kernel_pointer(controller, state)

    @property
    def cycles(self) -> int:
        """Length of a walk after the corrupted cycles."""
        longest = self.controller.robot.gait.step_duration[1]
        return round(AFTER * longest / self.controller.period)

    def show(self, start: int, truths: Any, edits: Any, violations: NDArray[np.int64]) -> None:
        """Corrupted observations in a row, starting from a state of the walk."""
        shown = new_array(OBSERVATION)
        flat = shown.view(np.float64)[: FIELDS - 1]
        if self.pointer is not None:
            states = np.concatenate([self.states[start]] * 2)
            _show(
                self.pointer, self.controller.parameters, states, truths, edits, shown, flat,
                self.limits, violations,
            )  # fmt: skip
            return
        state = self.states[start]
        for n in range(len(truths)):
            _edit(truths[n], *(column[n] for column in edits), flat, shown)
            state = self._step(state, shown.copy(), violations)

    def walk(
        self, state: Any, world: Any, edits: Any, garbage: int, cycles: int, violations: Any
    ) -> tuple[bool, NDArray[np.void], NDArray[np.void]]:
        """A closed loop whose first `garbage` cycles are corrupted.

        Returns:
            Whether it walks on for so many cycles; its last world and state.
        """
        shown = new_array(OBSERVATION)
        flat = shown.view(np.float64)[: FIELDS - 1]
        if self.pointer is not None:
            states, worlds = np.concatenate([state, state]), np.concatenate([world, world])
            fell = _walk(
                self.pointer, self.controller.parameters, states, self.simulator.parameters,
                worlds, self.simulator.push_array, edits, garbage, cycles,
                (shown, flat, self.limits, violations),
            )  # fmt: skip
            return not fell, worlds[:1].copy(), states[:1].copy()
        for n in range(cycles):
            seen = world["observation"].copy()
            if n < garbage:
                row = [column[n % len(column)] for column in edits]
                _edit(world["observation"][0], *row, flat, shown)
                seen = shown.copy()
            state = self._step(state, seen, violations)
            command = sf.Command.of(state["command"].copy())
            _, world = self.simulator.step(world, command)
            if world["fallen"][0]:
                return False, world, state
        return True, world, state

    def _step(self, state: Any, shown: NDArray[np.void], violations: NDArray[np.int64]) -> Any:
        command, state = self.controller.step(state, sf.Observation.of(shown))
        seen = state["validated"]["observation"].copy()
        _judge_one(self.limits, command.array, seen, violations)
        return state


def garbage(
    kind: str, count: int, rng: np.random.Generator, subject: Subject
) -> tuple[NDArray[np.int8], NDArray[np.float64], NDArray[np.int8], NDArray[np.int64]]:
    """Random changes of observations: modes (0 none, 1 replace, 2 add) and values of the numbers,
    and the same of the side (2 is the other one).

    Args:
        kind: one of `KINDS`.
        count: how many observations.
        rng: random numbers.
        subject: its robot scales the lengths.
    """
    width = FIELDS - 1
    modes, values = np.zeros((count, width), np.int8), np.zeros((count, width))
    side_modes, sides = np.zeros(count, np.int8), np.zeros(count, np.int64)
    rows, one = np.arange(count), rng.integers(0, width, count)
    sized = rng.choice((-1.0, 1.0), (count, width)) * 10.0 ** rng.uniform(-2.0, 1.0, (count, width))
    sized *= subject.controller.robot.hip * 5.0
    if kind == "bits":
        modes[:], side_modes[:] = 1, 1
        values = (
            np.frombuffer(rng.bytes(8 * count * width), np.float64).reshape(count, width).copy()
        )
        sides = np.frombuffer(rng.bytes(8 * count), np.int64).copy()
    elif kind == "special":
        modes[:] = rng.random((count, width)) < rng.uniform(0.05, 1.0, (count, 1))
        values = rng.choice(SPECIAL, (count, width))
        side_modes[:], sides = rng.random(count) < 0.3, rng.integers(-3, 4, count)
    elif kind == "field":
        modes[rows, one] = 1
        huge = rng.choice((-1.0, 1.0), count) * 10.0 ** rng.uniform(-4.0, 12.0, count)
        values[rows, one] = np.where(rng.random(count) < 0.5, rng.choice(SPECIAL, count), huge)
    elif kind == "jump":
        modes[rows, one] = 2
        values[rows, one] = sized[rows, one]
    elif kind == "jumps":
        modes[:], values = 2, sized
        side_modes[:] = 2 * (rng.random(count) < 0.2)
    elif kind == "contact":
        side_modes[:], sides = rng.choice((1, 2), count), rng.integers(-2, 3, count)
        elapsed = (OBSERVATION.fields or {})["elapsed"][1] // 8
        modes[:, elapsed] = rng.integers(0, 2, count)
        values[:, elapsed] = rng.uniform(0.0, 0.01, count)
    else:
        modes[:], side_modes[:] = 1, 1
        other = subject.truths[rng.integers(0, len(subject.truths), count)]
        values = other.view(np.float64).reshape(count, FIELDS)[:, :width].copy()
        sides = other["support_side"].copy()
    return modes, values, side_modes, sides


def fuzz(subject: Subject, observations: int, walks: int, seed: int = 0) -> Counts:
    """Test one controller.

    Args:
        subject: the controller.
        observations: how many, open loop.
        walks: how many with one corrupted cycle, and as many with 200.
        seed: of the random numbers.
    """
    rng, counts = np.random.default_rng(seed), Counts(subject.name)
    while counts.observations < observations:
        kind = KINDS[(counts.observations // SEQUENCE) % len(KINDS)]
        before, start = counts.violations.copy(), int(rng.integers(len(subject.states)))
        where = (start + np.arange(SEQUENCE)) % len(subject.states)
        edits = garbage(kind, SEQUENCE, rng, subject)
        subject.show(start, subject.truths[where], edits, counts.violations)
        counts.observations += SEQUENCE
        if (counts.violations != before).any():
            counts.examples.append(f"shown {kind} from {start}: {counts.violations - before}")
    for number in range(2 * walks):
        _corrupt(subject, KINDS[number // 2 % len(KINDS)], number % 2, rng, counts)
    return counts


def _corrupt(
    subject: Subject, kind: str, long: int, rng: np.random.Generator, counts: Counts
) -> None:
    """One walk with corrupted observations for one or 200 cycles."""
    start = int(rng.integers(len(subject.states)))
    cycles = LONG if long else 1
    # The same change in all cycles, or another in every cycle.
    edits = garbage(kind, 1 if rng.random() < 0.3 else cycles, rng, subject)
    before = counts.violations.copy()
    up, world, state = subject.walk(
        subject.states[start], subject.worlds[start], edits, cycles, cycles, counts.violations
    )
    counts.observations += cycles
    counts.walks[long] += 1
    ignored = np.zeros(len(COUNTED), np.int64)
    survived = up and subject.walk(state, world, edits, 0, subject.cycles, counts.violations)[0]
    if not survived and long:
        again = subject.controller.start(sf.Observation.of(world["observation"].copy()))
        possible = up and subject.walk(again, world, edits, 0, subject.cycles, ignored)[0]
        if not possible:
            counts.lost += 1
            counts.walks[1] -= 1
            counts.gone.append(f"{kind} for {cycles} from {start}, {len(edits[0])} drawn")
            return
    if not survived:
        counts.falls[long] += 1
        counts.examples.append(f"fell: {kind} for {cycles} from {start}, {len(edits[0])} drawn")
    if (counts.violations != before).any():
        counts.examples.append(
            f"walked {kind} for {cycles} from {start}: {counts.violations - before}"
        )


def subjects(names: Sequence[str] | None = None) -> list[Subject]:
    """Every method on the paper's biped, some on a leg of 3 m/s, and footholds.

    Args:
        names: only these.
    """
    robot = sf.load_robot("paper-biped")
    leg = robot.with_leg(max_speed=3.0, max_acceleration=60.0)
    made = [(one.key, one, robot) for one in methods()]
    made += [(f"{one.key}, leg", one, leg) for one in methods() if not one.fixed_steps]
    found = [
        Subject(name, one.controller(who, (0.3, 0.0)))
        for name, one, who in made
        if names is None or name in names
    ]
    if names is None or "footholds" in names:
        places = [
            sf.Foothold(side, 0.15 * k * (k > 0), -0.1 * side, 0.0, 0.5 * max(k, 0))
            for k, side in enumerate([sf.Side.LEFT, sf.Side.RIGHT] * 5, -1)
        ]
        found.append(Subject("footholds", sf.FootholdTracking(robot, places)))
    return found


def show(results: Sequence[Counts]) -> None:
    """Print the table."""
    table = Table(title="Forbidden commands and falls after corrupted observations")
    for head in ("method", "observations", *COUNTED, "fell after 1", f"fell after {LONG}", "lost"):
        table.add_column(head, justify="left" if head == "method" else "right")
    for one in results:
        table.add_row(
            one.method,
            str(one.observations),
            *(str(number) for number in one.violations),
            *(f"{fell} of {of}" for fell, of in zip(one.falls, one.walks, strict=True)),
            str(one.lost),
        )
    Console(width=150).print(table)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 1 if anything was counted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--observations", type=int, default=1_000_000, help="of all methods")
    parser.add_argument("--walks", type=int, default=400, help="of each compiled method")
    parser.add_argument("--slow-share", type=float, default=0.005, help="of those not compiled")
    parser.add_argument("--method", action="append", help="only this one; may be repeated")
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args(arguments)
    chosen_subjects = subjects(chosen.method)
    slow = [one for one in chosen_subjects if one.pointer is None]
    fast = max(len(chosen_subjects) - len(slow), 1)
    results = []
    for one in chosen_subjects:
        if one.pointer is not None:
            share, walks = (1.0 - chosen.slow_share * bool(slow)) / fast, chosen.walks
        else:
            # A decision takes milliseconds instead of less than a microsecond.
            share, walks = chosen.slow_share / len(slow), max(chosen.walks // 50, 2)
        results.append(fuzz(one, math.ceil(share * chosen.observations), walks, chosen.seed))
        for example in results[-1].examples[:5]:
            print(f"{one.name}: {example}", file=sys.stderr)
    show(results)
    print(f"{sum(one.observations for one in results)} observations in all")
    return 1 if any(one.total for one in results) else 0


if __name__ == "__main__":
    raise SystemExit(main())
