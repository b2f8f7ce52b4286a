"""What is asked of bodies: how much push each method survives, and what a body walks through."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import product
from types import MappingProxyType
from typing import Any, ClassVar

import msgspec

from surefoot.checks import check_number
from surefoot.dcm.pushes import DIRECTIONS
from surefoot.robot.feet import FEET
from surefoot.studies.compare.body_measure import measure_push, measure_walk
from surefoot.studies.engine.pushed_body import (
    BODY_METHODS,
    FIRST_PUSHED_STEP,
    PUSH_DURATION,
    TIME_AFTER_PUSH,
    BodyMethod,
    PushedBody,
    body_method,
    controller_of,
    mechanism_of,
    noise_of,
)
from surefoot.studies.engine.pushed_walk import (
    MethodStudy,
    check_count,
    check_different,
    find_named,
)
from surefoot.studies.engine.table import Row
from surefoot.worlds.body.gait import body_control
from surefoot.worlds.body.mapping import USUAL_MAPPING, check_mapping
from surefoot.worlds.body.plant import Surroundings
from surefoot.worlds.body.sensors import BodyNoise


@dataclass(frozen=True)
class BodyPush:
    """One limit: the smallest impulse that a method does not survive in one situation.

    Attributes:
        method: its key.
        direction: one of `dcm.pushes.DIRECTIONS`.
        phase: when the push begins, as a fraction of the step.
        foot: that stands then, "left" or "right".
    """

    method: str
    direction: str
    phase: float
    foot: str


@dataclass(frozen=True)
class BodyStudy(MethodStudy):
    """What studies of bodies share: the robot has a `[body]`, the methods are those of
    `body_method`.

    Args, beside those of `MethodStudy`:
        mapping: what moves the joints, see `worlds.body.mapping`.
    """

    velocity: tuple[float, float] = (0.3, 0.0)
    methods: tuple[str, ...] = tuple(one.key for one in BODY_METHODS)
    mapping: str = USUAL_MAPPING

    KEEP_EVERY: ClassVar = 0.0
    LIBRARIES: ClassVar = ("mujoco", "daqp", "numpy", "numba")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_mapping(self.mapping)

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return super().common() | {"mapping": self.mapping}

    def method(self, key: str) -> BodyMethod:
        """See `MethodStudy`."""
        return body_method(key)

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        return {
            "robot file": hashlib.sha256(msgspec.json.encode(self.robot)).hexdigest()[:16],
            **super().provenance(),
            "mass": f"{mechanism_of(self.robot).mass:.4g} kg",
            "joints": self.mapping,
        }

    def check(self) -> None:
        """Refuse a method that cannot control this robot."""
        for key in self.methods:
            controller_of(self.robot, key, self.velocity)


@dataclass(frozen=True)
class BodyPushes(BodyStudy):
    """How much push each method survives on a body.

    Args, beside those of `BodyStudy`:
        phases: how many, evenly over a step.
        step: of the scan over the impulse [N s].
        largest: where a scan gives up, over the mass [m/s].
        estimate: whether the control is given an estimate from sensors with the usual noise; else
            the truth.
    """

    phases: int = 8
    step: float = 2.0
    largest: float = 3.0
    estimate: bool = False

    NAME: ClassVar = "pushes"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number("step", self.step, 0.0, "N s", above=True)
        check_number("largest", self.largest, 0.0, "m/s", above=True)
        check_count("phases", self.phases, 8)

    @property
    def mass(self) -> float:
        """That Δv is of [kg]."""
        return mechanism_of(self.robot).mass

    def cells(self) -> Iterator[BodyPush]:
        """Everything that is to be measured; what shares a walk to the push is together."""
        for key, foot, phase, direction in product(
            self.methods, FEET, range(self.phases), DIRECTIONS
        ):
            yield BodyPush(key, direction, phase / self.phases, foot)

    def walk(self, cell: BodyPush) -> PushedBody:
        """The walk that is pushed in a cell."""
        return PushedBody(
            self.robot, cell.method, cell.foot, cell.phase, self.velocity, self.estimate,
            self.mapping,
        )  # fmt: skip

    def cell(self, row: Row) -> BodyPush:
        """The cell of a row."""
        return BodyPush(**{one.name: row[one.name] for one in fields(BodyPush)})

    def impulses(self) -> list[float]:
        """What is tried, from nothing upwards [N s]."""
        return [self.step * k for k in range(math.floor(self.largest * self.mass / self.step) + 1)]

    def measure(self, cell: BodyPush) -> Row:
        """See `measure_push`."""
        found = measure_push(self.walk(cell), cell.direction, self.impulses())
        return found | {"step": self.step}

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return super().common() | {
            "step": self.step,
            "largest": self.largest,
            "estimate": self.estimate,
            "noise": repr(noise_of(self.robot, self.estimate)),
            "push_duration": PUSH_DURATION,
            "recovery_time": TIME_AFTER_PUSH,
            "pushed_step": FIRST_PUSHED_STEP,
        }

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        noise = noise_of(self.robot, self.estimate)
        return {
            **super().provenance(),
            "push": f"{PUSH_DURATION:g} s on the base; {TIME_AFTER_PUSH:g} s of walking after it",
            "scan": f"{self.step:g} N s, upwards from 0 to {self.largest:g} m/s",
            "phases": f"{self.phases}, in steps of both feet",
            "state": f"estimated from {noise}" if self.estimate else "the truth",
        }

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """`key`, `label` and `adapts` of each method; mass [kg] and step of the scans [N s]."""
        methods = _named(map(body_method, self.methods), "key", "label", "adapts")
        return {"methods": methods, "mass": self.mass, "step": self.step}


USUAL = "usual-noise"
"""The key of the disturbance that is nothing but the usual noise of every sensor."""

SILENT = dict.fromkeys(("encoder", "rate", "gyro", "accelerometer", "gyro_bias", "force"), 0.0)
"""Parameters of a `BodyNoise` that is none."""

_NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class BodyDisturbance:
    """A disturbance of a body's sensors, of the body itself and of its floor.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        sensors: parameters of `BodyNoise`; the others are usual.
        world: parameters of `Surroundings`; the others are usual.
    """

    key: str
    label: str
    sensors: Mapping[str, float] = field(default_factory=lambda: _NOTHING)
    world: Mapping[str, float] = field(default_factory=lambda: _NOTHING)

    def noise(self, seed: int) -> BodyNoise:
        """Of the sensors."""
        return BodyNoise(**self.sensors, seed=seed)

    def surroundings(self, seed: int) -> Surroundings:
        """What the body stands on and carries."""
        return Surroundings(**self.world, seed=seed)


def _only(key: str, label: str, *names: str) -> BodyDisturbance:
    """The usual noise of some sensors alone."""
    usual = BodyNoise()
    return BodyDisturbance(key, label, SILENT | {name: getattr(usual, name) for name in names})


_DELAY, _HEAVY, _LOAD = {"delay": 0.005}, {"mass_factor": 1.1}, {"payload": 10.0}
_SMOOTH, _BUMPS = {"friction": 0.4}, {"bumps": 0.01}

BODY_DISTURBANCES = (
    BodyDisturbance(USUAL, "usual noise of all sensors"),
    _only("joint-noise", "joint angles 1 mrad only", "encoder"),
    _only("velocity-noise", "joint velocities 0.1 rad/s only", "rate"),
    _only("imu-noise", "inertial unit only", "gyro", "gyro_bias", "accelerometer"),
    BodyDisturbance("force-noise", "forces on the soles 5 N", {"force": 5.0}),
    BodyDisturbance("delay-5ms", "delay 5 ms", _DELAY),
    BodyDisturbance("mass+10%", "mass 10 % more", world=_HEAVY),
    BodyDisturbance("mass-10%", "mass 10 % less", world={"mass_factor": 0.9}),
    BodyDisturbance("payload-10kg", "payload 10 kg", world=_LOAD),
    BodyDisturbance("friction-0.4", "friction 0.4", world=_SMOOTH),
    BodyDisturbance("friction-0.6", "friction 0.6", world={"friction": 0.6}),
    BodyDisturbance("friction-1.0", "friction 1.0", world={"friction": 1.0}),
    BodyDisturbance("bumps-10mm", "bumps of 10 mm", world=_BUMPS),
    BodyDisturbance("all-at-once", "all at once", _DELAY, _HEAVY | _LOAD | _SMOOTH | _BUMPS),
)
"""In the order in which they are shown; all but the single ones on top of the usual noise."""


def body_disturbance(key: str) -> BodyDisturbance:
    """A disturbance by its name on the command line.

    Raises:
        ParameterError: there is none of that name.
    """
    return find_named("a disturbance of a body", BODY_DISTURBANCES, key)


def conditions_named(keys: Sequence[str]) -> tuple[str, ...]:
    """What was named after the usual noise, or everything for "all"."""
    if "all" in keys:
        return tuple(one.key for one in BODY_DISTURBANCES)
    return tuple(dict.fromkeys((USUAL, *keys)))


@dataclass(frozen=True)
class WalkCell:
    """One walk.

    Attributes:
        method: its key.
        condition: key of the disturbance.
        seed: of noise and bumps.
    """

    method: str
    condition: str
    seed: int


@dataclass(frozen=True)
class BodyWalks(BodyStudy):
    """How well each method walks a body on what its sensors measure, while it is disturbed.

    Args, beside those of `BodyStudy`:
        conditions: keys of `BODY_DISTURBANCES`.
        seeds: how many, from 0 on.
        duration: of a walk [s].
    """

    methods: tuple[str, ...] = ("unified",)
    conditions: tuple[str, ...] = tuple(one.key for one in BODY_DISTURBANCES)
    seeds: int = 3
    duration: float = 20.0

    NAME: ClassVar = "walks"

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in self.conditions:
            body_disturbance(key)
        check_number("duration", self.duration, 0.0, "s", above=True)
        check_count("seeds", self.seeds, 3)
        check_different("conditions", self.conditions)

    def cells(self) -> Iterator[WalkCell]:
        """Every walk."""
        for key, condition, seed in product(self.methods, self.conditions, range(self.seeds)):
            yield WalkCell(key, condition, seed)

    def measure(self, cell: WalkCell) -> Row:
        """See `measure_walk`."""
        disturbance = body_disturbance(cell.condition)
        return measure_walk(
            body_control(
                controller_of(self.robot, cell.method, self.velocity),
                mechanism_of(self.robot),
                self.mapping,
            ),
            self.duration,
            disturbance.surroundings(cell.seed),
            disturbance.noise(cell.seed),
        )

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return super().common() | {"duration": self.duration}

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        return {
            **super().provenance(),
            "walks": f"{self.duration:g} s from a stand, {self.seeds} seeds",
            "state": "estimated from its sensors",
        }

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """`key` and `label` of each method and condition."""
        return {
            "methods": _named(map(body_method, self.methods), "key", "label"),
            "conditions": _named(map(body_disturbance, self.conditions), "key", "label"),
        }


def _named(several: Iterable[Any], *names: str) -> list[dict[str, str]]:
    return [{name: getattr(one, name) for name in names} for one in several]
