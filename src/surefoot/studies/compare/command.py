"""`surefoot compare`: methods against each other, and against what is possible at all.

A point mass is pushed, or with `--simulator mujoco` bodies in physics: see `--help`.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.errors import ParameterError
from surefoot.options import (
    check_plotting,
    compiling_notice,
    given,
    json_option,
    legs_unknown_option,
    mapping_option,
    moved_robot,
    option_of,
    progress_bar,
    refuse_of_other_world,
    simulator_option,
)
from surefoot.studies.engine.command import (
    end,
    out_option,
    run_shown,
    stopped_by_ctrl_c,
    velocity_option,
    workers_option,
)

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot
    from surefoot.studies.compare.question import Comparison

FULL_SPEEDS, FULL_DURATIONS = (2.0, 3.0, 4.0, 6.0, math.inf), (0.1, 0.2, 0.4)
"""Leg speeds [m/s] and push durations [s] of `--full`."""

BODY_VELOCITY, BODY_STEP = (0.3, 0.0), 2.0
"""Of a comparison in physics, unless they are given [m/s, N s]."""

QUICK_PHASES, QUICK_STEP = 2, 10.0
"""Of `--quick` [-, N s]."""

OF_BODY_PUSHES = "estimate", "quick", "explain"
"""Options of bodies that are pushed."""

OF_BODY = "mapping", *OF_BODY_PUSHES
"""Options that a point mass has no use for."""

OF_POINT_MASS = "mass", "leg_speeds", "durations", "full", "directions", "legs_unknown"
"""Options that a body has no use for: its mass and legs are what they are."""

OF_PUSHES = "phases", "step", *OF_BODY_PUSHES
"""Options that walks without pushes have no use for; their state is always estimated."""

OF_WALKS = "seeds", "duration"
"""Options that only they have."""


@click.command()
@click.option(
    "--robot", "robots", multiple=True, default=("paper-biped",), show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file; of bodies there may be several.",
)  # fmt: skip
@simulator_option(
    "What is pushed: a point mass on two feet, one on legs of mass, or a body in physics."
)
@legs_unknown_option
@click.option(
    "--mass", type=float, metavar="KG", help="Of the robot; its own if left out. Limits scale."
)
@velocity_option("0.5 0, of a body 0.3 0")
@click.option(
    "--method", "methods", multiple=True, metavar="METHOD",
    help="One to compare; may be repeated. All but the slow nonlinear one if left out.",
)  # fmt: skip
@click.option(
    "--leg-speed", "leg_speeds", type=float, multiple=True, metavar="M/S",
    help="Speed limit of the swing foot, or inf; may be repeated. 3 if left out.",
)  # fmt: skip
@click.option(
    "--push-duration", "durations", type=float, multiple=True, metavar="S",
    help="May be repeated. 0.2 if left out.",
)  # fmt: skip
@click.option(
    "--full", is_flag=True, help="Leg speeds 2, 3, 4, 6 and inf; pushes of 0.1, 0.2 and 0.4 s."
)
@click.option("--directions", type=int, default=4, show_default=True, help="Evenly around.")
@click.option("--phases", type=int, default=8, show_default=True, help="Evenly over a step.")
@click.option(
    "--step", "--grid", "step", type=float, default=1.0, show_default="1, of a body 2",
    metavar="NS", help="Of the scan over the impulse [N s].",
)  # fmt: skip
@click.option(
    "--disturbance", "disturbances", multiple=True, metavar="NAME",
    help="Noise, delay, another mass: what is lost to it, or if a body walks; may be repeated. "
    "`all` for all, a wrong NAME lists them.",
)  # fmt: skip
@click.option(
    "--seeds", type=int, default=3, show_default=True, metavar="N",
    help="Body, with --disturbance: walks under each, with other noise and bumps.",
)  # fmt: skip
@click.option(
    "--duration", type=float, default=20.0, show_default=True, metavar="S",
    help="Body, with --disturbance: of a walk [s].",
)  # fmt: skip
@mapping_option
@click.option(
    "--estimate", is_flag=True,
    help="Body: give the controller an estimate from its noisy sensors, not the true state.",
)  # fmt: skip
@click.option(
    "--quick",
    is_flag=True,
    help=f"Body: {QUICK_PHASES} phases and a grid of {QUICK_STEP:g} N s, unless they are given.",
)
@click.option(
    "--explain", is_flag=True, help="Body: tell which limits bind in the worst push of each kind."
)
@workers_option
@out_option("compare", "table, report, page and pictures")
@json_option
def compare(
    robots: tuple[str, ...], simulator: str, legs_unknown: bool, mass: float | None,
    velocity: tuple[float, float],
    methods: tuple[str, ...], leg_speeds: tuple[float, ...], durations: tuple[float, ...],
    full: bool, directions: int, phases: int, step: float, disturbances: tuple[str, ...],
    seeds: int, duration: float, mapping: str | None, estimate: bool, quick: bool, explain: bool,
    workers: int, out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Compare control methods: the smallest push that each fails on, beside the theoretical limit.

    DIR/compare.html is a page on which to choose the leg speed; compare.md says it in words,
    compare.parquet holds every number. A study that was stopped goes on when the same command is
    given again; another one of the same robot and velocity adds to it.

    With disturbances, the answer is the noise-and-delay budget: DIR/budget.md and budget.png say
    what each method loses to each, beside the undisturbed walk. It needs a DIR of its own.

    With `--simulator mujoco` bodies are pushed: DIR/pushes.html and pushes.md report what fells
    them and why, with a picture and a table in a folder for each robot. With disturbances they walk
    without pushes: DIR/walks.html and walks.md say how well, and why what falls does.
    """
    from surefoot.robot.robot import load_robot
    from surefoot.studies.compare.question import Comparison

    _refuse_others(simulator, robots, disturbances)
    if simulator == "mujoco":
        asked: dict[str, Any] = {"velocity": velocity if given("velocity") else BODY_VELOCITY}
        if mapping is not None:
            asked["mapping"] = mapping
        if methods:
            asked["methods"] = methods
        if disturbances:
            asked |= {"conditions": disturbances, "seeds": seeds, "duration": duration}
        else:
            asked |= {
                "phases": QUICK_PHASES if quick and not given("phases") else phases,
                "step": step if given("step") else (QUICK_STEP if quick else BODY_STEP),
                "estimate": estimate,
            }
        sys.exit(_bodies(robots, out, workers, as_json, explain, asked))
    check_plotting()
    (robot,) = robots
    body = load_robot(robot) if mass is None else load_robot(robot).replace(mass=mass)
    body = moved_robot(body, simulator, legs_unknown)
    study = Comparison(
        body,
        velocity,
        methods=methods or _all_methods(body, velocity),
        directions=directions,
        phases=phases,
        leg_speeds=leg_speeds or (FULL_SPEEDS if full else (3.0,)),
        push_durations=durations or (FULL_DURATIONS if full else (0.2,)),
        step=step,
        disturbances=_all_disturbances(disturbances),
    )
    sys.exit(_compare(study, out, workers, as_json))


