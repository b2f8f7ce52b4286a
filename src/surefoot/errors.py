"""What Surefoot raises when the caller made a mistake: expected, got, do this.

A fall is not an error: it is the outcome of a rollout. Inside a control cycle nothing raises.
"""

from __future__ import annotations


class SurefootError(Exception):
    """A mistake of the caller: what was expected, what came, and what to do.

    Args:
        expected: what would have been right.
        got: what came instead.
        remedy: what the caller can do about it.
    """

    def __init__(self, expected: str, got: str, remedy: str) -> None:
        self.expected, self.got, self.remedy = expected, got, remedy
        super().__init__(f"expected {expected}; got {got}; {remedy}")


class RobotError(SurefootError, ValueError):
    """A robot description is wrong: a file, a key, a type or a range."""


class VelocityError(SurefootError, ValueError):
    """A commanded velocity is not a pair of numbers or cannot be walked."""


class ParameterError(SurefootError, ValueError):
    """An argument of a controller, a problem, a push or a simulation is out of range."""


class FileError(SurefootError, OSError):
    """A file cannot be written, or what it holds cannot be read."""


class StudyError(SurefootError, RuntimeError):
    """A study cannot go on; what it has measured is kept."""


class DisplayError(SurefootError, RuntimeError):
    """This machine cannot draw in three dimensions."""

    def __init__(self, cause: Exception) -> None:
        super().__init__(
            "OpenGL that draws without a screen",
            f"{type(cause).__name__}: {cause}",
            "install Mesa (Debian: apt install libegl1 libgl1-mesa-dri) and set MUJOCO_GL=egl, "
            "or leave the picture out",
        )


class MissingExtraError(SurefootError, ImportError):
    """An optional part of Surefoot is not installed."""

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(
            f"the extra '{extra}' for {purpose}",
            "an installation without it",
            f'run: pip install "surefoot[{extra}]"',
        )
