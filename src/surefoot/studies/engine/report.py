"""A report of a study: one value that is printed, written as Markdown, and written as one page.

What is shown is said once, as parts in an order:

    report = Report(
        name="falls",
        heading="Who falls",
        origin=("paper-biped", "2 masses"),
        parts=(
            Text("A heavier robot falls later."),
            Table("By mass", "Time of the fall.", ("mass [kg]", "fell after"), [("70", "3.2 s")]),
            Figure("falls.png", "When each of them fell.", lambda: falls_figure(rows)),
            provenance(found.provenance),
        ),
    )
    report.print(Console())
    page, text, picture = report.write(folder)  # falls.html, falls.md, falls.png

| part | terminal | Markdown | page |
| --- | --- | --- | --- |
| `Text` | a paragraph | a paragraph | a paragraph |
| `Table` | in pieces if it is too wide | under its heading | under its heading |
| `Figure` | left out | a link to its file | inside the page, a link, or left out |
| `Details` | left out | under a heading | under a heading, folded if asked |
| `Interactive` | left out | left out | with its script, inside the page |

Words may hold `code` and [links](address). The page is one file that loads nothing, which its
Content-Security-Policy says too; the same report makes the same bytes.
"""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

from matplotlib import style
from rich.console import Console
from rich.text import Text as TerminalText

from surefoot.checks import optional_module
from surefoot.errors import FileError, ParameterError
from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.studies.engine.terminal_table import print_rows
from surefoot.version import VERSION

_NUMBER = re.compile("[-+\N{MINUS SIGN}±≥>~]?\\s*[\\d.]")
_CODE, _LINK = re.compile(r"`([^`]+)`"), re.compile(r"\[([^\]]+)\]\(([^)]+)\)")


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    words: str


@dataclass(frozen=True)
class Table:
    """A table with a heading.

    Attributes:
        title: its heading; empty for none.
        note: what it shows, in a sentence or two.
        columns: headings, first those of what names a row.
        rows: one text for each column; numbers as they are to be read.
        names: how many columns name a row; all pieces of a table that is wider than the terminal
            begin with them.
        alarming: texts that a page shows in the colour of an alarm, such as a failed verdict.
    """

    title: str
    note: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: int = 1
    alarming: Sequence[str] = ()

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ParameterError(
                    f"rows of {len(self.columns)} texts: {', '.join(self.columns)}",
                    f"{len(row)}: {row!r}",
                    "give one text for each column",
                )

    def numeric(self, column: int) -> bool:
        """Whether a column holds numbers, which stand to the right; a dash is no number, but not
        against it."""
        values = [row[column] for row in self.rows if row[column] not in ("", "–")]
        return bool(values) and all(_NUMBER.match(value) for value in values)


@dataclass(frozen=True)
class Figure:
    """A picture.

    Attributes:
        name: of its file inside the folder, with folders and its ending, .png on a page.
        caption: what it shows.
        draw: makes it, in the style of the package.
        page: whether the page holds it; or links it, as one that differs from run to run, since
            times do; or leaves it out, as one that the page draws itself.
    """

    name: str
    caption: str
    draw: Callable[[], Any]
    page: Literal["inside", "link", "none"] = "inside"

    def content(self) -> bytes:
        """The content of its file."""
        with style.context(["default", palette.STYLE]):
            figure = self.draw()
        return picture_bytes(figure, self.name.rpartition(".")[2], figure.get_suptitle())


@dataclass(frozen=True)
class Details:
    """Parts for a reader who asks for more.

    Attributes:
        title: their heading.
        parts: what is under it.
        folded: whether a page shows only the heading, until the reader opens it.
    """

    title: str
    parts: Sequence[Part]
    folded: bool = False


@dataclass(frozen=True)
class Interactive:
    """A part of a page that draws itself, as the reader chooses.

    Attributes:
        markup: HTML with what the script fills; a picture with the id `map` is among it.
        data: what it draws from, plain values, in the element `data`: `angles` and `directions` of
            polar maps [deg], `choices` made by `choice`, and whatever the script takes.
        script: JavaScript that runs after `page.js`, which all pages share.
    """

    markup: str
    data: Any
    script: str

    @classmethod
    def of(cls, package: str, data: Any) -> Interactive:
        """The one whose `page.html` and `page.js` lie in a package, such as that of a study."""
        folder = files(package)
        markup, script = ((folder / f"page.{kind}").read_text("utf-8") for kind in ("html", "js"))
        return cls(markup, data, script)


def choice(values: Sequence[Any], words: Sequence[str], chosen: int) -> dict[str, Any]:
    """What a reader may choose: values, words of each, and the index of the one at the beginning.

    The control has the id of the choice: a range, or what is to hold a button for each value.
    """
    return {"values": list(values), "words": list(words), "chosen": chosen}


Part = Text | Table | Figure | Details | Interactive


