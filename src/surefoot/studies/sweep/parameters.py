"""The parameters that a sweep can set, by name, and what they make: controller, plant, push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, is_dataclass
from functools import lru_cache
from typing import Any

import msgspec

from surefoot.checks import check_number, closest
from surefoot.control.estimator import whole_cycles
from surefoot.control.fields import declared
from surefoot.control.registry import find_method
from surefoot.control.settings import checked_settings, settings
from surefoot.dcm.pushes import Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance

VELOCITY = (0.5, 0.0)
"""The usual command [m/s]."""

_RANGE, _PAIR = ("min", "max"), ("x", "y")


@dataclass(frozen=True)
class Parameter:
    """What a sweep can set.

    Attributes:
        unit: of its values, empty for a pure number.
        halves: how the halves of a pair are called, none of a single value.
        whole: whether it is a whole number.
        usual: of a push, its value where nothing is set.
        least: of a push, the smallest value.
        above: whether that is too small itself.
    """

    unit: str
    halves: tuple[str, ...] = ()
    whole: bool = False
    usual: Any = None
    least: float = 0.0
    above: bool = False


PUSH = {
    "impulse": Parameter("N s", usual=0.0),
    "angle": Parameter("deg", usual=0.0, least=-math.inf),
    "phase": Parameter("of the step", usual=0.0),
    "duration": Parameter("s", usual=0.2, above=True),
    "step": Parameter("", whole=True, usual=2),
}
"""A push: its impulse; its direction from forward (0) towards the foot that swings in the step of
the push (90); the phase of that step in which it begins; how long it lasts; which step that is,
from 0."""

BODY = {
    "mass": Parameter("kg"),
    "com_height": Parameter("m"),
    "hip": Parameter("m"),
    "gravity": Parameter("m/s^2"),
}
PARTS = {
    "foot": {"length": Parameter("m"), "width": Parameter("m")},
    "swing": {
        "height": Parameter("m"),
        "landing_velocity": Parameter("m/s"),
        "max_speed": Parameter("m/s"),
        "max_acceleration": Parameter("m/s^2"),
    },
    "trunk": {
        "inertia": Parameter("kg m^2"),
        "max_torque": Parameter("N m"),
        "max_lean": Parameter("rad"),
    },
}
"""Of the robot and of its parts, and of the plant, which is the robot that is really moved."""

GAIT = {
    "step_duration": Parameter("s", _RANGE),
    "step_x": Parameter("m", _RANGE),
    "step_y": Parameter("m", _RANGE),
    "dcm_offset": Parameter("m", _PAIR),
    "velocity": Parameter("m/s", _PAIR),
}
"""The limits of a step, and the command."""

DISTURBANCE = {
    "dcm_noise": Parameter("m"),
    "velocity_noise": Parameter("m/s"),
    "delay": Parameter("s"),
    "com_offset": Parameter("m", _PAIR),
    "landing_error": Parameter("m"),
    "touchdown_shift": Parameter("s"),
    "seed": Parameter("", whole=True),
}
"""As of `Disturbance`."""


@lru_cache(maxsize=32)
def parameters(controller: str) -> Mapping[str, Parameter]:
    """Everything that a study of this method can set, by name; pairs as wholes."""
    parts = {f"{part}.{name}": one for part, own in PARTS.items() for name, one in own.items()}
    rooms = {
        "robot": BODY | parts,
        "gait": GAIT,
        "plant": BODY | parts,
        "controller": _of_method(controller),
        "push": PUSH,
        "disturbance": DISTURBANCE,
    }
    return {f"{room}.{name}": one for room, known in rooms.items() for name, one in known.items()}


def _of_method(key: str) -> dict[str, Parameter]:
    make = find_method(key).make
    known = declared(make) if is_dataclass(make) else {}
    return {
        name: Parameter(
            known[name].unit if name in known else "",
            _PAIR if isinstance(usual, tuple) and len(usual) == 2 else (),
        )
        for name, usual in settings(key).items()
    }


def parameter(controller: str, name: str) -> Parameter | None:
    """A parameter of a study of this method, that of the whole for half of a pair, or None."""
    known = parameters(controller)
    whole, _, half = name.rpartition(".")
    if whole in known and half in known[whole].halves:
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
        disturbance: of what is seen and of landings; None without any.
        push: the numbers of `PUSH`.
    """

    controller: Controller
    plant: Robot
    disturbance: Disturbance | None
    push: dict[str, float]

    def start(self) -> float:
        """When the push begins [s]."""
        duration = float(self.controller.gait.step_duration)
        return (self.push["step"] + self.push["phase"]) * duration

    @property
    def support_side(self) -> Side:
        """The foot that stands in the step of the push; in the first step it is the right one."""
        return Side.RIGHT if self.push["step"] % 2 == 0 else Side.LEFT

    def direction(self) -> tuple[float, float]:
        """Its unit vector (x, y), exact on the axes."""
        return push_direction(self.push["angle"] % 360.0, self.support_side)

    def made_push(self) -> Push | None:
        """The push, None if it has no impulse."""
        if self.push["impulse"] == 0.0:
            return None
        duration = self.push["duration"]
        return Push.of_impulse(self.push["impulse"], self.direction(), self.start(), duration)


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
    velocity = _pair("gait.velocity", GAIT["velocity"], gait, "velocity", VELOCITY)
    known = _changed(robot, rooms.get("robot", {}), "robot")
    limits = {name: one for name, one in GAIT.items() if name != "velocity"}
    known = known.replace(gait=_struct(known.gait, "gait", limits, gait))
    plant = _changed(known, rooms.get("plant", {}), "plant")
    chosen = _chosen(
        "controller", _of_method(controller), rooms.get("controller", {}), settings(controller)
    )
    decides = find_method(controller).controller(
        known, velocity, **checked_settings(controller, chosen)
    )
    disturbance = None
    if given := rooms.get("disturbance", {}):
        disturbance = Disturbance(
            **_chosen("disturbance", DISTURBANCE, given, asdict(Disturbance()))
        )
        whole_cycles(disturbance.delay, decides.period)
    return Situation(decides, plant, disturbance, _push(rooms.get("push", {})))


