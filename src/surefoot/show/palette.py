"""Colours, dashes and fonts of the pictures; people of every colour vision can tell them apart.

The line colours are those of Okabe and Ito; what must not be mixed up differs in lightness or in
dashes too. What a colour means is the same in every picture.
"""

from __future__ import annotations

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

SOLE = {Side.LEFT: "#cfe3f2", Side.RIGHT: "#eae1d2"}
SOLE_EDGE = {Side.LEFT: "#6395bd", Side.RIGHT: "#a08c69"}
BOTH_SOLES = "#ececf0"
BOARD = "#e3e0d4"

DASHES = (0, (3, 2))
DOTS = (0, (1, 2))

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
