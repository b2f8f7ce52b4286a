"""Random numbers that are functions of where they are used, not of what was drawn before.

The number of a seed, a step, a cycle and a channel is a hash of the four: splitmix64 (Steele, Lea,
Flood 2014). So a walk has the same noise compiled or not, alone or among others, on any number of
threads, and from any cycle on.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_UNIT = 2.0**-53


@njit
def mixed(bits):
    """One output of splitmix64 from the state `bits`, all of them uint64."""
    bits = bits + _STEP
    bits = (bits ^ (bits >> _30)) * _FIRST
    bits = (bits ^ (bits >> _27)) * _SECOND
    return bits ^ (bits >> _31)


@njit
def noise_key(seed: int, steps: int, cycle: int):
    """What all channels of one control cycle have in common, a uint64.

    Args:
        seed: of the walk.
        steps: finished before this cycle.
        cycle: since the last touchdown.
    """
    return mixed(mixed(mixed(np.uint64(seed)) ^ np.uint64(steps)) ^ np.uint64(cycle))


@njit
def uniform(key, channel: int) -> float:
    """A number in (0, 1], uniformly distributed.

    Args:
        key: of `noise_key`.
        channel: which of the numbers of this cycle.
    """
    bits = mixed(key ^ np.uint64(channel))
    return (np.float64(bits >> _11) + 0.5) * _UNIT


@njit
def normal_pair(key, channel: int) -> tuple[float, float]:
    """Two independent numbers, normally distributed with mean 0 and variance 1: Box and Muller.

    Args:
        key: of `noise_key`.
        channel: which pair of this cycle; no other may use the channels 2 `channel` and the next.
    """
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * channel)))
    angle = 2.0 * math.pi * uniform(key, 2 * channel + 1)
    return radius * math.cos(angle), radius * math.sin(angle)
