"""The end of a walk with all that evolved: small, loadable, and enough to walk it again.

A dump is a rollout of the last one or two steps, in a NumPy archive that `load_rollout` reads too,
and beside it the states with which these began: of the world, of the sensors, of the controller.
`simulate` and `simulate_body` write one where a robot falls or a number is NaN; `replay` and
`replay_body` walk it again.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_writable
from surefoot.errors import FileError
from surefoot.rollout.rollout import Rollout, load_rollout

IN_FRONT = "dump_"
"""Of the names of a checkpoint's arrays."""


Checkpoint = dict[str, NDArray[Any]]
"""All that evolves in a walk, between two cycles: arrays by name, see `World.checkpoint`."""


@dataclass(frozen=True)
class Dump:
    """The end of a walk.

    Attributes:
        rollout: its last cycles.
        checkpoint: what was before the first of them.
    """

    rollout: Rollout
    checkpoint: Checkpoint


def check_dump_path(path: Path) -> None:
    """Refuse a file that no dump could be written to, before the walk.

    Raises:
        FileError: another ending than .npz, or the file cannot be written.
    """
    check_writable(path, (".npz",))


def write_dump(path: Path, dump: Dump) -> None:
    """Write the end of a walk.

    Args:
        path: file to write, ending in .npz.
        dump: what to write.

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    check_dump_path(path)
    dump.rollout.save(path, **{IN_FRONT + name: rows for name, rows in dump.checkpoint.items()})


def load_dump(path: str | Path) -> Dump:
    """Read a dump.

    Args:
        path: the file.

    Raises:
        FileError: there is no such file, it is no dump, damaged, or another version wrote it.
    """
    rollout = load_rollout(path)
    with np.load(path, allow_pickle=False) as archive:
        checkpoint = {
            name.removeprefix(IN_FRONT): archive[name]
            for name in archive.files
            if name.startswith(IN_FRONT)
        }
    if not checkpoint:
        raise FileError(
            "a dump that simulate(..., dump=...) wrote",
            f"{path} without states",
            "read a rollout with load_rollout",
        )
    return Dump(rollout, checkpoint)
