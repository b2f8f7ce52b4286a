"""A push map as one HTML page that needs nothing else: the reader chooses a cell, it tells."""

from __future__ import annotations

import base64
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.studies.compare.compare_page import words_table
from surefoot.studies.engine.report import embedded
from surefoot.studies.engine.words import angle_words, percent
from surefoot.studies.push_map.cube import NOT_WALKED, RECOVERED, PushCube
from surefoot.studies.push_map.push_cube_words import HEADING, finding, origin, protocol
from surefoot.version import VERSION

SCRIPTS = ("push_map/push_cube_data.js", "push_map/push_cube_page.js")
"""In the order in which they run."""

STYLES = ("engine/page.css", "push_map/push_cube_page.css")
"""In the order in which they count."""

NO_STEPS, MOST_STEPS = 63, 62
"""How a walk's steps to recover are packed into six bits: none, and so many or more."""

NO_MARGIN = -32768
"""How a margin is packed that there is none of."""

MARGIN_UNIT = 1e-4
"""Of a packed margin [m]."""

COLOURS = (
    "#440154", "#48186a", "#472d7b", "#424086", "#3b528b", "#33638d", "#2c728e", "#26828e",
    "#21918c", "#1fa088", "#28ae80", "#3fbc73", "#5ec962", "#84d44b", "#addc30", "#d8e219",
    "#fde725",
)  # fmt: skip
"""Viridis, from the least to the most: even in lightness, told apart with any colour vision."""

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'"

_SHOWN = (
    ("survived", "Largest survived impulse"),
    ("share", "Share of the limit"),
    ("steps", "Steps to recover"),
    ("margin", "Margin"),
)

_KEY = (
    ("<rect class='fate recovered' x='12' y='1' width='6' height='12'/>", "recovered"),
    ("<rect class='fate unsettled' x='12' y='4' width='6' height='9'/>", "did not settle"),
    ("<rect class='fate fell' x='12' y='8' width='6' height='5'/>", "fell"),
    ("<path class='limit' d='M1,7H29'/>", "limit of any policy"),
    ("<path class='limit causal' d='M1,7H29'/>", "if its end is unknown"),
    ("<path class='limit fixed' d='M1,7H29'/>", "limit of fixed steps"),
    ("<path class='hole' d='M11,3l8,8M19,3l-8,8'/>", "a harder push is survived again"),
)  # fmt: skip


def cube_page(cube: PushCube) -> str:
    """The page; the same map makes the same text.

    A choice can be put behind its address: `#show=share&phase=0.5&angle=90&impulse=60`.
    """
    folder = files("surefoot.studies")
    scripts = "\n".join(
        f"<script>\n{(folder / name).read_text(encoding='utf-8')}</script>" for name in SCRIPTS
    )
    style = "".join((folder / name).read_text(encoding="utf-8") for name in STYLES)
    body = [
        f"<h1>{HEADING}</h1>",
        f'<p class="source">{escape(origin(cube))}  ·  Surefoot {VERSION}</p>',
        f"<p>{escape(finding(cube))}</p>",
        _controls(cube),
        _view(),
        f"<noscript>{_phases(cube)}</noscript>",
        "<h2>What was measured, and how</h2>",
        *(f"<p>{escape(text)}</p>" for text in protocol(cube)),
        "<h2>Provenance</h2>",
        words_table(("what", "value"), list(cube.provenance.items())),
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Surefoot {VERSION}: {HEADING.lower()}</title>\n<style>\n{style}</style>\n"
        "</head>\n<body>\n<main>\n" + "\n".join(body) + "\n</main>\n"
        f'<script type="application/json" id="data">{embedded(page_data(cube))}</script>\n'
        f"{scripts}\n</body>\n</html>\n"
    )


