"""What a tuning asks: of which method on which robot, by which pushes, within which ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from msgspec import to_builtins

from surefoot.checks import check_number, check_seed
from surefoot.control.settings import with_settings
from surefoot.robot.robot import Robot
from surefoot.studies.engine.provenance import installed_version
from surefoot.studies.engine.pushed_walk import PushedWalk, push_cells
from surefoot.studies.engine.study import stamp
from surefoot.studies.tune.knobs import Knob, knobs_of, parameters_of
from surefoot.studies.tune.push_score import Pushed, Score, score
from surefoot.version import VERSION

SMALL_SHARE = 0.1
"""A small push is this share of the smallest limit."""

STEP_SHARE = 0.02
"""The impulse is scanned in steps of this share of the smallest limit, unless told otherwise."""


@dataclass(frozen=True)
class Question:
    """What is tuned, and by which pushes.

    Args:
        robot: who is pushed, with the speed limit that its leg is to have.
        velocity: commanded (v_x, v_y) [m/s].
        method: key of a control method that has knobs.
        asked: knobs, `NAME` or `NAME=LOW:HIGH`; all usual ones if none.
        directions: of the pushes, evenly around.
        phases: of the pushes, evenly over a step.
        step: of the scan over the impulse, a share of the smallest limit [-].
        seed: of the search.

    Raises:
        ParameterError: an argument is out of range, or the method has no such knobs.
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the method cannot control this robot.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.5, 0.0)
    method: str = "unified"
    asked: tuple[str, ...] = ()
    directions: int = 4
    phases: int = 2
    step: float = STEP_SHARE
    seed: int = 0
    knobs: tuple[Knob, ...] = field(init=False)
    walk: PushedWalk = field(init=False, repr=False)
    scan_step: float = field(init=False)
    seen: tuple[Pushed, ...] = field(init=False, repr=False)
    unseen: tuple[Pushed, ...] = field(init=False, repr=False)
    impulse: float = field(init=False)

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_number("step", self.step, 0.0, "-", above=True)
        object.__setattr__(
            self, "knobs", knobs_of(self.method, self.asked, self.robot, self.velocity)
        )
        with_settings(self.method, self.robot, self.velocity, {})  # refused now, not in a trial
        walk = PushedWalk(self.robot, self.velocity)
        walk.check_leg()
        cells = push_cells(self.directions, self.phases)
        # What the search does not see lies half-way between what it does.
        others = [
            replace(
                cell,
                angle=cell.angle + 180.0 / self.directions,
                phase=cell.phase + 0.5 / self.phases,
            )
            for cell in cells
        ]
        for name, some in (("seen", cells), ("unseen", others)):
            pushed = tuple(Pushed(one, walk.limits(one)["limit_finite"]) for one in some)
            object.__setattr__(self, name, pushed)
        smallest = min(one.limit for one in self.seen)
        object.__setattr__(self, "walk", walk)
        object.__setattr__(self, "scan_step", float(f"{self.step * smallest:.2g}"))
        object.__setattr__(self, "impulse", float(f"{SMALL_SHARE * smallest:.2g}"))

    def parameters(self, values: Mapping[str, float]) -> dict[str, Any]:
        """What is not as by default with these values of the knobs."""
        return parameters_of(self.method, self.knobs, values, self.robot, self.velocity)

    def measure(
        self, values: Mapping[str, float], cells: Sequence[Pushed], workers: int | None
    ) -> Score:
        """How the method does with these values of the knobs.

        Raises:
            SurefootError: it refuses them.
        """
        controller = with_settings(self.method, self.robot, self.velocity, self.parameters(values))
        return score(controller, self.walk, cells, self.impulse, self.scan_step, workers=workers)

    def common(self) -> dict[str, Any]:
        """What a folder is kept for, as plain values."""
        return {
            "robot": to_builtins(self.robot),
            "velocity": list(self.velocity),
            "method": self.method,
            "knobs": [asdict(knob) for knob in self.knobs],
            "directions": self.directions,
            "phases": self.phases,
            "step": self.step,
            "seed": self.seed,
            "version": VERSION,
            "sources": tune_stamp(),
            "optuna": installed_version("optuna"),
        }


def tune_stamp() -> str:
    """All sources that a trial depends on, as a hash: the kernels, and what asks the questions."""
    return stamp(Question)
