"""How one pushed step ends: many of them, in a compiled loop that stops at the touchdown."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.pushes import PUSH, Push, push_records
from surefoot.interface import Controller, Mode
from surefoot.robot.feet import Side
from surefoot.worlds.point.batch import kernel_pointer
from surefoot.worlds.point.plant import LipmSimulator, lipm_cycle

LANDING = np.dtype([("time", "f8"), ("offset", "f8", (2,)), ("adapted", "?")])
"""The end of a step: time since it began [s], d [m], whether it was decided online."""

_ADAPTING = int(Mode.ADAPTING)


@njit
def _land_all(kernel, parameters, state, simulator, world, pushes, max_cycles, landings):
    """One step under each row of `pushes`, up to its touchdown."""
    states, worlds = np.empty(2, state.dtype), np.empty(2, world.dtype)
    for i in range(landings.shape[0]):
        states[:], worlds[0] = state[0], world[0]
        now, adapted = 0, False
        for _ in range(max_cycles):
            kernel(parameters[0], states[now], worlds[now].observation, states[1 - now])
            command = states[1 - now].command
            adapted = adapted or command.mode == _ADAPTING
            lipm_cycle(simulator[0], worlds[now], command, pushes[i], worlds[1 - now])
            now = 1 - now
            if worlds[now].steps > 0:
                break
        observation = worlds[now].observation
        landings[i].time, landings[i].adapted = observation.time, adapted
        for k in range(2):
            landings[i].offset[k] = observation.dcm[k] - observation.support_foot[k]


def pushed_landings(
    controller: Controller, pushes: Sequence[Push], first_support: Side = Side.RIGHT
) -> NDArray[np.void]:
    """How one step from the nominal gait ends under each of several pushes.

    The gait is periodic, so a push in the third step is as good as one in the first.

    Args:
        controller: what decides; it must have a compiled kernel.
        pushes: one for each walk; their time counts from the touchdown that begins the step.
        first_support: the foot that stands.

    Returns:
        `LANDING` records, shape (len(pushes),).

    Raises:
        ParameterError: the controller has no kernel.
    """
    simulator = LipmSimulator(controller.robot, controller.period)
    observation = controller.first_observation(first_support)
    state = controller.start(observation)
    table = np.zeros((len(pushes), 1), PUSH)
    table[:, 0] = push_records(pushes)
    landings = np.zeros(len(pushes), LANDING)
    max_cycles = math.ceil(2.0 * controller.robot.gait.step_duration[1] / controller.period)
    kernel = kernel_pointer(controller, state)
    _land_all(
        kernel, controller.parameters, state, simulator.parameters, simulator.start(observation),
        table, max_cycles, landings,
    )  # fmt: skip
    return landings
