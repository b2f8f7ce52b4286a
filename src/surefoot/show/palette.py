"""Colours, dashes, fonts and marks of the pictures; people of every colour vision can read them.

The line colours are those of Okabe and Ito; what must not be mixed up differs in lightness or in
dashes too. What a colour means is the same in every picture.

Each method has a mark: six colours after Okabe and Ito, each twice, with a solid and with a dashed
line. All shapes differ, so that no one has to rely on colour. From the thirteenth method on, hues
are spread evenly over the circle by the golden ratio, and the shapes are stars with one more tip
each.
"""

from __future__ import annotations

import colorsys
import math
from dataclasses import dataclass
from typing import Any

from surefoot.robot.feet import Side

COM = "#222222"
COM_PLAN = "#a0522d"
DCM = "#0072b2"
DCM_PLAN = "#e66100"
ZMP = "#009e73"
ZMP_PLAN = "#004d38"
ADAPTED = "#7b3294"
ALARM = "#c1002b"
PUSH = "#ffd400"
PUSH_EDGE = "#6b5900"
QUIET = "#6f6f6f"
TOUCHDOWN = "#b5b5b5"
GRID = "#e8e8e8"

SOLE = {Side.LEFT: "#cfe3f2", Side.RIGHT: "#eae1d2"}
SOLE_EDGE = {Side.LEFT: "#6395bd", Side.RIGHT: "#a08c69"}
BOTH_SOLES = "#ececf0"
BOARD = "#e3e0d4"

DASHES = (0, (3, 2))
DOTS = (0, (1, 2))

MISSED: dict[str, Any] = {
    "facecolor": "none", "edgecolor": ADAPTED, "linewidth": 1.0, "linestyle": DASHES
}  # fmt: skip
"""Outline of a sole where a foot was to land that landed elsewhere."""

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#555555",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "hatch.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "pdf.fonttype": 42,
    # Element names in an SVG are random without it.
    "svg.hashsalt": "surefoot",
}
"""Settings that hold while a picture is made; the caller's own are left alone."""


def step_number(online: bool) -> dict[str, Any]:
    """How the number of a step is written: one that was decided online stands out."""
    if online:
        return {"fontsize": 8.5, "fontweight": "bold", "color": ADAPTED}
    return {"fontsize": 7.5, "fontweight": "normal", "color": QUIET}


def rgb(colour: str) -> tuple[int, int, int]:
    """Of "#rrggbb", from 0 to 255."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


Outline = tuple[tuple[float, float], ...]
"""Corners of a shape about the origin, y up, of about unit size."""


@dataclass(frozen=True)
class Mark:
    """How one method is drawn.

    Attributes:
        colour: of line and marker on white.
        dark: the same colour for a dark ground.
        dashed: whether the line is dashed.
        outline: of the marker.
    """

    colour: str
    dark: str
    dashed: bool
    outline: Outline


def mark(index: int) -> Mark:
    """The mark of the method at a place in the order of display, from 0."""
    if index < len(MARKS):
        return MARKS[index]
    further = index - len(MARKS)
    hue = GOLDEN * further
    tips = _polygon(2 * (FIRST_TIPS + further), 0.0, 1.2, 0.6)
    return Mark(_hex(hue, LIGHTNESS), _hex(hue, DARK_LIGHTNESS), further % 2 == 1, tips)


def _hex(hue: float, lightness: float) -> str:
    parts = colorsys.hls_to_rgb(hue % 1.0, lightness, SATURATION)
    return "#" + "".join(f"{round(255.0 * part):02x}" for part in parts)


def _polygon(corners: int, turn: float, size: float = 1.0, waist: float = 1.0) -> Outline:
    """A regular polygon with a corner at `turn` from the top; every second one at `waist`."""
    points = []
    for corner in range(corners):
        angle = 2.0 * math.pi * corner / corners + turn
        radius = size * (waist if corner % 2 else 1.0)
        points.append((round(-radius * math.sin(angle), 4), round(radius * math.cos(angle), 4)))
    return tuple(points)


def _plus(turn: float) -> Outline:
    long, thick = 1.0, 0.36
    arm = [(thick, long), (thick, thick), (long, thick)]
    points = []
    for quarter in range(4):
        angle = turn - 0.5 * math.pi * quarter
        cos, sin = math.cos(angle), math.sin(angle)
        points += [(round(cos * x - sin * y, 4), round(sin * x + cos * y, 4)) for x, y in arm]
    return tuple(points)


GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Of the circle of hues, from one further method to the next."""

LIGHTNESS, DARK_LIGHTNESS, SATURATION = 0.32, 0.68, 0.75
"""Of the colours of further methods, on white and on a dark ground."""

FIRST_TIPS = 7
"""Of the star of the thirteenth method."""

_COLOURS = (
    ("#0072b2", "#56b4f5"),
    ("#d55e00", "#ff8c3f"),
    ("#008a66", "#2fd0a0"),
    ("#7b3294", "#c79af0"),
    ("#b8860b", "#f0c548"),
    ("#c2558f", "#f59bc8"),
)

_SHAPES: tuple[Outline, ...] = (
    _polygon(24, 0.0, 0.92),
    _polygon(4, 0.25 * math.pi, 1.18),
    _polygon(3, 0.0, 1.15),
    _polygon(4, 0.0, 1.15),
    _polygon(3, math.pi, 1.15),
    _polygon(10, 0.0, 1.2, 0.45),
    _plus(0.0),
    _plus(0.25 * math.pi),
    _polygon(3, 0.5 * math.pi, 1.15),
    _polygon(3, -0.5 * math.pi, 1.15),
    _polygon(6, 0.0, 1.05),
    _polygon(8, 0.0, 1.2, 0.35),
)

MARKS: tuple[Mark, ...] = tuple(
    Mark(*_COLOURS[index % len(_COLOURS)], index >= len(_COLOURS), outline)
    for index, outline in enumerate(_SHAPES)
)
"""Of the first methods in the order of display; `mark` has those of all."""
