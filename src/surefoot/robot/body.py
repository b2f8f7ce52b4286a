"""What a robot is to physics: which model, where its feet are, how it stands, what its joints do.

The `[body]` table of a robot's TOML file. It is only read here; `robot.multibody` makes a
mechanism of it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import msgspec

from surefoot.errors import RobotError
from surefoot.robot.gait import GaitLimits, Swing

GENERATED_MODELS = ("paper-biped",)
"""Models that Surefoot makes rather than reads."""

MODEL_SUFFIXES = (".xml", ".urdf")
"""Of the model files that can be read."""


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The mechanism of a robot, as far as its model does not say.

    Attributes:
        model: "paper-biped", which Surefoot generates, or a file (.xml, .urdf). Its path starts
            from the robot's own file, or from where `package` is installed.
        package: the distribution, as pip knows it, that brings the model; empty if none does.
        base: outermost body of the model, the pelvis or trunk; it carries the free joint.
        trunk: body that pushes and payloads act on; the base, which is near the CoM, if empty.
        feet: left and right body whose undersides are the soles.
        sole: centre of the sole in the frame of the foot's body, left foot; the right foot's is
            mirrored in y [m].
        ankle_roll: whether the ankle can push sideways. A "passive" one is a hinge with a weak
            spring: a flat sole without any would keep the pelvis from moving sideways.
        locked: joints that are held rigid, as patterns such as ``"*_elbow"``; they weigh but do not
            move.
        leg_radius: of the capsules along thigh and shank that must not touch each other; a
            sixteenth of the CoM's height if None [m].
        posture: angle of joints in the nominal pose, 0 if not named; locked ones stay there [rad].
        torque: limit of joints by pattern, where the model has none or another [N m].
        speed: likewise of their velocity [rad/s].
        armature: inertia of a motor's rotor as its joint feels it, likewise [kg m^2].
        step_width: between the soles across, walking straight on; the `hip` of the robot if None.
            Wider than the hips leaves room to step inward before the legs meet [m].
        gait: limits of a step of the body, `step_y` from that width; None for what
            `worlds.body.gait` makes of the robot's.
        swing: likewise how its feet swing.
    """

    model: str
    base: str
    feet: tuple[str, str]
    sole: tuple[float, float, float]
    ankle_roll: Literal["passive", "actuated"]
    package: str = ""
    trunk: str = ""
    locked: tuple[str, ...] = ()
    leg_radius: float | None = None
    posture: dict[str, float] = {}
    torque: dict[str, float] = {}
    speed: dict[str, float] = {}
    armature: dict[str, float] = {}
    step_width: float | None = None
    gait: GaitLimits | None = None
    swing: Swing | None = None

    @property
    def is_generated(self) -> bool:
        """Whether Surefoot makes the model itself."""
        return self.model in GENERATED_MODELS

    def beside(self, folder: Path) -> Body:
        """The same body, read from a file in this folder: its model's path becomes absolute."""
        if self.is_generated or self.package:
            return self
        return msgspec.structs.replace(self, model=str((folder / self.model).resolve()))

    def __hash__(self) -> int:
        # What is derived from a robot is cached by robot; tables of joints are dictionaries.
        return hash(msgspec.json.encode(self))

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) for value in self.sole):
            raise RobotError(
                "`sole` of the body as [x, y, z], finite [m]",
                f"{list(self.sole)}",
                "measure the centre of the underside in the frame of the left foot",
            )
        if self.leg_radius is not None and not (0.0 < self.leg_radius < math.inf):
            raise RobotError(
                "`leg_radius` of the body to be positive [m]",
                f"{self.leg_radius}",
                "half the width of the shank",
            )
        if self.step_width is not None and not (0.0 < self.step_width < math.inf):
            raise RobotError(
                "`step_width` of the body to be positive and finite [m]",
                f"{self.step_width}",
                "leave it out for the robot's `hip`",
            )
        if not self.is_generated and not self.model.lower().endswith(MODEL_SUFFIXES):
            raise RobotError(
                f"`model` of the body to be one of {', '.join(GENERATED_MODELS)}, or a file "
                f"({', '.join(MODEL_SUFFIXES)})",
                repr(self.model),
                "name an MJCF or a URDF",
            )
        for name, unit in (("torque", "N m"), ("speed", "rad/s"), ("armature", "kg m^2")):
            for joint, limit in getattr(self, name).items():
                if not limit > 0.0:
                    raise RobotError(
                        f"`{name}` of `{joint}` to be positive [{unit}]",
                        f"{limit}",
                        "give it as the data sheet of the drive does",
                    )
        for joint, angle in self.posture.items():
            if not math.isfinite(angle):
                raise RobotError(
                    f"`posture` of `{joint}` to be finite [rad]", f"{angle}", "give an angle"
                )
