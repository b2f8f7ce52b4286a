"""Footholds that a user gives: where, in which heading and when each foot lands, from a file.

A table (.csv) or a list (.toml) of rows in the order of time. The first two rows are the feet as
they stand at the start: the first of them lifts first. Every further row lands at its time.

The DCM plan over them goes backwards from the last one, Section V of [Englsberger2015]:

    dcm_end,k = dcm_start,k+1,     dcm_start,k = p_k + (dcm_end,k - p_k) e^(-omega T_k)

Behind the last foothold the robot steps in place, in the heading of that foothold, so the
recursion begins with the start offset of that gait.
"""

from __future__ import annotations

import csv
import io
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.nominal_gait import NominalGait
from surefoot.errors import SurefootError
from surefoot.geometry import rotated
from surefoot.robot.feet import Side
from surefoot.robot.robot import Foot, Robot

REQUIRED = ("side", "x", "y", "time")
OPTIONAL = ("yaw",)
"""Keys of a row: side, position of the sole's centre [m], yaw [rad], time of touchdown [s]."""

LAST_DIGIT = 1e-8
"""By this part of its range a value may be outside: it was rounded when it was read."""


class FootholdError(SurefootError, ValueError):
    """A file of footholds is wrong; the message names the line."""


@dataclass(frozen=True)
class Foothold:
    """Where one foot stands.

    Attributes:
        side: which foot.
        x: centre of the sole, forward [m].
        y: centre of the sole, to the left [m].
        yaw: heading of the sole, counter-clockwise from x [rad].
        time: when it touches down [s].
        line: where the file says so, 0 if no file does.
    """

    side: Side
    x: float
    y: float
    yaw: float
    time: float
    line: int = 0


