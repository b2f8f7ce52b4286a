"""The command line, run within the tests' process."""

from __future__ import annotations

from click.testing import CliRunner, Result

from surefoot.cli import main


def run(*arguments: str) -> Result:
    """`surefoot` with these arguments; an error that it does not report itself fails the test."""
    result = CliRunner().invoke(main, list(arguments))
    assert not isinstance(result.exception, Exception), result.exception
    return result
