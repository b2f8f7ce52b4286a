"""What is asked of [OnlineGait]: its claims, what one step absorbs, and its pushes on a body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import ClassVar

from surefoot.studies.engine.study import Study
from surefoot.studies.engine.table import Row
from surefoot.studies.reproduce.body import (
    DRAWN,
    METHODS,
    PAPER_PUSHES,
    PaperPush,
    body_answer,
    body_claim,
    step_rows,
)
from surefoot.studies.reproduce.measure import CLAIMS
from surefoot.studies.reproduce.one_step import (
    Assumptions,
    OneStepLimit,
    every_assumption,
    one_step_impulse,
)


@dataclass(frozen=True)
class OneStep(Study):
    """How large a push one step absorbs, under every set of assumptions that the paper leaves
    open."""

    NAME: ClassVar = "one_step"

    def cells(self) -> Iterator[Assumptions]:
        """See `Study`."""
        return every_assumption()

    def measure(self, cell: Assumptions) -> Row:
        """See `Study`."""
        return {"impulse": one_step_impulse(self.robot, cell)}

    def at_once(self) -> int:
        """Those that differ in what counts as absorbed: they have the same landings."""
        return 4


@dataclass(frozen=True)
class ClaimCell:
    """One claim: a key of `measure.CLAIMS`."""

    name: str


@dataclass(frozen=True)
class Paper(Study):
    """What the paper claims of its point mass; 70 kg is the mass of its abstract.

    Attributes:
        limits: of one step, as `OneStep` measured them.
    """

    limits: tuple[OneStepLimit, ...]

    NAME: ClassVar = "paper"

    def cells(self) -> Iterator[ClaimCell]:
        """See `Study`."""
        return map(ClaimCell, CLAIMS)

    def measure(self, cell: ClaimCell) -> Row:
        """A `Claim`, by the names of its fields."""
        return asdict(CLAIMS[cell.name](self.robot, self.limits))


@dataclass(frozen=True)
class BodyCell:
    """One push on a body, and the key of the method that answers it."""

    method: str
    push: PaperPush


@dataclass(frozen=True)
class PaperOnBody(Study):
    """The paper's pushes on its robot in physics."""

    NAME: ClassVar = "paper_body"
    LIBRARIES: ClassVar = ("numpy", "numba", "mujoco", "daqp")

    def cells(self) -> Iterator[BodyCell]:
        """See `Study`."""
        return (BodyCell(*one) for one in product(METHODS, PAPER_PUSHES))

    def columns(self, cell: BodyCell) -> Row:
        """See `Study`."""
        return {
            "method": cell.method,
            "impulse": cell.push.impulse,
            "direction": cell.push.direction,
        }

    def measure(self, cell: BodyCell) -> Row:
        """A `Claim`, by the names of its fields; what was walked on and with; the steps of a walk
        that is drawn."""
        answer = body_answer(self.robot, cell.method, cell.push)
        drawn = tuple(self.columns(cell).values()) in DRAWN
        return asdict(body_claim(answer)) | {
            "surroundings": answer.rollout.body.surroundings if answer.rollout.body else "",
            "parameters": answer.rollout.controller_parameters,
            "steps": step_rows(answer) if drawn else [],
        }
