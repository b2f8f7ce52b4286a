"""What can be set in a controller, declared once, on its field: default, unit, words and range.

Checks, the Args of the class, `surefoot tune` and `surefoot sweep` read it there.
"""

from __future__ import annotations

import inspect
import math
import textwrap
from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from surefoot.checks import check_number, check_pair, check_weights
from surefoot.robot.own_units import WORDS, OwnUnits

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot

_Class = TypeVar("_Class", bound=type)

LINE = 100
"""Where a line of a docstring ends."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class Setting:
    """What a field of a controller says of its value.

    Attributes:
        unit: "" for what is no number.
        words: what it is, and what it is if None.
        least: smallest value; None if the class checks the value itself [unit].
        excluded: whether `least` itself is refused too.
        endless: whether infinity is allowed.
        is_weight: whether it is a weight of the cost that is minimised.
        search: interval in which `surefoot tune` searches it; for a pair, one for each component
            or None [unit].
        own: what a controller that was given None uses, of robot, gait and period [unit].
        check: refuses a controller for its value, for more than being too small.
        share: what it is if None, in `OwnUnits`, see `fill_shares`; then `least` is 0 if left out.
    """

    unit: str
    words: str
    least: float | None = None
    excluded: bool = False
    endless: bool = False
    is_weight: bool = False
    search: Interval | tuple[Interval | None, Interval | None] | None = None
    own: Callable[[Any], float] | None = None
    check: Callable[[Any], None] | None = None
    share: float | None = None


def setting(
    default: Any,
    unit: str,
    words: str,
    *,
    above: float | None = None,
    kw_only: bool | None = None,
    **about: Any,
) -> Any:
    """A field of a controller that can be set.

    Args:
        default: its value; None if the controller finds its own, see `own` of `Setting`.
        unit: "" for what is no number.
        words: what it is, and what it is if None.
        above: instead of `least`, the largest value that is not allowed.
        kw_only: whether it is given by its name only; as the class says if None.
        **about: what else `Setting` says of it, as needed.
    """
    if above is not None:
        about |= {"least": above, "excluded": True}
    if "share" in about:
        about.setdefault("least", 0.0)
    by_name: Any = MISSING if kw_only is None else kw_only
    known = Setting(unit, words, **about)
    return field(default=default, metadata={"setting": known}, kw_only=by_name)


def weight(default: Any, unit: str, words: str, **about: Any) -> Any:
    """A setting that is a weight of the cost that is minimised; 0 and more, if not `above` 0."""
    least = {} if "above" in about else {"least": 0.0}
    return setting(default, unit, words, is_weight=True, **least, **about)


def described(words: str, unit: str = "") -> dict[str, Setting]:
    """The metadata of a field that has no default: `field(metadata=described("..."))`."""
    return {"setting": Setting(unit, words)}


def declared(cls: Any) -> dict[str, Setting]:
    """What the fields of a controller class say of themselves; those that all classes share last.

    Robot and velocity come first.
    """
    known = sorted(fields(cls), key=lambda of: of.kw_only is True)
    return {of.name: of.metadata["setting"] for of in known if "setting" in of.metadata}


def check_fields(controller: Any) -> None:
    """Refuse a setting outside its range, and weights of one cost too far from each other.

    Raises:
        SurefootError: a setting is refused.
    """
    weights = {}
    for of in fields(controller):
        known: Setting | None = of.metadata.get("setting")
        if known is None or (of.default is None and getattr(controller, of.name) is None):
            continue
        value: Any = getattr(controller, of.name)
        if known.least is not None and isinstance(of.default, tuple):
            check_pair(of.name, value, known.least, known.unit)
        elif known.least is not None:
            check_number(
                of.name, value, known.least, known.unit,
                above=known.excluded, endless=known.endless,
            )  # fmt: skip
        if known.is_weight:
            weights[of.name] = value
        if known.check is not None:
            known.check(controller)
    check_weights(**weights)


def documented(cls: _Class) -> _Class:
    """Write what the fields say of themselves into the docstring of a class, as its Args."""
    lines = (
        [_line(entry) for entry in declared(cls).items()]
        if hasattr(cls, "__dataclass_fields__")
        else []
    )
    if not lines:
        return cls
    about, mark, rest = inspect.cleandoc(cls.__doc__ or "").partition("\nRaises:")
    cls.__doc__ = "\n".join([about.rstrip(), "", "Args:", *lines, *([mark + rest] if mark else [])])
    return cls


def _line(entry: tuple[str, Setting]) -> str:
    name, known = entry
    unit = f" [{known.unit}]" if known.unit else ""
    share = "" if known.share is None else f"; {known.share:g} {WORDS[known.unit]} if None"
    return textwrap.fill(
        f"{name}: {known.words}{share}{unit}.",
        LINE,
        initial_indent=4 * " ",
        subsequent_indent=8 * " ",
    )


def search_intervals(make: Any) -> dict[str, Interval]:
    """Where `surefoot tune` searches, by name; a component of a pair has `.x` or `.y` behind.

    Args:
        make: a controller class, or anything else that makes controllers.
    """
    found: dict[str, Interval] = {}
    for name, known in declared(make).items() if is_dataclass(make) else ():
        if isinstance(known.search, tuple) and isinstance(known.search[0], float):
            found[name] = known.search  # type: ignore[assignment]
        elif known.search is not None:
            pairs = zip("xy", known.search, strict=True)
            found |= {f"{name}.{part}": ends for part, ends in pairs if isinstance(ends, tuple)}
    return found


class Own(float):
    """A value that was left out: it follows from robot, gait and period.

    A copy of a controller for another robot or velocity, by `dataclasses.replace`, finds its own
    again. To keep the number, give it as a plain float.
    """


def fill_in(controller: Any) -> None:
    """Give the parameters that were left out the values that follow from robot, gait and period."""
    known = [(of.name, of.metadata.get("setting")) for of in fields(controller)]
    values = {name: it.own(controller) for name, it in known if it and it.own is not None}
    for name, value in values.items():
        given = getattr(controller, name)
        if given is None or isinstance(given, Own):
            object.__setattr__(controller, name, Own(value))


def fill_shares(owner: Any, robot: Robot) -> None:
    """Give the settings that are None what follows from the robot."""
    units = OwnUnits.of(robot)
    for name, known in declared(owner).items():
        if known.share is not None and getattr(owner, name) is None:
            object.__setattr__(owner, name, known.share * units.one(known.unit))


def filled(value: float | None) -> float:
    """A parameter after `fill_in`."""
    return math.nan if value is None else value
