"""Rows know the sources that they are of: the study's own folder, the engine and the kernels."""

from __future__ import annotations

import inspect
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

import surefoot as sf
from surefoot import compiled, plugins
from surefoot.studies.compare.body_question import BodyPushes
from surefoot.studies.compare.question import Comparison
from surefoot.studies.engine.study import Study, run, stamp
from surefoot.studies.push_map import question as push_map_question
from surefoot.studies.push_map.question import PushMap

PACKAGE = Path(sf.__file__).parent
STUDIES = PACKAGE / "studies"

QUESTION = """
from dataclasses import dataclass
from surefoot.studies.engine.study import Study

@dataclass(frozen=True)
class Cell:
    number: int

@dataclass(frozen=True)
class Toy(Study):
    NAME = "toy"

    def cells(self):
        return [Cell(1)]

    def measure(self, cell):
        measured.append(cell.number)
        return {"square": cell.number**2}

measured = []
"""

RUN = '''
import json, shutil, sys
from pathlib import Path
from surefoot import load_robot
from surefoot.compiled import source_stamp
from surefoot.errors import FileError
from surefoot.studies.engine.study import run
from surefoot.studies.toy.question import Toy, measured

package, out = map(Path, sys.argv[1:3])

def measures(change=None):
    """How often the cell is measured after a file has changed; whether its old row is refused."""
    if change is not None:
        path = package / change
        path.write_text(path.read_text() + "\\n# another line")
        source_stamp.cache_clear()
    measured.clear()
    refused = False
    try:
        run(Toy(load_robot("paper-biped")), out, workers=1)
    except FileError as error:
        refused = "sources" in str(error) and "delete this one" in str(error)
        shutil.rmtree(out)
        run(Toy(load_robot("paper-biped")), out, workers=1)
    return [len(measured), refused]

print(json.dumps({str(change): measures(change) for change in (None, *sys.argv[3:])}))
'''


