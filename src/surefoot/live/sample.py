"""What the charts show of an instant."""

from __future__ import annotations

from typing import NamedTuple

from surefoot.dcm.frame_turn import rotated
from surefoot.rollout.snapshot import Snapshot

SAMPLING = 0.02
"""How often a sample is taken [s]."""


class Sample(NamedTuple):
    """One instant for the charts: (x, y) along and across the standing sole [m], and times [s]."""

    time: float
    dcm: tuple[float, float]
    zmp: tuple[float, float]
    step_duration: float
    decision_time: float


def sample_of(snapshot: Snapshot, decision_time: float) -> Sample:
    """The sample of an instant, with the longest decision since the last one [s]."""
    seen = snapshot.observation
    foot, yaw = seen["support_foot"], float(seen["support_yaw"])
    zmp = [a - b for a, b in zip(snapshot.floor_zmp, foot, strict=True)]
    return Sample(
        snapshot.time,
        rotated(seen["dcm"] - foot, -yaw),
        rotated(zmp, -yaw),
        float(snapshot.command["step_duration"]),
        decision_time,
    )
