"""`surefoot compare`: methods against each other, and against what is possible at all."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.options import check_plotting, given, json_option, mapping_option
from surefoot.studies.compare.command_body import (
    BODY_STEP,
    BODY_VELOCITY,
    QUICK_PHASES,
    QUICK_STEP,
    push_bodies,
    refuse_others,
    walk_bodies,
)
from surefoot.studies.engine.command import (
    end,
    out_option,
    run_shown,
    velocity_option,
    workers_option,
)

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot
    from surefoot.studies.compare.question import Comparison

FULL_SPEEDS, FULL_DURATIONS = (2.0, 3.0, 4.0, 6.0, math.inf), (0.1, 0.2, 0.4)
"""Leg speeds [m/s] and push durations [s] of `--full`."""


@click.command()
@click.option(
    "--robot", "robots", multiple=True, default=("paper-biped",), show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file; of bodies there may be several.",
)  # fmt: skip
@click.option(
    "--simulator", type=click.Choice(["lipm", "mujoco"]), default="lipm", show_default=True,
    help="What is pushed: a point mass on two feet, or a body in physics.",
)  # fmt: skip
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
    help="Body: tell the controller an estimate from its noisy sensors, not the true state.",
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
    robots: tuple[str, ...], simulator: str, mass: float | None, velocity: tuple[float, float],
    methods: tuple[str, ...], leg_speeds: tuple[float, ...], durations: tuple[float, ...],
    full: bool, directions: int, phases: int, step: float, disturbances: tuple[str, ...],
    seeds: int, duration: float, mapping: str, estimate: bool, quick: bool, explain: bool,
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

    refuse_others(simulator, robots, disturbances)
    if simulator == "mujoco":
        asked: dict[str, Any] = {
            "velocity": velocity if given("velocity") else BODY_VELOCITY,
            "mapping": mapping,
        }
        if methods:
            asked["methods"] = methods
        if disturbances:
            asked |= {"disturbances": disturbances, "seeds": seeds, "duration": duration}
            sys.exit(walk_bodies(robots, out, workers, as_json, **asked))
        asked |= {
            "phases": QUICK_PHASES if quick and not given("phases") else phases,
            "step": step if given("step") else (QUICK_STEP if quick else BODY_STEP),
            "estimate": estimate,
        }
        sys.exit(push_bodies(robots, out, workers, as_json, explain=explain, **asked))
    check_plotting()
    (robot,) = robots
    body = load_robot(robot) if mass is None else load_robot(robot).replace(mass=mass)
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
    from surefoot.studies.compare.remarks import remarks
    from surefoot.studies.compare.show import comparison_report

    report = comparison_report(result) if study.must_settle else budget_report(result)

    def numbers() -> dict[str, Any]:
        # The paper disturbs nothing but the robot.
        return result.as_numbers() | {"remarks": remarks(result.rows) if study.must_settle else []}

    end(report, out, numbers, as_json=as_json, kept=f"table: {out / study.NAME}.parquet")
    return status