def test_a_row_is_measured_again_when_what_it_depends_on_changes(tmp_path: Path) -> None:
    package = tmp_path / "path" / "surefoot"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    toy = package / "studies" / "toy"
    toy.mkdir()
    for name, content in (("__init__", ""), ("question", QUESTION), ("words", "WORD = 1\n")):
        (toy / f"{name}.py").write_text(content)
    kept = [
        "studies/compare/question.py",
        "studies/gentleness/show.py",
        "cli/__init__.py",
        "errors.py",
    ]
    void = ["studies/toy/words.py", "studies/toy/question.py", "studies/engine/scan.py",
            "dcm/pushes.py", "control/hybrid.py", "interface.py", "record.py"]  # fmt: skip
    code = f"import sys; sys.path.insert(0, {str(package.parent)!r})\n{RUN}"
    done = subprocess.run(
        [sys.executable, "-c", code, str(package), str(tmp_path / "out"), *kept, *void],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told.pop("None") == [1, False]
    assert {name: told[name] for name in kept} == {name: [0, False] for name in kept}
    assert {name: told[name] for name in void} == {name: [1, True] for name in void}


def asking() -> list[type]:
    """Every study of the package."""
    for path in STUDIES.glob("*/question.py"):
        import_module(f"surefoot.studies.{path.parent.name}.question")
    found: list[type] = []
    left: list[type] = [Study]
    while left:
        below = left.pop().__subclasses__()
        found += [kind for kind in below if kind.__module__.startswith("surefoot.")]
        left += below
    return sorted(found, key=lambda kind: kind.__module__)


@pytest.fixture
def fresh_stamps() -> Iterator[None]:
    compiled.source_stamp.cache_clear()
    yield
    compiled.source_stamp.cache_clear()


def stamp_with_change(kind: type, changed: Path, patch: pytest.MonkeyPatch) -> str:
    with patch.context() as within:
        reads_as_changed(changed, within)
        compiled.source_stamp.cache_clear()
        return stamp(kind)


def reads_as_changed(changed: Path, patch: pytest.MonkeyPatch) -> None:
    """From now on a file reads as if somebody had added to it."""
    honest = Path.read_bytes
    patch.setattr(
        Path, "read_bytes", lambda path: honest(path) + (b"#" if path == changed else b"")
    )


@pytest.mark.usefixtures("fresh_stamps")
@pytest.mark.parametrize("kind", asking(), ids=lambda kind: kind.__name__)
def test_every_study_is_stamped_with_its_whole_folder_and_no_siblings(
    kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = Path(inspect.getfile(kind)).parent
    assert own.parent == STUDIES
    now = stamp(kind)
    for path in (*own.glob("*.py"), *(STUDIES / "engine").glob("*.py"), PACKAGE / "geometry.py"):
        assert stamp_with_change(kind, path, monkeypatch) != now, path
    siblings = [home for home in STUDIES.iterdir() if home not in (own, STUDIES / "engine")]
    others = [path for home in siblings for path in home.glob("*.py")]
    assert others
    for path in (*others, PACKAGE / "cli" / "walk.py"):
        assert stamp_with_change(kind, path, monkeypatch) == now, path


def test_a_study_that_is_in_no_file_is_refused() -> None:
    kind = type("Nowhere", (Study,), {"__module__": "nowhere"})
    with pytest.raises(sf.StudyError, match=r"a study whose class is in a file.*write it into one"):
        stamp(kind)


def test_rows_of_other_sources_are_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller = sf.HybridController(sf.load_robot("paper-biped"), (0.5, 0.0))
    tiny = PushMap(controller, directions=1, phases=1, step=1000.0)
    measured, honest = [], push_map_question.measure_cells

    def counted(asked: PushMap, cells: list) -> list:
        measured.extend(cells)
        return honest(asked, cells)

    monkeypatch.setattr(push_map_question, "measure_cells", counted)
    for _ in range(2):
        run(tiny, tmp_path / "map", workers=1)
    assert len(measured) == 1
    reads_as_changed(STUDIES / "engine" / "scan.py", monkeypatch)
    with pytest.raises(sf.FileError, match=r"the same study \(sources: .*choose another folder"):
        run(tiny, tmp_path / "map", workers=1)
    run(tiny, tmp_path / "other", workers=1)
    assert len(measured) == 2


THEIRS = """
from surefoot import HybridController

def make(robot, velocity, **parameters):
    return HybridController(robot, velocity)

class Theirs(HybridController):
    pass
"""


def test_rows_of_a_method_of_others_are_measured_again_when_their_package_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "theirs.py").write_text(THEIRS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(Comparison, "measure", lambda *_: {"impulse": 1.0, "scanned": 1.0})
    monkeypatch.setattr(Comparison, "notes", lambda *_: {})
    robot, folder = sf.load_robot("paper-biped"), tmp_path / "out"
    own, both = (
        Comparison(robot, methods=keys, directions=1, phases=1)
        for keys in (("hybrid",), ("hybrid", "theirs:make"))
    )
    # More methods of the same study are welcome.
    for study in (own, both, own):
        assert len(run(study, folder, workers=1).rows) == len(study.methods)
    pushed = BodyPushes(robot, methods=("unified", "theirs:make"))
    mapped = PushMap(import_module("theirs").Theirs(robot, (0.5, 0.0)))
    known = [both.foreign_sources(), pushed.foreign_sources(), mapped.foreign_sources()]
    (content,) = {what for sources in known for what in sources.values() if what}
    assert all(content in sources.values() for sources in known)
    (tmp_path / "theirs.py").write_text(f"{THEIRS}# another line\n")
    plugins.foreign_stamp.cache_clear()
    with pytest.raises(sf.FileError, match=r"sources of theirs:make: .*choose another folder"):
        run(both, folder, workers=1)
    run(own, folder, workers=1)
    plugins.foreign_stamp.cache_clear()
