"""Studies that are killed while they measure, and rows without what differs from run to run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any


def without_time(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows without how long they took."""
    return [{name: value for name, value in row.items() if name != "seconds"} for row in rows]


def shards(folder: Path) -> list[Path]:
    """The files of a study's folder in which rows are kept."""
    return sorted((folder / "shards").glob("*.parquet"))


def kill_when_kept(code: str, *arguments: Path, count: int) -> int:
    """Run a study by itself and kill -9 it once it has kept enough.

    Args:
        code: what runs the study, in Python.
        *arguments: of the code; the last is the folder of the study.
        count: how many shards are enough.

    Returns:
        How many shards it has kept.
    """
    folder = arguments[-1]
    study = subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)])
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and study.poll() is None:
        if len(shards(folder)) >= count:
            break
        time.sleep(0.02)
    os.kill(study.pid, signal.SIGKILL)
    study.wait()
    return len(shards(folder))
