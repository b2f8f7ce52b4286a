from __future__ import annotations

import re

import pytest

from invoked import run
from surefoot.cli.cite import BIBLIOGRAPHY, ENTRY
from surefoot.control.registry import method, methods


def cite(*words: str, status: int = 0) -> str:
    result = run("cite", *words)
    assert result.exit_code == status, result.output
    return result.output


def keys(text: str) -> list[str]:
    return re.findall(r"^@\w+\{(\w+),", text, re.MULTILINE)


@pytest.mark.parametrize("one", methods(), ids=lambda one: one.key)
def test_every_method_says_what_to_cite(one) -> None:
    told = cite(one.key)
    assert keys(told) == list(one.cites)
    # The year that the table names is one of the entries'.
    years = re.findall(r"\b(?:19|20)\d\d\b", one.source)
    assert set(years) <= set(re.findall(r"year\s*= \{(\d+)\}", told))


def test_an_entry_is_whole_and_printed_once() -> None:
    told = cite("capture-point", "Pratt2006", "Koolen2012")
    assert keys(told) == ["Pratt2006", "Koolen2012"]
    assert told.count("{") == told.count("}")
    assert told.rstrip().endswith("}")
    assert "Capture point: A step toward humanoid push recovery" in told


def test_surefoot_itself() -> None:
    assert keys(cite()) == ["Surefoot", "OnlineGait"]


def test_every_entry_of_the_references_can_be_printed() -> None:
    text = BIBLIOGRAPHY.read_text("utf-8")
    assert [found[1] for found in ENTRY.finditer(text)] == keys(text)


@method("bring", label="", source="a thesis", adapts="", cannot="", cites=("@book{Own,\n}",))
class Brings:
    """Cites what Surefoot does not know."""


@method("lost", label="", source="a thesis", adapts="", cannot="", cites=("Nobody1900",))
class Lost:
    """Cites nothing that is there."""


def test_a_method_brings_an_entry_of_its_own() -> None:
    assert cite(f"{__name__}:Brings") == "@book{Own,\n}\n"


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("Khadiv2061", "a method (tracking, "),
        (f"{__name__}:Lost", "with Nobody1900; name its publications"),
        (f"{__name__}:test_surefoot_itself", "with none"),
    ],
)
def test_what_cannot_be_cited_is_told(key: str, words: str) -> None:
    assert words in cite(key, status=2)
