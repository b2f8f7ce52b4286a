"""Every control method by name: what it adapts, where it is from, and what it cannot use.

A method is a class with `@method(...)` above it and an entry point of the group `surefoot.methods`
with the same name, in this package or in any other. `module:Class` names any class at all. Nothing
is imported before it is asked for.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from surefoot.control.fields import documented
from surefoot.errors import ParameterError
from surefoot.plugins import foreign_stamp, load, places

if TYPE_CHECKING:
    from surefoot.interface import Controller
    from surefoot.robot.robot import Robot

GROUP = "surefoot.methods"
"""The group of entry points."""

LAST = 1000
"""The `order` of a method that does not say its own."""

_Class = TypeVar("_Class", bound=type)


@dataclass(frozen=True)
class Method:
    """One way to keep a robot on its feet.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        make: its class, or what makes its controller from a robot, a velocity and parameters.
        source: who published it.
        adapts: what it changes when it is pushed.
        cannot: what it cannot use of what every method may use.
        cites: keys of its publications in `surefoot/references.bib`, or whole BibTeX entries.
        order: place in tables and pictures, from the ZMP alone to steps in place and time.
        fixed_steps: whether it always steps as planned, so that the speed of the leg is no matter.
        leans: whether it turns the trunk as a flywheel, which a body in physics has none of.
        slow: whether one decision takes milliseconds, so that it is compared only if asked for.
        nearness: how near to its nominal gait it walks undisturbed, if it follows it smoothly [m].
        zmp_trace: how much of a lost observation is left in the next ZMP, if the ZMP moves on from
            where it was [m].
        given_footsteps: whether the step under way is given too, so that a new velocity begins with
            the step after it.
        parameters: that make this variant of the class.
        rates: likewise, as multiples of the robot's omega.
        compared: what it is given beside these where methods are compared, each at its best.
    """

    key: str
    label: str
    make: Callable[..., Any]
    source: str
    adapts: str
    cannot: str
    cites: tuple[str, ...] = ()
    order: int = LAST
    fixed_steps: bool = False
    leans: bool = False
    slow: bool = False
    nearness: float = 1e-9
    zmp_trace: float = 1e-12
    given_footsteps: bool = False
    parameters: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    rates: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    compared: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def controller(
        self, robot: Robot, velocity: tuple[float, float], **parameters: Any
    ) -> Controller:
        """The controller of this method for a robot and a velocity [m/s].

        Raises:
            SurefootError: its class refuses the arguments.
        """
        given = {**self.parameters, **parameters}
        for name, times in self.rates.items():
            if given.get(name) is None:
                given[name] = times * robot.omega
        return self.make(robot, velocity, **given)

    @property
    def sources(self) -> str:
        """The content of the package that brings it, as a hash; "" for Surefoot's own.

        What a study keeps of a method holds as long as this does.
        """
        return foreign_stamp(getattr(sys.modules.get(self.make.__module__), "__file__", None) or "")

    def takes(self, parameter: str) -> bool:
        """Whether its class has a parameter of this name."""
        return parameter in settable(self.make)


def settable(make: Callable[..., Any]) -> dict[str, Any]:
    """The fields of a controller class that can be set, with their defaults; robot and velocity
    are no settings.

    Those that all classes share come last.
    """
    known = sorted(fields(make), key=lambda of: of.kw_only is True) if is_dataclass(make) else ()
    return {of.name: of.default for of in known if of.init and of.name not in ("robot", "velocity")}


def method(key: str, **about: Any) -> Callable[[_Class], _Class]:
    """Declare a class as a control method, and describe its parameters in its docstring.

    Args:
        key: its name on the command line, and that of its entry point.
        **about: what `Method` says of it: label, source, adapts and cannot, and the rest as needed.
    """

    def declare(cls: _Class) -> _Class:
        cls.METHOD = Method(key, make=cls, **about)  # type: ignore[attr-defined]
        return documented(cls)

    return declare


def variant(of: type, key: str, **changes: Any) -> Method:
    """A method of the same class with other parameters; its entry point names this value.

    Args:
        of: a class with `@method`.
        key: its own name.
        **changes: what differs from the method of the class.
    """
    known: Method = of.METHOD  # type: ignore[attr-defined]
    return replace(known, key=key, **changes)


def method_names() -> tuple[str, ...]:
    """The keys of all methods that are installed, sorted; nothing is imported."""
    return tuple(places(GROUP))


def methods() -> tuple[Method, ...]:
    """All methods that are installed, in the order in which they are shown."""
    return tuple(sorted(map(find_method, method_names()), key=lambda one: (one.order, one.key)))


def find_method(key: str) -> Method:
    """A method by its name on the command line, or by the `module:Class` of its controller.

    Raises:
        ParameterError: there is none of that name, or what is there makes no controllers.
    """
    place = places(GROUP).get(key, key)
    if ":" not in place:
        names = ", ".join(one.key for one in methods())
        raise ParameterError(
            f"a method ({names}, or module:Class)", repr(key), "choose one of these"
        )
    made = load(place)
    # A subclass is another method than its parent.
    declared = made if isinstance(made, Method) else getattr(made, "__dict__", {}).get("METHOD")
    if declared is None:
        return _undeclared(place, made)
    if key not in (declared.key, place):
        raise ParameterError(
            f"a method {key!r} at its entry point {place}",
            f"one that is declared as {declared.key!r}",
            "give both the same name",
        )
    # One that is not installed goes on under the name by which it was found.
    return declared if declared.key in places(GROUP) else replace(declared, key=key)


def _undeclared(place: str, made: Any) -> Method:
    """The method of a class that says nothing of itself.

    Raises:
        ParameterError: it cannot be called.
    """
    if not callable(made):
        raise ParameterError(
            f"a class of controllers at {place}",
            repr(made),
            "name a class, or a function of a robot, a velocity and parameters",
        )
    name = place.partition(":")[2]
    return Method(place, name, made, place, "not declared", "not declared")
