"""What a comparison of methods measured, as checked values, and what follows from it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from functools import cached_property
from typing import Any

from surefoot.errors import ParameterError

FAILURES = ("fell", "unsettled", "none")
"""What happened at the smallest failing impulse."""

DIRECTIONS = {"forward": 0.0, "outward": 90.0, "back": 180.0, "inward": 270.0}
"""Angle of a push [deg]; outward is towards the swing foot."""


@dataclass(frozen=True)
class Cell:
    """One scan of the impulse upwards: one method, direction, phase, duration and leg speed.

    Attributes:
        method: key of the method.
        angle: direction of the push [deg].
        phase: fraction of the step at which the push starts.
        push_duration: how long it lasts [s].
        leg_speed: largest speed of the swing foot, inf if unlimited [m/s].
        impulse: the smallest that fails, inf if none up to `scanned` does [N s].
        delta_v: impulse / mass [m/s].
        step: distance between neighbouring impulses [N s].
        scanned: the largest impulse that was tried [N s].
        failure: one of `FAILURES`.
        limit_point: the largest impulse that any policy could survive on a point foot [N s].
        limit_finite: the same on the robot's foot [N s].
        limit_fixed: the same with fixed steps, by the ZMP alone [N s].
        limit_causal: `limit_finite` of those who do not know when the push ends, nan in what was
            measured before it was computed [N s].
    """

    method: str
    angle: float
    phase: float
    push_duration: float
    leg_speed: float
    impulse: float
    delta_v: float
    step: float
    scanned: float
    failure: str
    limit_point: float
    limit_finite: float
    limit_fixed: float
    limit_causal: float = math.nan

    @property
    def condition(self) -> tuple[float, float, float, float]:
        """Leg speed, push duration, phase and angle."""
        return (self.leg_speed, self.push_duration, self.phase, self.angle)

    @property
    def unbroken(self) -> bool:
        """Whether nothing that was tried failed: what it survives is at least `survived`."""
        return math.isinf(self.impulse)

    @property
    def survived(self) -> float:
        """The largest impulse below which every push was survived [N s]."""
        return self.scanned if self.unbroken else max(self.impulse - self.step, 0.0)

    @property
    def fraction(self) -> float:
        """Of the limit, at most 1; nan where there is nothing to be survived."""
        if self.limit_finite == 0.0:
            return math.nan
        return min(self.survived / self.limit_finite, 1.0)

    @property
    def causal_fraction(self) -> float:
        """Of the limit of those who do not know when the push ends, likewise."""
        if self.limit_causal == 0.0:
            return math.nan
        return min(self.survived / self.limit_causal, 1.0)


@dataclass(frozen=True)
class Method:
    """A method that was measured.

    Attributes:
        key: its name in the cells.
        label: its name in words.
        source: where it was published.
        adapts: what it adapts.
        cannot: which of the given freedoms it cannot use.
        decision_p50: median time of a control cycle, nan if not measured [s].
        decision_p99_9: the time that 999 of 1000 cycles keep, nan if not measured [s].
        period: of the control cycle [s].
    """

    key: str
    label: str
    source: str
    adapts: str
    cannot: str
    decision_p50: float
    decision_p99_9: float
    period: float


@dataclass(frozen=True)
class Score:
    """What some cells of one method come to.

    Attributes:
        mean: mean fraction of the limit, nan without cells.
        worst: smallest fraction, nan without cells.
        causal: mean fraction of the limit of those who do not know when the push ends, or nan.
        at_least: whether a scan ended before anything failed, so that the mean is a lower bound.
        cells: how many were measured.
        possible: how many were measured by any method.
        fell: in how many the smallest failing push made it fall.
        unsettled: in how many it kept walking, but did not settle.
        unbroken: in how many nothing failed.
    """

    mean: float
    worst: float
    causal: float
    at_least: bool
    cells: int
    possible: int
    fell: int
    unsettled: int
    unbroken: int

    @property
    def complete(self) -> bool:
        """Whether the mean stands on every cell that any method was measured on."""
        return self.cells == self.possible


@dataclass(frozen=True)
class Comparison:
    """A comparison of methods; made by `comparison`, which checks it.

    Attributes:
        cells: everything that was measured.
        methods: in order of display.
        provenance: how and where it was measured, in words.
    """

    cells: tuple[Cell, ...]
    methods: tuple[Method, ...]
    provenance: Mapping[str, str]

    @cached_property
    def angles(self) -> tuple[float, ...]:
        """Directions that were measured [deg]."""
        return tuple(sorted({cell.angle for cell in self.cells}))

    @cached_property
    def phases(self) -> tuple[float, ...]:
        """Fractions of the step at which pushes started."""
        return tuple(sorted({cell.phase for cell in self.cells}))

    @cached_property
    def push_durations(self) -> tuple[float, ...]:
        """How long pushes lasted [s]."""
        return tuple(sorted({cell.push_duration for cell in self.cells}))

    @cached_property
    def leg_speeds(self) -> tuple[float, ...]:
        """Largest speeds of the swing foot [m/s]."""
        return tuple(sorted({cell.leg_speed for cell in self.cells}))

    def select(self, **choice: Any) -> list[Cell]:
        """The cells whose values are those chosen, such as `leg_speed=3.0`."""
        return [
            cell
            for cell in self.cells
            if all(getattr(cell, name) == value for name, value in choice.items())
        ]

    def score(self, method: Method, cells: Iterable[Cell]) -> Score:
        """What some cells come to for one method.

        Args:
            method: the method.
            cells: cells of any methods, among them those that it is measured against.
        """
        cells = list(cells)
        own = [cell for cell in cells if cell.method == method.key]
        fractions = [cell.fraction for cell in own if cell.limit_finite > 0.0]
        causal = [cell.causal_fraction for cell in own if cell.limit_causal != 0.0]
        return Score(
            mean=math.fsum(fractions) / len(fractions) if fractions else math.nan,
            worst=min(fractions, default=math.nan),
            causal=math.fsum(causal) / len(causal) if causal else math.nan,
            at_least=any(cell.unbroken and cell.fraction < 1.0 for cell in own),
            cells=len(own),
            possible=len({cell.condition for cell in cells}),
            fell=sum(cell.failure == "fell" for cell in own),
            unsettled=sum(cell.failure == "unsettled" for cell in own),
            unbroken=sum(cell.unbroken for cell in own),
        )


@dataclass(frozen=True)
class Choice:
    """The push that a table or a picture shows in single numbers.

    Attributes:
        leg_speed: largest speed of the swing foot [m/s].
        push_duration: how long the push lasts [s].
        phase: fraction of the step at which it starts.
    """

    leg_speed: float
    push_duration: float
    phase: float


def choose(
    measured: Comparison,
    *,
    leg_speed: float | None = None,
    push_duration: float | None = None,
    phase: float | None = None,
) -> Choice:
    """A choice among what was measured; what is left out is the value closest to the usual one.

    The usual: a leg of 3 m/s, pushes of 0.2 s, from the middle of a step.

    Raises:
        ParameterError: nothing was measured there.
    """
    return Choice(
        leg_speed=_pick("leg_speed", leg_speed, measured.leg_speeds, 3.0),
        push_duration=_pick("push_duration", push_duration, measured.push_durations, 0.2),
        phase=_pick("phase", phase, measured.phases, 0.5),
    )


def comparison(
    rows: Sequence[Mapping[str, Any]],
    methods: Sequence[Mapping[str, Any]],
    provenance: Mapping[str, str],
) -> Comparison:
    """Check what was measured.

    Args:
        rows: one for each cell, with the attributes of `Cell` as keys.
        methods: in order of display, with the attributes of `Method` as keys.
        provenance: how and where it was measured, in words.

    Raises:
        ParameterError: a key is missing or unknown, a value is impossible, a cell comes twice, or
            the limits of one push differ from method to method.
    """
    if not rows or not methods:
        raise ParameterError(
            "rows and methods", f"{len(rows)} rows, {len(methods)} methods", "measure something"
        )
    known = tuple(_made(Method, entry, "method") for entry in methods)
    cells = tuple(_made(Cell, row, "row") for row in rows)
    keys = [method.key for method in known]
    limits: dict[tuple[float, ...], tuple[float | str, ...]] = {}
    seen: set[tuple[Any, ...]] = set()
    for key in keys:
        if keys.count(key) > 1:
            raise ParameterError("each method once", f"{key!r} more than once", "leave one out")
    for cell in cells:
        _check_cell(cell, keys)
        if (cell.method, cell.condition) in seen:
            raise ParameterError("each cell once", f"{cell!r} again", "leave one out")
        seen.add((cell.method, cell.condition))
        own = (cell.limit_point, cell.limit_finite, cell.limit_fixed, str(cell.limit_causal))
        if limits.setdefault(cell.condition, own) != own:
            raise ParameterError(
                "the same limits for every method",
                f"{own} and {limits[cell.condition]} for the same push",
                "compute them once for each push",
            )
    return Comparison(cells, known, dict(provenance))


def _made(kind: type, entry: Mapping[str, Any], name: str) -> Any:
    wanted = {field.name for field in fields(kind)}
    optional = {field.name for field in fields(kind) if field.default is not MISSING}
    if set(entry) | optional != wanted:
        raise ParameterError(
            f"a {name} with the keys {', '.join(field.name for field in fields(kind))}",
            f"missing {sorted(wanted - optional - set(entry))}, "
            f"unknown {sorted(set(entry) - wanted)}",
            "give exactly these",
        )
    return kind(**{key: _plain(value) for key, value in entry.items()})


def _plain(value: Any) -> Any:
    """A number of NumPy as one of Python."""
    return value if isinstance(value, (str, int, float)) else float(value)


def _check_cell(cell: Cell, keys: Sequence[str]) -> None:
    ranges: dict[str, tuple[bool, str]] = {
        "method": (cell.method in keys, f"one of {', '.join(keys)}"),
        "angle": (0.0 <= cell.angle < 360.0, "in [0, 360) deg"),
        "phase": (0.0 <= cell.phase < 1.0, "in [0, 1)"),
        "push_duration": (0.0 < cell.push_duration < math.inf, "above 0 s and finite"),
        "leg_speed": (cell.leg_speed > 0.0, "above 0 m/s"),
        "impulse": (cell.impulse >= 0.0, "of at least 0 N s, inf if nothing failed"),
        "delta_v": (cell.delta_v >= 0.0, "of at least 0 m/s, inf if nothing failed"),
        "step": (0.0 < cell.step < math.inf, "above 0 N s and finite"),
        "scanned": (0.0 <= cell.scanned < math.inf, "of at least 0 N s and finite"),
        "failure": (cell.failure in FAILURES, f"one of {', '.join(FAILURES)}"),
        "limit_point": (0.0 <= cell.limit_point < math.inf, "of at least 0 N s and finite"),
        "limit_finite": (0.0 <= cell.limit_finite < math.inf, "of at least 0 N s and finite"),
        "limit_causal": (not cell.limit_causal < 0.0, "of at least 0 N s, nan if not computed"),
        "limit_fixed": (0.0 <= cell.limit_fixed < math.inf, "of at least 0 N s and finite"),
    }
    for name, (good, expected) in ranges.items():
        if not good:
            raise ParameterError(
                f"`{name}` {expected}", repr(getattr(cell, name)), "correct the row that says so"
            )
    if cell.unbroken != (cell.failure == "none"):
        raise ParameterError(
            "an infinite `impulse` exactly where `failure` is none",
            f"impulse {cell.impulse!r} and failure {cell.failure!r}",
            "correct the row that says so",
        )


def _pick(name: str, value: float | None, measured: Sequence[float], usual: float) -> float:
    if value is None:
        finite = [candidate for candidate in measured if math.isfinite(candidate)]
        return min(finite or measured, key=lambda candidate: abs(candidate - usual))
    if value not in measured:
        raise ParameterError(
            f"`{name}` that was measured: {', '.join(f'{known:g}' for known in measured)}",
            repr(value),
            "choose one of these",
        )
    return value
