"""The noise-and-delay budget in words: for the terminal, and as a report with its picture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib import style
from rich.console import Console
from rich.table import Table as TerminalTable

from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.plain_table import markdown_table
from surefoot.show.report_files import write_files
from surefoot.studies.compare.budget import Budget, Kept, Wrong
from surefoot.studies.compare.budget_figure import budget_figure, lost_words
from surefoot.studies.engine.words import TIME_WORDS, percent
from surefoot.version import VERSION

TEXT, PICTURE = "budget.md", "budget.png"
"""Names of the files."""

RULE = (
    f"A push is survived if the robot has not fallen {TIME_WORDS} after it, with the same rule "
    "for the undisturbed walk: under noise nobody is back on the gait. The limit is that of any "
    "policy on the robot that is really pushed, undisturbed. Where a disturbance takes several "
    "walks, one for each seed or direction, the worst counts."
)


def print_budget(measured: Budget, console: Console) -> None:
    """Print what is kept and what is lost; methods by number, named below.

    Args:
        measured: the budget.
        console: where to print.
    """
    for title, words in (
        ("% of the limit that is kept", lambda kept: percent(kept.share).removesuffix(" %")),
        ("change against undisturbed, N s", lambda kept: lost_words(kept.lost)),
    ):
        console.print(f"[bold]{title}[/]", highlight=False)
        table = TerminalTable(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
        table.add_column("disturbance")
        for number in range(len(measured.methods)):
            table.add_column(f"{number + 1}", justify="right", no_wrap=True)
        for row in _rows(measured, words):
            table.add_row(*row)
        console.print(table)
        console.print()
    names = [f"{n} {label}" for n, (_, label) in enumerate(measured.methods, start=1)]
    console.print("; ".join(names) + ".", highlight=False)
    console.print(RULE, highlight=False)


def budget_text(measured: Budget) -> str:
    """The report in Markdown."""
    columns = ("disturbance", *(label for _, label in measured.methods))
    lines = ["# What is left of the margin", "", f"Surefoot {VERSION}. {RULE}", ""]
    lines += [f"Means over {measured.situations} pushes.", ""]
    lines += [f"![Share of the limit of every method under every disturbance]({PICTURE})", ""]
    lines += ["## Share of the limit that is kept", ""]
    lines += markdown_table(columns, _rows(measured, lambda kept: percent(kept.share)))
    lines += ["## Change against undisturbed [N s]", ""]
    lines += markdown_table(columns, _rows(measured, lambda kept: lost_words(kept.lost)))
    drawn = {wrong.key for wrong in measured.wrongs if wrong.walks > 1}
    if drawn:
        lines += ["## The same as means over all walks of a disturbance", ""]
        lines += markdown_table(
            columns,
            _rows(
                measured,
                lambda kept: f"{percent(kept.mean_share)}, {lost_words(kept.mean_lost)}",
                lambda wrong: wrong.key in drawn,
            ),
        )
    if not measured.complete:
        lines += ["Not everything was measured on every push: – was not measured.", ""]
    lines += ["## Provenance", ""]
    lines += markdown_table(("what", "value"), list(measured.provenance.items()))
    return "\n".join(lines)


def write_budget_report(measured: Budget, folder: Path) -> list[Path]:
    """Write text and picture; the same budget makes the same bytes.

    Args:
        measured: the budget.
        folder: where to write; it exists.

    Returns:
        The files, the text first.

    Raises:
        FileError: the folder cannot be written to.
    """
    with style.context(["default", palette.STYLE]):
        figure = budget_figure(measured)
    files = {
        TEXT: budget_text(measured).encode(),
        PICTURE: picture_bytes(figure, "png", figure.get_suptitle()),
    }
    return write_files(files, folder)


def _rows(
    measured: Budget,
    words: Callable[[Kept], str],
    wanted: Callable[[Wrong], bool] = lambda _: True,
) -> list[tuple[str, ...]]:
    rows = []
    for wrong in filter(wanted, measured.wrongs):
        kept = [measured.kept.get((method, wrong.key)) for method, _ in measured.methods]
        label = wrong.label if wrong.walks == 1 else f"{wrong.label} ({wrong.walks} walks)"
        rows.append((label, *("–" if one is None else words(one) for one in kept)))
    return rows
