"""Walk a body on a circle: a velocity forward and a rate of turn.

The middle of the feet stays on a circle of radius speed / rate of turn, and the robot ends on its
course. The picture shows the circle from above. It needs the extras `mujoco` and `plot`.

Usage: python 11_turn_on_a_circle.py [PICTURE]        (circle.png if left out)
"""

import math
import sys

import numpy as np

import surefoot as sf

SPEED, TURNING = 0.3, 0.5  # m/s forward, rad/s counter-clockwise
DURATION = 1.0 + 2.0 * math.pi / TURNING  # s: from the stand into the first steps, and one round

multibody = sf.load_multibody(sf.load_robot("paper-biped"))
controller = sf.body_controller("unified", sf.walking_robot(multibody), velocity=(SPEED, 0.0))
control = sf.body_control(controller, multibody)
route = [(0.0, sf.Steering(velocity=(SPEED, 0.0), turning=TURNING))]  # (s, command), in order
rollout = sf.simulate_body(control, DURATION, steering=route)

# The circle through the middle of the feet, by least squares: x^2 + y^2 = 2 a x + 2 b y + c.
steps = rollout.footsteps
middle = np.array([np.add(step.landing, step.support_foot) / 2.0 for step in steps])  # m
rows = np.column_stack([2.0 * middle, np.ones(len(middle))])
a, b, c = np.linalg.lstsq(rows, (middle**2).sum(axis=1), rcond=None)[0]
radius = math.sqrt(c + a**2 + b**2)

turned = np.unwrap(rollout.body.base_turn[:, 2])[-1]  # rad, yaw of the base
measures = sf.measure_body(rollout, rollout.body)
print(f"outcome: {rollout.outcome.value}, {len(steps)} steps")
print(f"speed / rate of turn = {SPEED / TURNING:.3f} m; radius walked: {radius:.3f} m")
print(f"turned to the left by {math.degrees(turned):.0f} degrees")
print(
    f"beside its course by {1e3 * abs(measures.lateral_drift):.0f} mm, "
    f"heading off by {math.degrees(abs(measures.heading_error)):.1f} degrees"
)
rollout.plot(sys.argv[1] if len(sys.argv) > 1 else "circle.png")
