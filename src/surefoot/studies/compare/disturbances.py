"""The disturbances of the noise-and-delay budget, by name, and what helps against some of them.

They are those of sensors, buses and floors, so they are absolute: a small robot meets the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from surefoot.control.estimator import Estimator
from surefoot.interface import Controller
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.studies.engine.pushed_walk import find_named

UNDISTURBED = "none"
"""The key of the walk that the others are compared with."""

OFFSET = 0.02
"""By which CoM and DCM are measured beside their place [m]."""


@dataclass(frozen=True)
class NamedDisturbance:
    """One way to disturb a walk, by its name.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        disturbance: of what is measured and of landings.
        drawn: whether it depends on a seed, so that it is walked with several.
        offsets: of CoM and DCM; each is a walk of its own, since it is not known which it is [m].
        height: of the CoM, as a fraction of what the controller is given.
        mass: likewise.
        estimator: parameters of the `Estimator` that helps; none if empty.
    """

    key: str
    label: str
    disturbance: Disturbance = field(default_factory=Disturbance)
    drawn: bool = False
    offsets: tuple[tuple[float, float], ...] = ()
    height: float = 1.0
    mass: float = 1.0
    estimator: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def plant(self, robot: Robot) -> Robot:
        """The robot that is really pushed."""
        if self.height == self.mass == 1.0:
            return robot
        return robot.replace(com_height=self.height * robot.com_height, mass=self.mass * robot.mass)

    def walks(self, seeds: int) -> tuple[Disturbance, ...]:
        """Every walk with this disturbance; the worst of them counts."""
        one = self.disturbance
        if self.offsets:
            return tuple(replace(one, com_offset=offset) for offset in self.offsets)
        return tuple(replace(one, seed=seed) for seed in range(seeds if self.drawn else 1))

    def estimator_of(self, controller: Controller) -> Estimator | None:
        """What helps this controller, if anything does."""
        if not self.estimator:
            return None
        return Estimator(controller.robot, period=controller.period, **self.estimator)


def _helped(
    one: NamedDisturbance, suffix: str, words: str, **parameters: float
) -> NamedDisturbance:
    return replace(
        one,
        key=f"{one.key}+{suffix}",
        label=f"{one.label}, {words}",
        estimator=MappingProxyType(parameters),
    )


_NOISE = NamedDisturbance(
    "dcm-noise-5mm", "DCM noise 5 mm", Disturbance(dcm_noise=0.005), drawn=True
)  # fmt: skip
_VELOCITY = NamedDisturbance(
    "velocity-noise", "velocity noise 0.03 m/s", Disturbance(velocity_noise=0.03), drawn=True
)
_DELAY = NamedDisturbance("delay-20ms", "delay 20 ms", Disturbance(delay=0.02))
_BESIDE = NamedDisturbance(
    "com-offset",
    "CoM offset 2 cm",
    offsets=((OFFSET, 0.0), (-OFFSET, 0.0), (0.0, OFFSET), (0.0, -OFFSET)),
)

DISTURBANCES = (
    NamedDisturbance(UNDISTURBED, "undisturbed"),
    NamedDisturbance("dcm-noise-1mm", "DCM noise 1 mm", Disturbance(dcm_noise=0.001), drawn=True),
    _NOISE,
    _helped(_NOISE, "filter", "filtered", filter_time=0.01),
    _VELOCITY,
    _helped(_VELOCITY, "filter", "filtered", filter_time=0.01),
    NamedDisturbance("delay-5ms", "delay 5 ms", Disturbance(delay=0.005)),
    NamedDisturbance("delay-10ms", "delay 10 ms", Disturbance(delay=0.01)),
    _DELAY,
    _helped(_DELAY, "prediction", "predicted", delay=0.02),
    NamedDisturbance("height+10%", "CoM 10 % higher", height=1.1),
    NamedDisturbance("height-10%", "CoM 10 % lower", height=0.9),
    NamedDisturbance("mass+10%", "mass 10 % more", mass=1.1),
    NamedDisturbance("mass-10%", "mass 10 % less", mass=0.9),
    _BESIDE,
    _helped(_BESIDE, "estimate", "estimated", bias_time=0.3),
    NamedDisturbance(
        "landing-error", "landing error 1 cm", Disturbance(landing_error=0.01), drawn=True
    ),
    NamedDisturbance(
        "early-touchdown", "touchdown 30 ms early", Disturbance(touchdown_shift=-0.03)
    ),
    NamedDisturbance("late-touchdown", "touchdown 30 ms late", Disturbance(touchdown_shift=0.03)),
)
"""In the order in which they are shown; what helps follows what it helps against."""


def named_disturbance(key: str) -> NamedDisturbance:
    """A disturbance by its name on the command line.

    Raises:
        ParameterError: there is none of that name.
    """
    return find_named("a disturbance", DISTURBANCES, key)


def every_disturbance() -> tuple[str, ...]:
    """The keys of all disturbances."""
    return tuple(one.key for one in DISTURBANCES)
