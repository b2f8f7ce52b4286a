"""Whether a robot's file and its model agree, and whether it can stand and walk as commanded.

Nothing is imported of physics here, so that a finding can also say that there is none.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.errors import SurefootError
from surefoot.robot.robot import Robot

if TYPE_CHECKING:
    from surefoot.robot.legs import NominalPose
    from surefoot.robot.multibody import Multibody


OK, WARNING, PROBLEM = "ok", "warning", "problem"
"""What a check can find; a problem keeps the robot from walking in physics."""


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes:
        check: what was looked at.
        verdict: "ok", "warning" or "problem".
        expected: what would be right.
        got: what is.
        remedy: what to do about it; empty if all is well.
    """

    check: str
    verdict: str
    expected: str
    got: str
    remedy: str

    def as_words(self) -> dict[str, str]:
        """For JSON."""
        return asdict(self)


def refusal(check: str, error: SurefootError) -> Finding:
    """The finding that a robot cannot be loaded at all.

    Args:
        check: what could not be loaded.
        error: that says why.
    """
    return Finding(check, PROBLEM, error.expected, error.got, error.remedy)


def point_mass_only(robot: Robot) -> Finding:
    """The finding that a robot has no mechanism to check."""
    return Finding(
        "model", WARNING, "a [body] table", f"{robot.name!r} is a point mass only",
        "describe its body if it shall walk in physics: docs/robots.md",
    )  # fmt: skip


def check_robot(mechanism: Multibody, pose: NominalPose, walking: Robot) -> list[Finding]:
    """Check a mechanism against its robot's file.

    Args:
        mechanism: of the robot.
        pose: of the same mechanism, from `measure_pose`.
        walking: the point mass that its controller knows.
    """
    robot, model = mechanism.robot, mechanism.model
    links = f"{model.nbody - 1} links, {len(mechanism.motors)} motors"
    return [
        Finding("model", OK, "a model that compiles", links, ""),
        _shapes(mechanism),
        _mass(mechanism),
        _com_height(robot, pose),
        _hip(robot, pose),
        _flat(pose),
        _level(pose),
        _underside(robot, pose),
        _sole_size(robot, pose),
        _com_over_soles(robot, pose),
        _symmetry(mechanism, pose),
        _leg_joints(mechanism, pose),
        _knees(pose),
        _reach(walking, pose),
        _narrowest(walking, robot.foot.width),
        _ranges(mechanism),
        _given(mechanism, pose, "torque", "N m"),
        _given(mechanism, pose, "speed", "rad/s"),
        _load(mechanism, pose),
        _ankles(mechanism, pose),
    ]


def _finding(check: str, verdict: str, expected: str, got: str, remedy: str) -> Finding:
    """A finding; what is well needs no remedy."""
    return Finding(check, verdict, expected, got, "" if verdict == OK else remedy)


def _graded(
    check: str, error: float, limits: tuple[float, float], expected: str, got: str, remedy: str
) -> Finding:
    """A finding from an error: all is well up to the first limit, no harm up to the second."""
    fine, bearable = limits
    verdict = OK if abs(error) <= fine else WARNING if abs(error) <= bearable else PROBLEM
    return _finding(check, verdict, expected, got, remedy)


def _shapes(mechanism: Multibody) -> Finding:
    unseen = mechanism.unseen
    return _finding(
        "shapes", WARNING if unseen else OK, "meshes that MuJoCo can draw (.stl, .obj)",
        f"{len(unseen)} that it cannot: {', '.join(unseen[:3])}" if unseen else "all can be drawn",
        "convert them, or correct their paths; physics does without",
    )  # fmt: skip


def _mass(mechanism: Multibody) -> Finding:
    mass, stated = mechanism.mass, mechanism.robot.mass
    return _graded(
        "mass", mass / stated - 1.0, (0.01, 0.03),
        f"mass = {stated:g} kg, as the file says, to 1 %", f"{mass:.2f} kg",
        f"write mass = {mass:.2f}, or look for links without <inertial>",
    )  # fmt: skip


