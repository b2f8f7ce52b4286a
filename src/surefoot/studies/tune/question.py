"""What a tuning asks: of which method on which robot, by which pushes, within which ranges.

The ranges are those that the fields of the method declare. A component of a pair is a parameter of
its own, `offset_weight.x`. Of weights that only count by their ratios one is left alone: the first
on the step vector.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any, ClassVar

from surefoot.checks import check_number, check_seed, closest
from surefoot.control.registry import methods
from surefoot.control.settings import searched, settings, with_settings
from surefoot.errors import ParameterError, SurefootError
from surefoot.robot.robot import Robot
from surefoot.studies.engine.parameters import (
    PAIR,
    Parameter,
    chosen_values,
    component,
    method_parameters,
)
from surefoot.studies.engine.pushed_walk import PushCell, PushedWalk, push_cells
from surefoot.studies.engine.study import Study, installed_version
from surefoot.studies.engine.table import Row
from surefoot.studies.tune.choice import PREFERENCES
from surefoot.studies.tune.measure import Pushed, Score, score

SMALL_SHARE = 0.1
"""A small push is this share of the smallest limit."""

STEP_SHARE = 0.02
"""The usual step of the scan over the impulse, as a share of the smallest limit."""

OF_THE_QUESTION = ("step_duration", "period")
"""Settings that change what is measured rather than how well it is answered."""

REFUSED = "refused"
"""The column that says why the controller refused the values of a cell."""


@dataclass(frozen=True)
class Cell:
    """Values of the parameters, and the pushes on which they are measured.

    Attributes:
        pushes: "seen" by the search, or "unseen".
        values: in the order of `Tuning.parameters`.
    """

    pushes: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Tuning(Study):
    """What is tuned, and by which pushes; which cells that makes, the search decides.

    Args:
        robot: who is pushed, with the speed limit that its leg is to have.
        velocity: commanded (v_x, v_y) [m/s].
        method: key of a control method with parameters to search.
        asked: these, `NAME` or `NAME=LOW:HIGH`; all usual ones if none.
        directions: of the pushes, evenly around.
        phases: of the pushes, evenly over a step.
        step: of the scan over the impulse, a share of the smallest limit [-].
        seed: of the search.
        trials: how many are tried, with those that are there already.
        prefer: what to take of the front, a key of `choice.PREFERENCES`.
        threads: all cores if None; their number changes nothing.

    Raises:
        ParameterError: an argument is out of range, or the method has no such parameters.
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the method cannot control this robot.
    """

    velocity: tuple[float, float] = (0.5, 0.0)
    method: str = "unified"
    asked: tuple[str, ...] = ()
    directions: int = 4
    phases: int = 2
    step: float = STEP_SHARE
    seed: int = 0
    trials: int = 100
    prefer: str = "survival"
    threads: int | None = None

    NAME: ClassVar = "tune"
    LIBRARIES: ClassVar = ("numpy", "numba", "optuna")

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_number("step", self.step, 0.0, "-", above=True)
        trials: Any = self.trials
        if isinstance(trials, bool) or not isinstance(trials, int) or trials < 1:
            raise ParameterError("`trials` of at least 1", repr(trials), "100 is usual")
        if self.threads is not None:
            check_number("threads", self.threads, 1.0, "-")
        if self.prefer not in PREFERENCES:
            raise ParameterError(
                f"a preference ({', '.join(PREFERENCES)})", repr(self.prefer), "choose one of these"
            )
        # A robot that the method cannot control is refused now, not in a trial.
        _ = self.parameters, self.defaults
        self.walk.check_leg()
        _ = self.pushes

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is searched, and within which range."""
        return chosen_parameters(self.method, self.asked, self.robot, self.velocity)

    @cached_property
    def defaults(self) -> dict[str, Any]:
        """All settings of the method where nothing is set."""
        return default_settings(self.method, self.robot, self.velocity)

    @cached_property
    def walk(self) -> PushedWalk:
        """What is pushed."""
        return PushedWalk(self.robot, self.velocity)

    @cached_property
    def pushes(self) -> dict[str, tuple[Pushed, ...]]:
        """Those that the search sees, and others half-way between them."""
        seen = push_cells(self.directions, self.phases)
        turn, later = 180.0 / self.directions, 0.5 / self.phases
        unseen = [replace(one, angle=one.angle + turn, phase=one.phase + later) for one in seen]
        return {"seen": self._with_limits(seen), "unseen": self._with_limits(unseen)}

    def _with_limits(self, cells: Sequence[PushCell]) -> tuple[Pushed, ...]:
        return tuple(Pushed(one, self.walk.limits(one)["limit_finite"]) for one in cells)

    @property
    def scan_step(self) -> float:
        """Of the scan over the impulse [N s]."""
        return self._share_of_smallest_limit(self.step)

    @property
    def impulse(self) -> float:
        """Of the small pushes [N s]."""
        return self._share_of_smallest_limit(SMALL_SHARE)

    def _share_of_smallest_limit(self, share: float) -> float:
        return float(f"{share * min(one.limit for one in self.pushes['seen']):.2g}")

    @property
    def start(self) -> dict[str, float]:
        """The default of every parameter."""
        return {one.name: component(self.defaults, one.name) for one in self.parameters}

    def settings(self, values: Mapping[str, float]) -> dict[str, Any]:
        """What is not as by default with these values of the parameters."""
        return changed_settings(self.method, values, self.defaults)

    def cell(self, values: Mapping[str, float], pushes: str = "seen") -> Cell:
        """The cell of these values of the parameters."""
        return Cell(pushes, tuple(values[one.name] for one in self.parameters))

    def columns(self, cell: Cell) -> Row:
        """See `Study`."""
        names = (f"controller.{one.name}" for one in self.parameters)
        return {"pushes": cell.pushes, **dict(zip(names, cell.values, strict=True))}

    def measure(self, cell: Cell) -> Row:
        """How the method does: the numbers of a `Score`, or why it refuses the values."""
        names = (one.name for one in self.parameters)
        changed = self.settings(dict(zip(names, cell.values, strict=True)))
        try:
            controller = with_settings(self.method, self.robot, self.velocity, changed)
        except SurefootError as error:
            return {one.name: None for one in fields(Score)} | {REFUSED: str(error)}
        found = score(
            controller, self.walk, self.pushes[cell.pushes], self.impulse, self.scan_step,
            workers=self.threads,
        )  # fmt: skip
        return asdict(found) | {REFUSED: None}

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return {
            "velocity": list(self.velocity),
            "method": self.method,
            "parameters": [[one.name, one.low, one.high] for one in self.parameters],
            "directions": self.directions,
            "phases": self.phases,
            "step": self.step,
            "seed": self.seed,
            "optuna": installed_version("optuna"),
        }

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        swing, pushed = self.robot.swing, self.pushes["seen"][0].cell
        return {
            "velocity": f"{self.velocity[0]:g}, {self.velocity[1]:g} m/s",
            "leg": f"{swing.max_speed:g} m/s, {swing.max_acceleration:g} m/s^2",
            "controller": self.method,
            "pushes": f"{self.directions} directions, {self.phases} phases of the step, "
            f"{pushed.push_duration:g} s long",
            "scan": f"in steps of {self.scan_step:g} N s",
            "small push": f"{self.impulse:g} N s",
            "trials": f"{self.trials}",
            "seed": f"{self.seed}",
            "preferred": self.prefer,
        }


