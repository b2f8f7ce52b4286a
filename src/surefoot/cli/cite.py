"""`surefoot cite`: what to cite for a control method, as BibTeX."""

from __future__ import annotations

import re
from pathlib import Path

import click

from surefoot.errors import ParameterError

BIBLIOGRAPHY = Path(__file__).parents[1] / "references.bib"
ITSELF = ("Surefoot", "OnlineGait")
"""For Surefoot: the software, and the paper that it starts from."""

ENTRY = re.compile(r"^@\w+\{(\w+),\n.*?^\}", re.MULTILINE | re.DOTALL)


@click.command()
@click.argument("keys", nargs=-1, metavar="[METHOD|KEY]...")
def cite(keys: tuple[str, ...]) -> None:
    """Print what to cite for control methods, or for Surefoot itself, as BibTeX.

    METHOD is as of `surefoot walk --controller`; a KEY such as Khadiv2020 is one of the
    documentation's references.

    Example: surefoot cite hybrid >> references.bib
    """
    known = {found[1]: found[0] for found in ENTRY.finditer(BIBLIOGRAPHY.read_text("utf-8"))}
    cited = [one for key in keys for one in _cited(key, known)] if keys else list(ITSELF)
    click.echo("\n\n".join(known.get(one, one) for one in dict.fromkeys(cited)))


def _cited(key: str, known: dict[str, str]) -> tuple[str, ...]:
    """Keys of the bibliography, or whole entries that a method brings.

    Raises:
        ParameterError: there is no such key and no such method, or it names nothing to cite.
    """
    if key in known:
        return (key,)
    from surefoot.control.registry import find_method

    one = find_method(key)
    missing = [cited for cited in one.cites if cited not in known and not cited.startswith("@")]
    if missing or not one.cites:
        raise ParameterError(
            f"a method whose `cites` are keys of the references or BibTeX entries ({one.source})",
            f"{key!r} with {', '.join(missing) or 'none'}",
            "name its publications in @method(..., cites=(...))",
        )
    return one.cites