def page_data(cube: PushCube) -> dict[str, Any]:
    """What the script draws from.

    Cells stand phase after phase. `count` has the number of walks of each; `gap`, `code` and
    `margin` have, walk after walk, how many steps of the scan it lies above the one before; its
    fate times 64, and its steps to recover; and its margin in tenths of a millimetre. They are
    base64 of little-endian u2, u1, u1 and i2.
    """
    cells = cube.fate.reshape(-1, cube.fate.shape[-1])
    rows, numbers = np.nonzero(cells != NOT_WALKED)
    first = np.flatnonzero(np.diff(rows, prepend=-1))
    gap = np.diff(numbers, prepend=0)
    gap[first] = numbers[first]
    fate = cells[rows, numbers].astype(int)
    steps = cube.recovery_steps.reshape(cells.shape)[rows, numbers].astype(int)
    steps = np.where((fate == RECOVERED) & (steps >= 0), np.minimum(steps, MOST_STEPS), NO_STEPS)
    margin = cube.margin.reshape(cells.shape)[rows, numbers].astype(float) / MARGIN_UNIT
    lost = ~(np.abs(margin) < -NO_MARGIN - 1)
    margin = np.where(lost, NO_MARGIN, np.round(np.where(lost, 0.0, margin)))
    return {
        "phases": cube.phases.tolist(),
        "angles": cube.angles.tolist(),
        "step": cube.step,
        "coarse": cube.coarse,
        "duration": cube.push_duration,
        "directions": DIRECTIONS,
        "limit": np.round(cube.limit, 3).ravel().tolist(),
        "causal": np.round(cube.limit_causal, 3).ravel().tolist(),
        "fixed": np.round(cube.limit_fixed, 3).ravel().tolist(),
        "colours": COLOURS,
        "count": _packed(np.bincount(rows, minlength=len(cells)), "<u2"),
        "gap": _packed(gap, "<u1"),
        "code": _packed(64 * fate + steps, "<u1"),
        "margin": _packed(margin, "<i2"),
    }


def _packed(values: NDArray[Any], kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()


def _controls(cube: PushCube) -> str:
    choices = "".join(
        f'<label><input type="radio" name="show" value="{key}">{words}</label>'
        for key, words in _SHOWN
    )
    return (
        '<form class="alive"><fieldset id="show"><legend>Colour of a cell</legend>'
        f"{choices}</fieldset>\n"
        '<div class="sliders">\n'
        + _slider("impulse", "Impulse [N s], of steps and margin")
        + _slider("phase", "Phase of the step")
        + _slider("angle", "Direction")
        + "</div></form>"
    )


def _slider(name: str, words: str) -> str:
    return (
        f'<div class="slider"><label for="{name}">{words}</label> <output for="{name}" '
        f'id="{name}-value"></output><input type="range" id="{name}" min="0" step="1"></div>\n'
    )


def _view() -> str:
    key = "".join(
        f'<li><svg viewBox="0 0 30 14" aria-hidden="true">{picture}</svg>{words}</li>'
        for picture, words in _KEY
    )
    return (
        '<p id="said" class="alive" role="status" aria-live="polite"></p>\n'
        '<div class="cube alive">\n<figure id="whole">\n'
        '<svg id="map" tabindex="0" role="application" aria-roledescription="heat map" '
        'aria-describedby="map-caption said" aria-label="Map of directions and phases: left and '
        'right arrow keys change the direction, up and down the phase"></svg>\n'
        '<svg id="scale" role="img" aria-labelledby="map-caption"></svg>\n'
        '<div id="tip" hidden></div>\n<figcaption id="map-caption"></figcaption>\n</figure>\n'
        '<figure id="one"><svg id="scan" role="img" aria-labelledby="scan-caption"></svg>\n'
        '<figcaption id="scan-caption"></figcaption></figure>\n'
        '<figure id="around"><svg id="polar" viewBox="-250 -250 500 500" role="img" '
        'aria-labelledby="polar-caption"></svg>\n<figcaption id="polar-caption"></figcaption>'
        f'</figure>\n</div>\n<ul class="key alive">{key}</ul>'
    )


def _phases(cube: PushCube) -> str:
    """What is survived along the axes, for who runs no script."""
    ways = [int(np.argmin(np.abs(cube.angles - angle))) for angle in DIRECTIONS.values()]
    head = ("phase", *(f"{angle_words(float(cube.angles[way]))} [N s]" for way in ways),
            "mean of the limit", "worst")  # fmt: skip
    rows = [
        (
            f"{phase:.3g}",
            *(f"{cube.survived[row, way]:g} of {cube.limit[row, way]:.1f}" for way in ways),
            percent(float(np.mean(cube.share[row]))),
            percent(float(np.min(cube.share[row]))),
        )
        for row, phase in enumerate(cube.phases)
    ]
    return words_table(head, rows)