def _com_height(robot: Robot, pose: NominalPose) -> Finding:
    height = float(pose.com[2])
    return _graded(
        "CoM height", height / robot.com_height - 1.0, (0.01, 0.03),
        f"com_height = {robot.com_height:g} m, as the file says, to 1 %", f"{height:.3f} m",
        f"write com_height = {height:.3f}, or change body.posture",
    )  # fmt: skip


def _hip(robot: Robot, pose: NominalPose) -> Finding:
    if pose.spacing < 0.0:
        return Finding(
            "hip", PROBLEM, "body.feet as [left, right]",
            f"the first {-pose.spacing:.3f} m to the right of the second",
            "exchange the two names in body.feet",
        )  # fmt: skip
    return _graded(
        "hip", pose.spacing - robot.hip, (0.002, 0.01),
        f"soles hip = {robot.hip:g} m apart, as the file says, to 2 mm", f"{pose.spacing:.4f} m",
        f"write hip = {pose.spacing:.4f}, or roll the legs in body.posture",
    )  # fmt: skip


def _flat(pose: NominalPose) -> Finding:
    cosines = np.clip([min(axes[0, 0], axes[2, 2]) for axes in pose.axes], -1.0, 1.0)
    angle = float(np.degrees(np.arccos(cosines)).max())
    return _graded(
        "soles flat", angle, (0.1, 1.0), "soles level and pointing forward, to 0.1 degrees",
        f"{angle:.2f} degrees",
        "choose body.posture so that hip pitch, knee and ankle pitch add up to the sole's angle",
    )  # fmt: skip


def _level(pose: NominalPose) -> Finding:
    step = 1e3 * float(pose.soles[0, 2] - pose.soles[1, 2])
    return _graded(
        "soles level", step, (1.0, 2.0), "both soles on the ground, to 1 mm",
        f"left {step:+.1f} mm over right", "use patterns in body.posture that mean both legs",
    )  # fmt: skip


def _underside(robot: Robot, pose: NominalPose) -> Finding:
    expected = "body.sole under the lowest point of the foot, to 5 mm"
    lowest = [shape[:, 2].min() for shape in pose.foot_shapes if len(shape)]
    if not lowest:
        return Finding("soles' height", OK, expected, "feet have no shapes to compare with", "")
    worst = 1e3 * max(lowest, key=abs)
    z = 0.0 if robot.body is None else robot.body.sole[2]
    where = "above" if worst > 0.0 else "below"
    return _graded(
        "soles' height", worst, (5.0, 15.0), expected,
        f"the foot's lowest point is {abs(worst):.1f} mm {where}",
        f"write {z + 1e-3 * worst:.4f} as z of body.sole, if the foot's shape is right",
    )  # fmt: skip


def _sole_size(robot: Robot, pose: NominalPose) -> Finding:
    half = np.array(robot.foot.half)
    expected = "a sole inside the outline of the foot, to 5 mm"
    got = f"{robot.foot.length:g} m by {robot.foot.width:g} m"
    shapes = [shape for shape in pose.foot_shapes if len(shape)]
    if not shapes:
        return Finding("sole size", OK, expected, f"{got}; feet have no shapes to compare with", "")
    beyond = max(
        max((half - shape[:, :2].max(axis=0)).max(), (half + shape[:, :2].min(axis=0)).max())
        for shape in shapes
    )
    return _graded(
        "sole size", max(1e3 * beyond, 0.0), (5.0, 20.0), expected,
        f"{got}, {1e3 * beyond:.0f} mm beyond the outline" if beyond > 0.005 else got,
        "measure foot.length and foot.width, and the centre in body.sole",
    )  # fmt: skip


def _com_over_soles(robot: Robot, pose: NominalPose) -> Finding:
    x, y = pose.com[:2]
    # The trunk stays upright and moves with the hips, the legs' mass moves less.
    lean = 1.15 * x / np.nanmax([leg.length for leg in pose.legs] + [0.1])
    return _graded(
        "CoM over soles", 1e3 * max(abs(x), abs(y)), (5.0, 125.0 * robot.foot.length),
        "CoM over the middle of the soles, to 5 mm", f"x {1e3 * x:+.1f} mm, y {1e3 * y:+.1f} mm",
        f"add about {-lean:+.3f} rad to hip pitch and {lean:+.3f} to ankle pitch in body.posture, "
        "if they turn about +y" if abs(x) >= abs(y) else
        "hold both arms alike in body.posture, or look for a mass on one side only",
    )  # fmt: skip


