"""Write a controller of your own, in plain Python: capture-point steps at fixed times [Pratt2006].

The foot lands where the DCM will then be, less the nominal offset: p_next = dcm(T) - d_nom. It
recovers by the same steps (forward, left) as the compiled method with a point foot.
"""

from dataclasses import dataclass, field, replace

import numpy as np

import surefoot as sf


@dataclass(frozen=True)
class CaptureSteps:
    """Implements `sf.Controller`, which documents each method; its state is empty."""

    robot: sf.Robot
    velocity: tuple[float, float]  # m/s
    period: float = 0.001  # s
    gait: sf.NominalGait = field(init=False)
    kernel, parameters = None, np.zeros(1)  # for controllers that are compiled

    def __post_init__(self):
        object.__setattr__(self, "gait", sf.nominal_gait(self.robot, self.velocity))

    def first_observation(self, support_side=None):
        return self.gait.observation(support_side or sf.Side.RIGHT)

    def start(self, observation):
        return np.zeros(0)

    def with_velocity(self, velocity):
        return replace(self, velocity=velocity)

    def step(self, state, now):
        gait, foot, side = self.gait, now.support_foot, now.support_side
        left = max(gait.step_duration - now.elapsed, 0.0)  # s
        dcm_at_end = (now.dcm - foot) * np.exp(gait.omega * left)  # dcm(T) - p
        low, high = self.robot.gait.step_box(side, gait.hip)
        step = np.clip(dcm_at_end - gait.dcm_offset(side), low, high)
        planned = np.multiply(gait.start_offset(side), np.exp(gait.omega * now.elapsed))  # m
        way = (foot + step - now.swing_foot[:2]) * min(self.period / max(left, self.period), 1.0)
        height = self.robot.swing.height * np.sin(np.pi * left / gait.step_duration)
        command = sf.Command.of(np.zeros(1, sf.Command.DTYPE)).replace(
            zmp=foot, dcm_plan=foot + planned, dcm_offset=dcm_at_end - step,
            step_location=foot + step, step_duration=max(gait.step_duration, now.elapsed),
            swing_foot=(*now.swing_foot[:2] + way, height), mode=sf.Mode.ADAPTING,
        )  # fmt: skip
        return command, state


robot = sf.load_robot("paper-biped")
push = sf.Push(start=1.1, duration=0.2, force=(100.0, 50.0))  # s, s, N
own = sf.simulate(CaptureSteps(robot, (0.5, 0.0)), 6.0, [push])
compiled = sf.simulate(sf.CapturePointStepping(robot, (0.5, 0.0), ankle=False), 6.0, [push])
print("outcome:", own.outcome.value)
for k in range(1, 6):
    step, other = own.footsteps[k].step, compiled.footsteps[k].step
    print("step {}: {:+.3f} {:+.3f} m, compiled {:+.3f} {:+.3f} m".format(k + 1, *step, *other))
