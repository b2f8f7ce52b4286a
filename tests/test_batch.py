from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from conftest import InPython
from surefoot.interface import COMMAND
from surefoot.record import new_array
from surefoot.worlds.point.batch import pushed_landings, simulate_batch
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.sensors import PointSensors

ROBOT = sf.load_robot("paper-biped")
PUSHES = [[sf.Push(1.1, 0.2, (force, 0.3 * force))] for force in np.linspace(-1500.0, 1500.0, 23)]

LEG = ROBOT.with_leg(max_speed=3.0, max_acceleration=60.0)

CONTROLLERS = {
    "tracking": sf.DcmTracking(ROBOT, (0.5, 0.0)),
    "capture-point": sf.CapturePointStepping(ROBOT, (0.5, 0.0)),
    "step-timing": sf.StepTiming(ROBOT, (0.5, 0.0)),
    "hybrid": sf.HybridController(ROBOT, (0.5, 0.0)),
    "hybrid-adapting": sf.HybridController(ROBOT, (0.2, -0.1), threshold=0.0),
    "unified": sf.UnifiedController(LEG, (0.4, 0.0)),
}


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("force", [(176.0, 0.0), (30.0, -40.0), (1500.0, 0.0)])
def test_a_batch_of_one_is_the_walk_to_the_bit(name: str, force) -> None:
    controller, pushes = CONTROLLERS[name], [sf.Push(1.1, 0.2, force)]
    walk = sf.simulate(controller, 4.0, pushes)
    (result,) = simulate_batch(controller, [pushes], 4.0)
    assert result["final"].tobytes() == walk.observations[-1].tobytes()
    assert result["steps"] == len(walk.footsteps)
    assert result["cycles"] == len(walk.time)
    assert result["fallen"] == walk.fallen
    settled = walk.outcome in (sf.Outcome.WALKED, sf.Outcome.RECOVERED)
    assert result["settled"] == settled


@pytest.mark.parametrize("name", CONTROLLERS)
def test_workers_and_company_change_nothing(name: str) -> None:
    controller = CONTROLLERS[name]
    one = simulate_batch(controller, PUSHES, 6.0, stop_when_settled=True, workers=1)
    many = simulate_batch(controller, PUSHES, 6.0, stop_when_settled=True, workers=4)
    assert one.tobytes() == many.tobytes()
    for i in (0, 11, 22):
        alone = simulate_batch(controller, [PUSHES[i]], 6.0, stop_when_settled=True)
        assert alone[0].tobytes() == one[i].tobytes()
    assert one["fallen"].any()
    assert one["settled"].any()


def test_stopping_early_does_not_change_the_verdict() -> None:
    controller = CONTROLLERS["hybrid"]
    early = simulate_batch(controller, PUSHES, 8.0, stop_when_settled=True)
    late = simulate_batch(controller, PUSHES, 8.0)
    assert (early["settled"] == late["settled"]).all()
    assert (early["recovery_steps"] == late["recovery_steps"]).all()
    assert early["cycles"].sum() < late["cycles"].sum()


def test_what_cannot_run_in_a_batch() -> None:
    alone = InPython(CONTROLLERS["hybrid"])
    with pytest.raises(sf.ParameterError, match="compiled kernel; got InPython"):
        pushed_landings(alone, [sf.Push(0.1, 0.2, (50.0, 0.0))])


def test_no_walks_no_results() -> None:
    assert len(simulate_batch(CONTROLLERS["hybrid"], [], 1.0)) == 0
    assert len(simulate_batch(CONTROLLERS["hybrid"], 0, 1.0)) == 0


