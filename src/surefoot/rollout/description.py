"""What made a walk, in words that are kept with it."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


def describe(value: Any) -> str:
    """The parameters of a controller or an estimator as text, but for robot and velocity."""
    parts = []
    for parameter in fields(value):
        if parameter.init and parameter.name not in ("robot", "velocity", "multibody"):
            parts.append(f"{parameter.name}={getattr(value, parameter.name)!r}")
    return ", ".join(parts)
