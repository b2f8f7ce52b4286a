"""When a walk of a batch ends, and how: one rule for compiled walks and for those in Python."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surefoot.compiling import njit
from surefoot.models.record import new_array
from surefoot.simulation.outcome import is_settled, watch

PROGRESS = np.dtype(
    [
        ("quiet_time", "f8"),
        ("duration", "f8"),
        ("velocity", "f8", (2,)),
        ("cycles", "i8"),
        ("ended", "?"),
        ("fallen", "?"),
        ("settled", "?"),
    ],
)
"""When the last push is over and when the walk is [s], the command [m/s], and how it stands."""


@njit
def see(monitor, world, command, progress):
    """Take a cycle into the monitor and tell whether the walk has ended, and how.

    It ends with a fall, when its time is over, or at the first touchdown after `quiet_time` at
    which it is settled; see `simulation.outcome`.

    Args:
        monitor: a `MONITOR` record.
        world: a `LIPM_WORLD` record.
        command: the `COMMAND` record that answers it.
        progress: a `PROGRESS` record, written.
    """
    observation, quiet = world.observation, progress.quiet_time
    watch(monitor, observation, command)
    progress.cycles += 1
    rested = observation.time > quiet and monitor.touchdown_time[2] > quiet
    progress.fallen = world.fallen != 0
    over = progress.fallen or observation.time >= progress.duration
    settled = (over or rested) and is_settled(monitor, progress.velocity[0], progress.velocity[1])
    progress.ended = over or settled
    progress.settled = settled and not progress.fallen


def new_progress(
    velocity: tuple[float, float], quiet_time: float, duration: float
) -> NDArray[np.void]:
    """A walk that has not begun, shape (1,).

    Args:
        velocity: commanded [m/s].
        quiet_time: from here on the walk ends when it is settled [s].
        duration: how long to walk at most [s].
    """
    progress = new_array(PROGRESS)
    progress["velocity"] = velocity
    progress["quiet_time"], progress["duration"] = quiet_time, duration
    return progress
