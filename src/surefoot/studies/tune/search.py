"""Find weights and gains of a control method for a robot: by the pushes that it survives, and by
how gently it answers small ones. Then say what was changed, why, and whether it holds elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from surefoot.checks import optional_module
from surefoot.control.settings import Settings
from surefoot.errors import ParameterError, StudyError, SurefootError
from surefoot.studies.engine.study import made_with
from surefoot.studies.engine.table import claim_folder
from surefoot.studies.tune.choice import (
    Objectives,
    Reason,
    check_preference,
    choose,
    reasons,
    simplest,
)
from surefoot.studies.tune.measure import Score
from surefoot.studies.tune.question import Question
from surefoot.studies.tune.trials import REFUSED, Trials, Tried, pareto_front

Report = Callable[[int, int], None]


@dataclass(frozen=True)
class Tuned:
    """What came out.

    Attributes:
        settings: the method with what was changed for good.
        trials: all that were finished; the first is the default.
        front: numbers of those on the Pareto front.
        chosen: number of the one that was taken.
        dropped: parameters that it had changed, but that make no noticeable difference.
        reasons: why each of the others has its value.
        scores: by "default" and "tuned", and then by "seen" and "unseen".
        provenance: what a report says of itself.
    """

    settings: Settings
    trials: list[Tried]
    front: list[int]
    chosen: int
    dropped: list[str]
    reasons: list[Reason]
    scores: dict[str, dict[str, Score]]
    provenance: dict[str, str]

    def objectives(self, which: str, where: str) -> Objectives:
        """Survival and gentleness of "default" or "tuned", on pushes "seen" or "unseen"."""
        found, default = self.scores[which][where], self.scores["default"][where]
        return (found.survival, found.gentleness(default))

    def points(self) -> dict[int, Objectives]:
        """What every trial reached whose values were not refused, by its number."""
        return {one.number: one.objectives for one in self.trials if one.objectives is not None}

    def front_points(self) -> list[tuple[Tried, Objectives]]:
        """The trials of the front with what they reached, the gentlest first."""
        points = self.points()
        found = [(one, points[one.number]) for one in self.trials if one.number in self.front]
        return sorted(found, key=lambda one: one[1][1])

    @property
    def changed(self) -> bool:
        """Whether anything is better than the default."""
        return bool(self.reasons)

    def as_numbers(self) -> dict[str, Any]:
        """All of it as plain values."""
        return {
            "controller": self.settings.controller,
            "parameters": {
                name: list(value) if isinstance(value, tuple) else value
                for name, value in self.settings.parameters.items()
            },
            "changed": self.changed,
            "reasons": [
                {
                    "knob": one.parameter,
                    "default": one.default,
                    "value": one.value,
                    "without": one.without,
                }
                for one in self.reasons
            ],
            "dropped": self.dropped,
            "scores": {
                which: {
                    where: found.as_numbers() | {"gentleness": self.objectives(which, where)[1]}
                    for where, found in both.items()
                }
                for which, both in self.scores.items()
            },
            "trials": [asdict(one) for one in self.trials],
            "front": self.front,
            "chosen": self.chosen,
            "provenance": self.provenance,
        }


def tune(
    question: Question,
    folder: Path,
    trials: int,
    *,
    prefer: str = "survival",
    workers: int | None = None,
    report: Report | None = None,
) -> Tuned:
    """Search, choose, simplify, and check on pushes that the search did not see.

    Args:
        question: what is tuned.
        folder: keeps everything that was measured; a search that was stopped goes on there.
        trials: how many there are to be, with those that are there already.
        prefer: what to take of the front: "survival", "gentleness" or "balance".
        workers: threads, all cores if None; their number changes nothing.
        report: called with how many measurements are done, and about how many there are to be:
            trials, and what comes after them.

    Raises:
        ParameterError: less than one trial, or no such preference.
        FileError: the folder cannot be written to, or is that of another question.
        StudyError: the default does nothing about a small push, or another process is at work.
        MissingExtraError: Optuna is not installed.
    """
    if isinstance(trials, bool) or not isinstance(trials, int) or trials < 1:
        raise ParameterError("`trials` of at least 1", repr(trials), "100 is usual")
    defaults = question.start
    # Before the folder is claimed, so that a mistake leaves nothing behind.
    check_preference(prefer)
    optional_module("optuna", "tuning", "tune")
    claim_folder(folder, question.common())
    search = Trials(folder, question.parameters, defaults, question.seed)
    measured = _Measured(question, search, workers, report)
    if measured.default.effort <= 0.0:
        raise StudyError(
            "a default that answers a small push, to compare with",
            f"{question.method}, which does nothing about {question.impulse:g} N s",
            "choose another controller",
        )
    found = search.go_on(measured.trial, trials, measured.tell_trials)
    taken = choose(found, prefer)
    measured.begin_checks(len(found))
    values = simplest(taken, defaults, measured.of(measured.default), measured.objectives)
    scores = {
        which: {where: measured.score(of, where) for where in ("seen", "unseen")}
        for which, of in (("default", defaults), ("tuned", values))
    }
    why = reasons(values, defaults, measured.objectives)
    measured.end_checks()
    return Tuned(
        settings=Settings(question.method, question.settings(values)),
        trials=found,
        front=[one.number for one in pareto_front(found)],
        chosen=taken.number,
        dropped=[name for name, value in taken.values.items() if value != values[name]],
        reasons=why,
        scores=scores,
        provenance={
            **question.provenance(),
            "trials": f"{len(found)}",
            "seed": f"{question.seed}",
            "preferred": prefer,
            **made_with("numpy", "numba", "optuna"),
        },
    )


@dataclass
class _Measured:
    """What is measured in a search and after it; nothing is measured twice."""

    question: Question
    search: Trials
    workers: int | None
    report: Report | None
    default: Score = field(init=False)
    done: int = 0
    expected: int | None = None

    def __post_init__(self) -> None:
        self.default = self.score(self.question.start, "seen")

    def of(self, found: Score) -> Objectives:
        return (found.survival, found.gentleness(self.default))

    def trial(self, values: dict[str, float]) -> tuple[Objectives | None, dict[str, Any]]:
        """One trial; that of the default is known."""
        try:
            if not self.question.settings(values):
                found = self.default
            else:
                found = self.question.measure(values, self.question.seen, self.workers)
        except SurefootError as error:
            return None, {REFUSED: str(error)}
        return self.of(found), found.as_numbers()

    def objectives(self, values: Mapping[str, float]) -> Objectives | None:
        """On the pushes of the search; None if the controller refuses the values."""
        found = self._remembered(values, "seen")
        return None if REFUSED in found else self.of(Score(**found))

    def score(self, values: Mapping[str, float], where: str) -> Score:
        """Of values that the controller does not refuse."""
        return Score(**self._remembered(values, where))

    def tell_trials(self, done: int, trials: int) -> None:
        """So many trials are finished; afterwards each parameter is set back, some twice."""
        self.done = done
        self._tell(trials + 2 * len(self.question.parameters))

    def begin_checks(self, done: int) -> None:
        """From here on every measurement is reported."""
        self.done, self.expected = done, done + 2 * len(self.question.parameters)

    def end_checks(self) -> None:
        """All is measured, sooner or later than expected."""
        self._tell(self.done)

    def _remembered(self, values: Mapping[str, float], where: str) -> dict[str, Any]:
        cells = self.question.seen if where == "seen" else self.question.unseen

        def measure() -> dict[str, Any]:
            try:
                return self.question.measure(values, cells, self.workers).as_numbers()
            except SurefootError as error:
                return {REFUSED: str(error)}

        found = self.search.remembered({"where": where, "values": dict(values)}, measure)
        if self.expected is not None:
            self.done += 1
            self._tell(max(self.done, self.expected))
        return found

    def _tell(self, expected: int) -> None:
        if self.report is not None:
            self.report(self.done, expected)
