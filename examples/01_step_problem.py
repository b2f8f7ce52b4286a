"""Decide where and when to land in a loop of your own: the step problem by itself.

The loop is given the DCM relative to the right foot, which stands, and the time since touchdown. At
0.2 s a disturbance moves the DCM by 12 cm forward and 3 cm to the right. The decision is the
nominal step until then, and a longer step of shorter duration after it. tau = e^(omega T) for a
landing T after the touchdown; the offset is that of the DCM from the foot that lands.
"""

import math

import surefoot as sf

robot = sf.load_robot("paper-biped")
gait = sf.nominal_gait(robot, velocity=(0.5, 0.0))
foot, omega, limits = sf.Side.RIGHT, robot.omega, robot.gait
step_min, step_max = limits.step_box(foot, robot.hip)

PROBLEM = sf.StepProblem(
    growth=(0.0, 0.0),
    nominal_step=gait.step(foot),
    nominal_tau=gait.growth,
    nominal_offset=gait.dcm_offset(foot),
    step_min=step_min,
    step_max=step_max,
    tau_min=math.exp(omega * limits.step_duration[0]),
    tau_max=math.exp(omega * limits.step_duration[1]),
    offset_min=(-limits.dcm_offset[0], -limits.dcm_offset[1]),
    offset_max=limits.dcm_offset,
)


def decide(dcm: tuple[float, float], elapsed: float) -> float:
    """Print the decision for a DCM relative to the foot; return when to land [s]."""
    growth = math.exp(omega * elapsed)
    problem = PROBLEM.replace(
        growth=(dcm[0] / growth, dcm[1] / growth), tau_min=max(PROBLEM.tau_min, growth)
    )
    answer = sf.solve_step(problem)
    duration = math.log(answer.tau) / omega
    print(
        f"{elapsed:.2f} s: step {answer.step[0]:+.3f} {answer.step[1]:+.3f} m, "
        f"tau {answer.tau:.3f}, T {duration:.3f} s, "
        f"offset {answer.offset[0]:+.4f} {answer.offset[1]:+.4f} m, {answer.status.name}, "
        f"{answer.iterations} iterations, residual {sf.kkt_residual(problem, answer).largest:.0e}"
    )
    return duration


dcm, elapsed, period = gait.start_offset(foot), 0.0, 0.05
landing = decide(dcm, elapsed)
while landing - elapsed > 1e-9:
    wait = min(period, landing - elapsed)
    dcm = tuple(x * math.exp(omega * wait) for x in dcm)
    elapsed += wait
    if math.isclose(elapsed, 0.2):
        print("disturbed")
        dcm = (dcm[0] + 0.12, dcm[1] - 0.03)
    landing = decide(dcm, elapsed)
print("landed")
