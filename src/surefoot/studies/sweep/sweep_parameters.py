"""The parameters that a sweep can set, by name, and what they make: controller, plant, push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import msgspec

from surefoot.checks import check_number, closest
from surefoot.control.estimator import whole_cycles
from surefoot.control.registry import find_method
from surefoot.control.settings import checked_settings, settings
from surefoot.dcm.pushes import Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.gait import GaitLimits
from surefoot.robot.robot import Foot, Robot, Trunk
from surefoot.robot.swing import Swing
from surefoot.rollout.disturbance import Disturbance

HALVES = {"min": 0, "max": 1, "x": 0, "y": 1}
"""The halves of a pair, by the end of a name."""

WHOLE = ("push.step", "disturbance.seed")
"""Parameters that are whole numbers."""

PUSH = {"impulse": 0.0, "angle": 0.0, "phase": 0.0, "duration": 0.2, "step": 2}
"""A push and its defaults: impulse [N s]; direction from forward (0) towards the foot that swings
in the step of the push (90) [deg]; phase of that step in which it begins; how long it lasts [s];
which step that is, from 0."""

VELOCITY = (0.5, 0.0)
"""The usual command [m/s]."""

_ROBOT = ("mass", "com_height", "hip", "gravity")
_PARTS = {"foot": Foot, "swing": Swing, "trunk": Trunk}


def flat_names(table: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Nested TOML tables by dotted name, down to values, ranges and distributions."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{path}{key}"
        if (
            isinstance(value, dict)
            and value
            and not {"from", "to", "mean", "deviation"} & set(value)
        ):
            flat |= flat_names(value, f"{name}.")
        else:
            flat[name] = value
    return flat


def known_parameters(controller: str) -> list[str]:
    """Every name that a study of this method can use, pairs as wholes."""
    body = [*_ROBOT]
    body += [f"{part}.{name}" for part, kind in _PARTS.items() for name in kind.__struct_fields__]
    gait = [f"gait.{name}" for name in GaitLimits.__struct_fields__]
    return [
        *(f"robot.{name}" for name in body),
        *gait,
        "gait.velocity",
        *(f"plant.{name}" for name in body),
        *(f"controller.{name}" for name in settings(controller)),
        *(f"push.{name}" for name in PUSH),
        *(f"disturbance.{one.name}" for one in fields(Disturbance)),
    ]


def check_parameter(controller: str, name: str, origin: str) -> None:
    """Refuse a name that no study can use.

    Raises:
        ParameterError: there is no such method or parameter; the message names the nearest.
    """
    known = known_parameters(controller)
    whole, _, half = name.rpartition(".")
    if name in known or (whole in known and half in _halves(controller, whole)):
        return
    room = name.partition(".")[0]
    near = [one for one in known if one.startswith(f"{room}.")] or known
    raise ParameterError(
        f"a parameter of a study ({', '.join(near)})",
        f"`{name}` in {origin}",
        closest(name, known, "choose one of these"),
    )


def _halves(controller: str, whole: str) -> tuple[str, ...]:
    """How the halves of a pair are called; none of what is no pair."""
    room, _, name = whole.partition(".")
    if whole in ("gait.step_duration", "gait.step_x", "gait.step_y"):
        return ("min", "max")
    pair = whole in ("gait.dcm_offset", "gait.velocity", "disturbance.com_offset")
    if room == "controller":
        pair = isinstance(settings(controller)[name], tuple)
    return ("x", "y") if pair else ()


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
    gait = dict(rooms.get("gait", {}))
    velocity = _pair("gait.velocity", gait, "velocity", VELOCITY)
    known = _changed(robot, rooms.get("robot", {}), "robot")
    known = known.replace(gait=_struct(known.gait, gait, "gait"))
    plant = _changed(known, rooms.get("plant", {}), "plant")
    wanted = rooms.get("controller", {})
    told = settings(controller)
    whole = {name: _whole(f"controller.{name}", wanted, name, told[name]) for name in told}
    given = {name: value for name, value in whole.items() if _is_named(name, wanted)}
    decides = find_method(controller).controller(
        known, velocity, **checked_settings(controller, given)
    )
    wrong = rooms.get("disturbance", {})
    usual = Disturbance()
    parts = {
        one.name: _whole(f"disturbance.{one.name}", wrong, one.name, getattr(usual, one.name))
        for one in fields(Disturbance)
        if _is_named(one.name, wrong)
    }
    disturbance = Disturbance(**parts) if wrong else None
    if disturbance is not None:
        whole_cycles(disturbance.delay, decides.period)
    return Situation(decides, plant, disturbance, _push(rooms.get("push", {})))


def _push(given: Mapping[str, Any]) -> dict[str, float]:
    push = {**PUSH, **given}
    for name, value in push.items():
        least = {"angle": -math.inf, "impulse": 0.0}.get(name, 0.0)
        unit = {"impulse": "N s", "angle": "deg", "duration": "s"}.get(name, "-")
        check_number(f"push.{name}", value, least, unit, above=name == "duration")
    if push["step"] != int(push["step"]):
        raise ParameterError(
            "`push.step` as a whole number", repr(push["step"]), "2 is usual: the third step"
        )
    return push


def _is_named(name: str, given: Mapping[str, Any]) -> bool:
    return name in given or any(f"{name}.{half}" in given for half in HALVES)


def _whole(name: str, given: Mapping[str, Any], key: str, usual: Any) -> Any:
    """A value, or a pair of which a half may be given."""
    if any(f"{key}.{half}" in given for half in HALVES):
        return _pair(name, given, key, usual)
    value = given.get(key, usual)
    return tuple(value) if isinstance(value, list) else value


def _pair(name: str, given: Mapping[str, Any], key: str, usual: Any) -> tuple[float, float]:
    pair = given.get(key, usual)
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise ParameterError(f"`{name}` as a pair", repr(pair), "write [0.5, 0.0]")
    halves = list(pair)
    for half, place in HALVES.items():
        if f"{key}.{half}" in given:
            halves[place] = given[f"{key}.{half}"]
    for one in halves:
        check_number(name, one, -math.inf, "-")
    return float(halves[0]), float(halves[1])


def _changed(robot: Robot, given: Mapping[str, Any], room: str) -> Robot:
    changes: dict[str, Any] = {name: given[name] for name in _ROBOT if name in given}
    for part in _PARTS:
        own = {name[len(part) + 1 :]: value for name, value in given.items()
               if name.startswith(f"{part}.")}  # fmt: skip
        if not own:
            continue
        now = getattr(robot, part)
        if now is None:
            raise ParameterError(
                f"a robot with a [{part}]", f"`{room}.{part}` of {robot.name}, which has none",
                f"give its file a [{part}]",
            )  # fmt: skip
        changes[part] = _struct(now, own, f"{room}.{part}")
    for name, value in changes.items():
        if name in _ROBOT:
            check_number(f"{room}.{name}", value, 0.0, "-", above=True)
    return robot.replace(**changes) if changes else robot


def _struct(now: Any, given: Mapping[str, Any], room: str) -> Any:
    """A copy of a part of the robot with some values changed, checked like a file."""
    changes = {
        name: _whole(f"{room}.{name}", given, name, getattr(now, name))
        for name in now.__struct_fields__
        if _is_named(name, given)
    }
    for name, value in changes.items():
        for one in value if isinstance(value, tuple) else (value,):
            check_number(f"{room}.{name}", one, -math.inf, "-", endless=True)
    return msgspec.structs.replace(now, **changes) if changes else now
