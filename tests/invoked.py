"""The command line, run within the tests' process."""

from __future__ import annotations

import json
from typing import Any

from click.testing import CliRunner, Result

from surefoot.cli import main


def run(*arguments: str) -> Result:
    """`surefoot` with these arguments; an error that it does not report itself fails the test."""
    result = CliRunner().invoke(main, list(arguments))
    assert not isinstance(result.exception, Exception), result.exception
    return result


def numbers(*arguments: str) -> dict[str, Any]:
    """What `surefoot` with these arguments says to a machine."""
    return json.loads(run(*arguments, "--json").stdout)


def refused(*arguments: str) -> str:
    """What `surefoot` says of a wrong command, which exits with 2."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    return result.output
