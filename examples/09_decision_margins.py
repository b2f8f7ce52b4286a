"""See how close a walk was to falling: the margin of every decision, and the limits it met.

The margin is the distance of the DCM offset after the next landing from the edge of what further
steps can still save [m]; below 0 the robot falls. It decreases as the push grows, well before the
outcome changes. Printed is the last decision while the push acts, with the active limits of sole,
leg and step, which `sf.Limit` documents.
"""

import surefoot as sf

robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)  # m/s, along each axis
controller = sf.UnifiedController(robot, velocity=(0.5, 0.0))
START, DURATION = 1.1, 0.2  # s, of the push

print("  push    margin  outcome    limits that shape the decision")
for impulse in (0.0, 40.0, 80.0, 100.0, 110.0, 115.0, 120.0, 130.0):  # N s, forward
    pushes = [sf.Push(START, DURATION, (impulse / DURATION, 0.0))] if impulse else []
    rollout = sf.simulate(controller, duration=6.0, pushes=pushes)

    # A rollout keeps observations, not margins: the same controller decides every cycle again.
    decided = sf.decisions(controller, rollout)
    last = decided[rollout.time < START + DURATION][-1]
    limits = sf.Limit(int(last["active"]))

    print(
        f"{impulse:3.0f} N s  {1e3 * last['margin']:+5.0f} mm  {rollout.outcome.value:9s}"
        f"  {', '.join(limit.name or '' for limit in limits) or 'none'}"
    )