def _all_methods(robot: Robot, velocity: tuple[float, float]) -> tuple[str, ...]:
    """All that can be compared on this robot; say what is left out, and why."""
    from surefoot.control.registry import methods
    from surefoot.studies.compare.question import able_methods

    able, left_out = able_methods(robot, velocity)
    for one in methods():
        if one.slow:
            left_out[one.key] = f"slow; ask for it with --method {one.key}"
    for key, reason in left_out.items():
        click.echo(f"left out: {key}: {reason}", err=True)
    return tuple(able)


def _all_disturbances(named: tuple[str, ...]) -> tuple[str, ...]:
    """What was named, after the undisturbed walk that it is compared with."""
    from surefoot.studies.compare.disturbances import UNDISTURBED, every_disturbance

    if "all" in named:
        return every_disturbance()
    return tuple(dict.fromkeys((UNDISTURBED, *named)))


def _compare(study: Comparison, out: Path, workers: int, as_json: bool) -> int:
    (result,), status = run_shown({out: study}, out, workers=workers)
    from surefoot.studies.compare.budget import budget_report
    from surefoot.studies.compare.show import comparison_report, remarks

    report = comparison_report(result) if study.must_settle else budget_report(result)

    def numbers() -> dict[str, Any]:
        # The paper disturbs nothing but the robot.
        return result.as_numbers() | {"remarks": remarks(result.rows) if study.must_settle else []}

    end(report, out, numbers, as_json=as_json, kept=f"table: {out / study.NAME}.parquet")
    return status


