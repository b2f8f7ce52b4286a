"""Run a controller in a loop of your own, around a real-time clock: 1000 decisions a second.

The loop is three lines: read an observation, decide, act. Here the robot is `LipmSimulator`; on a
real one `observation` comes from your state estimator, and `command` goes to your whole-body
control. The output shows that the loop keeps real time, and that the walk does not depend on the
clock: it equals that of `sf.simulate`, to the bit.
"""

import time

import numpy as np

import surefoot as sf

robot = sf.load_robot("paper-biped")
controller = sf.UnifiedController(robot, velocity=(0.5, 0.0))
push = sf.Push(start=0.6, duration=0.2, force=(176.0, 0.0))
world = sf.LipmSimulator(robot, controller.period, [push])

observation = controller.first_observation()
state, plant = controller.start(observation), world.start(observation)
taken, late, steps, coms = [], 0, 0, [observation.com]
began = time.perf_counter()

while observation.time < 2.0:
    before = time.perf_counter()
    command, state = controller.step(state, observation)
    taken.append(time.perf_counter() - before)

    side = observation.support_side
    observation, plant = world.step(plant, command)
    steps += observation.support_side != side
    coms.append(observation.com)

    # Sleep until the instant of the next cycle, counted from the start: lateness does not add up.
    wait = began + observation.time - time.perf_counter()
    late += wait < 0.0
    time.sleep(max(wait, 0.0))

elapsed = time.perf_counter() - began
same = np.array_equal(coms, sf.simulate(controller, 2.0, [push]).com)
print(f"{len(taken)} cycles and {steps} steps in {observation.time:.1f} s of walking")
print(f"the same walk as sf.simulate, to the bit: {same}")
print(f"the clock was never ahead of the walk: {elapsed >= observation.time}")
print(
    f"this machine: {elapsed:.3f} s on the clock, a decision took {1e6 * np.median(taken):.1f} us"
    f" (median), {late} cycles were late"
)
