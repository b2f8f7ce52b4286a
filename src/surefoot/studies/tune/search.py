"""Find weights and gains of a control method for a robot: by the pushes that it survives, and by
how gently it answers small ones. Then say what was changed, why, and whether it holds elsewhere.

What is tried next is drawn by a multivariate tree-structured Parzen estimator [Bergstra2011] with a
seed of its own, made of that of the search and the number of trials that are finished. So it
depends on these alone: a search that was killed draws the same values again, and finds their rows.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.checks import optional_module
from surefoot.control.settings import Settings
from surefoot.errors import StudyError
from surefoot.studies.engine.cells import Progress, Row
from surefoot.studies.engine.study import OneByOne
from surefoot.studies.tune.choice import (
    Objectives,
    Reason,
    Tried,
    choose,
    pareto_front,
    reasons,
    simplest,
)
from surefoot.studies.tune.measure import Score
from surefoot.studies.tune.question import REFUSED, Tuning

DIGITS = 3
"""A value that is tried is rounded to these digits: it is to be read and copied."""

RANDOM_TRIALS = 10
"""So many are drawn at random, after the default, before the search learns from them."""

Measure = Callable[[dict[str, float]], tuple[Objectives | None, dict[str, Any]]]
"""Makes of values their objectives, None if the controller refuses them, and what else is kept."""


@dataclass(frozen=True)
class Tuned:
    """What came out.

    Attributes:
        settings: the method with what was changed for good.
        trials: all of them; the first is the default.
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
        found = [(one, one.reached) for one in self.trials if one.number in self.front]
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
                    where: asdict(found) | {"gentleness": self.objectives(which, where)[1]}
                    for where, found in both.items()
                }
                for which, both in self.scores.items()
            },
            "trials": [asdict(one) for one in self.trials],
            "front": self.front,
            "chosen": self.chosen,
            "provenance": self.provenance,
        }


def tune(question: Tuning, folder: Path, *, report: Progress | None = None) -> Tuned:
    """Search, choose, simplify, and check on pushes that the search did not see.

    Args:
        question: what is tuned.
        folder: keeps everything that was measured; a search that was stopped goes on there.
        report: called with how many measurements are done, and about how many there are to be.

    Raises:
        FileError: the folder cannot be written to, or is that of another question.
        StudyError: the default does nothing about a small push.
        MissingExtraError: Optuna or polars is not installed.
    """
    # Before the folder is begun, so that nothing is left behind.
    optional_module("optuna", "tuning", "tune")
    asked, defaults = _Asked(OneByOne(question, folder), report), question.start
    if asked.default.effort <= 0.0:
        raise StudyError(
            "a default that answers a small push, to compare with",
            f"{question.method}, which does nothing about {question.impulse:g} N s",
            "choose another controller",
        )
    trials = search(question, asked.trial)
    taken = choose(trials, question.prefer)
    values = simplest(taken, defaults, trials[0].reached, asked.objectives)
    scores = {
        which: {pushes: asked.score(of, pushes) for pushes in question.pushes}
        for which, of in (("default", defaults), ("tuned", values))
    }
    why = reasons(values, defaults, asked.objectives)
    asked.end()
    return Tuned(
        settings=Settings(question.method, question.settings(values)),
        trials=trials,
        front=[one.number for one in pareto_front(trials)],
        chosen=taken.number,
        dropped=[name for name, value in taken.values.items() if value != values[name]],
        reasons=why,
        scores=scores,
        provenance=asked.rows.finished().provenance,
    )


@dataclass
class _Asked:
    """The rows of a search, compared with that of the default; how many were asked for."""

    rows: OneByOne[Tuning]
    report: Progress | None
    done: int = 0
    default: Score = field(init=False)

    def __post_init__(self) -> None:
        question = self.rows.study
        # After the trials each parameter is set back, some twice.
        self.expected = question.trials + 2 * len(question.parameters)
        self.default = self.score(question.start, "seen")

    def trial(self, values: Mapping[str, float]) -> tuple[Objectives | None, dict[str, Any]]:
        """The objectives of values, None if the controller refuses them, and what else is known."""
        row = self._row(values, "seen")
        if row[REFUSED] is not None:
            return None, {REFUSED: row[REFUSED]}
        found = _score(row)
        return (found.survival, found.gentleness(self.default)), asdict(found)

    def objectives(self, values: Mapping[str, float]) -> Objectives | None:
        """On the pushes of the search; None if the controller refuses the values."""
        return self.trial(values)[0]

    def score(self, values: Mapping[str, float], pushes: str) -> Score:
        """Of values that the controller does not refuse."""
        return _score(self._row(values, pushes))

    def end(self) -> None:
        """All is measured, sooner or later than expected."""
        self.expected = self.done
        self._report()

    def _row(self, values: Mapping[str, float], pushes: str) -> Row:
        row = self.rows.row(self.rows.study.cell(values, pushes))
        self.done += 1
        self._report()
        return row

    def _report(self) -> None:
        if self.report is not None:
            self.report(self.done, max(self.done, self.expected))


def _score(row: Row) -> Score:
    return Score(**{one.name: row[one.name] for one in fields(Score)})


def search(question: Tuning, measure: Measure) -> list[Tried]:
    """Try values of the parameters: the default, some at random, then what promises most.

    Args:
        question: says what is searched, and how often.
        measure: of the values of one trial.

    Raises:
        MissingExtraError: Optuna is not installed.
    """
    optuna = optional_module("optuna", "tuning", "tune")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study, state = optuna.create_study(directions=["maximize", "minimize"]), optuna.trial.TrialState
    ranges = {
        one.name: optuna.distributions.FloatDistribution(one.low, one.high, log=one.log)
        for one in question.parameters
    }
    found = []
    for number in range(question.trials):
        if number == 0:
            # The default is tried as it is, whatever its digits.
            study.enqueue_trial(question.start)
        with _quiet():
            study.sampler = _sampler(optuna, question.seed, number)
            trial = study.ask(ranges)
        values = _readable(question, trial.params)
        reached, told = measure(values)
        study.tell(trial, reached, state=state.FAIL if reached is None else state.COMPLETE)
        found.append(Tried(number, values, reached, told))
    return found


def _readable(question: Tuning, drawn: Mapping[str, float]) -> dict[str, float]:
    """The values that are tried for those that were drawn: rounded, but for a default."""
    values = {}
    for one in question.parameters:
        value = drawn[one.name]
        if value != question.start[one.name]:
            value = min(max(float(f"{value:.{DIGITS}g}"), one.low), one.high)
        values[one.name] = value
    return values


def _sampler(optuna: Any, seed: int, done: int) -> Any:
    """What draws the next trial, from the finished ones and a seed of its own."""
    drawn = int(np.random.SeedSequence([seed, done]).generate_state(1)[0])
    return optuna.samplers.TPESampler(
        n_startup_trials=RANDOM_TRIALS, multivariate=True, constant_liar=False, seed=drawn
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Optuna 4 warns that what is used here was new in its version 2."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="optuna", category=UserWarning)
        warnings.filterwarnings("ignore", category=FutureWarning)
        yield