def _push(given: Mapping[str, Any]) -> dict[str, float]:
    push = {name: one.usual for name, one in PUSH.items()} | dict(given)
    for name, value in push.items():
        one = PUSH[name]
        check_number(f"push.{name}", value, one.least, one.unit or "-", above=one.above)
    if push["step"] != int(push["step"]):
        raise ParameterError(
            "`push.step` as a whole number", repr(push["step"]), "2 is usual: the third step"
        )
    return push


def _chosen(
    room: str,
    known: Mapping[str, Parameter],
    given: Mapping[str, Any],
    usual: Mapping[str, Any],
) -> dict[str, Any]:
    """The values of a room that are given; of a pair of which a half is given both."""
    found = {}
    for name, one in known.items():
        if any(f"{name}.{half}" in given for half in one.halves):
            found[name] = _pair(f"{room}.{name}", one, given, name, usual[name])
        elif name in given:
            value = given[name]
            found[name] = tuple(value) if isinstance(value, list) else value
    return found


def _pair(
    name: str, one: Parameter, given: Mapping[str, Any], key: str, usual: Any
) -> tuple[float, float]:
    pair = given.get(key, usual)
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise ParameterError(f"`{name}` as a pair", repr(pair), "write [0.5, 0.0]")
    x, y = (given.get(f"{key}.{half}", value) for half, value in zip(one.halves, pair, strict=True))
    for half in (x, y):
        check_number(name, half, -math.inf, one.unit)
    return float(x), float(y)


def _changed(robot: Robot, given: Mapping[str, Any], room: str) -> Robot:
    changes = _chosen(room, BODY, given, {})
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
    changes = _chosen(room, known, given, {name: getattr(now, name) for name in known})
    for name, value in changes.items():
        for one in value if isinstance(value, tuple) else (value,):
            check_number(f"{room}.{name}", one, -math.inf, known[name].unit, endless=True)
    return msgspec.structs.replace(now, **changes) if changes else now
