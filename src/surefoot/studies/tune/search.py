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
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.checks import optional_module
from surefoot.control.settings import Settings
from surefoot.errors import StudyError
from surefoot.studies.engine.study import OneByOne
from surefoot.studies.engine.table import Row
from surefoot.studies.engine.workers import Progress
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

Ask = Callable[[Mapping[str, float]], Row]
"""Makes of values of the parameters their row on the pushes of the search; see `Tuning.measure`."""


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
    default = _score(asked(defaults))
    if default.effort <= 0.0:
        raise StudyError(
            "a default that answers a small push, to compare with",
            f"{question.method}, which does nothing about {question.impulse:g} N s",
            "choose another controller",
        )

    def attempt(values: Mapping[str, float]) -> Objectives | None:
        return _objectives(asked(values), default)

    trials = search(question, asked)
    taken = choose(trials, question.prefer)
    values = simplest(taken, defaults, trials[0].reached, attempt)
    scores = {
        which: {pushes: _score(asked(of, pushes)) for pushes in question.pushes}
        for which, of in (("default", defaults), ("tuned", values))
    }
    why = reasons(values, defaults, attempt)
    if report is not None:
        report(asked.done, asked.done)
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
    """The rows of a search, and how many were asked for."""

    rows: OneByOne[Tuning]
    report: Progress | None
    done: int = 0

    def __call__(self, values: Mapping[str, float], pushes: str = "seen") -> Row:
        question = self.rows.study
        row = self.rows.row(question.cell(values, pushes))
        self.done += 1
        if self.report is not None:
            # After the trials each parameter is set back, some twice.
            expected = question.trials + 2 * len(question.parameters)
            self.report(self.done, max(self.done, expected))
        return row


def _score(row: Row) -> Score:
    return Score(**{one.name: row[one.name] for one in fields(Score)})


def _objectives(row: Row, default: Score) -> Objectives | None:
    """Survival and gentleness; None if the controller refused the values."""
    if row[REFUSED] is not None:
        return None
    found = _score(row)
    return found.survival, found.gentleness(default)


def search(question: Tuning, ask: Ask) -> list[Tried]:
    """Try values of the parameters: the default, some at random, then what promises most.

    Args:
        question: says what is searched, and how often.
        ask: measures the values of one trial.

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
    # The default is tried first, as it is, whatever its digits.
    study.enqueue_trial(question.start)
    found, default = [], None
    for number in range(question.trials):
        with _quiet():
            study.sampler = _sampler(optuna, question.seed, number)
            trial = study.ask(ranges)
        values = _readable(question, trial.params)
        row = ask(values)
        default = default or _score(row)
        reached = _objectives(row, default)
        study.tell(trial, reached, state=state.FAIL if reached is None else state.COMPLETE)
        told = {REFUSED: row[REFUSED]} if reached is None else asdict(_score(row))
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
