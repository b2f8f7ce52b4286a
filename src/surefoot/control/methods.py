"""Every control method by name: what it adapts, where it is from, and what it cannot use."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from surefoot.control.capture_point import CapturePointStepping
from surefoot.control.dcm_tracking import DcmTracking
from surefoot.control.defaults import DCM_GAIN
from surefoot.control.hybrid import HybridController
from surefoot.control.mpc.ankle_hip import AnkleHipStepMpc
from surefoot.control.mpc.linear import LinearMpc
from surefoot.control.mpc.placement import FootPlacementMpc
from surefoot.control.preview_control import PreviewControl
from surefoot.control.step_timing import StepTiming
from surefoot.control.timing_nlp import TimingNlp
from surefoot.control.unified.controller import UnifiedController
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.robot import Robot


@dataclass(frozen=True)
class Method:
    """One way to keep a robot on its feet.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        make: its class.
        source: who published it.
        adapts: what it changes when it is pushed.
        cannot: what it cannot use of what every method may use.
        fixed_steps: whether it always steps as planned, so that the speed of the leg is no matter.
        leans: whether it turns the trunk as a flywheel, which a body in physics has none of.
        slow: whether one decision takes milliseconds, so that it is compared only if asked for.
        parameters: that make this variant of the class.
        rates: likewise, as multiples of the robot's omega.
        compared: what it is given beside these where methods are compared, each at its best.
    """

    key: str
    label: str
    make: type[Any]
    source: str
    adapts: str
    cannot: str
    fixed_steps: bool = False
    leans: bool = False
    slow: bool = False
    parameters: MappingProxyType[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    rates: MappingProxyType[str, float] = field(default_factory=lambda: MappingProxyType({}))
    compared: MappingProxyType[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def controller(
        self, robot: Robot, velocity: tuple[float, float], **parameters: Any
    ) -> Controller:
        """The controller of this method for a robot and a velocity [m/s].

        Raises:
            SurefootError: its class refuses the arguments.
        """
        given = {**self.parameters, **parameters}
        for name, times in self.rates.items():
            if given.get(name) is None:
                given[name] = times * robot.omega
        return self.make(robot, velocity, **given)


METHODS = (
    Method(
        "tracking",
        "DCM tracking, K_f = 3",
        DcmTracking,
        "Englsberger, Ott, Albu-Schäffer 2015",
        "ZMP",
        "steps as planned: neither where nor when it steps answers a push",
        fixed_steps=True,
    ),
    Method(
        "tracking-stiff",
        "DCM tracking, K_f = 30",
        DcmTracking,
        "Englsberger, Ott, Albu-Schäffer 2015; ten times the paper's gain",
        "ZMP",
        "steps as planned: neither where nor when it steps answers a push",
        fixed_steps=True,
        rates=MappingProxyType({"dcm_gain": 10.0 * DCM_GAIN}),
    ),
    Method(
        "preview-control",
        "preview control",
        PreviewControl,
        "Kajita et al. 2003",
        "ZMP",
        "steps as planned: neither where nor when it steps answers a push",
        fixed_steps=True,
    ),
    Method(
        "linear-mpc",
        "linear MPC, fixed steps",
        LinearMpc,
        "Wieber 2006; solved every 5 ms",
        "ZMP",
        "steps as planned: neither where nor when it steps answers a push",
        fixed_steps=True,
    ),
    Method(
        "capture-point",
        "capture-point stepping",
        CapturePointStepping,
        "Pratt et al. 2006; Koolen et al. 2012",
        "ZMP, step location",
        "steps at fixed times; clips a landing to the step box only, and the leg may come short",
    ),
    Method(
        "foot-placement-mpc",
        "MPC with foot placement",
        FootPlacementMpc,
        "Diedam et al. 2008; Herdt et al. 2010; solved every 5 ms",
        "ZMP, step location",
        "steps at fixed times",
    ),
    Method(
        "foot-placement-mpc-100ms",
        "MPC with foot placement, 100 ms",
        FootPlacementMpc,
        "Herdt et al. 2010; solved every 100 ms, as published",
        "ZMP, step location",
        "steps at fixed times, and learns of a push up to 100 ms late",
        parameters=MappingProxyType({"solve_period": math.inf}),
    ),
    Method(
        "ankle-hip-step-mpc",
        "MPC with ankle, hip and step",
        AnkleHipStepMpc,
        "Aftab, Robert, Wieber 2012",
        "ZMP, hip torque, step location",
        "steps at fixed times; its trunk is a freedom that no other method and no limit has",
        leans=True,
    ),
    Method(
        "step-timing",
        "step location and timing",
        StepTiming,
        "Khadiv et al. 2016, 2020",
        "step location, timing",
        "leaves the ZMP at the centre of the foot; knows the leg, which as published it does not",
        compared=MappingProxyType({"knows_leg": True}),
    ),
    Method(
        "timing-nlp",
        "nonlinear step timing",
        TimingNlp,
        "after Kryczka et al. 2015",
        "ZMP, step location, timing",
        "decides every 10 ms; a local solver may not find the best landing",
        slow=True,
    ),
    Method(
        "hybrid",
        "the paper's hybrid",
        HybridController,
        "On-line gait adjustment, III-C",
        "ZMP or step location, timing",
        "holds the ZMP while it adapts the step; knows the leg, which as published it does not",
        compared=MappingProxyType({"knows_leg": True}),
    ),
    Method(
        "unified",
        "unified (ours)",
        UnifiedController,
        "Surefoot",
        "ZMP, step location, timing",
        "keeps its trunk upright",
    ),
)
"""In the order in which they are shown: from the ZMP alone to steps in place and time."""


def method(key: str) -> Method:
    """A method by its name on the command line.

    Raises:
        ParameterError: there is none of that name.
    """
    for one in METHODS:
        if one.key == key:
            return one
    names = ", ".join(one.key for one in METHODS)
    raise ParameterError(f"a method ({names})", repr(key), "choose one of these")
