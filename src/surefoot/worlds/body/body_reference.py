"""What a body is to do until the next cycle, in the world frame: the seam before the joints.

Made from a `Command`, the same that drives the point mass, and carried out by a mapping to joints
(`worlds.body.mapping`).
"""

from __future__ import annotations

import numpy as np

BODY_REFERENCE = np.dtype(
    [
        ("stands", "i8", (2,)),
        ("zmp", "f8", (2,)),
        ("com", "f8", (3,)),
        ("com_velocity", "f8", (3,)),
        ("com_acceleration", "f8", (3,)),
        ("swing_foot", "f8", (3,)),
        ("swing_foot_velocity", "f8", (3,)),
        ("swing_foot_acceleration", "f8", (3,)),
        ("swing_yaw", "f8"),
        ("swing_yaw_rate", "f8"),
        ("trunk", "f8", (3,)),
        ("trunk_yaw_rate", "f8"),
    ],
)
"""Which soles carry, left and right (1 or 0); where the ground should push [m]; CoM [m], velocity
and acceleration; centre of the swinging sole likewise; its heading [rad] and turning rate [rad/s];
roll, pitch and yaw of the trunk [rad] and its turning rate [rad/s].

With one foot on the ground it is the ZMP that counts for the CoM's horizontal motion, and with two
the acceleration; kinematic playback uses the CoM itself.
"""
