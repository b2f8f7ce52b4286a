"""ZMP preview control: optimal gains, a look ahead, a ZMP under the sole, nothing that winds up."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.conformance import closed_loop
from surefoot.control.cycle import side_index
from surefoot.control.preview_law import cart_table, error_system, preview_gains

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
OMEGA = ROBOT.omega
WEIGHTS = [(1.0, (0.0, 0.0, 0.0), 1e-6), (2.0, (10.0, 1.0, 0.1), 1e-5)]


@pytest.fixture(scope="module")
def controller() -> sf.PreviewControl:
    return sf.PreviewControl(ROBOT, (0.5, 0.0))


@pytest.mark.parametrize(("q_e", "q_x", "r"), WEIGHTS)
@pytest.mark.parametrize("sample_time", [0.001, 0.005])
def test_the_gains_satisfy_the_riccati_equation(sample_time: float, q_e, q_x, r) -> None:
    gains = preview_gains(OMEGA, sample_time, 100, q_e, q_x, r)
    a, b = error_system(OMEGA, sample_time)
    p, gain = gains.cost, np.array([[gains.integral, *gains.state]])
    assert p == pytest.approx(p.T)
    assert gain * (r + b.T @ p @ b) == pytest.approx(b.T @ p @ a, rel=1e-9)
    residual = a.T @ p @ (a - b @ gain) + np.diag((q_e, *q_x)) - p
    assert np.abs(residual).max() < 1e-9 * np.abs(p).max()
    assert np.abs(np.linalg.eigvals(a - b @ gain)).max() < 1.0


def test_the_cost_is_what_the_closed_loop_pays() -> None:
    """X^T P X is the sum of Q_e e^2 + dx^T Q_x dx + R du^2, which needs no solver to add up."""
    q_e, q_x, r = WEIGHTS[1]
    gains = preview_gains(OMEGA, 0.005, 1, q_e, q_x, r)
    a, b = error_system(OMEGA, 0.005)
    gain = np.array([gains.integral, *gains.state])
    begin = np.array([0.02, 0.001, -0.01, 0.1])
    paid, error = 0.0, begin
    for _ in range(4000):
        change = -gain @ error
        paid += error @ (np.array((q_e, *q_x)) * error) + r * change**2
        error = a @ error + b[:, 0] * change
    assert paid == pytest.approx(begin @ gains.cost @ begin, rel=1e-9)


def test_a_step_for_ever_ahead_counts_as_much_as_the_position() -> None:
    """The law knows no origin: the preview gains add up to that of the position."""
    gains = preview_gains(OMEGA, 0.001, 8000, *WEIGHTS[0])
    assert gains.preview.sum() == pytest.approx(gains.state[0], rel=1e-9)
    assert gains.preview[0] == pytest.approx(gains.integral, rel=1e-9)


def test_it_moves_before_the_reference_does() -> None:
    """The reference steps aside by 0.1 m: the CoM has left before, and not before it can know."""
    t, samples, step_at = 0.005, 320, 500
    a, b, c = cart_table(OMEGA, t)
    gains = preview_gains(OMEGA, t, samples, *WEIGHTS[0])
    reference = np.where(np.arange(1600) >= step_at, 0.1, 0.0)
    x, total, com, zmp = np.zeros(3), 0.0, [], []
    for k in range(1200):
        com.append(x[0])
        zmp.append((c @ x).item())
        total += zmp[-1] - reference[k]
        ahead = gains.preview @ reference[k + 1 : k + 1 + samples]
        x = a @ x + b[:, 0] * (ahead - gains.state @ x - gains.integral * total)
    assert com[step_at - samples] == 0.0
    assert 0.04 < com[step_at] < 0.06
    assert zmp[step_at - 20] == pytest.approx(0.0, abs=0.005)
    assert zmp[step_at + 20] == pytest.approx(0.1, abs=0.005)
    assert com[-1] == pytest.approx(0.1, abs=1e-3)


def test_the_zmp_sets_out_for_the_next_foot_before_it_lands(controller) -> None:
    rollout = sf.simulate(controller, 2.0)
    away = rollout.zmp - rollout.support_foot
    just_before = np.isclose(rollout.observations["elapsed"], 0.495)
    at_rest = np.isclose(rollout.observations["elapsed"], 0.25)
    assert away[just_before, 0].min() > 0.02
    assert (away[just_before, 1] * rollout.support_side[just_before]).min() > 0.02
    assert np.abs(away[at_rest]).max() < 0.01


def by_hand(controller: sf.PreviewControl, state, observation: sf.Observation) -> np.ndarray:
    """The ZMP that the published law asks for, sample by sample of its reference."""
    parameters, t = controller.parameters[0], controller.period
    weights = controller.error_weight, controller.state_weight, controller.input_weight
    gains = preview_gains(OMEGA, t, 1600, *weights)
    foot, side = np.array(observation.support_foot), observation.support_side
    times = observation.elapsed + t * np.arange(1600)
    reference = np.zeros((1600, 2))
    touchdown = controller.gait.step_duration
    while touchdown < times[-1] + t:
        reference[times > touchdown - 1e-9] += controller.gait.step(side)
        touchdown, side = touchdown + controller.gait.step_duration, side.other
    com, velocity = observation.com - foot, observation.com_velocity
    zmp = state["command"]["zmp"][0] - foot
    acceleration = OMEGA**2 * (com - zmp)
    total = state["plan"]["measured_sum"][0] + zmp
    jerk = gains.preview @ reference - gains.integral * total
    jerk = jerk - gains.state @ np.array([com, velocity, acceleration])
    com = com + t * velocity + t**2 / 2 * acceleration + t**3 / 6 * jerk
    assert parameters["samples"] == 1600
    return foot + com - (acceleration + t * jerk) / OMEGA**2


def walk(controller: sf.PreviewControl, pushes: list[sf.Push], until: float):
    """Observation in the cycle at some time, and the state before it."""
    cycles = round(until / controller.period) + 1
    *_, before, last = closed_loop(controller, controller.first_observation(), cycles, pushes)
    return last.observation, before.state


@pytest.mark.parametrize("until", [0.05, 0.3, 0.72, 0.901])
def test_the_law_is_the_published_one(controller, until: float) -> None:
    """Measured CoM, the acceleration of the ZMP that acted, and 1600 samples of footsteps ahead."""
    observation, state = walk(controller, [sf.Push(0.02, 0.01, (20.0, -10.0))], until)
    asked = by_hand(controller, state, observation)
    command, after = controller.step(state, observation)
    assert command.status == sf.Status.OK
    assert command.zmp == pytest.approx(asked, abs=1e-9)
    moved = state["plan"]["measured_sum"] + state["command"]["zmp"] - observation.support_foot
    assert after["plan"]["measured_sum"] == pytest.approx(moved, abs=1e-15)


def test_at_the_edge_of_the_sole_the_integrator_rests(controller) -> None:
    """Pushed forward: it rests along, and goes on across."""
    observation, state = walk(controller, [sf.Push(1.1, 0.2, (120.0, 0.0))], 1.3)
    asked = by_hand(controller, state, observation) - observation.support_foot
    assert asked[0] > ROBOT.foot.half[0] + 0.01
    command, after = controller.step(state, observation)
    assert command.status == sf.Status.ZMP_AT_EDGE
    assert command.zmp[0] - observation.support_foot[0] == pytest.approx(0.1, abs=1e-12)
    before, now = state["plan"]["measured_sum"][0], after["plan"]["measured_sum"][0]
    assert now[0] == before[0]
    assert now[1] != before[1]


@pytest.mark.parametrize("velocity", [(0.5, 0.0), (0.0, 0.2)])
def test_its_own_gait_is_near_the_nominal_one_but_another(velocity) -> None:
    controller = sf.PreviewControl(ROBOT, velocity)
    for side in sf.Side:
        own, nominal = controller.first_observation(side), controller.gait.observation(side)
        assert 1e-5 < np.abs(own.dcm - nominal.dcm).max() < 5e-3
        assert own.dcm == pytest.approx(own.com + own.com_velocity / OMEGA, abs=1e-12)
    # From the nominal gait it settles on its own.
    nominal = controller.gait.observation(sf.Side.RIGHT)
    errors = [
        np.abs(true.dcm - command.dcm_plan).max()
        for true, command, _ in closed_loop(controller, nominal, 4000)
    ]
    assert errors[0] > 1e-5
    assert max(errors[-500:]) < 1e-6


def test_the_mirror_image_of_a_start_is_the_other_start(controller) -> None:
    right, left = controller.parameters["start"][0]
    for name in ("com", "com_velocity", "zmp", "step"):
        assert left[name] == pytest.approx(right[name] * (1.0, -1.0), abs=1e-12), name
    assert controller.parameters["end_offset"][0, side_index.py_func(sf.Side.RIGHT)] == (
        pytest.approx(left["com"] + left["com_velocity"] / OMEGA, abs=1e-12)
    )


def test_the_plan_keeps_pace_through_a_dropout(controller) -> None:
    """Half a second is lost, a touchdown with it: the plan is where it would have been."""
    begin = controller.first_observation()
    lossy = controller.start(begin)
    for k, (true, command, _) in enumerate(closed_loop(controller, begin, 1000)):
        lost = 300 <= k < 800
        measured = true.replace(dcm=(np.nan, 0.0)) if lost else true
        after_loss, lossy = controller.step(lossy, measured)
        if not lost:
            assert after_loss.dcm_plan == pytest.approx(command.dcm_plan, abs=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"state_weight": (0.0, -1.0, 0.0)}, "`state_weight` of at least 0"),
        ({"state_weight": (0.0, 1.0)}, r"`state_weight` as \(position, velocity, acceleration\)"),
        ({"preview": 0.0}, "`preview` of at least 0.001"),
        ({"preview": 3.0}, "a preview of at most 2000 periods; got 3.0 s in periods of 0.001 s"),
        ({"input_weight": 1e-10}, "a gait that becomes periodic"),
        ({"preview": 0.05}, "a gait that becomes periodic"),
        (
            {"input_weight": 1e-300},
            r"1e\+12 of each other; got `error_weight` 1 beside `input_weight` ",
        ),
    ],
)
def test_parameters_that_make_no_sense(arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.PreviewControl(ROBOT, (0.5, 0.0), **arguments)


def test_gains_that_rounding_leaves_nothing_of_are_refused() -> None:
    """Effort at the end of what a double resolves: some of these matrices are singular."""
    refused = 0
    for weight in np.geomspace(1e-16, 1e-14, 50):
        try:
            preview_gains(3.5, 0.001, 100, 1.0, (0.0, 0.0, 0.0), float(weight))
        except sf.ParameterError:
            refused += 1
    assert refused > 0


def test_the_ratio_of_weights_is_that_of_similar_robots() -> None:
    """What a robot of 0.1 mm is given by default may be written out."""
    small = ROBOT.replace(com_height=1e-4 * ROBOT.com_height, hip=1e-4 * ROBOT.hip)
    gait = ROBOT.gait
    pairs = {
        name: (1e-4 * getattr(gait, name)[0], 1e-4 * getattr(gait, name)[1])
        for name in ("step_x", "step_y", "dcm_offset")
    }
    times = (0.01 * gait.step_duration[0], 0.01 * gait.step_duration[1])
    small = small.replace(
        gait=type(gait)(step_duration=times, **pairs),
        foot=type(ROBOT.foot)(length=2e-5, width=1e-5),
        swing=sf.Swing(height=5e-6),
    )
    left_out = sf.PreviewControl(small, (0.005, 0.0), period=1e-5)
    written = sf.PreviewControl(
        small,
        (0.005, 0.0),
        input_weight=left_out.input_weight,
        preview=left_out.preview,
        period=1e-5,
    )
    assert written.parameters.tobytes() == left_out.parameters.tobytes()
