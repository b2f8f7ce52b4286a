"""The report beside the paper: one HTML page that needs nothing else, and the same in Markdown."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from surefoot.errors import ParameterError
from surefoot.show.plain_table import Table, markdown_table
from surefoot.show.report_files import write_files
from surefoot.version import VERSION

COLUMNS = ("where", "what", "paper", "ours", "verdict", "why")
"""Of the table of claims."""

PICTURES = "pictures"
"""The folder of pictures beside page and text."""

CLOCK_WORDS = (
    "How long a decision takes is measured on the clock of the machine and differs from run to "
    "run, so that picture lies beside this page and is no part of it"
)

_CSS = """
:root { color-scheme: light dark; --line: #8885; --good: #00735a; --bad: #b00028; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .87rem; }
th, td { text-align: left; vertical-align: top; padding: .45rem .6rem; }
tr { border-bottom: 1px solid var(--line); } th { white-space: nowrap; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.verdict { font-weight: 600; color: var(--good); } .verdict.not { color: var(--bad); }
figure { margin: 1.4rem 0; } figcaption { font-size: .9rem; margin-top: .3rem; }
img { max-width: 100%; height: auto; background: #fff; border-radius: 4px; }
@media (prefers-color-scheme: dark) { :root { --good: #5fd3b0; --bad: #ff8095; } }
"""


@dataclass(frozen=True)
class PaperReport:
    """What the report says; plain data, so that it can come from anywhere.

    Attributes:
        claims: rows of `COLUMNS`.
        parameters: (name, value) of what was run.
        pictures: PNG files by name, in order.
        captions: of the pictures, by name.
        tables: more tables.
        clock_pictures: PNG files by name that differ from run to run.
        name: of the files, without their ending.
        heading: of the report.
        command: that makes it.
    """

    claims: Sequence[Sequence[str]]
    parameters: Sequence[tuple[str, str]]
    pictures: Mapping[str, bytes]
    captions: Mapping[str, str]
    tables: Sequence[Table] = ()
    clock_pictures: Mapping[str, bytes] = field(default_factory=dict)
    name: str = "paper"
    heading: str = "The paper, figure by figure and number by number"
    command: str = "surefoot reproduce"

    def __post_init__(self) -> None:
        for row in self.claims:
            if len(row) != len(COLUMNS):
                raise ParameterError(
                    f"claims of {len(COLUMNS)} texts: {', '.join(COLUMNS)}",
                    f"{len(row)}: {row!r}",
                    "give one text for each column",
                )
        missing = sorted(set(self.pictures) - set(self.captions))
        if missing:
            raise ParameterError(
                "a caption for every picture", f"none for {', '.join(missing)}", "add them"
            )


def write_paper_report(report: PaperReport, folder: Path) -> list[Path]:
    """Write page, text and pictures; the same report makes the same bytes.

    Args:
        report: what to say.
        folder: where to write; made if it does not exist.

    Returns:
        The files, the page first.

    Raises:
        FileError: the folder cannot be made or written to.
    """
    files = {f"{report.name}.html": page(report).encode()}
    files[f"{report.name}.md"] = text(report).encode()
    for name, content in {**report.pictures, **report.clock_pictures}.items():
        files[f"{PICTURES}/{name}.png"] = content
    return write_files(files, folder, subfolders=(PICTURES,))


def counts(report: PaperReport) -> list[tuple[str, int]]:
    """How often each verdict was reached, in the order in which they first occur."""
    verdicts = [row[COLUMNS.index("verdict")] for row in report.claims]
    return [(verdict, verdicts.count(verdict)) for verdict in dict.fromkeys(verdicts)]


def page(report: PaperReport) -> str:
    """The report as one HTML page, pictures included."""
    body = [
        f"<h1>{escape(report.heading)}</h1>",
        f"<p>{escape(_summary(report).replace('`', ''))}</p>",
        _html_table(("parameter", "value"), report.parameters),
        "<h2>Claims</h2>",
        _html_table(COLUMNS, report.claims),
        "<h2>Figures</h2>",
    ]
    for name, content in report.pictures.items():
        data = base64.b64encode(content).decode()
        caption = escape(report.captions[name])
        body.append(
            f'<figure id="{name}"><img alt="{caption}" src="data:image/png;base64,{data}">'
            f"<figcaption>{caption}</figcaption></figure>"
        )
    for name in report.clock_pictures:
        body.append(
            f'<p>{escape(CLOCK_WORDS)}: <a href="{PICTURES}/{name}.png">{name}.png</a>.</p>'
        )
    for table in report.tables:
        body.append(f"<h2>{escape(table.title)}</h2><p>{escape(table.note)}</p>")
        body.append(_html_table(table.columns, table.rows))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Surefoot {VERSION}: the paper reproduced</title>\n<style>{_CSS}</style>\n"
        "</head>\n<body>\n<main>\n" + "\n".join(body) + "\n</main>\n</body>\n</html>\n"
    )


def text(report: PaperReport) -> str:
    """The report in Markdown; its pictures lie in a folder beside it."""
    lines = [f"# {report.heading}", "", _summary(report), ""]
    lines += markdown_table(("parameter", "value"), report.parameters)
    lines += ["## Claims", ""]
    lines += markdown_table(COLUMNS, report.claims)
    lines += ["## Figures", ""]
    for name in report.pictures:
        caption = report.captions[name]
        lines += [f"![{caption}]({PICTURES}/{name}.png)", "", caption, ""]
    for name in report.clock_pictures:
        lines += [f"{CLOCK_WORDS}: [{name}.png]({PICTURES}/{name}.png).", ""]
    for table in report.tables:
        lines += [f"## {table.title}", "", table.note, ""]
        lines += markdown_table(table.columns, table.rows)
    return "\n".join(lines)


def _summary(report: PaperReport) -> str:
    verdicts = ", ".join(f"{number} {verdict}" for verdict, number in counts(report))
    return (
        f"Surefoot {VERSION}. Claims: {verdicts}. Everything is simulated anew by "
        f"`{report.command}`; no number of ours is written down beforehand."
    )


def _html_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in columns)
    body = "\n".join(
        "<tr>"
        + "".join(_cell(name, value) for name, value in zip(columns, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return (
        f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def _cell(column: str, value: str) -> str:
    kind = ""
    if column == "verdict":
        kind = ' class="verdict not"' if value.startswith("not ") else ' class="verdict"'
    elif value.replace(".", "", 1).isdigit():
        kind = ' class="number"'
    return f"<td{kind}>{escape(value)}</td>"