def test_walks_in_python_are_the_compiled_walks_to_the_bit() -> None:
    """One rule for both, and the fork at the push changes nothing."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    pushes = [[sf.Push(1.1, 0.2, (force, 20.0))] for force in (0.0, 100.0, 700.0, 1400.0)]
    compiled = simulate_batch(controller, pushes, 6.0, stop_when_settled=True)
    walked = simulate_batch(InPython(controller), pushes, 6.0, stop_when_settled=True)
    assert compiled.tobytes() == walked.tobytes()
    assert compiled["fallen"].tolist() == [False, False, False, True]


def same_as_alone(
    controller: sf.HybridController, result: np.void, duration: float, *arguments, **how
):
    walk = sf.simulate(controller, duration, *arguments, **how)
    assert result["final"].tobytes() == walk.observations[-1].tobytes()
    assert result["cycles"] == len(walk.time)
    return walk


def test_every_column_of_a_table_is_the_argument_of_one_walk() -> None:
    """Order, company and branching off change nothing: each row is `simulate`, to the bit."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    first = controller.first_observation(None)
    walked = sf.simulate(controller, 0.55)
    starts = [first, first, sf.Observation.of(walked.observations[-1:].copy()), first, first]
    pushes = [
        [sf.Push(0.9, 0.1, (100.0, 0.0))],
        [sf.Push(0.3, 0.1, (0.0, 90.0)), sf.Push(1.5, 0.1, (-50.0, 0.0))],
        [],
        [sf.Push(0.9, 0.1, (160.0, 0.0))],
        [sf.Push(0.9005, 0.1, (-60.0, 0.0))],
    ]
    heavy = ROBOT.replace(mass=75.0)
    plants = [ROBOT, heavy, ROBOT, heavy, ROBOT]
    wrong = sf.Disturbance(dcm_noise=0.002)
    late = sf.Disturbance(delay=0.005, landing_error=0.01)
    disturbances = [wrong, wrong, late, wrong, late]
    gains, robots = [3.0, 5.0, 3.0, 3.0, 3.0], [ROBOT, LEG, ROBOT, ROBOT, ROBOT]
    seeds, times = [7, 8, 9, 7, 9], 16
    table = sf.Walks(
        pushes=pushes * times, starts=starts * times, plants=plants * times,
        disturbances=disturbances * times, seeds=seeds * times,
        parameters={"dcm_gain": np.array(gains * times), "robot": robots * times},
    )  # fmt: skip
    # So many that several are one thread's: these may share their way.
    results = sf.simulate_batch(controller, table, 3.0, workers=1)
    assert results.tobytes() == results[:5].tobytes() * times
    for i, result in enumerate(results[:5]):
        own = replace(controller, dcm_gain=gains[i], robot=robots[i])
        disturbance = replace(disturbances[i], seed=seeds[i])
        world = LipmSimulator(plants[i], 0.001, pushes[i], disturbance)
        final, cycles = one_by_one(own, world, starts[i], disturbance, 3.0)
        assert result["final"].tobytes() == final.tobytes(), i
        assert result["cycles"] == cycles


def one_by_one(controller, simulator, start, disturbance, duration) -> tuple[np.ndarray, int]:
    """The loop of `simulate` from another start."""
    sensors = PointSensors(controller, simulator.robot, disturbance)
    state, world, measured = controller.start(start), simulator.start(start), sensors.start()
    command, cycles = sf.Command.of(new_array(COMMAND)), 0
    while True:
        seen, measured = sensors.step(measured, world, command)
        command, state = controller.step(state, seen)
        cycles += 1
        if world["observation"]["time"][0] >= duration or world["fallen"][0]:
            return world["observation"], cycles
        _, world = simulator.step(world, command)


def test_a_number_of_walks_differs_in_its_noise() -> None:
    controller, noise = CONTROLLERS["hybrid"], sf.Disturbance(dcm_noise=0.003, seed=4)
    results = sf.simulate_batch(controller, 3, 2.0, disturbance=noise)
    assert len({result["final"].tobytes() for result in results}) == 3
    for seed, result in zip((4, 5, 6), results, strict=True):
        same_as_alone(controller, result, 2.0, disturbance=replace(noise, seed=seed))


def test_steps_to_recover_and_margin_are_those_of_the_walk() -> None:
    controller = CONTROLLERS["hybrid"]
    push = sf.Push(1.1, 0.2, (150.0, 60.0))
    (result,) = sf.simulate_batch(controller, [[push]], 6.0)
    walk = sf.simulate(controller, 6.0, [push])
    steps = walk.footsteps
    bounds = [sf.viable_offsets(ROBOT, step.side, ROBOT.foot.half) for step in steps]
    margins = [one.margin(step.dcm_offset) for one, step in zip(bounds, steps, strict=True)]
    nominal = sf.viable_offsets(ROBOT, sf.Side.LEFT, ROBOT.foot.half)
    margins.append(nominal.margin(tuple(walk.dcm[0] - walk.support_foot[0])))
    assert result["margin"] == pytest.approx(min(margins), abs=1e-12)
    assert result["dcm_error"] == pytest.approx(
        np.linalg.norm(walk.dcm_error, axis=1).max(), abs=1e-12
    )
    ends = [step.start + step.duration for step in steps]
    back = [
        end
        for end in ends
        if end > push.end and sf.simulate(controller, end, [push]).outcome is sf.Outcome.RECOVERED
    ]
    assert result["recovery_time"] == pytest.approx(back[0] - push.end, abs=1e-9)
    assert result["recovery_steps"] == sum(push.end < end <= back[0] for end in ends)
    late = sf.Push(1.3, 0.15, (0.0, -900.0))
    (never,) = sf.simulate_batch(controller, [[late]], 6.0)
    assert (never["recovery_steps"], never["fallen"]) == (-1, True)
    assert np.isnan(never["recovery_time"])
    fall = sf.simulate(controller, 6.0, [late]).fall
    assert fall is not None
    assert never["margin"] <= fall.lost_margin < 0.0


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({}, "at least one column"),
        ({"pushes": [[]], "seeds": [1, 2]}, "pushes of 1, seeds of 2"),
        ({"count": 2, "parameters": {"dcm_gain": [1.0]}}, "of 1, count of 2"),
        ({"count": True}, "a number of walks"),
        ({"seeds": [-1]}, "seed"),
        ({"seeds": [1.5]}, "seed"),
        ({"durations": [np.inf]}, "durations"),
        ({"durations": [-1.0]}, "durations"),
        ({"plants": ["paper-biped"]}, "a Robot for each walk"),
        ({"starts": [3]}, "an? Observation for each walk"),
        ({"controllers": [1]}, "a Controller for each walk"),
        ({"pushes": 2.5}, "`pushes`: a list with an entry for each walk; got 2.5"),
        ({"seeds": iter([1, 2])}, "`seeds`: a list with an entry for each walk"),
        ({"parameters": {"dcm_gain": 3.0}}, "`parameters.*: a list with an entry for each walk"),
    ],
)
def test_a_table_that_is_none(columns, words: str) -> None:
    with pytest.raises(sf.ParameterError, match=words):
        sf.Walks(**columns)


