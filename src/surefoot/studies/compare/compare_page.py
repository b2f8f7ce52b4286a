"""A comparison as one HTML page that needs nothing else: the reader chooses, it draws."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from surefoot.checks import check_writable
from surefoot.errors import FileError
from surefoot.show.method_marks import mark
from surefoot.studies.compare.compare_table import compare_table
from surefoot.studies.compare.compare_words import HEADING, cautions, protocol
from surefoot.studies.compare.comparison import DIRECTIONS, FAILURES, Choice, Comparison, choose
from surefoot.version import VERSION

SCRIPTS = ("compare_numbers.js", "compare_page.js")
"""In the order in which they run."""

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'"

_HEADINGS = (
    "Method", "Mean of the limit", "Worst", *(name.capitalize() for name in DIRECTIONS),
    "Fell / not settled", "Cycle p50", "p99.9", "Cells", "Mean if the end is unknown",
)  # fmt: skip

_KEY = (
    ("<path class='limit' d='M1,7H29'/>", "limit of any policy"),
    ("<path class='limit point' d='M1,7H29'/>", "on a point foot"),
    ("<path class='limit fixed' d='M1,7H29'/>", "of fixed steps"),
    ("<path class='mark' d='M11,3h8v8h-8Z'/>", "fell"),
    ("<path class='mark hollow' d='M11,3h8v8h-8Z'/>", "did not settle"),
    ("<path class='mark' d='M7,3h8v8h-8Z'/><path class='line open' d='M15,7H27'/>",
     "nothing failed so far"),
)  # fmt: skip


def write_compare_page(
    measured: Comparison,
    path: Path,
    remarks: Sequence[str] = (),
    choice: Choice | None = None,
) -> None:
    """Write the page into a file.

    Args:
        measured: the comparison.
        path: file to write; it ends in .html.
        remarks: paragraphs of text that follow the map and the table.
        choice: with what the page opens; that of `choose` if None.

    Raises:
        FileError: another ending, or the file cannot be written.
        ParameterError: nothing was measured at the choice.
    """
    path = Path(path)
    check_writable(path, (".html",))
    content = compare_page(measured, remarks, choice)
    try:
        path.write_text(content, encoding="utf-8")
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error.strerror}", "choose another place"
        ) from error


def compare_page(
    measured: Comparison, remarks: Sequence[str] = (), choice: Choice | None = None
) -> str:
    """The page; the same comparison makes the same text.

    A choice can be put behind its address: `#speed=3&duration=0.2&phase=worst&methods=a,b`.

    Args:
        measured: the comparison.
        remarks: paragraphs of text that follow the map and the table.
        choice: with what the page opens; that of `choose` if None.

    Raises:
        ParameterError: nothing was measured at the choice.
    """
    choice = choose(measured) if choice is None else choice
    table = compare_table(measured, choice)
    folder = files("surefoot.studies.compare")
    scripts = "\n".join(
        f"<script>\n{(folder / name).read_text(encoding='utf-8')}</script>" for name in SCRIPTS
    )
    style = (files("surefoot.studies.engine") / "page.css").read_text(encoding="utf-8") + _colours(
        measured
    )
    body = [
        f"<h1>{HEADING}</h1>",
        f'<p class="source">{escape(_origin(measured))}</p>',
        _controls(),
        _view(),
        f"<noscript><p>{escape(table.note)}</p>{words_table(table.columns, table.rows)}</noscript>",
        *(["<h2>Remarks</h2>"] if remarks else []),
        *(f"<p>{escape(remark)}</p>" for remark in remarks),
        "<h2>What was measured, and how</h2>",
        *(f"<p>{escape(text)}</p>" for text in [*protocol(measured), *cautions(measured)]),
        "<h2>The methods</h2>",
        words_table(
            ("method", "adapts", "what it cannot use", "source"),
            [(m.label, m.adapts, m.cannot, m.source) for m in measured.methods],
        ),
        "<h2>Provenance</h2>",
        words_table(("what", "value"), list(measured.provenance.items())),
    ]
    data = embedded(page_data(measured, choice))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Surefoot {VERSION}: {HEADING.lower()}</title>\n<style>\n{style}</style>\n"
        "</head>\n<body>\n<main>\n" + "\n".join(body) + "\n</main>\n"
        f'<script type="application/json" id="data">{data}</script>\n{scripts}\n</body>\n</html>\n'
    )


def page_data(measured: Comparison, choice: Choice) -> dict[str, Any]:
    """What the script draws from: lists of values, and indices into them.

    `pushes` are (leg speed, duration, phase, angle, four limits), the first four as indices;
    `cells` are (method, push, impulse, delta_v, step, scanned, failure), the first two and the
    last as indices.
    """
    speeds, durations = measured.leg_speeds, measured.push_durations
    phases, angles = measured.phases, measured.angles
    rank = {method.key: index for index, method in enumerate(measured.methods)}
    places: dict[tuple[float, ...], int] = {}
    pushes, cells = [], []
    for cell in measured.cells:
        if cell.condition not in places:
            places[cell.condition] = len(pushes)
            pushes.append(
                [
                    speeds.index(cell.leg_speed), durations.index(cell.push_duration),
                    phases.index(cell.phase), angles.index(cell.angle),
                    cell.limit_point, cell.limit_finite, cell.limit_fixed, cell.limit_causal,
                ]
            )  # fmt: skip
        cells.append(
            [
                rank[cell.method], places[cell.condition], cell.impulse, cell.delta_v, cell.step,
                cell.scanned, FAILURES.index(cell.failure),
            ]
        )  # fmt: skip
    return {
        "choice": {
            "speed": speeds.index(choice.leg_speed),
            "duration": durations.index(choice.push_duration),
            "phase": phases.index(choice.phase),
        },
        "directions": DIRECTIONS,
        "failures": FAILURES,
        "speeds": speeds,
        "durations": durations,
        "phases": phases,
        "angles": angles,
        "methods": [
            {
                "key": method.key, "label": method.label, "adapts": method.adapts,
                "p50": method.decision_p50, "tail": method.decision_p99_9,
                "dashed": mark(index).dashed, "outline": mark(index).outline,
            }
            for index, method in enumerate(measured.methods)
        ],
        "pushes": pushes,
        "cells": cells,
    }  # fmt: skip


def embedded(data: Any) -> str:
    """Data as JSON that cannot end the element it stands in; what is no number is a word.

    JSON has no infinity: it is written as the text "inf", and what is not known as "nan".
    """
    text = json.dumps(_spelled(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _spelled(data: Any) -> Any:
    if isinstance(data, float) and not math.isfinite(data):
        return str(data)
    if isinstance(data, dict):
        return {key: _spelled(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_spelled(value) for value in data]
    return data


def _origin(measured: Comparison) -> str:
    known = measured.provenance
    parts = [
        known.get("robot", ""), known.get("velocity", ""), f"{len(measured.methods)} methods",
        f"{len(measured.cells)} scans of pushes", f"Surefoot {VERSION}",
    ]  # fmt: skip
    return "  ·  ".join(part for part in parts if part)


def _colours(measured: Comparison) -> str:
    marks = [mark(index) for index in range(len(measured.methods))]
    light = " ".join(f"--m{index}: {how.colour};" for index, how in enumerate(marks))
    dark = " ".join(f"--m{index}: {how.dark};" for index, how in enumerate(marks))
    return (
        f":root {{ {light} }}\n"
        f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    )


def _controls() -> str:
    return (
        '<p id="finding" class="alive" role="status" aria-live="polite"></p>\n'
        '<form class="alive"><div class="choices">\n'
        '<fieldset id="speed"><legend>Leg speed</legend></fieldset>\n'
        '<fieldset id="duration"><legend>Push lasts</legend></fieldset>\n'
        '</div><fieldset id="phase"><legend>Push starts at this fraction of the step</legend>'
        "</fieldset></form>"
    )


def _view() -> str:
    key = "".join(
        f'<li><svg viewBox="0 0 30 14" aria-hidden="true">{picture}</svg>{words}</li>'
        for picture, words in _KEY
    )
    head = "".join(f'<th scope="col">{heading}</th>' for heading in _HEADINGS)
    return (
        '<div class="view alive">\n<figure>\n'
        '<svg id="map" viewBox="-250 -250 500 500" tabindex="0" role="application" '
        'aria-roledescription="push map" aria-describedby="map-caption" aria-label="Push map: left '
        'and right arrow keys change the direction, up and down the method"></svg>\n'
        '<div id="tip" role="status" hidden></div>\n'
        f'<figcaption id="map-caption"></figcaption>\n<ul class="key">{key}</ul>\n</figure>\n'
        '<div>\n<div class="tools"><button type="button" id="all">Show all</button>'
        '<button type="button" id="none">Show none</button></div>\n'
        '<div class="wide" tabindex="0" role="region" aria-label="Table of methods">'
        f'<table class="numbers"><thead><tr>{head}</tr></thead>\n'
        '<tbody id="rows"></tbody>\n<tfoot><tr id="limits"></tr></tfoot></table></div>\n'
        '<p class="note" id="table-note"></p>\n</div>\n</div>'
    )


def words_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as HTML; the first column heads its rows."""
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in columns)
    body = "\n".join(
        f'<tr><th scope="row">{escape(first)}</th>'
        + "".join(f"<td>{escape(value)}</td>" for value in rest)
        + "</tr>"
        for first, *rest in rows
    )
    return (
        f'<div class="wide"><table class="words"><thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )
