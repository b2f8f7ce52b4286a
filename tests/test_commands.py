"""A command is an entry point: the package's own, a study's, anybody's."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HELLO = '''
import click

@click.command()
@click.argument("name")
def hello(name: str) -> None:
    """Greet somebody.

    At length."""
    import surefoot as sf
    if name == "nobody":
        raise sf.ParameterError("a name", name, "name somebody")
    click.echo(f"hello {name} from {sf.__version__}")
'''


@pytest.fixture
def packages(tmp_path: Path) -> Path:
    """A folder on the path with somebody's package, which brings three commands, two of them
    broken."""
    (tmp_path / "greeting.py").write_text(HELLO)
    (tmp_path / "half.py").write_text("1 / 0\n")
    home = tmp_path / "greeting-1.dist-info"
    home.mkdir()
    (home / "METADATA").write_text("Metadata-Version: 2.1\nName: greeting\nVersion: 1\n")
    (home / "entry_points.txt").write_text(
        "[surefoot.commands]\nhello = greeting:hello\nhalf = half:half\nnumber = greeting:HELLO\n"
    )
    (tmp_path / "greeting.py").write_text(HELLO + "\nHELLO = 3\n")
    return tmp_path


def surefoot(packages: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join((str(packages), *sys.path))
    return subprocess.run(
        [sys.executable, "-c", "from surefoot.cli import main; main()", *arguments],
        capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip


def test_somebodys_command_stands_beside_the_packages_own(packages: Path) -> None:
    done = surefoot(packages, "hello", "Ada")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("hello Ada from ")
    wrong = surefoot(packages, "hello", "nobody")
    assert wrong.returncode == 2
    assert wrong.stderr == "error: expected a name; got nobody; name somebody\n"


def test_help_lists_all_and_says_what_is_broken(packages: Path) -> None:
    done = surefoot(packages, "--help")
    assert done.returncode == 0, done.stderr
    lines = {words[0]: line for line in done.stdout.splitlines() if (words := line.split())}
    own = {"walk", "live", "replay", "robots", "limits", "reproduce", "compare", "push-map",
           "gentleness", "sweep", "tune"}  # fmt: skip
    assert own | {"hello", "half", "number"} <= set(lines)
    assert "Greet somebody." in lines["hello"]
    assert "cannot be loaded: division by zero" in lines["half"]
    assert "cannot be loaded" in lines["number"]
    assert not [name for name in own if "cannot be loaded" in lines[name]]


def test_a_broken_command_says_why(packages: Path) -> None:
    done = surefoot(packages, "half", "--anything", "at", "all")
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr
    done = surefoot(packages, "number")
    assert done.returncode == 2
    assert "expected a command at greeting:HELLO; got 3; decorate it" in done.stderr
    done = surefoot(packages, "fly")
    assert done.returncode == 2
    assert "No such command 'fly'" in done.stderr


def test_a_command_loads_no_other(packages: Path) -> None:
    code = (
        "import sys\nfrom surefoot.cli import main\n"
        "try: main(['limits', '--help'])\n"
        "finally: print([name for name in sys.modules if 'command' in name or 'live' in name])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith("[]")
