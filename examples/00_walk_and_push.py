"""Walk at 0.5 m/s, get pushed forward with 35 N s, recover.

The output shows each step: the standing foot, the duration, and how far forward the other foot
lands. The third step is longer and shorter in time than planned; after it the gait is nominal
again. The picture shows the walk from above and over time; it needs the extra `plot`.

Usage: python 00_walk_and_push.py [PICTURE]        (walk.png if left out)
"""

import sys

import surefoot as sf


def main(picture: str) -> None:
    """Push the preset in its third step, and print what it did."""
    robot = sf.load_robot("paper-biped")
    controller = sf.HybridController(robot, velocity=(0.5, 0.0))
    push = sf.Push(start=1.1, duration=0.2, force=(176.0, 0.0))

    rollout = sf.simulate(controller, duration=6.0, pushes=[push])

    print(f"pushed with {push.impulse[0]:.1f} N s, {push.delta_v(robot.mass)[0]:.2f} m/s, forward")
    print("step  stands  duration  forward  decided")
    for step in rollout.footsteps:
        print(
            f"{step.index + 1:4d}  {step.side.name.lower():6s}  {step.duration:6.3f} s"
            f"  {step.step[0]:+.3f} m  {'online' if step.adapted else 'planned'}"
        )
    print(f"outcome: {rollout.outcome.value}")
    print(f"final velocity: {rollout.final_velocity[0]:.3f} m/s")

    try:
        rollout.plot(picture)
    except sf.MissingExtraError as missing:
        print(f"no picture: {missing}")
    else:
        print(f"picture: {picture}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "walk.png")
