"""What may be wrong with a body's sensors, with the body and with its floor, by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from surefoot.errors import ParameterError
from surefoot.worlds.body.plant import Surroundings
from surefoot.worlds.body.sensors import BodyNoise

USUAL = "usual-noise"
"""The key of the condition in which nothing is wrong but what is wrong with every sensor."""

SILENT = {
    "encoder": 0.0,
    "rate": 0.0,
    "gyro": 0.0,
    "accelerometer": 0.0,
    "gyro_bias": 0.0,
    "force": 0.0,
}
"""Parameters of a `BodyNoise` that is none."""

_NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class BodyCondition:
    """What is wrong in a walk of a body.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        senses: parameters of `BodyNoise`; the others are usual.
        world: parameters of `Surroundings`; the others are usual.
    """

    key: str
    label: str
    senses: Mapping[str, float] = field(default_factory=lambda: _NOTHING)
    world: Mapping[str, float] = field(default_factory=lambda: _NOTHING)

    def noise(self, seed: int) -> BodyNoise:
        """What the sensors do."""
        return BodyNoise(**self.senses, seed=seed)

    def surroundings(self, seed: int) -> Surroundings:
        """What it stands on and carries."""
        return Surroundings(**self.world, seed=seed)


def _only(**senses: float) -> Mapping[str, float]:
    return SILENT | senses


_USUAL = BodyNoise()
_DELAY, _HEAVY, _LOAD = {"delay": 0.005}, {"mass_factor": 1.1}, {"payload": 10.0}
_SMOOTH, _BUMPS = {"friction": 0.4}, {"bumps": 0.01}

BODY_CONDITIONS = (
    BodyCondition(USUAL, "usual noise of all sensors"),
    BodyCondition("joint-noise", "joint angles 1 mrad only", _only(encoder=_USUAL.encoder)),
    BodyCondition("velocity-noise", "joint velocities 0.1 rad/s only", _only(rate=_USUAL.rate)),
    BodyCondition(
        "imu-noise",
        "inertial unit only",
        _only(gyro=_USUAL.gyro, gyro_bias=_USUAL.gyro_bias, accelerometer=_USUAL.accelerometer),
    ),
    BodyCondition("force-noise", "forces on the soles 5 N", {"force": 5.0}),
    BodyCondition("delay-5ms", "delay 5 ms", _DELAY),
    BodyCondition("mass+10%", "mass 10 % more", world=_HEAVY),
    BodyCondition("mass-10%", "mass 10 % less", world={"mass_factor": 0.9}),
    BodyCondition("payload-10kg", "payload 10 kg", world=_LOAD),
    BodyCondition("friction-0.4", "friction 0.4", world=_SMOOTH),
    BodyCondition("friction-0.6", "friction 0.6", world={"friction": 0.6}),
    BodyCondition("friction-1.0", "friction 1.0", world={"friction": 1.0}),
    BodyCondition("bumps-10mm", "bumps of 10 mm", world=_BUMPS),
    BodyCondition(
        "all-at-once",
        "all at once",
        _DELAY,
        _HEAVY | _LOAD | _SMOOTH | _BUMPS,
    ),
)
"""In the order in which they are shown; all but the single ones on top of the usual noise."""


def body_condition(key: str) -> BodyCondition:
    """A condition by its name on the command line.

    Raises:
        ParameterError: there is none of that name.
    """
    for one in BODY_CONDITIONS:
        if one.key == key:
            return one
    names = ", ".join(one.key for one in BODY_CONDITIONS)
    raise ParameterError(f"a disturbance of a body ({names})", repr(key), "choose one of these")
