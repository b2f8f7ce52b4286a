"""The paper's biped in another size: lengths times lambda, times its root, masses times mu.

What is alike walks alike (dynamic similarity): torques and springs times mu lambda, dampers times
mu lambda^1.5, inertias times mu lambda^2, speeds times the root of lambda, angles as they are.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import msgspec

import surefoot as sf
from surefoot.robot.gait import GaitLimits, Swing
from surefoot.robot.paper_biped import paper_biped_mjcf
from surefoot.robot.robot import Foot


@dataclass(frozen=True)
class Size:
    """Another size: `length` is lambda, `mass` is mu."""

    length: float
    mass: float

    @property
    def time(self) -> float:
        return math.sqrt(self.length)

    @property
    def speed(self) -> float:
        return math.sqrt(self.length)

    @property
    def force(self) -> float:
        return self.mass

    @property
    def torque(self) -> float:
        return self.mass * self.length

    @property
    def inertia(self) -> float:
        return self.mass * self.length**2


def scaled_mjcf(text: str, size: Size) -> str:
    """The same mechanism in another size."""
    factors = {
        **dict.fromkeys(("pos", "size", "fromto"), size.length),
        **dict.fromkeys(("diaginertia", "armature"), size.inertia),
        "mass": size.mass,
        "stiffness": size.torque,
        "damping": size.torque * size.time,
    }
    root = ET.fromstring(text)
    for element in root.iter():
        for name in factors.keys() & element.attrib.keys():
            values = [factors[name] * float(value) for value in element.attrib[name].split()]
            element.set(name, " ".join(map(repr, values)))
    return ET.tostring(root, encoding="unicode")


def scaled_gait(gait: GaitLimits, size: Size) -> GaitLimits:
    def times(pair: tuple[float, float], factor: float) -> tuple[float, float]:
        return (factor * pair[0], factor * pair[1])

    return GaitLimits(
        step_duration=times(gait.step_duration, size.time),
        step_x=times(gait.step_x, size.length),
        step_y=times(gait.step_y, size.length),
        dcm_offset=times(gait.dcm_offset, size.length),
    )


def scaled_biped(folder: Path, size: Size, *, own_gait: bool = True) -> sf.Robot:
    """The paper's biped in another size, its model in a file of the folder.

    Args:
        folder: where the model is written.
        size: how large it is.
        own_gait: whether its file says how it steps and swings, or leaves it to Surefoot.
    """
    robot = sf.load_robot("paper-biped")
    body, foot = robot.body, robot.foot
    assert body is not None
    assert body.gait is not None
    assert body.swing is not None
    model = folder / f"biped-{size.length:g}-{size.mass:g}.xml"
    text = paper_biped_mjcf(robot.hip, (foot.length, foot.width))
    model.write_text(scaled_mjcf(text, size), "utf-8")
    swing = Swing(
        height=size.length * body.swing.height,
        landing_velocity=size.speed * body.swing.landing_velocity,
        max_speed=size.speed * body.swing.max_speed,
        max_acceleration=body.swing.max_acceleration,
    )
    x, y, z = body.sole
    body = msgspec.structs.replace(
        body,
        model=str(model),
        sole=(size.length * x, size.length * y, size.length * z),
        leg_radius=size.length * (body.leg_radius or 0.0),
        torque={name: size.torque * value for name, value in body.torque.items()},
        speed={name: value / size.time for name, value in body.speed.items()},
        gait=scaled_gait(body.gait, size) if own_gait else None,
        swing=swing if own_gait else None,
    )
    return robot.replace(
        name=model.stem,
        mass=size.mass * robot.mass,
        com_height=size.length * robot.com_height,
        hip=size.length * robot.hip,
        foot=Foot(length=size.length * foot.length, width=size.length * foot.width),
        gait=scaled_gait(robot.gait, size),
        body=body,
    )
