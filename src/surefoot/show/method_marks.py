"""The mark of each method in every picture and on the page: colour, dash and shape.

Six colours after Okabe and Ito, each twice: with a solid and with a dashed line. All shapes differ,
so that no one has to rely on colour. From the thirteenth method on, hues are spread evenly over the
circle by the golden ratio, and the shapes are stars with one more tip each.
"""

from __future__ import annotations

import colorsys
import math
from dataclasses import dataclass

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
