"""Colours of the scene, as numbers and as dots of a legend."""

from __future__ import annotations

from surefoot.show import palette

REGION = palette.ADAPTED
"""Of the landings that can still be saved."""


GHOST = "#8a8f98"
"""Of the second walk."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Of "#rrggbb", from 0 to 255."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def dot(colour: str) -> str:
    """A dot of this colour for HTML."""
    return f'<span style="color:{colour};font-size:1.15em">&#9679;</span>'
