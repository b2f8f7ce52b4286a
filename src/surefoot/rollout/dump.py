"""The end of a walk with all that evolved: small, loadable, and enough to walk it again.

A dump is a rollout of the last one or two steps, in a NumPy archive that `load_rollout` reads too,
and beside it the states with which these began: of the world, of the sensors, of the controller.
`worlds.point.simulate` writes one where a robot falls or a number is NaN, and replays it.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_writable
from surefoot.errors import FileError
from surefoot.rollout.rollout import Rollout, load_rollout

IN_FRONT = "dump_"
"""Of the names of a checkpoint's arrays."""


class Checkpoint(NamedTuple):
    """A walk between two cycles: records of shape (1,), but for the first two.

    Attributes:
        cycles: how many were retained before it.
        heading: of the controller's frame [rad].
        world: a `LIPM_WORLD` record.
        measured: a `MEASURED` record, of the sensors.
        state: of the controller.
        command: a `COMMAND` record, the last one.
    """

    cycles: int
    heading: float
    world: NDArray[np.void]
    measured: NDArray[np.void]
    state: NDArray[np.void]
    command: NDArray[np.void]


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


def write_dump(path: Path, rollout: Rollout, checkpoint: Checkpoint) -> None:
    """Write the cycles of a walk that follow a checkpoint.

    Args:
        path: file to write, ending in .npz.
        rollout: of the whole walk.
        checkpoint: of the same walk.

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    check_dump_path(path)
    states = {IN_FRONT + name: np.asarray(value) for name, value in checkpoint._asdict().items()}
    rollout.since(checkpoint.cycles).save(path, **states)


def load_dump(path: str | Path) -> Dump:
    """Read a dump.

    Args:
        path: the file.

    Raises:
        FileError: there is no such file, it is no dump, damaged, or another version wrote it.
    """
    rollout = load_rollout(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            states = {name: archive[IN_FRONT + name] for name in Checkpoint._fields}
    except (OSError, zipfile.BadZipFile, KeyError, ValueError) as error:
        raise FileError(
            "a dump that simulate(..., dump=...) wrote",
            f"{path}: {error}",
            "read a rollout with load_rollout",
        ) from error
    cycles, heading = int(states.pop("cycles")), float(states.pop("heading"))
    return Dump(rollout, Checkpoint(cycles, heading, **states))
