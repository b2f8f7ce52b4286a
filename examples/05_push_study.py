"""Measure how much push a controller survives, in four directions, beside the theoretical limit.

The impulse is scanned upwards until the robot does not recover. It is printed as J [N s], as the
change of velocity J / m [m/s], and as a share of the theoretical limit: the largest impulse that
ANY policy can survive which learns of the push when it starts. The first method adapts the place of
its landings, the second place and time, and the third also anticipates that the push continues.
"""

import surefoot as sf

VELOCITY = (0.5, 0.0)  # m/s
DIRECTIONS = {
    "forward": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "towards the swing foot": (0.0, 1.0),  # left: the right foot stands
    "away from it": (0.0, -1.0),
}

robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)  # m/s, along each axis
start, duration = 1.1, 0.2  # s: 0.1 s into the third step
elapsed = start - 2 * sf.nominal_gait(robot, VELOCITY).step_duration

for method in (sf.CapturePointStepping, sf.HybridController, sf.UnifiedController):
    controller = method(robot, VELOCITY)
    print(method.__name__)
    for name, direction in DIRECTIONS.items():
        found = sf.smallest_failing_push(controller, direction, start=start, duration=duration)
        limit = sf.push_limit(
            robot,
            direction,
            velocity=VELOCITY,
            elapsed=elapsed,
            duration=duration,
            zmp_reach=robot.foot.half,
        )
        print(
            f"  {name:22s}  fails at {found.impulse:3.0f} N s, {found.delta_v:.2f} m/s;"
            f"  survives {found.survived / limit.impulse:3.0%} of the limit"
        )
