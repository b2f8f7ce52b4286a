"""A walk on one page: from above, and over time."""

from __future__ import annotations

import textwrap
from io import BytesIO
from pathlib import Path

from matplotlib import style
from matplotlib.figure import Figure

from surefoot.checks import check_writable
from surefoot.errors import FileError
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.body_figure import draw_body
from surefoot.show.page import WIDTH, lay_out, view_size
from surefoot.show.push_arrows import label_places
from surefoot.show.stances import stances
from surefoot.show.time_plots import draw_time_plots
from surefoot.show.top_view import draw_top_view, extent
from surefoot.show.walk_legend import legend_entries
from surefoot.show.walk_words import fall_evidence, title
from surefoot.version import VERSION

FORMATS = (".png", ".pdf", ".svg")
"""The endings that a picture's file may have."""

RESOLUTION = 160
"""Of a .png [1/in]."""

_SEPARATOR = "  ·  "
_TITLE_LENGTH = 112


def draw_walk(rollout: Rollout, path: Path) -> None:
    """Draw a walk into a file; the same walk gives the same bytes.

    Args:
        rollout: the walk.
        path: file to write; its ending names the format (.png, .pdf, .svg).

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    path = Path(path)
    check_figure_path(path)
    if rollout.body is not None:
        draw_body(rollout, rollout.body, path)
        return
    picture = BytesIO()
    form = path.suffix.lower()[1:]
    with style.context(["default", palette.STYLE]):
        walk_figure(rollout).savefig(
            picture, format=form, dpi=RESOLUTION, metadata=_about(rollout, form)
        )
    try:
        path.write_bytes(picture.getvalue())
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error.strerror}", "choose another place"
        ) from error


def check_figure_path(path: str | Path) -> None:
    """Refuse a path to which no picture can be written, before a walk is computed.

    Nothing is left behind, and an existing file is not touched.

    Raises:
        FileError: an unknown ending, no such directory, or no permission.
    """
    check_writable(Path(path), FORMATS)


def walk_figure(rollout: Rollout) -> Figure:
    """The picture of a walk, in the caller's matplotlib style; `draw_walk` has its own.

    Args:
        rollout: the walk.

    Returns:
        A figure of its own, not known to pyplot.
    """
    parts = stances(rollout)
    ground = extent(rollout, parts)
    size = view_size(ground)
    lines = [level for _, _, level in label_places(rollout, ground.filling(*size), size[0])]
    entries = legend_entries(rollout, parts)
    headline = _headline(title(rollout))
    evidence = textwrap.fill(fall_evidence(rollout), 150)
    headline_height = 0.24 * len(headline.splitlines())
    title_height = 0.14 + headline_height + 0.2 * len(evidence.splitlines())
    page = lay_out(ground, title_height, max(lines, default=-1) + 1, len(entries))

    figure = Figure(figsize=(WIDTH, page.height))
    across, up = 0.25 / WIDTH, 1.0 / page.height
    figure.text(
        across, 1.0 - 0.14 * up, headline, fontsize=12.0, fontweight="bold", va="top", gid="title"
    )
    if evidence:
        figure.text(
            across,
            1.0 - (0.18 + headline_height) * up,
            evidence,
            fontsize=9.0,
            va="top",
            color=palette.ALARM,
            gid="fall-evidence",
        )
    draw_top_view(page.add_axes(figure, page.top_view), rollout, parts, page.shown)
    draw_time_plots(page.add_time_axes(figure), rollout, parts)
    figure.legend(
        handles=entries,
        loc="upper left",
        ncols=page.legend_columns,
        frameon=False,
        bbox_to_anchor=(page.legend[0] / WIDTH, 1.0 - page.legend[1] * up),
        borderaxespad=0.0,
        borderpad=0.0,
        labelspacing=0.35,
        handlelength=2.2,
        columnspacing=1.2,
    )
    return figure


def _headline(parts: list[str]) -> str:
    """The parts of a title, with a new line before what does not fit any more."""
    text, room = "", _TITLE_LENGTH
    for part in parts:
        if text and room < len(part):
            text, room = f"{text}\n{part}", _TITLE_LENGTH
        else:
            text = f"{text}{_SEPARATOR}{part}" if text else part
        room -= len(part) + len(_SEPARATOR)
    return text


def _about(rollout: Rollout, form: str) -> dict[str, str | None]:
    """What the file says of itself, without a date."""
    maker = f"Surefoot {VERSION}"
    name = ", ".join(title(rollout))
    settings = f"{rollout.controller}({rollout.controller_parameters})"
    if form == "png":
        return {"Title": name, "Description": settings, "Software": maker}
    if form == "pdf":
        about = {"Title": name, "Subject": settings, "Creator": maker, "Producer": maker}
        return {**about, "CreationDate": None}
    return {"Title": name, "Description": settings, "Creator": maker, "Date": None}