def usual_parameters(key: str) -> tuple[Parameter, ...]:
    """What is searched in a method unless another choice is made.

    Raises:
        ParameterError: no such method.
    """
    return tuple(_within(key, name, *ends) for name, ends in searched(key).items())


def _within(key: str, name: str, low: float, high: float) -> Parameter:
    """A setting of a method, or a component of one, with the interval in which it is searched."""
    known = method_parameters(key)[name.partition(".")[0]]
    return replace(known, name=name, parts=(), low=low, high=high)


def chosen_parameters(
    key: str, asked: Iterable[str], robot: Robot, velocity: tuple[float, float]
) -> tuple[Parameter, ...]:
    """The parameters that are to be searched.

    Args:
        key: of the method.
        asked: `NAME` or `NAME=LOW:HIGH`; only these are searched. The usual ones if none.
        robot: whose defaults count.
        velocity: of its gait [m/s].

    Raises:
        ParameterError: a method without parameters to search, an unknown one, or a range that is
            none or leaves out the default.
    """
    usual = {one.name: one for one in usual_parameters(key)}
    texts = list(asked)
    if not usual:
        able = [one.key for one in methods() if usual_parameters(one.key)]
        raise ParameterError(
            f"a compiled method with gains ({', '.join(able)})",
            repr(key),
            "choose one of these; a slow method takes too long to be tried often",
        )
    if not texts:
        return tuple(usual.values())
    defaults = default_settings(key, robot, velocity)
    possible = [*usual, *(name for name in _numbers(defaults) if name not in usual)]
    found = [_parsed(key, text, usual, possible) for text in texts]
    names = [one.name for one in found]
    if len(set(names)) < len(names):
        raise ParameterError("every --knob once", ", ".join(names), "leave the second one out")
    for one in found:
        value = component(defaults, one.name)
        if not one.low <= value <= one.high:
            raise ParameterError(
                f"a range of `{one.name}` with its default {value:g} in it, where the search "
                "begins",
                f"{one.low:g}:{one.high:g}",
                "widen the range",
            )
    return tuple(found)


def default_settings(key: str, robot: Robot, velocity: tuple[float, float]) -> dict[str, Any]:
    """What a method has where nothing is set: some of it follows from the robot and its gait.

    Raises:
        SurefootError: the method cannot control this robot.
    """
    made = with_settings(key, robot, velocity, {})
    return {name: getattr(made, name) for name in settings(key)}


def changed_settings(
    key: str, values: Mapping[str, float], defaults: Mapping[str, Any]
) -> dict[str, Any]:
    """The settings of a method that differ from its defaults, with parameters at these values."""
    changed = {name: one for name, one in values.items() if one != component(defaults, name)}
    return chosen_values("controller", method_parameters(key), changed, defaults)


def _numbers(defaults: Mapping[str, Any]) -> list[str]:
    """The names of everything that is a number, and no part of the question."""
    names = []
    for name, value in defaults.items():
        if name in OF_THE_QUESTION:
            continue
        if isinstance(value, tuple) and len(value) == len(PAIR):
            names += [f"{name}.{part}" for part in PAIR]
        elif isinstance(value, float):
            names.append(name)
    return names


def _parsed(key: str, text: str, usual: Mapping[str, Parameter], possible: list[str]) -> Parameter:
    name, given, ends = text.partition("=")
    if name not in possible:
        raise ParameterError(
            f"a knob ({', '.join(possible)})",
            repr(name),
            closest(name, possible, "choose one of these"),
        )
    if given:
        return _within(key, name, *_interval(text, ends))
    if name not in usual:
        raise ParameterError(
            f"a range for `{name}`, which has none of its own",
            repr(text),
            f"write --knob {name}=LOW:HIGH",
        )
    return usual[name]


def _interval(text: str, ends: str) -> tuple[float, float]:
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        low = high = math.nan
    if not (math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high):
        raise ParameterError(
            "NAME=LOW:HIGH with two numbers, 0 <= LOW < HIGH",
            repr(text),
            "write for example --knob dcm_gain=1:30",
        )
    return low, high
