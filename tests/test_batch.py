from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import surefoot as sf
from surefoot.simulation.batch import simulate_batch
from surefoot.simulation.landings import pushed_landings

ROBOT = sf.load_robot("paper-biped")
PUSHES = [[sf.Push(1.1, 0.2, (force, 0.3 * force))] for force in np.linspace(-1500.0, 1500.0, 23)]

CONTROLLERS = {
    "tracking": sf.DcmTracking(ROBOT, (0.5, 0.0)),
    "hybrid": sf.HybridController(ROBOT, (0.5, 0.0)),
    "hybrid-adapting": sf.HybridController(ROBOT, (0.2, -0.1), threshold=0.0),
}


@dataclass(frozen=True)
class InPython:
    """A compiled controller that hides its kernel."""

    inner: sf.HybridController
    kernel: None = None

    def __getattr__(self, name: str):
        return getattr(self.inner, name)


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("force", [(176.0, 0.0), (30.0, -40.0), (1500.0, 0.0)])
def test_a_batch_of_one_is_the_walk_to_the_bit(name: str, force) -> None:
    controller, pushes = CONTROLLERS[name], [sf.Push(1.1, 0.2, force)]
    walk = sf.simulate(controller, 4.0, pushes)
    (result,) = simulate_batch(controller, [pushes], 4.0, stop_when_settled=False)
    assert result["final"].tobytes() == walk.observations[-1].tobytes()
    assert result["cycles"] == len(walk.time)
    assert result["fallen"] == walk.fallen
    settled = walk.outcome in (sf.Outcome.WALKED, sf.Outcome.RECOVERED)
    assert result["settled"] == settled


@pytest.mark.parametrize("name", CONTROLLERS)
def test_workers_and_company_change_nothing(name: str) -> None:
    controller = CONTROLLERS[name]
    one = simulate_batch(controller, PUSHES, 6.0, workers=1)
    many = simulate_batch(controller, PUSHES, 6.0, workers=4)
    assert one.tobytes() == many.tobytes()
    for i in (0, 11, 22):
        alone = simulate_batch(controller, [PUSHES[i]], 6.0)
        assert alone[0].tobytes() == one[i].tobytes()
    assert one["fallen"].any()
    assert one["settled"].any()


def test_stopping_early_does_not_change_the_verdict() -> None:
    controller = CONTROLLERS["hybrid"]
    early = simulate_batch(controller, PUSHES, 8.0)
    late = simulate_batch(controller, PUSHES, 8.0, stop_when_settled=False)
    assert (early["settled"] == late["settled"]).all()
    assert early["cycles"].sum() < late["cycles"].sum()


def test_what_cannot_run_in_a_batch() -> None:
    alone = InPython(CONTROLLERS["hybrid"])
    with pytest.raises(sf.ParameterError, match="compiled kernel; got InPython"):
        pushed_landings(alone, [sf.Push(0.1, 0.2, (50.0, 0.0))])
    with pytest.raises(sf.ParameterError, match="same number of pushes"):
        simulate_batch(CONTROLLERS["hybrid"], [[], PUSHES[0]], 1.0)


def test_no_walks_no_results() -> None:
    assert len(simulate_batch(CONTROLLERS["hybrid"], [], 1.0)) == 0


def test_walks_in_python_are_the_compiled_walks_to_the_bit() -> None:
    """One rule for both, and the fork at the push changes nothing."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    pushes = [[sf.Push(1.1, 0.2, (force, 20.0))] for force in (0.0, 100.0, 700.0, 1400.0)]
    compiled = simulate_batch(controller, pushes, 6.0)
    walked = simulate_batch(InPython(controller), pushes, 6.0)
    assert compiled.tobytes() == walked.tobytes()
    assert compiled["fallen"].tolist() == [False, False, False, True]
