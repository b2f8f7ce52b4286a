"""What a check of a robot finds; needs no physics, so that it can also say that there is none."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from surefoot.errors import SurefootError
from surefoot.robot.robot import Robot

OK, WARNING, PROBLEM = "ok", "warning", "problem"
"""What a check can find; a problem keeps the robot from walking in physics."""


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes:
        check: what was looked at.
        verdict: "ok", "warning" or "problem".
        expected: what would be right.
        got: what is.
        remedy: what to do about it; empty if all is well.
    """

    check: str
    verdict: str
    expected: str
    got: str
    remedy: str

    def as_words(self) -> dict[str, str]:
        """For JSON."""
        return asdict(self)


def refusal(check: str, error: SurefootError) -> Finding:
    """The finding that a robot cannot be loaded at all.

    Args:
        check: what could not be loaded.
        error: that says why.
    """
    return Finding(check, PROBLEM, error.expected, error.got, error.remedy)


def point_mass_only(robot: Robot) -> Finding:
    """The finding that a robot has no mechanism to check."""
    return Finding(
        "model", WARNING, "a [body] table", f"{robot.name!r} is a point mass only",
        "describe its body if it shall walk in physics: docs/robots.md",
    )  # fmt: skip
