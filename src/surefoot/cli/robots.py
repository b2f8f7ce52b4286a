"""`surefoot robots`: what can be walked, what is missing for it, and whether one's own is right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.options import check_plotting, json_option, path_option, print_json

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot

PROBLEMS = 2
"""Exit status of a check that found some."""

_COLOURS = {"ok": "green", "warning": "yellow", "problem": "red"}


@click.group(invoke_without_command=True)
@click.option("--show", metavar="NAME", help="Print the file of a preset, to start your own from.")
@json_option
@click.pass_context
def robots(context: click.Context, show: str | None, as_json: bool) -> None:
    """List the robots that are installed, and what is missing to put them into physics."""
    if context.invoked_subcommand is not None:
        return
    from surefoot.robot.robot import load_robot, preset_names, preset_text

    if show is not None:
        click.echo(preset_text(show), nl=False)
        return
    presets = [load_robot(name) for name in preset_names()]
    if as_json:
        print_json({"robots": [_as_numbers(robot) for robot in presets]})
    else:
        _print_presets(presets)


def _as_numbers(robot: Robot) -> dict[str, Any]:
    from surefoot.robot.model_file import how_to_install, missing_packages

    missing = missing_packages(robot)
    return {
        "name": robot.name,
        "mass": robot.mass,
        "com_height": robot.com_height,
        "hip": robot.hip,
        "description": robot.description,
        "point_mass_only": robot.body is None,
        "missing": missing,
        "install": how_to_install(missing) if missing else None,
    }


def _print_presets(presets: list[Robot]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("name", "mass [kg]", "CoM height [m]", "hip [m]", "in physics", "what it is"):
        table.add_column(column, no_wrap=column == "name")
    commands: dict[str, list[str]] = {}
    for robot in presets:
        numbers = _as_numbers(robot)
        missing = numbers["missing"]
        physics = "missing: " + ", ".join(missing) if missing else "ready"
        table.add_row(
            robot.name,
            f"{robot.mass:g}",
            f"{robot.com_height:g}",
            f"{robot.hip:g}",
            "point mass only" if robot.body is None else physics,
            robot.description,
        )
        if missing:
            commands.setdefault(numbers["install"], []).append(robot.name)
    Console().print(table)
    for command, names in commands.items():
        click.echo(f"\nFor {', '.join(names)} in physics:\n    {command}")


@robots.command()
@click.argument("robot", metavar="NAME|FILE.toml")
@path_option("--picture", about="Draw the nominal pose with soles and frames (.png, .pdf, .svg).")
@json_option
@click.pass_context
def check(context: click.Context, robot: str, picture: Path | None, as_json: bool) -> None:
    """Check a robot for physics: file and model, pose, soles, limits. Exits with 2 on a problem."""
    if picture is not None:
        _check_picture(picture)
    name, findings, draw = _look_at(robot)
    found_problem = any(finding["verdict"] == "problem" for finding in findings)
    if as_json:
        print_json({"robot": name, "good": not found_problem, "checks": findings})
    else:
        for line in _check_lines(name, findings):
            click.echo(line)
    if picture is not None and draw is None:
        click.echo("no picture: there is no mechanism to draw", err=True)
    elif picture is not None and draw is not None:
        draw(picture)
    context.exit(PROBLEMS if found_problem else 0)


def _check_lines(name: str, findings: Sequence[Mapping[str, str]]) -> Iterator[str]:
    """One line for what is well, three for what is not, and how many there are.

    Args:
        name: of the robot.
        findings: with check, verdict, expected, got and remedy.
    """
    from surefoot.show.words import counted

    width = max(len(finding["check"]) for finding in findings)
    indent = " " * (11 + width)
    for finding in findings:
        verdict = finding["verdict"]
        head = click.style(f"{verdict:7}", fg=_COLOURS[verdict])
        head += f"  {finding['check']:{width}}  "
        if verdict == "ok":
            yield head + finding["got"]
            continue
        yield f"{head}expected {finding['expected']}"
        yield f"{indent}got {finding['got']}"
        yield f"{indent}do this: {finding['remedy']}"
    counts = Counter(finding["verdict"] for finding in findings)
    found = [counted(counts[noun], noun) for noun in ("problem", "warning") if counts[noun]]
    yield f"{name}: {' and '.join(found) or 'all is well'}"


def _check_picture(path: Path) -> None:
    """Refuse early what cannot be drawn."""
    from importlib.util import find_spec

    from surefoot.checks import check_writable
    from surefoot.errors import DisplayError

    check_plotting()
    check_writable(path, (".png", ".pdf", ".svg"))
    if find_spec("mujoco") is None:
        return
    try:
        # It reads MUJOCO_GL, and fails if there is no such library.
        import mujoco  # noqa: F401
    except (AttributeError, ImportError, OSError, RuntimeError) as error:
        raise DisplayError(error) from error


def _look_at(name: str) -> tuple[str, list[dict[str, str]], Callable[[Path], None] | None]:
    """The name of a robot, what was found, and what draws it if it can be drawn."""
    from surefoot.checks import optional_module
    from surefoot.errors import SurefootError
    from surefoot.robot.check import point_mass_only, refusal
    from surefoot.robot.robot import load_robot

    try:
        robot = load_robot(name)
    except SurefootError as error:
        return name, [refusal("file", error).as_words()], None
    if robot.body is None:
        return robot.name, [point_mass_only(robot).as_words()], None
    try:
        optional_module("mujoco", "physics", "mujoco")
        from surefoot.robot.multibody import load_multibody

        mechanism = load_multibody(robot, any_mass=True)
    except SurefootError as error:
        return robot.name, [refusal("model", error).as_words()], None
    from surefoot.robot.check import check_robot
    from surefoot.robot.legs import measure_pose
    from surefoot.worlds.body.gait import walking_robot

    pose = measure_pose(mechanism)
    findings = check_robot(mechanism, pose, walking_robot(mechanism))
    found = [finding.as_words() for finding in findings]

    def draw(path: Path) -> None:
        from surefoot.show.robot import draw_robot

        draw_robot(mechanism, pose, path)

    return robot.name, found, draw
