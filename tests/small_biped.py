"""A small biped as a URDF, for tests of robots of one's own: 30 kg, legs of two links of 0.3 m."""

from __future__ import annotations

import struct
from pathlib import Path

URDF_TOML = """
name = "small"
mass = 30.0
com_height = 0.635
hip = 0.16

[foot]
length = 0.16
width = 0.09

[gait]
step_duration = [0.25, 0.7]
step_x = [-0.25, 0.35]
step_y = [-0.05, 0.2]
dcm_offset = [0.08, 0.04]

[swing]
max_speed = 3.0

[body]
model = "model/small.urdf"
base = "pelvis"
feet = ["left_foot", "right_foot"]
sole = [0.0, 0.0, -0.06]
ankle_roll = "actuated"
locked = ["*_arm"]

[body.posture]
"*_hip_pitch" = -0.452
"*_knee" = 0.84
"*_ankle_pitch" = -0.388
"""


def _inertial(mass: float, z: float) -> str:
    size = 0.02 * mass
    return (
        f'<inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/><inertia ixx="{size}" '
        f'iyy="{size}" izz="{size}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def _box(x: float, y: float, z: float, size: str) -> str:
    shape = f'<origin xyz="{x} {y} {z}"/><geometry><box size="{size}"/></geometry>'
    return f"<visual>{shape}</visual><collision>{shape}</collision>"


def _joint(
    name: str, parent: str, child: str, axis: str, xyz: str, limit: str = "-1.5 1.5 90 12"
) -> str:
    low, high, effort, velocity = limit.split()
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="{velocity}"/></joint>'
    )


def _side(side: str, y: float) -> str:
    links = {
        f"{side}_hip_a": _inertial(0.5, 0.0),
        f"{side}_hip_b": _inertial(0.5, 0.0),
        f"{side}_thigh": _inertial(2.5, -0.1) + _box(0, 0, -0.15, "0.06 0.06 0.28"),
        f"{side}_shank": _inertial(1.5, -0.1) + _box(0, 0, -0.15, "0.05 0.05 0.28"),
        f"{side}_ankle": _inertial(0.2, 0.0),
        f"{side}_foot": _inertial(0.8, -0.03) + _box(0, 0, -0.05, "0.16 0.09 0.02"),
        f"{side}_arm_link": _inertial(1.0, -0.2),
    }
    joints = (
        _joint(f"{side}_hip_yaw", "pelvis", f"{side}_hip_a", "0 0 1", f"0 {y} 0"),
        _joint(f"{side}_hip_roll", f"{side}_hip_a", f"{side}_hip_b", "1 0 0", "0 0 0"),
        _joint(f"{side}_hip_pitch", f"{side}_hip_b", f"{side}_thigh", "0 1 0", "0 0 0"),
        _joint(
            f"{side}_knee", f"{side}_thigh", f"{side}_shank", "0 1 0", "0 0 -0.3", "0 2.4 120 14"
        ),
        _joint(f"{side}_ankle_pitch", f"{side}_shank", f"{side}_ankle", "0 1 0", "0 0 -0.3"),
        _joint(f"{side}_ankle_roll", f"{side}_ankle", f"{side}_foot", "1 0 0", "0 0 0"),
        _joint(f"{side}_arm", "pelvis", f"{side}_arm_link", "0 1 0", f"0 {2.2 * y} 0.35"),
    )
    return "".join(f'<link name="{name}">{text}</link>' for name, text in links.items()) + "".join(
        joints
    )


def small_urdf() -> str:
    """The document; its pelvis has a mesh of a package, and one that MuJoCo cannot read.

    A camera weighs nothing, although it has a shape.
    """
    meshes = "".join(
        f'<visual><geometry><mesh filename="package://small_description/meshes/{name}"/>'
        "</geometry></visual>"
        for name in ("pelvis.stl", "pelvis.dae")
    )
    pelvis = f'<link name="pelvis">{_inertial(16.0, 0.2)}{meshes}</link>'
    pelvis += """<link name="camera"><collision><geometry><box size="0.1 0.1 0.1"/></geometry>
      </collision></link><joint name="camera" type="fixed"><parent link="pelvis"/>
      <child link="camera"/></joint>"""
    return f'<robot name="small">{pelvis}{_side("left", 0.08)}{_side("right", -0.08)}</robot>'


def tetrahedron(edge: float = 0.1) -> bytes:
    """A mesh in binary STL."""
    corners = [(0.0, 0.0, 0.0), (edge, 0.0, 0.0), (0.0, edge, 0.0), (0.0, 0.0, edge)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in corners[corner]), 0)
        for face in faces
    )
    return bytes(80) + struct.pack("<I", len(faces)) + body


def write_small_biped(folder: Path, name: str = "small_description") -> Path:
    """Write TOML, URDF and mesh into a folder as a robot's package has them; where the TOML is."""
    package = folder / name
    for part in ("model", "meshes"):
        (package / part).mkdir(parents=True)
    (package / "model" / "small.urdf").write_text(small_urdf())
    (package / "meshes" / "pelvis.stl").write_bytes(tetrahedron())
    (package / "meshes" / "pelvis.dae").write_text("<COLLADA/>")
    path = package / "small.toml"
    path.write_text(URDF_TOML)
    return path
