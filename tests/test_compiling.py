from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import surefoot as sf
from surefoot.compiled import NOT_COMPILED, source_stamp

SOURCE = Path(sf.__file__).parent

ASK = """
import numpy as np
from surefoot.control.tracking import Plan, Tracking, follow_plan
from surefoot.interface import Command, Observation
records = [np.zeros(1, kind.DTYPE) for kind in (Tracking, Observation, Plan, Command)]
tracking, observation, plan, command = records
plan["start_offset"] = 0.5
follow_plan(tracking[0], observation[0], 2.0, plan[0], command[0])
print(command["dcm_plan"][0, 0], *follow_plan.stats.cache_hits.values())
"""


def ask(package: Path) -> list[str]:
    """The planned DCM by a kernel that calls another file's, and whether it came from the cache."""
    environment = os.environ | {"PYTHONPATH": str(package.parent)}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, "-c", ASK], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_a_kernel_is_compiled_anew_when_a_function_it_calls_has_changed(tmp_path: Path) -> None:
    package = tmp_path / "surefoot"
    shutil.copytree(SOURCE, package, ignore=shutil.ignore_patterns("__pycache__"))
    assert ask(package) == ["1.0"]
    assert ask(package) == ["1.0", "1"]  # from the cache
    callee = package / "dcm" / "dcm_plan.py"
    text = callee.read_text()
    assert "start_offset * growth" in text
    callee.write_text(text.replace("start_offset * growth", "start_offset * growth * 3.0"))
    assert ask(package) == ["3.0"]
    assert ask(package) == ["3.0", "1"]


def test_every_file_with_a_kernel_is_in_the_stamp() -> None:
    homes = {
        path.relative_to(SOURCE).parts[0]
        for path in SOURCE.rglob("*.py")
        if "@njit" in path.read_text()
    }
    assert {"dcm", "control", "worlds"} <= homes
    assert not homes & NOT_COMPILED
    assert {SOURCE / name for name in NOT_COMPILED} <= set(SOURCE.iterdir())
    assert len(source_stamp()) == 64
