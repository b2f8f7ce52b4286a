"""The report of a comparison on bodies: one HTML page that needs nothing else, and Markdown."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from matplotlib import style

from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.plain_table import Table, markdown_table
from surefoot.show.report_files import write_files
from surefoot.studies.compare.body_push_figure import body_push_figure
from surefoot.studies.compare.body_pushes import (
    AIM,
    DIRECTIONS,
    BodyPushes,
    body_table,
    explained_table,
    impulse_words,
)
from surefoot.version import VERSION

PAGE, TEXT, PICTURE = "pushes.html", "pushes.md", "pushes.png"
"""Names of the files; the picture lies in the folder of its robot."""

HEADING = "How much push a body survives"

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"

_STYLE = """
img { max-width: 100%; height: auto; background: #fff; border-radius: 6px; display: block; }
.view { display: block; } figure { position: static; }
.words th { white-space: normal; min-width: 7rem; } details { margin: .8rem 0; }
td { min-width: 4.6rem; } summary { cursor: pointer; }
"""


def write_body_report(
    measured: Sequence[BodyPushes], folder: Path, explained: Sequence[dict[str, Any]] = ()
) -> list[Path]:
    """Write page, text and pictures; the same comparisons make the same bytes.

    Args:
        measured: the comparisons, one for each robot.
        folder: where to write; it exists.
        explained: what bound in single pushes, see `explained_table`.

    Returns:
        The files, the page first.

    Raises:
        FileError: the folder cannot be written to.
    """
    pictures = {one.robot: _picture(one) for one in measured}
    contents = {
        PAGE: body_page(measured, pictures, explained).encode(),
        TEXT: body_text(measured, explained).encode(),
    }
    contents |= {f"{robot}/{PICTURE}": picture for robot, picture in pictures.items()}
    return write_files(contents, folder, subfolders=pictures)


def _picture(measured: BodyPushes) -> bytes:
    with style.context(["default", palette.STYLE]):
        figure = body_push_figure(measured)
    return picture_bytes(figure, "png", figure.get_suptitle())


def protocol_words(measured: BodyPushes) -> list[str]:
    """What was measured and how, in paragraphs."""
    phases = len({cell.phase for cell in measured.cells})
    about = measured.provenance
    return [
        f"A robot that walks at {about.get('velocity', '')} is pushed once on its base, for 0.2 s "
        f"from one of {phases} phases of a step on, once while the left foot stands and once while "
        f"the right one does. The impulse is scanned upwards from zero in steps of "
        f"{measured.step:g} N s, never bisected: the smallest that it does not survive ends the "
        "scan. The stance side is that of the foot on the ground, the swing side the other one.",
        "Survived means that for 5 s after the push nothing but the soles touches the floor, the "
        "legs do not touch each other, the trunk leans less than 0.8 rad and stays above 65 % of "
        "its height, and the robot goes on stepping. Motors have limits of torque, speed and "
        "position. A cause is what went wrong first in the last second before the fall.",
        f"Δv is the impulse over the mass, {measured.mass:.4g} kg. The aim is that of the paper, "
        f"85 N s on 70 kg: {AIM:.2f} m/s. With timing fixed a step lasts as long as nominal to "
        "5 ms, with place fixed it lands where nominal to 5 mm; both are the unified controller "
        "with a narrower box of steps.",
        f"What the controllers are told of the body: {about.get('state', '')}.",
    ]


def body_text(measured: Sequence[BodyPushes], explained: Sequence[dict[str, Any]] = ()) -> str:
    """The report in Markdown."""
    lines = [f"# {HEADING}", "", f"Surefoot {VERSION}.", ""]
    for one in measured:
        for table in _tables(one, explained):
            lines += [f"## {table.title}", "", *([table.note, ""] if table.note else [])]
            lines += markdown_table(table.columns, table.rows)
            if table is not None and table.title.startswith(one.robot):
                lines += [f"![Δv over phase]({one.robot}/{PICTURE})", ""]
    lines += ["## What was measured, and how", ""]
    for paragraph in protocol_words(measured[0]):
        lines += [paragraph, ""]
    for one in measured:
        lines += [f"## Provenance of {one.robot}", ""]
        lines += markdown_table(("what", "value"), list(one.provenance.items()))
    return "\n".join(lines)


def body_page(
    measured: Sequence[BodyPushes],
    pictures: dict[str, bytes],
    explained: Sequence[dict[str, Any]] = (),
) -> str:
    """The report as a page.

    Args:
        measured: the comparisons.
        pictures: PNG files by robot.
        explained: what bound in single pushes.
    """
    sheet = (files("surefoot.studies.engine") / "page.css").read_text(encoding="utf-8")
    body = [
        f"<h1>{HEADING}</h1>",
        f'<p class="source">{escape(_origin(measured))}</p>',
    ]
    for one in measured:
        first, *others = _tables(one, explained)
        data = base64.b64encode(pictures[one.robot]).decode()
        body += [
            f"<h2>{escape(first.title)}</h2>",
            f"<p>{escape(first.note)}</p>",
            _html_table(first),
            f'<figure><img alt="Δv over phase, direction and foot, {escape(one.robot)}" '
            f'src="data:image/png;base64,{data}"></figure>',
        ]
        for table in others:
            body += [f"<h2>{escape(table.title)}</h2>", f"<p>{escape(table.note)}</p>"]
            body.append(_html_table(table))
        body += [
            "<details><summary>Every scan</summary>",
            _html_table(every_scan(one)),
            "</details>",
        ]
    body.append("<h2>What was measured, and how</h2>")
    body += [f"<p>{escape(text)}</p>" for text in protocol_words(measured[0])]
    for one in measured:
        rows = list(one.provenance.items())
        body.append(f"<h2>Provenance of {escape(one.robot)}</h2>")
        body.append(_html_table(Table("", "", ("what", "value"), rows)))
    return (
        '<!doctype html>\n<html lang="en" class="live">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Surefoot {VERSION}: {HEADING.lower()}</title>\n<style>\n{sheet}{_STYLE}</style>\n"
        "</head>\n<body>\n<main>\n" + "\n".join(body) + "\n</main>\n</body>\n</html>\n"
    )


def every_scan(measured: BodyPushes) -> Table:
    """All scans with what was seen of their falls."""
    order = {direction: place for place, direction in enumerate(DIRECTIONS)}
    rows = [
        (label, cell.direction, cell.foot, f"{cell.phase:.3g}", impulse_words(cell), cell.words)
        for key, label, _ in measured.methods
        for cell in sorted(measured.of(key), key=lambda c: (order[c.direction], c.foot, c.phase))
    ]
    columns = ("method", "direction", "foot", "phase", "N s (Δv)", "what was seen of the fall")
    return Table("Every scan", "", columns, rows)


def _tables(one: BodyPushes, explained: Sequence[dict[str, Any]]) -> list[Table]:
    own = [entry for entry in explained if entry["robot"] == one.robot]
    return [body_table(one), *([explained_table(one, own)] if own else [])]


def _origin(measured: Sequence[BodyPushes]) -> str:
    scans = sum(len(one.cells) for one in measured)
    return "  ·  ".join(
        [
            ", ".join(one.robot for one in measured),
            f"{len({key for one in measured for key, _, _ in one.methods})} methods",
            f"{scans} scans of pushes",
            f"Surefoot {VERSION}",
        ]
    )


def _html_table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in table.columns)
    body = "\n".join(
        f'<tr><th scope="row">{escape(first)}</th>'
        + "".join(f"<td>{escape(value)}</td>" for value in rest)
        + "</tr>"
        for first, *rest in table.rows
    )
    return (
        f'<div class="wide"><table class="words"><thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )
