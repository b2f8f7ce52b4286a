"""From a body's reference to its joints: one interface, whatever is inside.

Two leaves: `worlds.body.inverse_dynamics` for torque-controlled robots,
`worlds.body.inverse_kinematics` for playback.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.body.mechanics import Mechanics


@runtime_checkable
class Mapping(Protocol):
    """Anything that turns a reference into motor commands."""

    def joints(self, mechanics: Mechanics, reference: NDArray[np.void]) -> JointCommand:
        """The command for one cycle; never raises.

        Args:
            mechanics: at the state that was estimated.
            reference: a `BODY_REFERENCE` record, shape (1,).
        """
        ...
