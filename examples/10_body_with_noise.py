"""Walk a body in physics on an estimate from noisy sensors.

The body has joints, motors and contacts; its encoders, inertial unit and load cells are noisy and
late. The output shows the speed, a little too high while the robot makes up for its start, and the
difference of the estimated from the true DCM: the controller is given the estimate, the recording
has both. It needs the extra `mujoco`.
"""

import numpy as np

import surefoot as sf

multibody = sf.load_multibody(sf.load_robot("paper-biped"))
point_mass = sf.walking_robot(multibody)  # the model that the controller plans with
controller = sf.body_controller("unified", point_mass, velocity=(0.3, 0.0))
control = sf.body_control(controller, multibody)

usual = sf.BodyNoise.of(point_mass, seed=3)
noisy = sf.BodyNoise.of(
    point_mass,
    encoder=3.0 * usual.encoder,  # rad
    rate=3.0 * usual.rate,  # rad/s, of the joints
    gyro=3.0 * usual.gyro,  # rad/s
    accelerometer=3.0 * usual.accelerometer,  # m/s^2
    delay=0.005,  # s, of all sensors
    seed=3,
)

for name, noise in {
    "perfect sensors": None,
    "usual noise": usual,
    "3 times the noise, 5 ms late": noisy,
}.items():
    rollout = sf.simulate_body(control, duration=7.0, noise=noise)
    measures = sf.measure_body(rollout, rollout.body)

    # The DCM from the foot that stands is what the controller acts on.
    seen, true = (rows[rollout.body.walking] for rows in (rollout.seen, rollout.observations))
    error = (seen["dcm"] - seen["support_foot"]) - (true["dcm"] - true["support_foot"])
    forward, left = 1e3 * np.sqrt((error**2).mean(axis=0))

    print(f"{name}: {rollout.outcome.value}, {len(rollout.footsteps)} steps")
    print(f"  speed {measures.speed[0]:.2f} m/s, commanded {measures.commanded[0]:.2f} m/s")
    print(f"  DCM off by {forward:.1f} mm forward, {left:.1f} mm to the left (r.m.s.)")
