"""Walk a thousand robots at once: one table, a row for each walk, all cores.

Each robot gets a random push and has its own mass, up to 10 % off the one in its controller's
model. The output shows how many fall, by the impulse of the push, and that a row of the table
equals the walk of `sf.simulate`, to the bit.
"""

import numpy as np

import surefoot as sf

COUNT, DURATION = 1000, 0.2  # walks, s of push
robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)
controller = sf.HybridController(robot, velocity=(0.5, 0.0))

random = np.random.default_rng(seed=1)
impulse = random.uniform(0.0, 200.0, COUNT)  # N s
angle = random.uniform(-np.pi, np.pi, COUNT)  # rad, counter-clockwise from forward
force = (impulse * [np.cos(angle), np.sin(angle)] / DURATION).T  # N
start = random.uniform(1.0, 2.0, COUNT)  # s
mass = robot.mass * random.uniform(0.9, 1.1, COUNT)  # kg

table = sf.Walks(
    pushes=[[sf.Push(start[i], DURATION, force[i])] for i in range(COUNT)],
    plants=[robot.replace(mass=mass[i]) for i in range(COUNT)],
)
results = sf.simulate_batch(controller, table, duration=6.0)

print(f"{COUNT} walks, {1e-6 * results['cycles'].sum():.1f} million control cycles")
for low in range(0, 200, 40):
    rows = (impulse >= low) & (impulse < low + 40)
    print(f"{low:3d} to {low + 40:3d} N s: {results['fallen'][rows].mean():4.0%} fell")

row = int(np.argmax(results["recovery_time"] > 0.0))
alone = sf.simulate(controller, 6.0, table.pushes[row], plant=table.plants[row])
same = alone.observations[-1].tobytes() == results["final"][row].tobytes()
print(f"walk {row} alone ends as in the batch, to the bit: {same}")
