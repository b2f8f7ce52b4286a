"""The report of a comparison in Markdown, its pictures in a folder beside it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from matplotlib import style
from matplotlib.figure import Figure

from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.plain_table import markdown_table
from surefoot.show.report_files import write_files
from surefoot.studies.compare.compare_page import compare_page
from surefoot.studies.compare.compare_table import compare_table
from surefoot.studies.compare.compare_words import HEADING, cautions, protocol
from surefoot.studies.compare.comparison import Choice, Comparison, choose
from surefoot.studies.compare.fraction_figure import fraction_figure
from surefoot.studies.engine.push_map import push_map_figure
from surefoot.studies.engine.words import angle_words, speed_words
from surefoot.version import VERSION

PAGE, TEXT, PICTURES = "compare.html", "compare.md", "pictures"
"""Names of the files, and of the folder of pictures beside them."""


def write_compare_report(
    measured: Comparison,
    folder: Path,
    remarks: Sequence[str] = (),
    choice: Choice | None = None,
) -> list[Path]:
    """Write page, text and pictures; the same comparison makes the same bytes.

    Args:
        measured: the comparison.
        folder: where to write; made if it does not exist.
        remarks: paragraphs of text that follow the summary.
        choice: the push that single numbers are of, and with which the page opens; that of
            `choose` if None.

    Returns:
        The files, the page first.

    Raises:
        FileError: the folder cannot be made or written to.
        ParameterError: nothing was measured at the choice.
    """
    choice = choose(measured) if choice is None else choice
    files = {
        PAGE: compare_page(measured, remarks, choice).encode(),
        TEXT: compare_text(measured, remarks, choice).encode(),
    }
    for name, _, draw in _pictures(measured, choice):
        with style.context(["default", palette.STYLE]):
            figure = draw()
        title = figure.get_suptitle()
        files[f"{PICTURES}/{name}.png"] = picture_bytes(figure, "png", title)
    return write_files(files, folder, subfolders=(PICTURES,))


def compare_text(
    measured: Comparison, remarks: Sequence[str] = (), choice: Choice | None = None
) -> str:
    """The report in Markdown.

    Args:
        measured: the comparison.
        remarks: paragraphs of text that follow the summary.
        choice: the push that single numbers are of; that of `choose` if None.

    Raises:
        ParameterError: nothing was measured at the choice.
    """
    choice = choose(measured) if choice is None else choice
    lines = [f"# {HEADING}", "", _summary(measured), ""]
    for remark in remarks:
        lines += [remark, ""]
    lines += ["## What was measured, and how", ""]
    for paragraph in [*protocol(measured), *cautions(measured)]:
        lines += [paragraph, ""]
    pictures = {name: caption for name, caption, _ in _pictures(measured, choice)}
    lines += ["## All leg speeds", "", *_picture("shares", pictures)]
    for leg_speed in measured.leg_speeds:
        table = compare_table(measured, Choice(leg_speed, choice.push_duration, choice.phase))
        lines += [f"## {table.title}", "", table.note, ""]
        lines += markdown_table(table.columns, table.rows)
        lines += _picture(_map_name(leg_speed), pictures)
    lines += ["## Where methods fail by not settling", "", *_unsettled(measured)]
    lines += ["## The methods", ""]
    lines += markdown_table(
        ("method", "adapts", "what it cannot use", "source"),
        [(m.label, m.adapts, m.cannot, m.source) for m in measured.methods],
    )
    lines += ["## Provenance", ""]
    lines += markdown_table(("what", "value"), list(measured.provenance.items()))
    return "\n".join(lines)


def _summary(measured: Comparison) -> str:
    return (
        f"Surefoot {VERSION}: {len(measured.methods)} methods, {len(measured.cells)} scans of "
        "pushes, measured against the limit that no policy can pass. "
        f"[{PAGE}]({PAGE}) shows the same and lets you choose."
    )


def _picture(name: str, captions: dict[str, str]) -> list[str]:
    if name not in captions:
        return []
    return [f"![{captions[name]}]({PICTURES}/{name}.png)", "", captions[name], ""]


def _pictures(
    measured: Comparison, choice: Choice
) -> Iterator[tuple[str, str, Callable[[], Figure]]]:
    """Name, caption and maker of every picture."""
    yield (
        "shares",
        "Mean and worst share of the limit for every leg speed, and the time that a control cycle "
        "takes: median and the time that 999 of 1000 cycles keep.",
        lambda: fraction_figure(measured),
    )
    duration = choice.push_duration
    for leg_speed in measured.leg_speeds:
        if not measured.select(leg_speed=leg_speed, push_duration=duration):
            continue
        yield (
            _map_name(leg_speed),
            f"{speed_words(leg_speed).capitalize()}, pushes of {duration:g} s: the largest "
            "survived impulse in every direction, from above, forward up; the dark outline is the "
            "limit of any policy.",
            lambda leg_speed=leg_speed: push_map_figure(measured, leg_speed, duration),
        )


def _map_name(leg_speed: float) -> str:
    return "map-" + re.sub(r"\W", "_", f"{leg_speed:g}")


def _unsettled(measured: Comparison) -> list[str]:
    """Where the smallest failing push left the robot walking, but not on its gait."""
    lines = []
    for method in measured.methods:
        own = measured.select(method=method.key)
        unsettled = [cell for cell in own if cell.failure == "unsettled"]
        if not unsettled:
            continue
        angles = sorted({cell.angle for cell in unsettled})
        where = ", ".join(
            f"{angle_words(angle)} ({sum(cell.angle == angle for cell in unsettled)})"
            for angle in angles[:12]
        ) + (f" and {len(angles) - 12} directions more" if len(angles) > 12 else "")
        lines.append(f"- {method.label}: {len(unsettled)} of {len(own)} cells; {where}.")
    return [*(lines or ["Nowhere: every failing push made the robot fall."]), ""]
