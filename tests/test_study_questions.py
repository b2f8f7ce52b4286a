"""Questions of studies that make no sense are refused before anything is measured."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import pytest

import surefoot as sf
from surefoot.studies.compare.body_question import BodyPushes, BodyWalks
from surefoot.studies.compare.question import Comparison
from surefoot.studies.gentleness.question import Gentleness
from surefoot.studies.push_map.question import PushMap

ROBOT = sf.load_robot("paper-biped")
MAP = partial(PushMap, sf.HybridController(ROBOT, (0.5, 0.0)))
COMPARE, GENTLENESS, PUSHES, WALKS = (
    partial(study, ROBOT) for study in (Comparison, Gentleness, BodyPushes, BodyWalks)
)

REFUSED = [
    (COMPARE, {"methods": ("lqr",)}, r"a method \("),
    (COMPARE, {"methods": ()}, "at least one of `methods`"),
    (COMPARE, {"methods": ("hybrid", "hybrid")}, "`methods` without repetition"),
    (COMPARE, {"directions": 0}, "`directions` as a whole number of at least 1"),
    (COMPARE, {"phases": 2.5}, "`phases` as a whole number"),
    (COMPARE, {"leg_speeds": (0.0,)}, r"`leg_speeds` above 0 \[m/s\]"),
    (COMPARE, {"leg_speeds": (math.nan,)}, "`leg_speeds` above 0"),
    (COMPARE, {"push_durations": (math.inf,)}, r"`push_durations` above 0 \[s\] and finite"),
    (COMPARE, {"step": 0.0}, r"`step` above 0 \[N s\]"),
    (COMPARE, {"velocity": (9.0, 0.0)}, "."),
    (COMPARE, {"leg_speeds": (3.0, 1.5)}, r"a leg of at least 1\.875 m/s .* walk at less"),
    (GENTLENESS, {"impulses": (0.0,)}, r"`impulses` above 0 \[N s\]"),
    (GENTLENESS, {"impulses": ()}, "at least one of `impulses`"),
    (GENTLENESS, {"leg_speeds": (3.0, 3.0)}, "`leg_speeds` without repetition"),
    (GENTLENESS, {"methods": ("lqr", "hybrid")}, r"a method \("),
    (PUSHES, {"methods": ()}, "at least one of `methods`"),
    (WALKS, {"conditions": ("fog",)}, "a disturbance of a body"),
    (WALKS, {"conditions": ()}, "at least one of `conditions`"),
    (WALKS, {"methods": ("unified", "unified")}, "`methods` without repetition"),
    (WALKS, {"seeds": 0}, "`seeds` as a whole number"),
    (WALKS, {"duration": 0.0}, "`duration` above 0"),
    (MAP, {"directions": 0}, "`directions` as a whole number of at least 1; got 0; 72 is usual"),
    (MAP, {"phases": 2.5}, "`phases` as a whole number"),
    (MAP, {"step": 0.0}, r"`step` above 0 \[N s\]"),
    (MAP, {"push_duration": -0.1}, r"`push_duration` above 0 \[s\]"),
    (MAP, {"coarse": 2.5}, "1 to 200 times the step of 1 N s; got 2.5 N s; give"),
    (MAP, {"coarse": 0.5}, "1 to 200 times the step"),
    (MAP, {"coarse": 300.0}, "1 to 200 times the step"),
]


@pytest.mark.parametrize(("study", "arguments", "message"), REFUSED)
def test_a_question_that_makes_no_sense_is_refused(
    study: Any, arguments: dict[str, Any], message: str
) -> None:
    is_about_speed = "velocity" in arguments or "a leg of" in message
    with pytest.raises(sf.VelocityError if is_about_speed else sf.ParameterError, match=message):
        study(**arguments)
