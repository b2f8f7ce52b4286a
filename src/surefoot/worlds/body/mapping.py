"""What turns a reference into motor commands, by name.

A mapping is a class that is made from a `Multibody`, see `worlds.body.interface.JointMapping`, and
an entry point of the group `surefoot.mappings`, in this package or in any other. `module:Class`
names any class at all. Nothing is imported before it is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from surefoot.errors import ParameterError
from surefoot.plugins import load, places

if TYPE_CHECKING:
    from surefoot.robot.multibody import Multibody
    from surefoot.worlds.body.interface import JointMapping

GROUP = "surefoot.mappings"
"""The group of entry points."""

USUAL_MAPPING = "inverse-dynamics"
"""Of a body whose motors are given torques."""


def mapping_names() -> tuple[str, ...]:
    """The names of those that are installed, the usual one first."""
    return tuple(sorted(places(GROUP), key=lambda name: (name != USUAL_MAPPING, name)))


def check_mapping(name: str) -> None:
    """Refuse a name that is none, without an import.

    Raises:
        ParameterError: there is none of that name.
    """
    if ":" not in name and name not in places(GROUP):
        raise ParameterError(
            f"a mapping ({', '.join(mapping_names())}), or module:Class",
            repr(name),
            "choose one of these",
        )


def joint_mapping(name: str, multibody: Multibody) -> JointMapping:
    """The mapping of that name for a mechanism.

    Args:
        name: one of `mapping_names`, or `module:Class`.
        multibody: the mechanism.

    Raises:
        SurefootError: there is no such mapping, an extra is not installed, or its class refuses
            the mechanism.
    """
    check_mapping(name)
    return load(places(GROUP).get(name, name))(multibody)