def _symmetry(mechanism: Multibody, pose: NominalPose) -> Finding:
    differences = _asymmetries(mechanism, pose)
    return _finding(
        "symmetry", PROBLEM if differences else OK,
        "a right leg that mirrors the left, to 1 % of mass and 2 mm",
        "; ".join(differences) or "legs mirror each other",
        "correct the model, or the patterns of posture, torque and speed",
    )  # fmt: skip


def _asymmetries(mechanism: Multibody, pose: NominalPose) -> list[str]:
    left, right = pose.legs
    if len(left.links) != len(right.links) or len(left.joints) != len(right.joints):
        return [f"left leg with joints {', '.join(left.joints)}, right {', '.join(right.joints)}"]
    model, data = mechanism.model, mechanism.data()
    found = []
    for one, other in zip(left.links, right.links, strict=True):
        pair = f"{model.body(one).name} and {model.body(other).name}"
        masses = model.body_mass[[one, other]]
        if abs(masses[0] - masses[1]) > 0.01 * masses.max():
            found.append(f"{pair} weigh {masses[0]:.3f} and {masses[1]:.3f} kg")
        distance = np.linalg.norm(data.xpos[one] * (1.0, -1.0, 1.0) - data.xpos[other])
        if distance > 0.002:
            found.append(f"{pair} are {1e3 * distance:.1f} mm from mirroring each other")
    order = {name: place for place, name in enumerate(mechanism.joint_names)}
    for one, other in zip(left.joints, right.joints, strict=True):
        for what, limits in (("torque", mechanism.torque), ("speed", mechanism.speed)):
            if limits[order[one]] != limits[order[other]]:
                found.append(f"{what} of {one} and {other} differ")
    return found


def _leg_joints(mechanism: Multibody, pose: NominalPose) -> Finding:
    passive = mechanism.body.ankle_roll == "passive"
    wanted = 5 if passive else 6
    kind = "passive" if passive else "actuated"
    counts = [len(leg.joints) for leg in pose.legs]
    others = len(mechanism.motors) - sum(counts)
    expected = f"{wanted} motors a leg (ankle roll {kind}), all other joints locked"
    if counts != [wanted, wanted]:
        names = "; ".join(", ".join(leg.joints) or "none" for leg in pose.legs)
        return Finding(
            "joints", PROBLEM, expected, f"{counts[0]} and {counts[1]}: {names}",
            "correct body.feet, body.base or body.ankle_roll, or lock a joint",
        )  # fmt: skip
    if others:
        names = {name for leg in pose.legs for name in leg.joints}
        free = ", ".join(name for name in mechanism.joint_names if name not in names)
        return Finding("joints", WARNING, expected, f"{free} move too", "add them to body.locked")
    return Finding("joints", OK, expected, f"{wanted} a leg", "")


def _knees(pose: NominalPose) -> Finding:
    expected = "hip to ankle 80 to 96 % of the straight leg"
    if not all(leg.knee for leg in pose.legs):
        return Finding(
            "knees", PROBLEM, "three joints a leg that turn about y: hip pitch, knee, ankle pitch",
            "another number", "correct body.feet, or face the model along x",
        )  # fmt: skip
    shares = [leg.length / leg.straight for leg in pose.legs]
    got = f"{100 * shares[0]:.1f} % left, {100 * shares[1]:.1f} % right"
    bent, locked = all(0.8 <= share <= 0.96 for share in shares), max(shares) > 0.99
    return _finding(
        "knees", OK if bent else PROBLEM if locked else WARNING, expected, got,
        "bend the knees in body.posture: 90 to 93 % leave room for long steps",
    )  # fmt: skip


