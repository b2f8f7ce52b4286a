"""Find the cause of a fall of a body: what happened first, when, and how the walk ended.

Four walks: a push that the body survives, ice, and two pushes that are too strong. A fall is a
result, not an error, and each of these has its own cause. It needs the extra `mujoco`.
"""

import surefoot as sf

multibody = sf.load_multibody(sf.load_robot("paper-biped"))
controller = sf.body_controller("unified", sf.walking_robot(multibody), velocity=(0.3, 0.0))
control = sf.body_control(controller, multibody)

START, DURATION = 2.5, 0.2  # s, of each push
WALKS = {  # impulse forward and to the left [N s], friction of the floor [-]
    "30 N s forward": ((30.0, 0.0), 0.8),
    "ice": (None, 0.15),
    "120 N s forward": ((120.0, 0.0), 0.8),
    "90 N s to the left": ((0.0, 90.0), 0.8),
}

for name, (impulse, friction) in WALKS.items():
    pushes = []
    if impulse is not None:
        force = (impulse[0] / DURATION, impulse[1] / DURATION)  # N
        pushes.append(sf.Push(START, DURATION, force))
    floor = sf.Surroundings(friction=friction)
    rollout = sf.simulate_body(control, duration=7.0, pushes=pushes, surroundings=floor)

    fall = rollout.body_fall  # None if it did not fall
    print(f"{name}: {rollout.outcome.value}")
    if fall is not None:
        print(f"  cause: {fall.cause.value}, at {fall.time:.2f} s")
        print(f"  observed: {fall.words}")
        print(f"  end: at {fall.end:.2f} s {fall.ending}")
