"""A report says the same in a terminal, in Markdown and on a page that needs nothing else."""

from __future__ import annotations

import io
import json
import re
from html import unescape
from pathlib import Path

import pytest
from matplotlib.figure import Figure as Picture
from rich.console import Console

import surefoot as sf
from surefoot.studies.engine.report import (
    Details,
    Figure,
    Interactive,
    Report,
    Table,
    Text,
    embedded,
    word_table,
)

NASTY = "</script><b> | `&` [m/s] and more"

WIDE = Table(
    "By method",
    "Shares of the limit; see [the protocol](protocol.md).",
    ("method", "what it adapts", *(f"direction {number} [N s]" for number in range(7))),
    [
        (f"method {row} {NASTY}", "step location and the time of the landing too",
         *(f"{10 * row + number}.5" for number in range(6)), "–")
        for row in range(3)
    ],
)  # fmt: skip


def drawn() -> Picture:
    figure = Picture(figsize=(2.0, 1.0))
    figure.suptitle("a picture")
    return figure


REPORT = Report(
    "falls",
    "Who falls & why",
    ("paper-biped", "", "3 methods"),
    (
        Text(f"A heavier robot falls later. {NASTY}"),
        WIDE,
        Figure("pictures/falls.png", "When each of them fell.", drawn),
        Figure("times.png", "Times differ from run to run", drawn, page="link"),
        Figure("drawn.png", "The page draws this itself.", drawn, page="none"),
        Interactive("<p id='live'></p>", {"end": float("inf"), "x": NASTY}, "let a = 1 < 2;"),
        Details("Provenance", [word_table(("what", "value"), {"date": "today"})], folded=True),
    ),
)


def printed(report: Report, width: int) -> str:
    stream = io.StringIO()
    report.print(Console(file=stream, width=width))
    return stream.getvalue()


@pytest.mark.parametrize("width", [60, 80, 200])
def test_the_terminal_shows_every_number_whatever_its_width(width: int) -> None:
    lines = printed(REPORT, width).splitlines()
    assert max(len(line.rstrip()) for line in lines) <= width
    for row in WIDE.rows:
        for value in row[2:]:
            assert any(value in line for line in lines)
    for number in range(7):
        heads = (f"direction {number}", f"{number} [N s]")
        assert any(head in line for line in lines for head in heads)
    assert any("[N s]" in line for line in lines)
    # Every piece begins with the name of its rows.
    heads = sum(re.match(r"method +(?!\d)", line) is not None for line in lines)
    assert (heads > 1) == (width < 200)


def test_every_piece_of_a_wide_table_begins_with_what_names_a_row() -> None:
    numbers = tuple(f"{10 * number}" for number in range(12))
    rows = [("here", "now", *numbers), ("here", "then", *numbers)]
    columns = ("where", "when", *(f"column {number}" for number in range(12)))
    said = io.StringIO()
    shown = Report("wide", "Wide", (), [Table("", "", columns, rows, names=2)])
    shown.print(Console(file=said, width=60))
    lines = [line for line in said.getvalue().splitlines() if line.startswith(("here", "where"))]
    assert len(lines) >= 6
    assert all(line.split()[1] in ("when", "now", "then") for line in lines)


def test_every_word_is_in_all_three_forms() -> None:
    text, page = REPORT.markdown(), unescape(REPORT.html())
    terminal = " ".join(printed(REPORT, 400).split())
    for row in WIDE.rows:
        assert "| " + " | ".join(one.replace("|", "\\|") for one in row) + " |" in text
        for value in row:
            assert f">{value}</" in page
            assert " ".join(value.split()) in terminal
    for words in ("Who falls & why", "A heavier robot falls later.", "Shares of the limit"):
        assert words in text
        assert words in page
        assert words in terminal
    for words in ("When each of them fell.", "Provenance", "today"):
        assert words in text
        assert words in page


def test_numbers_stand_to_the_right() -> None:
    assert [WIDE.numeric(column) for column in range(9)] == [False] * 2 + [True] * 6 + [False]
    table = Table("", "", ("a", "b"), [("x", "≥ 60 %"), ("y", "> 30"), ("z", "–")])
    assert table.numeric(1)
    assert '<td class="number">&gt; 30</td>' in Report("r", "R", (), (table,)).html()


def test_what_is_alarming_has_a_colour_of_its_own() -> None:
    verdicts = [("Fig. 4", "reproduced"), ("Fig. 5", "not reproduced")]
    table = Table("", "", ("where", "verdict"), verdicts, alarming=("not reproduced",))
    page = Report("claims", "Claims", (), (table,)).html()
    assert re.findall(r'<td class="alarm">([^<]*)</td>', page) == ["not reproduced"]


def test_a_page_loads_nothing_and_says_so() -> None:
    page = REPORT.html()
    assert not re.search(r"""(?:src|href)=["'](?!data:|times\.png|protocol\.md)""", page)
    assert not re.search(r"https?://|@import|url\(", page)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    assert policy[1].startswith("default-src 'none'")
    assert "script-src" in policy[1]
    still = Report("r", "R", (), (WIDE,)).html()
    assert "script" not in still.split("<body>")[0]
    assert "<script" not in still


def test_data_cannot_end_the_element_it_stands_in() -> None:
    page = REPORT.html()
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    assert json.loads(found[1]) == {"end": "inf", "x": NASTY}
    assert embedded(float("nan")) == '"nan"'


def test_the_same_report_is_the_same_bytes(tmp_path: Path) -> None:
    first, second = (REPORT.write(tmp_path / name) for name in ("one", "two"))
    assert [str(path.relative_to(tmp_path / "one")) for path in first] == [
        "falls.html", "falls.md", "pictures/falls.png", "times.png", "drawn.png",
    ]  # fmt: skip
    for one, two in zip(first, second, strict=True):
        assert one.read_bytes() == two.read_bytes()
    text = first[1].read_text()
    assert "![When each of them fell.](pictures/falls.png)" in text
    assert "[times.png](times.png)" in text
    assert "![The page draws this itself.](drawn.png)" in text
    page = first[0].read_text()
    assert page.count("<img") == 1
    assert '<a href="times.png">' in page
    assert "draws this itself" not in page


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(sf.FileError, match="expected a folder that can be written to"):
        REPORT.write(tmp_path / "file")


def test_a_row_has_one_text_for_each_column() -> None:
    with pytest.raises(sf.ParameterError, match="rows of 2 texts: a, b; got 1"):
        Table("", "", ("a", "b"), [("x",)])
