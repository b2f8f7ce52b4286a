"""A search by Optuna that survives being killed, and then goes on as if nothing had happened.

The trials are in a journal on disk. What is tried next is drawn by a multivariate tree-structured
Parzen estimator [Bergstra2011] with a seed of its own, made of that of the search and the number of
trials that are finished; so it depends on these alone, and not on where a process began.
"""

from __future__ import annotations

import json
import logging
import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.checks import optional_module
from surefoot.errors import FileError, StudyError
from surefoot.studies.tune.parameters import Parameter, rounded

JOURNAL, NAME = "trials.journal", "tune"

RANDOM_TRIALS = 10
"""So many are drawn at random, after the default, before the search learns from them."""

REFUSED = "refused"
"""Under this name a trial keeps why the controller refused its values."""

NOTES = "note:"
"""Begins the name of what a search remembers beside its trials."""


@dataclass(frozen=True)
class Tried:
    """One finished trial.

    Attributes:
        number: 0 is the default.
        values: of the parameters.
        objectives: what came out, or None if the controller refused the values.
        told: what else was measured, or under `REFUSED` why they were refused.
    """

    number: int
    values: dict[str, float]
    objectives: tuple[float, float] | None
    told: dict[str, Any]


Measure = Callable[[dict[str, float]], tuple[tuple[float, float] | None, dict[str, Any]]]
"""Makes of values what is to be large and what is to be small, or None if the controller refuses
them, and what else is kept."""


@dataclass(frozen=True)
class Trials:
    """The search in a folder.

    Args:
        folder: it exists.
        parameters: that are searched.
        start: values of the first trial.
        seed: of the search.

    Raises:
        MissingExtraError: Optuna is not installed.
        FileError: the journal cannot be read.
    """

    folder: Path
    parameters: tuple[Parameter, ...]
    start: Mapping[str, float]
    seed: int = 0
    study: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        optuna = optional_module("optuna", "tuning", "tune")
        journal = optional_module("optuna.storages.journal", "tuning", "tune")
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        path = self.folder / JOURNAL
        _cut_half_line(path)
        try:
            lock = journal.JournalFileOpenLock(str(path), grace_period=5)
            backend = journal.JournalFileBackend(str(path), lock_obj=lock)
            study = optuna.create_study(
                study_name=NAME,
                storage=optuna.storages.JournalStorage(backend),
                directions=["maximize", "minimize"],
                load_if_exists=True,
            )
        except (OSError, ValueError, KeyError) as error:
            raise FileError(
                "a journal that a search wrote", f"{path}: {error}", "delete the folder"
            ) from error
        # What a killed process was at is not finished, and will not be.
        for trial in study.get_trials(deepcopy=False):
            if not trial.state.is_finished():
                study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
        object.__setattr__(self, "study", study)

    def finished(self) -> list[Tried]:
        """The trials that were finished, in order."""
        found = []
        for trial in self.study.get_trials(deepcopy=False):
            told = trial.user_attrs.get("told", {})
            if trial.values or REFUSED in told:
                values = {one.name: self._tried(one, trial.params) for one in self.parameters}
                good = (trial.values[0], trial.values[1]) if trial.values else None
                found.append(Tried(len(found), values, good, told))
        return found

    def go_on(
        self,
        measure: Measure,
        trials: int,
        report: Callable[[int, int], None] | None = None,
    ) -> list[Tried]:
        """Try until so many trials are finished.

        Args:
            measure: of the values of one trial.
            trials: how many there are to be, with those that are there already.
            report: called with how many are finished, and how many are wanted.

        Raises:
            StudyError: another process works in the same folder.
        """
        done = len(self.finished())
        optuna = optional_module("optuna", "tuning", "tune")
        while done < trials:
            if report is not None:
                report(done, trials)
            self._try_one(optuna, done, measure)
            done += 1
        if report is not None:
            report(done, max(done, trials))
        return self.finished()

    def remembered(self, question: Any, measure: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """What was measured beside the trials: once, and then read from the journal.

        Args:
            question: plain values that distinguish it from others.
            measure: makes the answer, plain values too.
        """
        name = NOTES + json.dumps(question, sort_keys=True)
        notes = self.study.user_attrs
        if name not in notes:
            self.study.set_user_attr(name, measure())
            return self.study.user_attrs[name]
        return notes[name]

    def _tried(self, one: Parameter, drawn: Mapping[str, float]) -> float:
        # The default is tried as it is, whatever its digits.
        value = drawn[one.name]
        if value == self.start[one.name]:
            return value
        return min(max(rounded(value), one.low), one.high)

    def _try_one(self, optuna: Any, done: int, measure: Measure) -> None:
        ranges = {
            one.name: optuna.distributions.FloatDistribution(one.low, one.high, log=one.log)
            for one in self.parameters
        }
        state = optuna.trial.TrialState
        if done == 0:
            good, told = measure({one.name: self.start[one.name] for one in self.parameters})
            # Whole or not at all: a trial that is only asked for is lost to a kill.
            self.study.add_trial(
                optuna.trial.create_trial(
                    params=dict(self.start),
                    distributions=ranges,
                    values=good,
                    state=state.FAIL if good is None else state.COMPLETE,
                    user_attrs={"told": told},
                )
            )
            return
        self.study.sampler = _sampler(optuna, self.seed, done)
        with _quiet():
            trial = self.study.ask(ranges)
        good, told = measure({one.name: self._tried(one, trial.params) for one in self.parameters})
        try:
            trial.set_user_attr("told", told)
            self.study.tell(trial, good, state=state.FAIL if good is None else state.COMPLETE)
        except (optuna.exceptions.UpdateFinishedTrialError, ValueError) as error:
            raise StudyError(
                "one search in a folder",
                f"another process that works in {self.folder}",
                "wait until it is done, or choose another folder",
            ) from error


def pareto_front(trials: Sequence[Tried]) -> list[Tried]:
    """The trials that no other one dominates by being as good in both and better in one."""
    good = [one for one in trials if one.objectives is not None]
    return [one for one in good if not any(_dominates(other, one) for other in good)]


def _dominates(one: Tried, other: Tried) -> bool:
    if one.objectives is None or other.objectives is None:
        return False
    (survival, gentleness), (least, most) = one.objectives, other.objectives
    return survival >= least and gentleness <= most and (survival > least or gentleness < most)


def _sampler(optuna: Any, seed: int, done: int) -> Any:
    """What draws the next trial, from the finished ones and a seed of its own."""
    drawn = int(np.random.SeedSequence([seed, done]).generate_state(1)[0])
    with _quiet():
        return optuna.samplers.TPESampler(
            n_startup_trials=RANDOM_TRIALS, multivariate=True, constant_liar=False, seed=drawn
        )


@contextmanager
def _quiet() -> Iterator[None]:
    """Optuna 4 warns that what is used here was new in its version 2."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="optuna", category=UserWarning)
        warnings.filterwarnings("ignore", category=FutureWarning)
        logging.getLogger("optuna").setLevel(logging.WARNING)
        yield


def _cut_half_line(path: Path) -> None:
    """Drop what a crash left of the last line, which would spoil the one that follows."""
    if not path.exists():
        return
    text = path.read_bytes()
    whole = text.rfind(b"\n") + 1
    if whole < len(text):
        os.truncate(path, whole)
