"""A row is of the sources that measured it: whoever changes one of them does not get old rows."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

import surefoot as sf
from surefoot import studies
from surefoot.studies.engine import study
from surefoot.studies.engine.study import Study, run, stamp
from surefoot.studies.push_map import question as push_map_question
from surefoot.studies.push_map.question import PushMap
from surefoot.studies.tune.question import Question

FOLDER = Path(studies.__file__).parent


def kinds(base: type = Study) -> Iterator[type]:
    for kind in base.__subclasses__():
        if kind.__module__.startswith("surefoot."):
            yield kind
        yield from kinds(kind)


for path in FOLDER.glob("*/question.py"):
    import_module(f"surefoot.studies.{path.parent.name}.question")

ASKING = sorted({*kinds(), Question}, key=lambda kind: kind.__name__)


def change(monkeypatch: pytest.MonkeyPatch, changed: Path) -> None:
    """From now on a file reads as if somebody had added a line to it."""
    honest = Path.read_bytes

    def read_bytes(path: Path) -> bytes:
        return honest(path) + (b"# changed\n" if path == changed else b"")

    monkeypatch.setattr(Path, "read_bytes", read_bytes)


@pytest.mark.parametrize("kind", ASKING, ids=lambda kind: kind.__name__)
def test_every_file_of_a_study_and_of_the_engine_counts(
    kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, own = stamp(kind), Path(inspect.getfile(kind)).parent
    assert own.parent == FOLDER
    for folder in (own, Path(study.__file__).parent):
        for path in folder.glob("*.py"):
            with monkeypatch.context() as patch:
                change(patch, path)
                assert stamp(kind) != before, path
    with monkeypatch.context() as patch:
        sibling = "push_map" if own.name == "sweep" else "sweep"
        change(patch, FOLDER / sibling / "measure.py")
        assert stamp(kind) == before


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
    change(monkeypatch, FOLDER / "engine" / "scan.py")
    with pytest.raises(sf.FileError, match=r"the same study \(sources: .*choose another folder"):
        run(tiny, tmp_path / "map", workers=1)
    run(tiny, tmp_path / "other", workers=1)
    assert len(measured) == 2