def _refuse_others(simulator: str, robots: tuple[str, ...], disturbances: tuple[str, ...]) -> None:
    """Refuse options that make no sense with a simulator, or with a disturbance of a body.

    Raises:
        ParameterError: there is one; it is named.
    """
    refuse_of_other_world(simulator, OF_POINT_MASS, OF_BODY)
    if simulator != "mujoco" and len(robots) > 1:
        raise ParameterError(
            f"one --robot with --simulator {simulator}",
            ", ".join(robots),
            "give a command for each, or choose --simulator mujoco",
        )
    if len(set(robots)) < len(robots):
        raise ParameterError("every --robot once", ", ".join(robots), "leave the others out")
    walks = simulator == "mujoco" and bool(disturbances)
    refused = filter(given, OF_PUSHES if walks else OF_WALKS)
    wrong = next(map(option_of, refused), "")
    if wrong and walks:
        raise ParameterError(
            f"{wrong} without --disturbance: bodies that are disturbed are not pushed",
            f"{wrong} and --disturbance {disturbances[0]}",
            "leave one of them out",
        )
    if wrong:
        raise ParameterError(
            f"{wrong} with --simulator mujoco and --disturbance",
            f"--simulator {simulator}" if simulator != "mujoco" else "no --disturbance",
            f"leave {wrong} out, or add what is missing",
        )


def _bodies(
    robots: tuple[str, ...], out: Path, workers: int, as_json: bool, explain: bool,
    asked: dict[str, Any],
) -> int:  # fmt: skip
    """Push bodies, or walk disturbed ones; print and report how well; the exit status.

    Args:
        robots: names or files.
        out: has a folder for each of them.
        workers: processes.
        as_json: print JSON.
        explain: what binds in the worst pushes.
        asked: arguments of `body_question.BodyWalks` if `conditions` are among them, else of
            `body_question.BodyPushes`.

    Raises:
        SurefootError: an extra or a robot is not there; or see `engine.study.run`.
    """
    from surefoot.checks import check_folder, optional_module
    from surefoot.robot.robot import load_robot

    check_plotting()
    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    loaded = [load_robot(name) for name in robots]
    from surefoot.studies.compare.body_measure import explain_worst
    from surefoot.studies.compare.body_question import BodyPushes, BodyWalks, conditions_named
    from surefoot.studies.compare.body_show import push_report, walk_report

    walks = "conditions" in asked
    if walks:
        asked["conditions"] = conditions_named(asked["conditions"])
    studies = [(BodyWalks if walks else BodyPushes)(robot, **asked) for robot in loaded]
    with compiling_notice(4.0, "a minute"):
        for study in studies:
            study.check()
    check_folder(out)
    folders = {out / study.robot.name: study for study in studies}
    measured: list[Any]
    measured, status = run_shown(folders, out, workers=workers)
    explained = []
    with stopped_by_ctrl_c(out):
        for one in measured if explain else ():
            with progress_bar("explaining") as progress:
                explained += explain_worst(one.study, one.rows, progress)
    beside = {} if walks else {"explained": explained}
    end(
        walk_report(measured) if walks else push_report(measured, explained),
        out,
        lambda: {"robots": [one.as_numbers() for one in measured], **beside},
        as_json=as_json,
        kept="a table in the folder of each robot",
    )
    return status