@dataclass(frozen=True)
class Report:
    """What a study has to say.

    Attributes:
        name: of the files, without their endings.
        heading: of the report.
        origin: what it is made of, in a few words each; empty ones are left out.
        parts: in the order in which they are read.
    """

    name: str
    heading: str
    origin: Sequence[str]
    parts: Sequence[Part] = field(default_factory=tuple)

    @property
    def source(self) -> str:
        """The line under the heading."""
        return "  ·  ".join(part for part in (*self.origin, f"Surefoot {VERSION}") if part)

    def print(self, console: Console) -> None:
        """Print what a reader wants first: paragraphs and tables."""
        console.print(TerminalText(self.heading, style="bold"))
        console.print(TerminalText(self.source))
        for part in self.parts:
            if isinstance(part, Text):
                console.print()
                console.print(TerminalText(_bare(part.words)))
            elif isinstance(part, Table):
                console.print()
                _print_table(part, console)

    def markdown(self) -> str:
        """The report in Markdown; its pictures are files beside it."""
        page = f"{self.name}.html"
        lines = [f"# {self.heading}", "", f"{self.source}. As a page: [{page}]({page}).", ""]
        for part in self.parts:
            lines += _markdown(part)
        return "\n".join(lines)

    def html(self, pictures: Mapping[str, bytes] | None = None) -> str:
        """The report as one page.

        Args:
            pictures: contents of the figures by name; drawn if None.

        Raises:
            MissingExtraError: jinja2 is not installed.
        """
        jinja2 = optional_module("jinja2", "reports of studies", "study")
        folder = files("surefoot.studies.engine")
        contents = self.pictures() if pictures is None else pictures
        live = [part for part in _all_parts(self.parts) if isinstance(part, Interactive)]
        environment = jinja2.Environment(
            autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
        )
        environment.filters["prose"] = _prose
        environment.filters["kind"] = lambda part: type(part).__name__
        environment.filters["png"] = lambda part: base64.b64encode(contents[part.name]).decode()
        template = environment.from_string((folder / "report.html").read_text("utf-8"))
        return template.render(
            report=self,
            version=VERSION,
            style=(folder / "page.css").read_text("utf-8"),
            shared=(folder / "page.js").read_text("utf-8"),
            live=live,
            embedded=embedded,
        )

    def pictures(self) -> dict[str, bytes]:
        """The contents of all figures, by name."""
        return {p.name: p.content() for p in _all_parts(self.parts) if isinstance(p, Figure)}

    def write(self, folder: Path) -> list[Path]:
        """Write page, text and pictures; the same report makes the same bytes.

        Args:
            folder: where to write; made if it does not exist.

        Returns:
            The files: the page, the text, the pictures in their order.

        Raises:
            FileError: the folder cannot be made or written to.
            MissingExtraError: jinja2 is not installed.
        """
        pictures = self.pictures()
        contents = {
            f"{self.name}.html": self.html(pictures).encode(),
            f"{self.name}.md": self.markdown().encode(),
            **pictures,
        }
        return write_files(contents, folder)


def write_files(contents: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write files into a folder, which is made if it does not exist.

    Args:
        contents: by path inside the folder.
        folder: where to write.

    Returns:
        The files, in the order given.

    Raises:
        FileError: the folder cannot be made or written to.
    """
    try:
        for name, content in contents.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    except OSError as error:
        raise FileError(
            "a folder that can be written to", f"{folder}: {error.strerror}", "choose another place"
        ) from error
    return [folder / name for name in contents]


def word_table(columns: tuple[str, str], words: Mapping[str, str]) -> Table:
    """Names and their values as a table without a heading, such as a provenance."""
    return Table("", "", columns, list(words.items()))


def provenance(about: Mapping[str, str], title: str = "Provenance") -> Details:
    """What a study says of itself, to be made again."""
    return Details(title, [word_table(("what", "value"), about)])


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


def _all_parts(parts: Sequence[Part]) -> Iterator[Part]:
    """All of them, with those of details."""
    for part in parts:
        yield part
        if isinstance(part, Details):
            yield from _all_parts(part.parts)


def _bare(words: str) -> str:
    """Words without the marks of code and links."""
    return _LINK.sub(r"\1", words).replace("`", "")


def _prose(words: str) -> Any:
    """Words as HTML."""
    markup = optional_module("markupsafe", "reports of studies", "study")
    text = _CODE.sub(r"<code>\1</code>", str(markup.escape(words)))
    return markup.Markup(_LINK.sub(r'<a href="\2">\1</a>', text))


def _markdown(part: Part) -> list[str]:
    """The lines of a part, an empty one last."""
    if isinstance(part, Text):
        return [part.words, ""]
    if isinstance(part, Figure):
        if part.page == "link":
            return [f"{part.caption}: [{part.name}]({part.name}).", ""]
        return [f"![{part.caption}]({part.name})", "", part.caption, ""]
    if isinstance(part, Details):
        return [f"## {part.title}", "", *(line for one in part.parts for line in _markdown(one))]
    if isinstance(part, Interactive):
        return []
    lines = [f"## {part.title}", ""] if part.title else []
    lines += [part.note, ""] if part.note else []
    lines += ["| " + " | ".join(part.columns) + " |", "|" + " --- |" * len(part.columns)]
    for row in part.rows:
        # A bar would end the cell.
        lines.append("| " + " | ".join(value.replace("|", "\\|") for value in row) + " |")
    return [*lines, ""]


def _print_table(table: Table, console: Console) -> None:
    if table.title:
        console.print(TerminalText(table.title, style="bold"))
    numeric = [table.numeric(column) for column in range(len(table.columns))]
    print_rows(console, table.columns, table.rows, numeric=numeric, names=table.names)
    if table.note:
        console.print(TerminalText(f"\n{_bare(table.note)}"))
