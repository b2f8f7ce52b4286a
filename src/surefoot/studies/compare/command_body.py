"""`surefoot compare --simulator mujoco`: methods on bodies that are pushed, or disturbed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.errors import ParameterError
from surefoot.options import (
    check_plotting,
    compiling_notice,
    given,
    progress_bar,
    refuse_of_other_world,
)
from surefoot.studies.engine.command import end, run_shown, stopped_by_ctrl_c

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot
    from surefoot.studies.engine.report import Report
    from surefoot.studies.engine.study import Measured, Study

BODY_VELOCITY, BODY_STEP = (0.3, 0.0), 2.0
"""Of a comparison in physics, unless they are given [m/s, N s]."""

QUICK_PHASES, QUICK_STEP = 2, 10.0
"""Of `--quick` [-, N s]."""

OF_BODY = {
    "mapping": "--mapping",
    "estimate": "--estimate",
    "quick": "--quick",
    "explain": "--explain",
}
"""Options that a point mass has no use for."""

OF_POINT_MASS = {
    "mass": "--mass",
    "leg_speeds": "--leg-speed",
    "durations": "--push-duration",
    "full": "--full",
    "directions": "--directions",
}
"""Options that a body has no use for: its mass and legs are what they are."""

OF_PUSHES = {"phases": "--phases", "step": "--step", **OF_BODY}
"""Options that walks without pushes have no use for; their state is always estimated."""

OF_WALKS = {"seeds": "--seeds", "duration": "--duration"}
"""Options that only they have."""


def refuse_others(simulator: str, robots: tuple[str, ...], disturbances: tuple[str, ...]) -> None:
    """Refuse options that make no sense with a simulator, or with a disturbance of a body.

    Raises:
        ParameterError: there is one; it is named.
    """
    refuse_of_other_world(simulator, OF_POINT_MASS, OF_BODY)
    if simulator == "lipm" and len(robots) > 1:
        raise ParameterError(
            "one --robot with --simulator lipm",
            ", ".join(robots),
            "give a command for each, or choose --simulator mujoco",
        )
    if len(set(robots)) < len(robots):
        raise ParameterError("every --robot once", ", ".join(robots), "leave the others out")
    walks = simulator == "mujoco" and bool(disturbances)
    for name, option in (OF_PUSHES if walks else OF_WALKS).items():
        if given(name) and walks:
            raise ParameterError(
                f"{option} without --disturbance: bodies that are disturbed are not pushed",
                f"{option} and --disturbance {disturbances[0]}",
                "leave one of them out",
            )
        if given(name):
            raise ParameterError(
                f"{option} with --simulator mujoco and --disturbance",
                f"--simulator {simulator}" if simulator != "mujoco" else "no --disturbance",
                f"leave {option} out, or add what is missing",
            )


def push_bodies(
    robots: Sequence[str], out: Path, workers: int, as_json: bool, *, explain: bool, **asked: Any
) -> int:
    """Push bodies, print and report what they survive; the exit status.

    Args:
        robots: names or files.
        out: has a folder for each of them.
        workers: processes.
        as_json: print JSON.
        explain: what binds in the worst pushes.
        **asked: arguments of `body_question.BodyPushes`.

    Raises:
        SurefootError: see `engine.study.run`.
    """
    loaded = _load(robots)
    from surefoot.studies.compare.body_measure import explain_worst
    from surefoot.studies.compare.body_question import BodyPushes
    from surefoot.studies.compare.body_show import push_report

    studies = [BodyPushes(robot, **asked) for robot in loaded]
    measured, status = _measure(studies, out, workers)
    explained = []
    with stopped_by_ctrl_c(out):
        for one in measured if explain else ():
            with progress_bar("explaining") as report:
                explained += explain_worst(one.study, one.rows, report)
    _end(measured, push_report(measured, explained), out, as_json, {"explained": explained})
    return status


def walk_bodies(
    robots: Sequence[str], out: Path, workers: int, as_json: bool, *,
    disturbances: Sequence[str], **asked: Any,
) -> int:  # fmt: skip
    """Walk disturbed bodies, print and report how well; the exit status.

    Args:
        robots: names or files.
        out: has a folder for each of them.
        workers: processes.
        as_json: print JSON.
        disturbances: keys of `body_question.BODY_DISTURBANCES`, or "all".
        **asked: other arguments of `body_question.BodyWalks`.

    Raises:
        SurefootError: see `engine.study.run`.
    """
    loaded = _load(robots)
    from surefoot.studies.compare.body_question import BODY_DISTURBANCES, USUAL, BodyWalks
    from surefoot.studies.compare.body_show import walk_report

    conditions = tuple(dict.fromkeys((USUAL, *disturbances)))
    if "all" in conditions:
        conditions = tuple(one.key for one in BODY_DISTURBANCES)
    studies = [BodyWalks(robot, conditions=conditions, **asked) for robot in loaded]
    measured, status = _measure(studies, out, workers)
    _end(measured, walk_report(measured), out, as_json, {})
    return status


def _load(robots: Sequence[str]) -> list[Robot]:
    """The robots, once all extras are there.

    Raises:
        SurefootError: an extra or a robot is not there.
    """
    from surefoot.checks import optional_module
    from surefoot.robot.robot import load_robot

    check_plotting()
    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    return [load_robot(name) for name in robots]


def _measure(studies: Sequence[Study], out: Path, workers: int) -> tuple[list[Measured[Any]], int]:
    from surefoot.checks import check_folder

    with compiling_notice(4.0, "a minute"):
        for study in studies:
            study.check()
    check_folder(out)
    return run_shown({out / study.robot.name: study for study in studies}, out, workers=workers)


def _end(
    measured: Sequence[Measured[Any]], report: Report, out: Path, as_json: bool, beside: dict
) -> None:
    end(
        report,
        out,
        lambda: {"robots": [one.as_numbers() for one in measured], **beside},
        as_json=as_json,
        kept="a table in the folder of each robot",
    )