def load_footholds(path: str | Path, robot: Robot) -> tuple[Foothold, ...]:
    """Read footholds and check that the robot can step on them.

    Args:
        path: a .csv file with the columns side, x, y, yaw, time (yaw may be left out), or a .toml
            file with one [[foothold]] of these keys for each.
        robot: whose limits hold.

    Returns:
        The footholds, in order.

    Raises:
        FootholdError: the file cannot be read, a value is missing or no number, times run
            backwards, feet cross or tread on each other, or a step is out of reach.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FootholdError(
            "a readable file of footholds", f"{path}: {error}", "check the path"
        ) from error
    readers = {".csv": _csv_rows, ".toml": _toml_rows}
    if path.suffix.lower() not in readers:
        raise FootholdError("a path ending in .csv or .toml", str(path), "rename the file")
    rows = readers[path.suffix.lower()](text, path)
    footholds = tuple(_foothold(row, line, path) for line, row in rows)
    check_footholds(footholds, robot, str(path))
    return footholds


def check_footholds(footholds: Sequence[Foothold], robot: Robot, origin: str) -> None:
    """Refuse footholds that the robot cannot step on.

    Args:
        footholds: in the order of time.
        robot: whose limits hold.
        origin: what to call them in messages.

    Raises:
        FootholdError: see `load_footholds`.
    """
    if len(footholds) < 3:
        raise FootholdError(
            "at least three footholds: two feet that stand, and a step",
            f"{len(footholds)} in {origin}",
            "add the first landing",
        )
    _check_stance(footholds[0], footholds[1], robot, origin)
    for standing, landing in pairwise(footholds[1:]):
        where = f"{origin}, line {landing.line}" if landing.line else origin
        if landing.side is not standing.side.other:
            raise FootholdError(
                f"the {standing.side.other.name.lower()} foot to land next",
                f"{landing.side.name.lower()} again ({where})",
                "feet alternate",
            )
        _check_time(standing, landing, robot, where)
        _check_step(standing, landing, robot, where)


def step_in_foot(standing: Foothold, landing: Foothold) -> tuple[float, float]:
    """The step vector in the axes of the foot that stands (x, y) [m]."""
    return rotated((landing.x - standing.x, landing.y - standing.y), -standing.yaw)


def _check_stance(first: Foothold, second: Foothold, robot: Robot, origin: str) -> None:
    where = f"{origin}, line {second.line}" if second.line else origin
    if second.side is first.side:
        raise FootholdError(
            "one left and one right foot in the first two rows",
            f"{first.side.name.lower()} twice ({where})",
            "the first two rows are the feet as they stand at the start",
        )
    if second.time < first.time:
        raise FootholdError(
            "times that run forward", f"{second.time} s after {first.time} s ({where})", "sort them"
        )
    _check_step(first, second, robot, where)


def _check_time(standing: Foothold, landing: Foothold, robot: Robot, where: str) -> None:
    duration = landing.time - standing.time
    shortest, longest = robot.gait.step_duration
    if duration <= 0.0:
        raise FootholdError(
            "times that run forward",
            f"{landing.time} s after {standing.time} s ({where})",
            "every foot lands later than the one before",
        )
    # A time with three decimals must not fail for its last binary digit.
    slack = LAST_DIGIT * longest
    if not shortest - slack <= duration <= longest + slack:
        raise FootholdError(
            f"a step of {shortest} to {longest} s",
            f"{duration:.4g} s ({where})",
            f"change the time, or step_duration of robot '{robot.name}'",
        )


def _check_step(standing: Foothold, landing: Foothold, robot: Robot, where: str) -> None:
    x, y = step_in_foot(standing, landing)
    outward = standing.side * y
    if outward <= 0.0:
        raise FootholdError(
            f"the {landing.side.name.lower()} foot on its own side",
            f"{-1e3 * outward:.0f} mm across the other foot ({where})",
            "legs would cross: move it outward",
        )
    if _overlap(standing, landing, robot.foot):
        raise FootholdError(
            "soles that do not overlap",
            f"a landing {1e3 * x:.0f} mm ahead of and {1e3 * outward:.0f} mm beside the other foot "
            f"({where})",
            f"a sole is {robot.foot.length} m long and {robot.foot.width} m wide",
        )
    low, high = robot.gait.step_box(standing.side, robot.hip)
    for name, value, least, most in zip("xy", (x, y), low, high, strict=True):
        slack = LAST_DIGIT * (most - least)
        if not least - slack <= value <= most + slack:
            raise FootholdError(
                f"a step of {least:g} to {most:g} m in {name} of the foot that stands",
                f"{value:.4g} m ({where})",
                f"move it nearer, or change step_{name} of robot '{robot.name}'",
            )


def _overlap(one: Foothold, two: Foothold, foot: Foot) -> bool:
    """Whether two soles overlap: no side of either separates them."""
    angle = two.yaw - one.yaw
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    # Along its own axes a sole reaches `half`, along those of the other one `half` and `reach`.
    reach = (foot.half[0] * cos + foot.half[1] * sin, foot.half[0] * sin + foot.half[1] * cos)
    for here, there in ((one, two), (two, one)):
        away = step_in_foot(here, there)
        if any(
            abs(distance) >= half + other
            for distance, half, other in zip(away, foot.half, reach, strict=True)
        ):
            return False
    return True


def _csv_rows(text: str, path: Path) -> list[tuple[int, Mapping[str, Any]]]:
    reader = csv.DictReader(io.StringIO(text), skipinitialspace=True)
    names = [name.strip() for name in reader.fieldnames or ()]
    reader.fieldnames = names
    if not set(REQUIRED) <= set(names) <= {*REQUIRED, *OPTIONAL}:
        raise FootholdError(
            f"the columns {', '.join((*REQUIRED, *OPTIONAL))}",
            f"{', '.join(names) or 'an empty file'} ({path}, line 1)",
            "the first line of the file names the columns",
        )
    rows = []
    for row in reader:
        if None in row or None in row.values():
            raise FootholdError(
                f"{len(names)} values", f"{path}, line {reader.line_num}", "check the commas"
            )
        rows.append((reader.line_num, row))
    return rows


def _toml_rows(text: str, path: Path) -> list[tuple[int, Mapping[str, Any]]]:
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FootholdError(
            "a TOML document", f"{path}: {error}", "correct the line that is named"
        ) from error
    rows = table.get("foothold")
    if set(table) != {"foothold"} or not isinstance(rows, list):
        raise FootholdError(
            "a list of [[foothold]] and nothing else",
            f"{', '.join(table)} in {path}",
            "see the docs",
        )
    lines = [
        number
        for number, line in enumerate(text.splitlines(), 1)
        if line.replace(" ", "").startswith("[[foothold]]")
    ]
    # Rows of an inline array have no line of their own: they are counted instead.
    return list(
        zip(lines if len(lines) == len(rows) else range(1, len(rows) + 1), rows, strict=True)
    )


def _foothold(row: Mapping[str, Any], line: int, path: Path) -> Foothold:
    where = f"{path}, line {line}"
    unfit = sorted(set(row) - {*REQUIRED, *OPTIONAL}) or sorted(set(REQUIRED) - set(row))
    if unfit:
        raise FootholdError(
            f"the keys {', '.join((*REQUIRED, *OPTIONAL))}",
            f"{', '.join(unfit)} unknown or missing ({where})",
            "yaw may be left out, nothing else",
        )
    side = str(row["side"]).strip().upper()
    if side not in Side.__members__:
        raise FootholdError(
            '"left" or "right" as side', f"{row['side']!r} ({where})", "name the foot"
        )
    numbers = {}
    for key in ("x", "y", "time", "yaw"):
        value = row.get(key, 0.0)
        try:
            numbers[key] = math.nan if isinstance(value, bool) else float(value)
        except (TypeError, ValueError):
            numbers[key] = math.nan
        if not math.isfinite(numbers[key]):
            raise FootholdError(f"a number as {key}", f"{value!r} ({where})", "use SI units")
    return Foothold(Side[side], numbers["x"], numbers["y"], numbers["yaw"], numbers["time"], line)


@dataclass(frozen=True)
class PlannedStep:
    """One step over given footholds.

    Attributes:
        side: foot that stands.
        duration: T [s].
        start_offset: planned DCM at touchdown, relative to the foot that stands (x, y) [m].
        end_offset: planned DCM at the end, relative to the landing (x, y) [m].
        landing_yaw: heading of the landing foot [rad].
    """

    side: Side
    duration: float
    start_offset: tuple[float, float]
    end_offset: tuple[float, float]
    landing_yaw: float


def plan_footholds(footholds: Sequence[Foothold], in_place: NominalGait) -> list[PlannedStep]:
    """The steps over the footholds, and two more in place, one for each foot.

    Args:
        footholds: checked ones; the first two are the feet that stand at the start.
        in_place: the nominal gait for no velocity.

    Returns:
        A step for every foothold from the second on, then the two that repeat for ever.
    """
    last = footholds[-1]
    ends = {side: np.array(rotated(in_place.start_offset(side), last.yaw)) for side in Side}
    feet = [np.array((foothold.x, foothold.y)) for foothold in footholds[1:]]
    starts = [ends[last.side]]
    for k in range(len(feet) - 2, -1, -1):
        duration = footholds[k + 2].time - footholds[k + 1].time
        dcm_end = feet[k + 1] + starts[0]
        starts.insert(0, (dcm_end - feet[k]) * math.exp(-in_place.omega * duration))
    steps = [
        PlannedStep(
            standing.side,
            landing.time - standing.time,
            _pair(starts[k]),
            _pair(starts[k + 1]),
            landing.yaw,
        )
        for k, (standing, landing) in enumerate(pairwise(footholds[1:]))
    ]
    side = last.side
    for _ in range(2):
        steps.append(
            PlannedStep(
                side, in_place.step_duration, _pair(ends[side]), _pair(ends[side.other]), last.yaw
            )
        )
        side = side.other
    return steps


def _pair(vector: NDArray[np.float64]) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])
