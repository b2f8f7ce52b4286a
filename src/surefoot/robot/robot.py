"""What a robot is to the gait: mass, height, feet and limits, read from a strict TOML file."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any, get_args

import msgspec

from surefoot.checks import closest
from surefoot.errors import RobotError
from surefoot.plugins import load, places
from surefoot.robot.body import Body
from surefoot.robot.gait import GaitLimits, Swing, check_positive

STANDARD_GRAVITY = 9.81
"""Gravitational acceleration, which a robot file may override [m/s^2]."""

PRESETS = Path(__file__).parent / "presets"
"""The files of the robots that Surefoot ships."""

GROUP = "surefoot.robots"
"""The group of entry points of robots."""


class Foot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The rectangular sole, centred under the ankle.

    Attributes:
        length: extent in x [m].
        width: extent in y [m].
    """

    length: float
    width: float

    def __post_init__(self) -> None:
        check_positive("foot", length=self.length, width=self.width)

    @property
    def half(self) -> tuple[float, float]:
        """How far the ZMP can move from the centre (x, y) [m]."""
        return (0.5 * self.length, 0.5 * self.width)


class Trunk(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The upper body as a flywheel at the hip, the same about both axes.

    Attributes:
        inertia: moment of inertia that the hip torque turns [kg m^2].
        max_torque: limit of the hip torque [N m].
        max_lean: where the trunk meets its stop, to either side [rad].
    """

    inertia: float
    max_torque: float
    max_lean: float

    def __post_init__(self) -> None:
        check_positive(
            "trunk", inertia=self.inertia, max_torque=self.max_torque, max_lean=self.max_lean
        )


class Legs(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The masses of the legs, for the three-mass pendulum; a point mass has massless legs.

    Attributes:
        mass: of one leg [kg].
        length: height of the hip over the sole in walking [m].
        com: where the CoM of a leg is, from 0 at the hip to 1 at the foot [-].
        inertia: of one leg about its CoM and a horizontal axis [kg m^2].
        heavy: whether the simulator moves these masses.
        known: whether the robot moves its ZMP by what they need, as far as the sole reaches.
    """

    mass: float
    length: float
    com: float
    inertia: float
    heavy: bool = False
    known: bool = False

    def __post_init__(self) -> None:
        check_positive("legs", mass=self.mass, length=self.length, inertia=self.inertia)
        if not 0.0 <= self.com <= 1.0:
            raise RobotError(
                "`com` of the legs between 0 (at the hip) and 1 (at the foot)",
                f"{self.com}",
                "give the fraction of the line from hip to foot",
            )


class Robot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A biped as the gait sees it.

    Attributes:
        name: what to call it.
        description: where the numbers come from.
        mass: total mass [kg].
        com_height: height of the CoM over the ground in walking [m].
        hip: lateral distance of the sole centres in straight walking [m].
        foot: sole rectangle.
        gait: limits of a step.
        swing: motion of the foot in the air.
        trunk: the flywheel of methods that use the hips; None for a trunk that stays upright.
        legs: masses of the legs for the three-mass pendulum; None for massless ones.
        body: its mechanism for the physics simulator; None if it is only ever a point mass.
        gravity: gravitational acceleration [m/s^2].

    Raises:
        RobotError: a quantity that must be positive is not.
    """

    name: str
    mass: float
    com_height: float
    hip: float
    foot: Foot
    gait: GaitLimits
    swing: Swing = Swing()
    trunk: Trunk | None = None
    legs: Legs | None = None
    body: Body | None = None
    gravity: float = STANDARD_GRAVITY
    description: str = ""

    def __post_init__(self) -> None:
        check_positive(
            "robot",
            mass=self.mass,
            com_height=self.com_height,
            hip=self.hip,
            gravity=self.gravity,
        )

    @property
    def omega(self) -> float:
        """Natural frequency of the pendulum [1/s]."""
        return math.sqrt(self.gravity / self.com_height)

    def with_leg(
        self, *, max_speed: float | None = None, max_acceleration: float | None = None
    ) -> Robot:
        """A copy with another leg; a limit that is None stays as it is.

        Args:
            max_speed: of the swing foot, each axis by itself, may be inf [m/s].
            max_acceleration: likewise [m/s^2].

        Raises:
            RobotError: a limit is not positive.
        """
        limits = {"max_speed": max_speed, "max_acceleration": max_acceleration}
        changes = {name: value for name, value in limits.items() if value is not None}
        return self.replace(swing=msgspec.structs.replace(self.swing, **changes))

    def with_heavy_legs(self, *, known: bool = False) -> Robot:
        """A copy that the point-mass simulator moves as a three-mass pendulum: see
        `dcm.three_mass`.

        Args:
            known: whether the robot moves its ZMP by what the legs need.

        Raises:
            RobotError: the robot has no `[legs]`, or they leave no trunk.
        """
        if self.legs is None:
            raise RobotError(
                "a robot with a [legs] table for the three-mass pendulum",
                f"robot '{self.name}' without one",
                "give mass, length, com and inertia of one leg: `surefoot robots --show "
                "paper-biped` has an example",
            )
        _check_trunk_over_legs(self.mass, self.com_height, self.legs)
        return self.replace(legs=msgspec.structs.replace(self.legs, heavy=True, known=known))

    def scaled(self, *, length: float = 1.0, mass: float = 1.0) -> Robot:
        """The same robot in another size, under the same gravity.

        Its lengths are times lambda, its times times sqrt(lambda), its masses times mu; so speeds
        are times sqrt(lambda), accelerations as they were, forces times mu, impulses times
        mu sqrt(lambda), torques times mu lambda, angles as they were. By the law of dynamic
        similarity [Froude] it walks alike: with velocities, pushes and control period scaled
        likewise, every controller takes the same steps, scaled, and survives the same share.

        Args:
            length: lambda, positive.
            mass: mu, positive.

        Raises:
            RobotError: a factor is not positive, or the robot has a body, whose model is a file of
                its own: leave that out with `robot.replace(body=None)`.
        """
        check_positive("scale", length=length, mass=mass)
        if self.body is not None:
            raise RobotError(
                "a robot without a body to scale, whose model is a file of its own",
                f"robot '{self.name}' with the body of {self.body.model}",
                "scale its point mass: robot.replace(body=None).scaled(...)",
            )
        time = math.sqrt(length)
        gait, swing, trunk, legs = self.gait, self.swing, self.trunk, self.legs
        return self.replace(
            mass=mass * self.mass,
            com_height=length * self.com_height,
            hip=length * self.hip,
            foot=Foot(length=length * self.foot.length, width=length * self.foot.width),
            gait=GaitLimits(
                step_duration=_times(time, gait.step_duration),
                step_x=_times(length, gait.step_x),
                step_y=_times(length, gait.step_y),
                dcm_offset=_times(length, gait.dcm_offset),
            ),
            swing=Swing(
                height=length * swing.height,
                landing_velocity=time * swing.landing_velocity,
                max_speed=time * swing.max_speed,
                max_acceleration=swing.max_acceleration,
            ),
            trunk=None
            if trunk is None
            else Trunk(
                inertia=mass * length**2 * trunk.inertia,
                max_torque=mass * length * trunk.max_torque,
                max_lean=trunk.max_lean,
            ),
            legs=None
            if legs is None
            else msgspec.structs.replace(
                legs,
                mass=mass * legs.mass,
                length=length * legs.length,
                inertia=mass * length**2 * legs.inertia,
            ),
        )

    def replace(self, **changes: Any) -> Robot:
        """A copy with some attributes changed, checked like a file: `robot.replace(mass=70.0)`.

        Raises:
            RobotError: an unknown attribute, or a value out of range.
        """
        unknown = sorted(set(changes) - set(self.__struct_fields__))
        if unknown:
            raise RobotError(
                f"attributes of Robot ({', '.join(self.__struct_fields__)})",
                ", ".join(unknown),
                "replace nested values as a whole: robot.replace(swing=Swing(max_speed=3.0))",
            )
        return msgspec.structs.replace(self, **changes)


def _check_trunk_over_legs(mass: float, com_height: float, legs: Legs) -> None:
    """Refuse legs that leave no trunk, or one whose CoM is not over that of the legs.

    Raises:
        RobotError: they do.
    """
    trunk = mass - 2.0 * legs.mass
    leg_height = (1.0 - legs.com) * legs.length
    if trunk <= 0.0 or leg_height >= com_height:
        raise RobotError(
            "two legs that are lighter than the robot, with their CoM under that of the robot",
            f"a trunk of {trunk:g} kg, legs with a CoM at {leg_height:g} m, the robot's at "
            f"{com_height:g} m",
            "give the mass of ONE leg, and `com` from the hip down",
        )


def _times(factor: float, pair: tuple[float, float]) -> tuple[float, float]:
    return factor * pair[0], factor * pair[1]


def preset_names() -> list[str]:
    """The robots that Surefoot ships and those that other packages bring, sorted by name.

    A package brings one as an entry point of `surefoot.robots`: the path of its TOML file.
    """
    return sorted({*_shipped(), *places(GROUP)})


def _shipped() -> dict[str, Path]:
    return {path.stem: path for path in PRESETS.glob("*.toml")}


def load_robot(name_or_path: str | Path) -> Robot:
    """Load a robot by the name of a preset or from a TOML file.

    Args:
        name_or_path: a preset such as "paper-biped", see `preset_names`, or a path that ends in
            .toml.

    Returns:
        The robot, every value checked.

    Raises:
        RobotError: no such preset or file, not TOML, an unknown key, a wrong type or a bad range;
            the message names the file and the key.
    """
    if str(name_or_path).endswith(".toml"):
        return _read_robot(Path(name_or_path), str(name_or_path))
    return _read_robot(_preset_file(str(name_or_path)), str(name_or_path))


def preset_text(name: str) -> str:
    """The TOML file of a preset, to start one's own from.

    Raises:
        RobotError: there is no such preset, or more than one.
    """
    return _read_text(_preset_file(name))


def _preset_file(name: str) -> Path:
    shipped, brought = _shipped().get(name), places(GROUP).get(name)
    if shipped is None and brought is None:
        raise RobotError(
            f"a preset ({', '.join(preset_names())}) or a path ending in .toml",
            repr(name),
            "run `surefoot robots` to see the presets",
        )
    if shipped is not None and brought is not None:
        raise RobotError(
            f"one robot of the name {name!r}",
            f"{shipped} and the entry point {brought}",
            "uninstall the package, or name the robot by the path of its file",
        )
    return shipped or Path(load(brought or ""))


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RobotError(
            "a readable robot file", f"{path}: {error}", "check the path and its permissions"
        ) from error


def _read_robot(path: Path, origin: str) -> Robot:
    robot = parse_robot(_read_text(path), origin)
    # A rollout carries its robot elsewhere, so the model's place must not depend on where one is.
    return robot if robot.body is None else robot.replace(body=robot.body.beside(path.parent))


def parse_robot(text: str, origin: str) -> Robot:
    """A robot from TOML text.

    Args:
        text: the TOML document.
        origin: what to call the document in messages.

    Raises:
        RobotError: see `load_robot`.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise RobotError(
            "a TOML document", f"{origin}: {error}", "correct the line that is named"
        ) from error
    _reject_unknown_keys(table, Robot, origin, "")
    try:
        return msgspec.convert(table, Robot)
    except msgspec.ValidationError as error:
        if isinstance(error.__cause__, RobotError):
            cause = error.__cause__
            raise RobotError(cause.expected, f"{cause.got} in {origin}", cause.remedy) from error
        raise RobotError(
            "every key of a robot with its type",
            f"{origin}: {error}",
            "compare with a preset: `surefoot robots --show paper-biped`",
        ) from error


def _reject_unknown_keys(table: dict[str, Any], struct: type, origin: str, path: str) -> None:
    fields = {field.name: field.type for field in msgspec.structs.fields(struct)}
    for key, value in table.items():
        where = f"{path}{key}"
        if key not in fields:
            raise RobotError(
                f"one of the keys {', '.join(path + name for name in fields)}",
                f"unknown key `{where}` in {origin}",
                closest(where, [path + name for name in fields], "remove it"),
            )
        for nested in get_args(fields[key]) or (fields[key],):
            if (
                isinstance(value, dict)
                and isinstance(nested, type)
                and issubclass(nested, msgspec.Struct)
            ):
                _reject_unknown_keys(value, nested, origin, f"{where}.")