def test_a_parameter_that_is_none() -> None:
    controller = CONTROLLERS["hybrid"]
    with pytest.raises(sf.ParameterError, match="did you mean `dcm_gain`"):
        sf.simulate_batch(controller, sf.Walks(parameters={"dcm_gian": [1.0]}))
    with pytest.raises(sf.ParameterError, match="dcm_gain"):
        sf.simulate_batch(controller, sf.Walks(parameters={"dcm_gain": [3.0, -1.0]}))
    with pytest.raises(sf.ParameterError, match="numbers, words or pairs for dcm_gain"):
        sf.simulate_batch(controller, sf.Walks(parameters={"dcm_gain": [{"x": 1.0}]}))
    for count, said in ((2.5, "a list with an entry for each walk"), (True, "a number of walks")):
        with pytest.raises(sf.ParameterError, match=said):
            sf.simulate_batch(controller, count)  # type: ignore[arg-type]
    with pytest.raises(sf.ParameterError, match="PUSH records"):
        sf.simulate_batch(controller, sf.Walks(pushes=np.zeros(3)))
    with pytest.raises(sf.ParameterError, match="a Push"):
        sf.simulate_batch(controller, [[176.0]])
    with pytest.raises(sf.ParameterError, match="a list of pushes for each walk"):
        sf.simulate_batch(controller, [sf.Push(1.0, 0.2, (1.0, 0.0))])
    for name, value in (("start", np.nan), ("end", np.nan), ("force", np.inf)):
        records = sf.Walks(pushes=PUSHES).push_table()
        records[name][3] = value
        with pytest.raises(sf.ParameterError, match="PUSH records with a finite"):
            sf.simulate_batch(controller, sf.Walks(pushes=records))
    with pytest.raises(sf.ParameterError, match="duration"):
        sf.simulate_batch(controller, 1, 0.0)


def test_records_and_lists_of_pushes_are_the_same() -> None:
    controller = CONTROLLERS["hybrid"]
    records = sf.Walks(pushes=PUSHES).push_table()
    listed = sf.simulate_batch(controller, PUSHES, 3.0)
    assert (
        sf.simulate_batch(controller, sf.Walks(pushes=records), 3.0).tobytes() == listed.tobytes()
    )


def test_it_tells_how_far_it_is() -> None:
    told: list[tuple[int, int]] = []
    sf.simulate_batch(
        CONTROLLERS["tracking"], 5000, 0.01, report=lambda done, of: told.append((done, of))
    )
    assert told == [(4096, 5000), (5000, 5000)]


@pytest.mark.parametrize("early", [False, True])
def test_walks_that_nothing_pushes_are_the_same_in_any_company(early: bool) -> None:
    controller = CONTROLLERS["hybrid"]
    late, soon = [sf.Push(3.1, 0.2, (90.0, 0.0))], [sf.Push(0.4, 0.2, (90.0, 0.0))]
    ever = [sf.Push(0.3, np.inf, (5.0, 0.0))]
    for order in ([[], late, [], soon], [late, [], soon, late], [soon, late, ever, []]):
        # So many that several are one thread's: these may share their way.
        many = simulate_batch(controller, order * 16, 6.0, stop_when_settled=early, workers=1)
        together = many[-len(order) :]
        assert many.tobytes() == together.tobytes() * 16
        python = simulate_batch(InPython(controller), order, 6.0, stop_when_settled=early)
        assert python.tobytes() == together.tobytes()
        for pushes, result in zip(order, together, strict=True):
            (alone,) = simulate_batch(controller, [pushes], 6.0, stop_when_settled=early)
            assert alone.tobytes() == result.tobytes()
