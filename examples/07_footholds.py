"""Give the footholds instead of a velocity: stepping stones, each with its place, heading and time.

The plan of the DCM runs backwards from the last foothold, and the ZMP follows it inside the sole.
Each foot lands on its stone, also while the robot is pushed; after the last one the robot steps in
place. A stone out of reach is refused before the walk begins. The picture needs the extra `plot`.

Usage: python 07_footholds.py [PICTURE]        (footholds.png if left out)
"""

import math
import sys

import surefoot as sf

robot = sf.load_robot("paper-biped")
LEFT, RIGHT = sf.Side.LEFT, sf.Side.RIGHT
STONES = [  # foot, x and y of its centre [m], heading counter-clockwise [rad], touchdown [s]
    sf.Foothold(LEFT, 0.00, 0.10, 0.0, 0.0),  # as it stands: it lifts first
    sf.Foothold(RIGHT, 0.00, -0.10, 0.0, 0.0),  # as it stands
    sf.Foothold(LEFT, 0.30, 0.12, 0.0, 0.6),
    sf.Foothold(RIGHT, 0.45, -0.12, 0.1, 1.1),
    sf.Foothold(LEFT, 0.80, 0.10, 0.2, 1.8),
    sf.Foothold(RIGHT, 0.95, -0.06, 0.3, 2.3),
    sf.Foothold(LEFT, 1.20, 0.22, 0.3, 2.9),
    sf.Foothold(RIGHT, 1.26, 0.03, 0.3, 3.4),
]

controller = sf.FootholdTracking(robot, STONES)
push = sf.Push(start=1.2, duration=0.2, force=(0.0, 25.0))  # 5 N s to the left
rollout = sf.simulate(controller, duration=5.0, pushes=[push])

print("outcome:", rollout.outcome.value)
for stone, step in zip(STONES[2:], rollout.footsteps, strict=False):
    missed = math.dist((stone.x, stone.y), step.landing)
    print(
        f"{stone.side.name.lower():5s} foot lands at {step.start + step.duration:.1f} s,"
        f" {step.landing[0]:.2f} {step.landing[1]:+.2f} m, off its stone by {1e3 * missed:.1f} mm"
    )

try:
    sf.FootholdTracking(robot, [*STONES, sf.Foothold(LEFT, 1.87, 0.43, 0.3, 3.9)])
except sf.FootholdError as refused:
    print("refused:", refused)
rollout.plot(sys.argv[1] if len(sys.argv) > 1 else "footholds.png")
