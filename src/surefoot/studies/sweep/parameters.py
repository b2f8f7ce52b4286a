"""The parameters that a sweep can set, by name, and what they make: controller, plant, push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from typing import Any

import msgspec

from surefoot.checks import check_number, closest
from surefoot.control.estimator import whole_cycles
from surefoot.control.fields import declared, setting
from surefoot.control.registry import find_method
from surefoot.control.settings import checked_settings, settings
from surefoot.dcm.pushes import Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.gait import GaitLimits, Swing
from surefoot.robot.robot import Foot, Robot, Trunk
from surefoot.rollout.disturbance import Disturbance
from surefoot.studies.engine.parameters import (
    PAIR,
    Parameter,
    chosen_pair,
    chosen_values,
    documented_parameters,
    method_parameters,
)

VELOCITY = (0.5, 0.0)
"""The usual command [m/s]."""

RANGES = ("step_duration", "step_x", "step_y")
"""Pairs of the gait that are a smallest and a largest value."""


@dataclass(frozen=True)
class PushSettings:
    """One push."""

    impulse: float = setting(0.0, "N s", "its size", least=0.0)
    angle: float = setting(
        0.0, "deg", "from forward (0) towards the foot that swings in the step of the push (90)"
    )
    phase: float = setting(0.0, "of the step", "part of that step before it begins", least=0.0)
    duration: float = setting(0.2, "s", "how long it lasts", above=0.0)
    step: int = setting(2, "", "which step that is, from 0", least=0.0)

    def __post_init__(self) -> None:
        for name, one in declared(type(self)).items():
            least = -math.inf if one.least is None else one.least
            check_number(
                f"push.{name}", getattr(self, name), least, one.unit or "-", above=one.excluded
            )
        if self.step != int(self.step):
            raise ParameterError(
                "`push.step` as a whole number", repr(self.step), "2 is usual: the third step"
            )


PUSH = {
    one.name: Parameter(one.name, one.metadata["setting"].unit, whole=one.type == "int")
    for one in fields(PushSettings)
}
BODY = documented_parameters(Robot)
PARTS = {
    name: documented_parameters(part)
    for name, part in (("foot", Foot), ("swing", Swing), ("trunk", Trunk))
}
LIMITS = {
    name: replace(one, parts=("min", "max")) if name in RANGES else one
    for name, one in documented_parameters(GaitLimits).items()
}
COMMAND = Parameter("velocity", "m/s", PAIR)
DISTURBANCE = documented_parameters(Disturbance)


@lru_cache(maxsize=32)
def parameters(controller: str) -> Mapping[str, Parameter]:
    """Everything that a study of this method can set, by name; pairs as wholes."""
    parts = {f"{part}.{name}": one for part, own in PARTS.items() for name, one in own.items()}
    rooms = {
        "robot": BODY | parts,
        "gait": LIMITS | {COMMAND.name: COMMAND},
        "plant": BODY | parts,
        "controller": method_parameters(controller),
        "push": PUSH,
        "disturbance": DISTURBANCE,
    }
    return {f"{room}.{name}": one for room, known in rooms.items() for name, one in known.items()}


def parameter(controller: str, name: str) -> Parameter | None:
    """A parameter of a study of this method, that of the whole for half of a pair, or None."""
    known = parameters(controller)
    whole, _, half = name.rpartition(".")
    if whole in known and half in known[whole].parts:
        return known[whole]
    return known.get(name)


def check_parameter(controller: str, name: str, origin: str) -> None:
    """Refuse a name that no study can use.

    Raises:
        ParameterError: there is no such method or parameter; the message names the nearest.
    """
    if parameter(controller, name) is not None:
        return
    known = list(parameters(controller))
    room = name.partition(".")[0]
    near = [one for one in known if one.startswith(f"{room}.")] or known
    raise ParameterError(
        f"a parameter of a study ({', '.join(near)})",
        f"`{name}` in {origin}",
        closest(name, known, "choose one of these"),
    )


@dataclass(frozen=True)
class Situation:
    """What one cell of a sweep is about.

    Attributes:
        controller: decides.
        plant: is moved.
        disturbance: of what is measured and of landings; None without any.
        push: that is made if it has an impulse.
    """

    controller: Controller
    plant: Robot
    disturbance: Disturbance | None
    push: PushSettings

    @property
    def elapsed(self) -> float:
        """From the touchdown of the step of the push to the push [s]."""
        return self.push.phase * float(self.controller.gait.step_duration)

    def start(self) -> float:
        """When the push begins [s]."""
        return (self.push.step + self.push.phase) * float(self.controller.gait.step_duration)

    @property
    def support_side(self) -> Side:
        """The foot that stands in the step of the push; in the first step it is the right one."""
        return Side.RIGHT if self.push.step % 2 == 0 else Side.LEFT

    def direction(self) -> tuple[float, float]:
        """Its unit vector (x, y), exact on the axes."""
        return push_direction(self.push.angle % 360.0, self.support_side)

    def made_push(self) -> Push | None:
        """The push, None if it has no impulse."""
        if self.push.impulse == 0.0:
            return None
        return Push.of_impulse(
            self.push.impulse, self.direction(), self.start(), self.push.duration
        )


def situation(robot: Robot, controller: str, values: Mapping[str, Any]) -> Situation:
    """What a cell is about.

    Args:
        robot: as its file says.
        controller: key of the method.
        values: by name; what is not named is as usual.

    Raises:
        SurefootError: a value has another type, is out of range, or makes a robot or a gait that
            there cannot be.
    """
    rooms: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        room, _, rest = name.partition(".")
        rooms.setdefault(room, {})[rest] = value
    gait = rooms.get("gait", {})
    velocity = chosen_pair("gait", COMMAND, gait, VELOCITY)
    known = _changed(robot, rooms.get("robot", {}), "robot")
    known = known.replace(gait=_struct(known.gait, "gait", LIMITS, gait))
    plant = _changed(known, rooms.get("plant", {}), "plant")
    chosen = chosen_values(
        "controller",
        method_parameters(controller),
        rooms.get("controller", {}),
        settings(controller),
    )
    decides = find_method(controller).controller(
        known, velocity, **checked_settings(controller, chosen)
    )
    disturbance = None
    if given := rooms.get("disturbance", {}):
        disturbance = Disturbance(
            **chosen_values("disturbance", DISTURBANCE, given, asdict(Disturbance()))
        )
        whole_cycles(disturbance.delay, decides.period)
    return Situation(decides, plant, disturbance, PushSettings(**rooms.get("push", {})))


def _changed(robot: Robot, given: Mapping[str, Any], room: str) -> Robot:
    changes = chosen_values(room, BODY, given, {})
    for part, known in PARTS.items():
        own = {name: given[f"{part}.{name}"] for name in known if f"{part}.{name}" in given}
        if not own:
            continue
        now = getattr(robot, part)
        if now is None:
            raise ParameterError(
                f"a robot with a [{part}]", f"`{room}.{part}` of {robot.name}, which has none",
                f"give its file a [{part}]",
            )  # fmt: skip
        changes[part] = _struct(now, f"{room}.{part}", known, own)
    for name, one in BODY.items():
        if name in changes:
            check_number(f"{room}.{name}", changes[name], 0.0, one.unit, above=True)
    return robot.replace(**changes) if changes else robot


def _struct(now: Any, room: str, known: Mapping[str, Parameter], given: Mapping[str, Any]) -> Any:
    """A copy of a part of the robot with some values changed, checked like a file."""
    changes = chosen_values(room, known, given, {name: getattr(now, name) for name in known})
    for name, value in changes.items():
        for one in value if isinstance(value, tuple) else (value,):
            check_number(f"{room}.{name}", one, -math.inf, known[name].unit, endless=True)
    return msgspec.structs.replace(now, **changes) if changes else now
