"""A table that grows on disk while a study runs, and survives a study that is killed.

Rows go into small Parquet files, each written beside its place and then moved there, so that a
file is whole or absent. What must be the same for all rows is kept with them; a study that asks
something else, or another version of Surefoot, is refused rather than mixed in.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

from surefoot.checks import check_folder, optional_module
from surefoot.errors import FileError

RUN_FILE = "run.json"

Row = dict[str, Any]


@dataclass(frozen=True)
class Shards:
    """The growing table.

    Args:
        folder: where it lives; made if it is missing.
        common: what all rows have in common, as plain values; it is compared with the folder's.

    Raises:
        FileError: the folder cannot be written to, or holds rows of another study.
        MissingExtraError: polars is not installed.
    """

    folder: Path
    common: Mapping[str, Any]
    rows: list[dict[str, Any]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        polars = optional_module("polars", "tables of studies", "study")
        claim_folder(self.folder, self.common)
        (self.folder / "shards").mkdir(exist_ok=True)
        rows: list[dict[str, Any]] = []
        for path in self._files():
            try:
                rows += polars.read_parquet(path).to_dicts()
            except (polars.exceptions.PolarsError, OSError) as error:
                raise FileError(
                    "a Parquet file that this study wrote", f"{path}: {error}", "delete that file"
                ) from error
        object.__setattr__(self, "rows", rows)

    def _files(self) -> list[Path]:
        return sorted((self.folder / "shards").glob("*.parquet"))

    def add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Keep more rows; when this returns they are on disk."""
        if not rows:
            return
        polars = optional_module("polars", "tables of studies", "study")
        # All rows tell of what kind a column is, not only the first ones.
        table = polars.DataFrame([dict(row) for row in rows], infer_schema_length=None)
        # A name of its own: another study may be adding to the same table.
        path = self.folder / "shards" / f"{time.time_ns()}-{uuid4().hex[:8]}.parquet"
        _write_whole(path, table.write_parquet)
        self.rows.extend(dict(row) for row in rows)


def claim_folder(folder: Path, common: Mapping[str, Any]) -> None:
    """Keep a folder for one study: say in it what all of it has in common, or compare with that.

    What is said for the first time, as by a method that was not asked for before, is added.

    Args:
        folder: made if it is missing.
        common: plain values.

    Raises:
        FileError: the folder cannot be written to, or is that of another study.
    """
    check_folder(folder)
    run = folder / RUN_FILE
    # As it comes back from a file: tuples are lists there.
    common = json.loads(json.dumps(common))
    there = _read_json(run) if run.exists() else {}
    for name, value in common.items():
        if there.get(name, value) != value:
            raise FileError(
                f"a folder of the same study ({name}: {value})",
                f"{run} with {name}: {there.get(name)}",
                "choose another folder, or delete this one",
            )
    if not common.keys() <= there.keys():
        text = json.dumps({**there, **common}, indent=1) + "\n"
        _write_whole(run, lambda path: path.write_text(text))


def write_table(rows: Sequence[Mapping[str, Any]], path: Path, notes: Mapping[str, Any]) -> None:
    """Write rows as one Parquet file, with notes (as JSON) in its metadata as `surefoot.NAME`.

    Raises:
        MissingExtraError: polars is not installed.
    """
    polars = optional_module("polars", "tables of studies", "study")
    table = polars.DataFrame([dict(row) for row in rows], infer_schema_length=None)
    metadata = {f"surefoot.{name}": json.dumps(value) for name, value in notes.items()}
    _write_whole(path, lambda whole: table.write_parquet(whole, metadata=metadata))


def _read_json(path: Path) -> dict[str, Any]:
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise FileError(
            "what a study writes at its start",
            f"{path}: {error}",
            "delete it and its shards",
        ) from error


def _write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Write beside the place and move there: a killed study leaves no half of a file.

    Raises:
        FileError: it cannot be written, for want of space or of permission.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        write(beside)
        os.replace(beside, path)
    except Exception as error:  # polars has errors of its own for a full disk
        beside.unlink(missing_ok=True)
        raise FileError(
            "room for another file",
            f"{path}: {error}",
            "free some space; what is there is kept, and the same command goes on",
        ) from error


def select(rows: Iterable[Row], **choice: Any) -> list[Row]:
    """The rows whose values are those chosen, such as `leg_speed=3.0`."""
    return [row for row in rows if all(row[name] == value for name, value in choice.items())]


def values(rows: Iterable[Row], name: str) -> list[float]:
    """The different values of a column, upwards."""
    return sorted({row[name] for row in rows})


def without_infinity(value: Any) -> Any:
    """Plain values for JSON, which has no word for infinity, nor for what is no number: null."""
    if isinstance(value, dict):
        return {name: without_infinity(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_infinity(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
