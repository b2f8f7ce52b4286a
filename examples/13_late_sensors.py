"""Give the controller a DCM that is late, and an estimator that predicts over the delay.

With late sensors a push has already moved the DCM when the controller is given it. The output shows
the smallest failing push forward for each delay, and how much of the loss is recovered by an
estimator, which predicts the motion of the pendulum over the delay.
"""

import surefoot as sf

robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)  # m/s, along each axis
controller = sf.HybridController(robot, velocity=(0.5, 0.0))

print("delay   falls at   with an estimator")
for delay in (0.0, 0.010, 0.020, 0.040):  # s
    late = sf.Disturbance(delay=delay)
    estimator = sf.Estimator(robot, delay=delay)
    without, predicted = (
        sf.smallest_failing_push(
            controller,
            direction=(1.0, 0.0),
            disturbance=late,
            estimator=between,
            must_settle=False,  # a push fails only by a fall
        )
        for between in (None, estimator)
    )
    print(
        f"{1e3 * delay:2.0f} ms   {without.impulse:3.0f} N s    {predicted.impulse:3.0f} N s"
        f", {predicted.delta_v:.2f} m/s"
    )
