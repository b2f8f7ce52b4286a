"""`surefoot tune`: weights and gains for a robot, by push survival and gentleness."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from surefoot.options import (
    check_plotting,
    compiling_notice,
    given,
    json_option,
    progress_bar,
    robot_option,
)
from surefoot.studies.engine.command import (
    end,
    out_option,
    stopped_by_ctrl_c,
    velocity_option,
)
from surefoot.studies.tune.choice import PREFERENCES

if TYPE_CHECKING:
    from surefoot.studies.tune.question import Tuning

USUAL_LEG_SPEED = 3.0
"""Of a robot whose file names no limit [m/s]."""

QUICK_PHASES, QUICK_STEP = 1, 0.1
"""Of a quick search: phases, and the step of the scan as a share of the smallest limit."""

SETTINGS = "tuned.toml"
"""Name of the file of settings."""


@click.command()
@robot_option
@click.option(
    "--controller", default="unified", show_default=True, metavar="METHOD",
    help="What is tuned; a wrong METHOD lists those that can be.",
)  # fmt: skip
@velocity_option()
@click.option(
    "--leg-speed", type=float, metavar="M/S",
    help="Speed limit of the swing foot; the robot's own if left out, or 3 if it has none.",
)  # fmt: skip
@click.option(
    "--trials", type=int, default=100, show_default=True, metavar="N",
    help="How many are tried, with those that are there already.",
)  # fmt: skip
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the search.")
@click.option(
    "--knob", "knobs", multiple=True, metavar="NAME[=LOW:HIGH]",
    help="Search this parameter, within this range; may be repeated. All usual ones if left out.",
)  # fmt: skip
@click.option(
    "--prefer", type=click.Choice(list(PREFERENCES)), default="survival", show_default=True,
    help="What to take of what is no worse than the default.",
)  # fmt: skip
@click.option("--directions", type=int, default=4, show_default=True, help="Evenly around.")
@click.option("--phases", type=int, default=2, show_default=True, help="Evenly over a step.")
@click.option(
    "--step", type=float, default=0.02, show_default=True, metavar="SHARE",
    help="Of the scan over the impulse, as a share of the smallest limit.",
)  # fmt: skip
@click.option(
    "--quick", is_flag=True,
    help=f"{QUICK_PHASES} phase and a step of {QUICK_STEP:g}, unless they are given.",
)  # fmt: skip
@click.option("--workers", type=int, metavar="N", help="Threads; all cores if left out.")
@out_option("tune", "settings, report, picture and every trial")
@json_option
def tune(
    robot: str, controller: str, velocity: tuple[float, float], leg_speed: float | None,
    trials: int, seed: int, knobs: tuple[str, ...], prefer: str, directions: int, phases: int,
    step: float, quick: bool, workers: int | None, out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Find weights and gains for a robot by the pushes that it survives and by gentleness.

    DIR/tuned.toml holds what is not as by default, for `surefoot walk --settings DIR/tuned.toml`;
    DIR/tune.md says what changed and why, and whether it holds on pushes that the search did not
    see; DIR/tune.png shows every trial. What is taken is never worse than the default. A search
    that was stopped goes on when the same command is given again, as if it had not been.

    Example: surefoot tune --controller hybrid --trials 60
    """
    check_plotting()
    from surefoot.checks import optional_module
    from surefoot.robot.robot import load_robot
    from surefoot.studies.tune.question import Tuning

    optional_module("optuna", "tuning", "tune")
    body = load_robot(robot)
    if leg_speed is None and math.isinf(body.swing.max_speed):
        leg_speed = USUAL_LEG_SPEED
    with compiling_notice():
        question = Tuning(
            body.with_leg(max_speed=leg_speed), velocity, controller, knobs, directions,
            QUICK_PHASES if quick and not given("phases") else phases,
            QUICK_STEP if quick and not given("step") else step,
            seed, trials, prefer, workers,
        )  # fmt: skip
    walk = f"surefoot walk --robot {shlex.quote(robot)} --velocity {velocity[0]:g} {velocity[1]:g}"
    if leg_speed is not None:
        walk += f" --leg-speed {leg_speed:g}"
    walk += f" --settings {shlex.quote(str(out / SETTINGS))}"
    _tune(question, out, walk, as_json)


def _tune(question: Tuning, out: Path, walk: str, as_json: bool) -> None:
    from surefoot.control.settings import settings_text
    from surefoot.studies.engine.report import write_files
    from surefoot.studies.tune.search import tune as search
    from surefoot.studies.tune.show import report, settings_notes

    with stopped_by_ctrl_c(out), progress_bar("tuning") as progress:
        tuned = search(question, out, report=progress)
    settings = settings_text(tuned.settings, settings_notes(tuned, walk))
    (path,) = write_files({SETTINGS: settings.encode()}, out)
    end(report(tuned, walk), out, tuned.as_numbers, as_json=as_json, kept=f"settings: {path}")
    if not as_json:
        click.echo(f"walk with it: {walk}")
