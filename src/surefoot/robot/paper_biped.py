"""The paper's hydraulic biped as a MuJoCo model, made of the masses of its Table 1.

Table 1 gives masses, the total height of 1.67 m and five degrees of freedom a leg: hip yaw, roll
and pitch, knee and ankle pitch. The rest is chosen: links of 0.43 m, and a trunk whose centre of
mass lies where the CoM of the standing robot is at the 0.8 m of Table 2. The ankle rolls about a
passive hinge, since a flat sole without one would keep the pelvis from moving sideways.

Limits, from the hydraulics of Table 1: a cylinder of 25 mm bore (491 mm^2) at 21 MPa pushes with
10.3 kN, on a lever of 29 to 34 mm with 300 to 350 N m; the annulus around a rod of 14 mm pulls with
two thirds of it, which a linkage with two levers evens out. At 12 rad/s such a joint takes 0.2 l/s,
an eighth of the 1.5 l/s of a pump of 15 kW at 10 MPa, so seven joints may move at their limit.
"""

from __future__ import annotations

from typing import NamedTuple

LINK = 0.43
"""Length of thigh and shank [m]."""

ANKLE = 0.08
"""Height of the ankle over the sole [m]."""

ROLL = 0.02
"""Height of the hinge about which the sole rolls [m]: a low one adds little to the pendulum."""

HEIGHT = 1.67
"""Of the standing robot, Table 1 [m]."""


class _Joint(NamedTuple):
    name: str
    axis: str
    low: float
    high: float


_HIP = (
    _Joint("hip_yaw", "0 0 1", -0.8, 0.8),
    _Joint("hip_roll", "1 0 0", -0.8, 0.8),
    _Joint("hip_pitch", "0 1 0", -2.0, 1.2),
)
_KNEE = _Joint("knee", "0 1 0", 0.0, 2.4)
_ANKLE_PITCH = _Joint("ankle_pitch", "0 1 0", -1.3, 0.9)


def _joint(side: str, joint: _Joint) -> str:
    return (
        f'<joint name="{side}_{joint.name}" axis="{joint.axis}" range="{joint.low} {joint.high}" '
        'armature="0.02" damping="0.5"/>'
    )


def _leg(side: str, y: float, length: float, width: float) -> str:
    hip = "".join(_joint(side, joint) for joint in _HIP)
    return f"""
    <body name="{side}_thigh" pos="0 {y} 0">
      {hip}
      <inertial pos="0 0 -0.19" mass="12.5" diaginertia="0.19 0.19 0.045"/>
      <geom class="look" type="sphere" size="0.075" rgba="0.25 0.27 0.3 1"/>
      <geom class="look" type="capsule" fromto="0 0 -0.03 0 0 -{LINK - 0.04}" size="0.062"/>
      <body name="{side}_shank" pos="0 0 -{LINK}">
        {_joint(side, _KNEE)}
        <inertial pos="0 0 -0.19" mass="5.5" diaginertia="0.08 0.08 0.012"/>
        <geom class="look" type="cylinder" euler="1.5708 0 0" size="0.055 0.05"
          rgba="0.25 0.27 0.3 1"/>
        <geom class="look" type="capsule" fromto="0 0 -0.03 0 0 -{LINK - 0.04}" size="0.045"/>
        <body name="{side}_ankle" pos="0 0 -{LINK}">
          {_joint(side, _ANKLE_PITCH)}
          <inertial pos="0 0 -0.03" mass="0.7" diaginertia="0.0012 0.0015 0.0012"/>
          <geom class="look" type="sphere" size="0.04" rgba="0.25 0.27 0.3 1"/>
          <geom class="look" type="box" pos="0 0 -0.035" size="0.035 0.02 0.025"
            rgba="0.25 0.27 0.3 1"/>
          <body name="{side}_foot" pos="0 0 {ROLL - ANKLE:.3f}">
            <joint name="{side}_ankle_roll" axis="1 0 0" range="-0.6 0.6" armature="0.005"
              stiffness="10" damping="0.6"/>
            <inertial pos="0 0 -0.005" mass="0.8" diaginertia="0.0009 0.0028 0.0035"/>
            <geom class="look" type="box" pos="0 0 -0.006" size="{length / 2} {width / 2} 0.014"
              rgba="0.86 0.45 0.2 1"/>
          </body>
        </body>
      </body>
    </body>"""


def paper_biped_mjcf(hip: float, foot: tuple[float, float], trunk_centre: float = 0.282) -> str:
    """The model as MJCF text.

    Args:
        hip: lateral distance of the hips [m].
        foot: length and width of the sole [m].
        trunk_centre: height of the trunk's centre of mass over the hips [m].
    """
    legs = "".join(_leg(side, y, *foot) for side, y in (("left", hip / 2), ("right", -hip / 2)))
    # Knees bent by 0.8 rad in standing; the head fills what is left of the height.
    hips = ANKLE + 2.0 * LINK * 0.921
    top = HEIGHT - hips
    return f"""<mujoco model="paper-biped">
  <compiler angle="radian"/>
  <default>
    <default class="look">
      <geom contype="0" conaffinity="0" group="1" mass="0" rgba="0.72 0.74 0.78 1"/>
    </default>
  </default>
  <worldbody>
    <body name="trunk" pos="0 0 {hips:.4f}">
      <freejoint name="base"/>
      <inertial pos="0 0 {trunk_centre}" mass="29" diaginertia="2.25 1.76 0.92"/>
      <geom class="look" type="box" pos="0 0 0.03" size="0.09 {hip / 2 + 0.02} 0.06"
        rgba="0.25 0.27 0.3 1"/>
      <geom class="look" type="box" pos="0 0 0.34" size="0.11 0.2 0.23"/>
      <geom class="look" type="box" pos="0.115 0 0.4" size="0.01 0.12 0.1" rgba="0.86 0.45 0.2 1"/>
      <geom class="look" type="capsule" fromto="0 -0.24 0.5 0 0.24 0.5" size="0.03"
        rgba="0.25 0.27 0.3 1"/>
      <geom class="look" type="box" pos="0.02 0 {top - 0.1}" size="0.09 0.075 0.1"/>
      <geom class="look" type="box" pos="0.105 0 {top - 0.09}" size="0.01 0.06 0.03"
        rgba="0.1 0.12 0.14 1"/>
      {legs}
    </body>
  </worldbody>
</mujoco>
"""
