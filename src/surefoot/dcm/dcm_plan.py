"""The DCM plan of one step in single support: Eq. (20) of [OnlineGait]."""

from __future__ import annotations

from surefoot.compiled import njit


@njit
def planned_dcm(support_foot: float, start_offset: float, growth: float) -> float:
    """dcm_plan(t) = p + d_start e^(omega t), one axis.

    Args:
        support_foot: p, centre of the sole on the ground [m].
        start_offset: planned DCM relative to it at touchdown [m].
        growth: e^(omega t), t the time since touchdown.

    Returns:
        The planned DCM [m].
    """
    return support_foot + start_offset * growth
