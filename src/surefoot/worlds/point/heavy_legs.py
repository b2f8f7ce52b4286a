"""What the masses of the legs do in a cycle of the point mass: see `dcm.three_mass`."""

from __future__ import annotations

from surefoot.compiled import njit
from surefoot.dcm.support import nearest_supported


@njit
def swing_legs(parameters, foot, velocity, duration, next_world):
    """Write what a foot of a heavy leg does to the pivot in this cycle: it moves on the cubic
    between its states, so its acceleration changes evenly.

    Args:
        parameters: a `LIPM_PARAMETERS` record.
        foot, velocity: of the swing foot at the start of the cycle.
        duration: of the cycle [s].
        next_world: its swing foot is that at the end of the cycle.
    """
    observation, legs = next_world.observation, next_world.legs
    for i in range(2):
        after = observation.swing_foot_velocity[i]
        mean = (observation.swing_foot[i] - foot[i]) / duration
        now = (6.0 * mean - 4.0 * velocity[i] - 2.0 * after) / duration
        change = (6.0 * (velocity[i] + after) - 12.0 * mean) / (duration * duration)
        legs[i, 0], legs[i, 1] = parameters.foot_gain * now, parameters.foot_gain * change


@njit
def place_zmp(parameters, command, duration, next_world):
    """Write the ZMP at which the CoM moves as without legs, as far as the soles reach.

    c'' = omega^2 (c - zmp) is wanted, and omega'^2 (c - zmp' + kappa f'') is what there is; the
    ZMP stays where it is for the whole cycle.
    """
    observation, zmp, legs = next_world.observation, next_world.zmp, next_world.legs
    ratio = (parameters.expected_omega / parameters.omega) ** 2
    foot, half = observation.support_foot, parameters.half_foot
    for i in range(2):
        com, share = observation.com[i], legs[i, 0] + 0.5 * duration * legs[i, 1]
        zmp[i] = com + share - ratio * (com - command.zmp[i]) - foot[i]
    shared = command.double_support != 0
    x, y = nearest_supported(observation, shared, zmp[0], zmp[1], half[0], half[1])
    zmp[0], zmp[1] = foot[0] + x, foot[1] + y


@njit
def stop_leg(parameters, observation):
    """A heavy leg whose foot still moves over the ground passes its momentum on as it lands."""
    for i in range(2):
        stopped = parameters.omega**2 * parameters.foot_gain * observation.swing_foot_velocity[i]
        observation.com_velocity[i] -= stopped
        observation.dcm[i] -= stopped / parameters.omega
