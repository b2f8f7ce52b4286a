"""The documentation builds, names what exists, and all code in it runs.

The blocks of a page run in order, in one directory and one Python namespace. A python block that is
directly followed by a text block must print just that. A toml or python block whose first line is a
comment with a file name is written to that file instead. Of the shell blocks, the lines that call
surefoot are run; a comment `# exits with 1` at the end gives the expected exit status.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import msgspec
import pytest

import surefoot as sf

ROOT = Path(__file__).parents[1]
DOCS, SOURCE = ROOT / "docs", ROOT / "src" / "surefoot"
PAGES = [*sorted(DOCS.glob("*.md")), *ROOT.glob("README.md")]
BLOCK = re.compile(r"^```(?P<language>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
CITATION = re.compile(r"\[(OnlineGait|[A-Z][A-Za-z]+\d{4})\]")


@dataclass(frozen=True)
class Block:
    language: str
    text: str
    line: int
    printed: str | None
    """The text block that follows directly, if one does."""


def blocks_of(page: str) -> list[Block]:
    found = list(BLOCK.finditer(page))
    blocks = []
    for block, after in zip(found, [*found, None][1:], strict=True):
        printed = None
        if after is not None and after["language"] == "text":
            between = page[block.end() : after.start()]
            printed = after["text"] if not between.strip() else None
        line = page.count("\n", 0, block.start("text"))
        blocks.append(Block(block["language"], block["text"], line, printed))
    return blocks


def commands_of(block: Block) -> list[tuple[list[str], int]]:
    """The words of every surefoot command in a shell block, and the status it is to exit with."""
    lines = block.text.replace("\\\n", " ").splitlines()
    if block.language == "console":
        lines = [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
    commands = []
    for line in lines:
        if line.startswith("surefoot "):
            status = re.search(r"# exits with (\d)", line)
            commands.append((shlex.split(line, comments=True)[1:], int(status[1]) if status else 0))
    return commands


def run_python(block: Block, origin: str, namespace: dict) -> None:
    code = compile("\n" * block.line + block.text, origin, "exec")
    with contextlib.redirect_stdout(io.StringIO()) as output:
        exec(code, namespace)
    if block.printed is not None:
        assert output.getvalue().rstrip() == block.printed.rstrip()


def run_commands(block: Block, folder: Path) -> None:
    surefoot = Path(sysconfig.get_path("scripts")) / "surefoot"
    for words, status in commands_of(block):
        done = subprocess.run([surefoot, *words], cwd=folder, capture_output=True, text=True)
        output = f"surefoot {shlex.join(words)}\n{done.stdout}{done.stderr}"
        assert done.returncode == status, output
        assert "Traceback" not in done.stderr, output


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_code_of_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path), *sys.path)))
    monkeypatch.syspath_prepend(tmp_path)
    namespace = {"__name__": page.stem}
    for block in blocks_of(page.read_text("utf-8")):
        name = re.match(r"# (\S+\.(?:toml|py))\n", block.text)
        if name is not None:
            (tmp_path / name[1]).write_text(block.text, "utf-8")
        elif block.language == "python":
            run_python(block, str(page), namespace)
        elif block.language in ("sh", "bash", "console"):
            run_commands(block, tmp_path)


def test_sphinx_builds_without_a_warning(tmp_path: Path) -> None:
    build = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run(
        [*build, "-d", tmp_path / "trees", DOCS, tmp_path / "html"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "html" / "index.html").exists()


def test_every_cited_key_is_in_the_bibliography() -> None:
    known = set(re.findall(r"^@\w+\{(\w+),", (SOURCE / "references.bib").read_text("utf-8"), re.M))
    texts = [*SOURCE.rglob("*.py"), *DOCS.glob("*.md"), *ROOT.glob("*.md")]
    cited = {
        (key, str(path.relative_to(ROOT)))
        for path in texts
        for key in CITATION.findall(path.read_text("utf-8"))
    }
    assert {key for key, _ in cited} >= {"OnlineGait", "Khadiv2016", "Englsberger2015"}
    assert {(key, path) for key, path in cited if key not in known} == set()


def test_api_page_has_every_public_name() -> None:
    documented = set(
        re.findall(r"^\.\. auto\w+:: surefoot\.(\w+)$", (DOCS / "api.md").read_text("utf-8"), re.M)
    )
    assert documented == set(sf.__all__) - {"__version__"}


def test_files_and_functions_named_in_the_map_exist() -> None:
    page = (DOCS / "architecture.md").read_text("utf-8")
    pages = [page, *((ROOT / name).read_text("utf-8") for name in ("README.md", "CONTRIBUTING.md"))]
    pages += [path.read_text("utf-8") for path in DOCS.glob("*.md")]
    files = {name for text in pages for name in re.findall(r"`((?:\w+/)+\w+\.py)`", text)}
    files -= {"their_robots/__init__.py"}  # of a package that the page makes up
    missing = {name for name in files if not any((at / name).is_file() for at in (ROOT, SOURCE))}
    assert len(files) > 30
    assert missing == set()
    rooms = set(re.findall(r"`(\w+)/`", page))
    assert len(rooms) > 8
    assert {name for name in rooms if not [*SOURCE.glob(f"**/{name}/__init__.py")]} == set()
    tick = page.split("## One tick")[1].split("\n## ")[0].split("```")[-1]
    source = "\n".join(path.read_text("utf-8") for path in SOURCE.rglob("*.py"))
    functions = set(re.findall(r"`([a-z_]+)`", tick)) - {"state", "world"}
    assert {name for name in functions if f"def {name}(" not in source} == set()


def keys_of(struct: type, path: str = "") -> set[str]:
    keys = set()
    for field in msgspec.structs.fields(struct):
        kinds = get_args(field.type) or (field.type,)  # `Trunk | None` has the keys of Trunk
        nested = [k for k in kinds if isinstance(k, type) and issubclass(k, msgspec.Struct)]
        keys |= keys_of(nested[0], f"{path}{field.name}.") if nested else {path + field.name}
    return keys


def test_robot_page_has_every_key() -> None:
    page = (DOCS / "robots.md").read_text("utf-8")
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    assert set(re.findall(r"`([\w.]+)`", "".join(rows))) == keys_of(sf.Robot)


def test_citation_and_changelog_name_the_version() -> None:
    assert f"version: {sf.__version__}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"## [{sf.__version__}]" in (ROOT / "CHANGELOG.md").read_text("utf-8")
