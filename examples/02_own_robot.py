"""Describe a robot of your own in one TOML file, then push it just below and just above its limit.

The output shows what follows from the file alone: the natural frequency of the pendulum, the
largest speed, and the theoretical limit of a push. The file my-robot.toml is written here so that
the example is complete; docs/robots.md has every key. All values are SI: kg, m, s.
"""

from pathlib import Path

import surefoot as sf

TOML = """\
name = "my-robot"
mass = 32.0                  # kg
com_height = 0.55            # m, of the centre of mass in walking
hip = 0.16                   # m, between the centres of the soles

[foot]
length = 0.16                # m
width = 0.09                 # m

[gait]
step_duration = [0.25, 0.7]  # s, shortest and longest step
step_x = [-0.25, 0.35]       # m, backward and forward
step_y = [-0.1, 0.2]         # m, inward and outward, relative to hip
dcm_offset = [0.08, 0.04]    # m, of the DCM from the foot that lands

[swing]
max_speed = 4.0              # m/s, of the foot in the air, along each axis
"""

Path("my-robot.toml").write_text(TOML, "utf-8")
robot = sf.load_robot("my-robot.toml")
velocity = (0.3, 0.0)
print(f"{robot.name}: {robot.mass:g} kg, omega = sqrt(g / h) = {robot.omega:.3f} 1/s")
print(f"it can walk forward at up to {sf.largest_speed(robot, (1.0, 0.0)):.2f} m/s")

gait = sf.nominal_gait(robot, velocity)
print(f"at {velocity[0]} m/s: steps of {gait.step_length:.3f} m in {gait.step_duration:.3f} s")

start, duration = 2.25 * gait.step_duration, 0.1
limit = sf.push_limit(
    robot,
    (1.0, 0.0),
    velocity=velocity,
    elapsed=0.25 * gait.step_duration,
    duration=duration,
    zmp_reach=robot.foot.half,
)
controller = sf.UnifiedController(robot, velocity)
for share in (0.95, 1.05):
    push = sf.Push(start, duration, force=(share * limit.impulse / duration, 0.0))
    rollout = sf.simulate(controller, duration=8.0, pushes=[push])
    print(f"{share:.0%} of the limit, {push.impulse[0]:.1f} N s: {rollout.outcome.value}")
