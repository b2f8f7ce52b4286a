"""The report of a tuning: for the terminal, and as text with its picture and the settings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib import style
from rich.console import Console
from rich.table import Table as TerminalTable

from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.plain_table import markdown_table
from surefoot.show.report_files import write_files
from surefoot.studies.tune.tune_figure import tune_figure
from surefoot.studies.tune.tune_words import (
    COLUMNS,
    RULE,
    changes,
    dropped_words,
    front_rows,
    outcome,
    score_rows,
    verdict,
)
from surefoot.version import VERSION

TEXT, PICTURE, SETTINGS = "tune.md", "tune.png", "tuned.toml"
"""Names of the files."""


def print_tuning(tuned: Mapping[str, Any], console: Console) -> None:
    """Print what came out, what changed and why, and whether it holds.

    Args:
        tuned: plain values of a tuning.
        console: where to print.
    """
    console.print(outcome(tuned), highlight=False)
    for text in changes(tuned):
        console.print(f"  {text}", highlight=False)
    table = TerminalTable(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
    for number, name in enumerate(COLUMNS[:5]):
        table.add_column(name, justify="left" if number < 2 else "right", no_wrap=True)
    for row in score_rows(tuned):
        table.add_row(*row[:5])
    console.print(table)
    for text in (verdict(tuned), dropped_words(tuned)):
        if text:
            console.print(text, highlight=False)


def tuning_text(tuned: Mapping[str, Any], command: str) -> str:
    """The report in Markdown; `command` walks with the settings."""
    about = tuned["provenance"]
    lines = [f"# {_title(tuned)}", "", f"Surefoot {VERSION}. {outcome(tuned)}", ""]
    lines += [f"![Survival over gentleness of every trial]({PICTURE})", ""]
    lines += ["## What changed, and why", ""]
    told = [f"- {text}" for text in changes(tuned)]
    lines += [*(told or ["Nothing."]), ""]
    lines += ["Each is turned back alone, the others stay.", ""] if told else []
    lines += [dropped_words(tuned), ""] if tuned["dropped"] else []
    lines += ["## Does it hold?", ""]
    lines += [verdict(tuned), ""] if tuned["changed"] else []
    lines += markdown_table(COLUMNS, score_rows(tuned))
    lines += [RULE, "", f"The small pushes have {about['small push']}.", ""]
    lines += ["## What else there is", ""]
    lines += ["The trials that no other one beats, whatever is preferred.", ""]
    lines += markdown_table(("trial", "survived", "gentleness", "values"), front_rows(tuned))
    lines += ["## Walk with it", "", "```sh", command, "```", ""]
    lines += ["## Provenance", ""]
    lines += markdown_table(("what", "value"), list(about.items()))
    return "\n".join(lines)


def settings_notes(tuned: Mapping[str, Any], command: str) -> list[str]:
    """What stands above the settings in their file."""
    about = tuned["provenance"]
    return [
        f"{_title(tuned)} (Surefoot {VERSION}, {about['trials']} trials, seed {about['seed']})",
        *changes(tuned),
        *([verdict(tuned)] if tuned["changed"] else []),
        f"Walk with it: {command}",
    ]


def write_tuning(tuned: Mapping[str, Any], settings: str, folder: Path, command: str) -> list[Path]:
    """Write text, picture and settings.

    Args:
        tuned: plain values of a tuning.
        settings: the content of their file.
        folder: where to write; it exists.
        command: that walks with the settings.

    Returns:
        The files, in this order.

    Raises:
        FileError: the folder cannot be written to.
    """
    with style.context(["default", palette.STYLE]):
        figure = tune_figure(tuned, _title(tuned))
    files = {
        TEXT: tuning_text(tuned, command).encode(),
        PICTURE: picture_bytes(figure, "png", figure.get_suptitle()),
        SETTINGS: settings.encode(),
    }
    return write_files(files, folder)


def _title(tuned: Mapping[str, Any]) -> str:
    about = tuned["provenance"]
    return f"{tuned['controller']} tuned for {about['robot']} at {about['velocity']}"