def _reach(robot: Robot, pose: NominalPose) -> Finding:
    reach = min(leg.step_reach for leg in pose.legs)
    longest = max(robot.gait.step_x[1], -robot.gait.step_x[0])
    if not reach < longest:
        got = f"{longest:g} m; legs reach {reach:.2f} m"
        return Finding("step length", OK, "steps within reach of the legs", got, "")
    return Finding(
        "step length", WARNING, f"step_x within the {reach:.2f} m that the legs reach",
        f"{longest:g} m", "bend the knees more, or shorten step_x in [body.gait]",
    )  # fmt: skip


def _narrowest(robot: Robot, width: float) -> Finding:
    """`robot` is the one that walks, which has its own steps and a narrower sole."""
    gap = 1e3 * (robot.hip + robot.gait.step_y[0] - width)
    return _graded(
        "step width", min(gap, 0.0), (0.0, np.inf),
        "soles that do not overlap in the narrowest step",
        f"{gap:.0f} mm between them" if gap >= 0.0 else f"they overlap by {-gap:.0f} mm",
        f"write {width + 0.02 - robot.hip:.3f} as the first of body.gait.step_y",
    )  # fmt: skip


def _ranges(mechanism: Multibody) -> Finding:
    model = mechanism.model
    outside = []
    for joint, angle in zip(
        mechanism.motors, mechanism.nominal[mechanism.motor_positions], strict=True
    ):
        low, high = model.jnt_range[joint]
        if model.jnt_limited[joint] and not low <= angle <= high:
            outside.append(f"{model.joint(joint).name} {angle:g} not in [{low:g}, {high:g}]")
    return _finding(
        "joint ranges", PROBLEM if outside else OK, "a posture within the joints' ranges [rad]",
        "; ".join(outside) or "within", "correct body.posture",
    )  # fmt: skip


def _given(mechanism: Multibody, pose: NominalPose, key: str, unit: str) -> Finding:
    limits = dict(zip(mechanism.joint_names, getattr(mechanism, key), strict=True))
    legs = [name for leg in pose.legs for name in leg.joints]
    without = [name for name in legs if not np.isfinite(limits[name])]
    values = [limits[name] for name in legs if name not in without]
    got = f"{min(values):g} to {max(values):g} {unit}" if values else "none"
    if without:
        got = f"none for {', '.join(without)}"
    return _finding(
        f"{key} limits", PROBLEM if without else OK, f"a {key} limit for every joint of the legs",
        got, f"give them in [body.{key}], patterns allowed [{unit}]",
    )  # fmt: skip


def _load(mechanism: Multibody, pose: NominalPose) -> Finding:
    share = pose.load / mechanism.torque
    worst = int(share.argmax())
    return _graded(
        "standing torque", float(share[worst]), (0.7, 1.0),
        "at most 70 % of any torque limit with the weight on one foot",
        f"{mechanism.joint_names[worst]} {pose.load[worst]:.0f} of "
        f"{mechanism.torque[worst]:g} N m, {100 * share[worst]:.0f} %",
        "bend the knees less, or correct body.torque; a motor needs room for more than standing",
    )  # fmt: skip


def _ankles(mechanism: Multibody, pose: NominalPose) -> Finding:
    expected = "ankles that can shift the ZMP to the ends of the sole"
    order = {name: place for place, name in enumerate(mechanism.joint_names)}
    torques = [mechanism.torque[order[leg.ankle]] for leg in pose.legs if leg.ankle]
    if not torques:
        return Finding("ankles", OK, expected, "no ankle was found", "")
    holds = min(torques) / (mechanism.mass * mechanism.robot.gravity)
    half = mechanism.robot.foot.half[0]
    ends = max(abs(leg.sole_ahead) + half for leg in pose.legs)
    return _graded(
        "ankles", max(ends - holds, 0.0), (0.002, np.inf), expected,
        f"{min(torques):g} N m hold it within {holds:.3f} m of them, a sole ends at {ends:.3f} m",
        "shorten foot.length and move body.sole under the ankle: the rest cannot be stood on",
    )  # fmt: skip
