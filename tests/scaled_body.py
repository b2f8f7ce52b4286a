"""The paper's biped in another size: lengths times lambda, times its root, masses times mu.

What is alike walks alike (dynamic similarity): torques and springs times mu lambda, dampers times
mu lambda^1.5, inertias times mu lambda^2, speeds times the root of lambda, angles as they are.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec

import surefoot as sf
from scales import Scale
from surefoot.robot.paper_biped import paper_biped_mjcf


def scaled_mjcf(text: str, size: Scale) -> str:
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


def scaled_biped(folder: Path, size: Scale, *, own_gait: bool = True) -> sf.Robot:
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
    point_mass = robot.replace(body=None)
    walking = size.robot(point_mass.replace(gait=body.gait, swing=body.swing))
    x, y, z = body.sole
    body = msgspec.structs.replace(
        body,
        model=str(model),
        sole=(size.length * x, size.length * y, size.length * z),
        leg_radius=size.length * (body.leg_radius or 0.0),
        torque={name: size.torque * value for name, value in body.torque.items()},
        speed={name: value / size.time for name, value in body.speed.items()},
        gait=walking.gait if own_gait else None,
        swing=walking.swing if own_gait else None,
    )
    return size.robot(point_mass).replace(name=model.stem, body=body)
