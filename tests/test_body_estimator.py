"""The state of a body: exact without noise, calm with it, and the same in every frame."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import body_motion as motions
import surefoot as sf
from surefoot.geometry import rotate, rotate_in_world, rotated_by, rotation_matrix
from surefoot.robot.leg_kinematics import SOLES, find_soles, leg_links
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.base_filter import ERRORS, FEET, POSITION, VELOCITY
from surefoot.worlds.body.estimator import BodyEstimator, BodyMemory
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.sensors import measure, measure_standing

NO_FLOOR = 1e3
"""Uneven enough for the floor to say nothing [m]."""


@pytest.fixture(scope="module")
def estimator(multibody: Multibody) -> BodyEstimator:
    return BodyEstimator(multibody, floor=NO_FLOOR)


@pytest.fixture(scope="module")
def motion(multibody: Multibody) -> motions.Motion:
    return motions.prescribed(multibody)


@pytest.fixture(scope="module")
def standing(motion: motions.Motion) -> motions.Motion:
    """Both feet on the ground, nothing moves."""
    still = np.tile(motion.qpos[0], (1500, 1))
    return motions.sensed(still, np.ones((1500, 2), np.int64))


def com_velocity(multibody: Multibody, qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    data, found = mujoco.MjData(multibody.model), []
    for data.qpos[:], data.qvel[:] in zip(qpos, qvel, strict=True):
        mujoco.mj_kinematics(multibody.model, data)
        mujoco.mj_comPos(multibody.model, data)
        mujoco.mj_comVel(multibody.model, data)
        mujoco.mj_subtreeVel(multibody.model, data)
        found.append(data.subtree_linvel[multibody.base].copy())
    return np.array(found)


def tilt_errors(truth: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Of the vertical in the frame of the base, for positions of both [rad]."""
    rows = zip(truth[:, 3:7], found[:, 3:7], strict=True)
    return np.array([motions.matrix(a)[2] - motions.matrix(b)[2] for a, b in rows])


def test_quaternions_turn_as_mujocos_do() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = rng.standard_normal(4)
        q /= np.linalg.norm(q)
        rotation, expected, turn, axis = rng.standard_normal(3), np.empty(4), np.empty(4), None
        angle = float(np.linalg.norm(rotation))
        axis = rotation / angle
        mujoco.mju_axisAngle2Quat(turn, axis, angle)
        for ours, order in ((rotate, (q, turn)), (rotate_in_world, (turn, q))):
            out = np.empty(4)
            ours(q, rotation, out)
            mujoco.mju_mulQuat(expected, *order)
            assert out == pytest.approx(expected, abs=1e-14)
        R = np.empty((3, 3))
        rotation_matrix(q, R)
        assert pytest.approx(motions.matrix(q), abs=1e-14) == R


def test_soles_are_where_mujoco_has_them(multibody: Multibody) -> None:
    links, soles, data = leg_links(multibody), np.zeros(1, SOLES), multibody.data()
    upright = [data.site_xmat[site].reshape(3, 3).copy() for site in multibody.soles]
    rng, jacobian = np.random.default_rng(2), np.zeros((2, 3, multibody.model.nv))
    for _ in range(20):
        data.qpos[:7] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
        data.qpos[7:] = multibody.nominal[7:] + rng.uniform(-0.5, 0.5, 12)
        mujoco.mj_kinematics(multibody.model, data)
        mujoco.mj_comPos(multibody.model, data)
        find_soles(links, data.qpos[7:].copy(), soles[0])
        for leg in (0, 1):
            position, rotation = motions.sole_pose(multibody, data, leg)
            assert soles["position"][0, leg] == pytest.approx(position, abs=1e-13)
            assert soles["rotation"][0, leg] == pytest.approx(rotation @ upright[leg].T, abs=1e-13)
            mujoco.mj_jacSite(multibody.model, data, *jacobian, multibody.soles[leg])
            spread = np.sqrt((jacobian[0][:, 6:] ** 2).sum(axis=1))
            assert soles["spread"][0, leg] == pytest.approx(spread, abs=1e-12)
            turn = math.sqrt((jacobian[1][2, 6:] ** 2).sum())
            assert soles["turn_spread"][0, leg] == pytest.approx(turn, abs=1e-12)


@pytest.mark.parametrize("delay", [0, 5])
def test_without_noise_it_is_the_truth(
    multibody: Multibody, motion: motions.Motion, delay: int
) -> None:
    estimator = BodyEstimator(multibody, floor=NO_FLOOR, delay=delay * motions.PERIOD)
    late = [motion.senses[max(k - delay, 0)] for k in range(len(motion.senses))]
    # The feet are known when their forces are: as late as they.
    feet = np.array([motion.feet[max(k - delay, 0)] for k in range(len(late))])
    found = motions.estimate(estimator, replace(motion, senses=late, feet=feet))
    assert np.abs(found.qpos - motion.qpos).max() < 1e-8
    assert np.abs(found.qvel - motion.qvel).max() < 1e-7
    assert np.abs(motion.qvel[:, :3]).max() > 0.3, "it moved"


def test_noise_is_smoothed_without_a_lag(
    multibody: Multibody, estimator: BodyEstimator, motion: motions.Motion
) -> None:
    """DCM = CoM + velocity / omega: below 5 mm if the velocity is below 18 mm/s."""
    found = motions.estimate(estimator, motions.disturbed(motion, bias=(0.003, -0.003, 0.003)))
    later = slice(400, None)
    error = com_velocity(multibody, found.qpos, found.qvel) - com_velocity(
        multibody, motion.qpos, motion.qvel
    )
    assert error[later].std(axis=0).max() < 0.006
    assert np.abs(error[later].mean(axis=0)).max() < 0.003
    assert np.abs(tilt_errors(motion.qpos, found.qpos)[later]).max() < 0.003
    joints = (found.qvel - motion.qvel)[later, 6:]
    assert joints.std() < 0.03
    acceleration = motion.expected[later, 6:]
    lag = -(joints * acceleration).sum() / (acceleration**2).sum()
    assert abs(lag) < 5e-4, "[s]"


def test_joints_are_smoothed_less_where_nothing_is_known_of_them(
    estimator: BodyEstimator, motion: motions.Motion
) -> None:
    noisy = motions.disturbed(motion)
    found = motions.estimate(estimator, replace(noisy, expected=0.0 * motion.expected))
    error = (found.qvel - motion.qvel)[400:, 6:]
    assert 0.03 < error.std() < 0.15


def test_it_knows_how_wrong_it_is(estimator: BodyEstimator, motion: motions.Motion) -> None:
    """Of lean and velocity; both are seen by the feet's and the inertial unit's agreement."""
    found = motions.estimate(estimator, motions.disturbed(motion))
    lean, speed = [], []
    for k in range(400, 1500, 5):
        covariance = found.memories[k + 1].base["covariance"][0]
        assert np.abs(covariance - covariance.T).max() < 1e-15
        assert np.linalg.eigvalsh(covariance)[0] > 0.0
        deviation = np.sqrt(np.diag(covariance))
        R, told = motions.matrix(motion.qpos[k, 3:7]), motions.matrix(found.qpos[k, 3:7])
        turn = told @ R.T
        lean.append(np.array([turn[2, 1], turn[0, 2]]) / deviation[:2])
        speed.append((found.qvel[k, :3] - motion.qvel[k, :3]) / deviation[VELOCITY : VELOCITY + 3])
    for normalised in (lean, speed):
        assert 0.3 < np.sqrt(np.mean(np.square(normalised))) < 2.0


def test_what_a_leaning_start_got_wrong_is_found(
    estimator: BodyEstimator, standing: motions.Motion
) -> None:
    shaken = list(standing.senses)
    shaken[0] = shaken[0]._replace(accelerometer=np.array([0.2, -0.2, 9.8]))
    found = motions.estimate(estimator, replace(standing, senses=shaken))
    error = np.abs(tilt_errors(standing.qpos, found.qpos)).max(axis=1)
    assert error[0] > 0.015
    assert error[-1] < 0.0005
    assert found.qpos[-1, :3] == pytest.approx(standing.qpos[0, :3], abs=0.001)


def test_the_gyroscopes_offset_is_found(estimator: BodyEstimator, standing: motions.Motion) -> None:
    bias = (0.005, -0.005, 0.005)
    found = motions.estimate(estimator, motions.disturbed(standing, bias=bias))
    assert found.memories[-1].base["bias"][0] == pytest.approx(bias, abs=0.002)


def turned_world(memory: BodyMemory, yaw: float, shift: tuple[float, float]) -> BodyMemory:
    """The same memory in a world that is seen from elsewhere."""
    base = memory.base.copy()
    c, s = math.cos(yaw), math.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    rotate_in_world(base["orientation"][0], np.array([0.0, 0.0, yaw]), base["orientation"][0])
    base["velocity"][0] = R @ base["velocity"][0]
    base["position"][0] = R @ base["position"][0] + (*shift, 0.0)
    base["feet"][0] = base["feet"][0] @ R.T + (*shift, 0.0)
    base["headings"][0] += yaw
    turn = np.eye(ERRORS)
    for start in (0, VELOCITY, POSITION, FEET, FEET + 3):
        turn[start : start + 3, start : start + 3] = R
    base["covariance"][0] = turn @ base["covariance"][0] @ turn.T
    return memory._replace(base=base)


def test_the_world_may_be_seen_from_anywhere(
    estimator: BodyEstimator, motion: motions.Motion
) -> None:
    noisy, yaw, shift = motions.disturbed(motion), 2.0, (3.0, -2.0)
    here = motions.estimate(estimator, noisy)
    # What is expected of the base's acceleration is said in the world.
    elsewhere = noisy.expected.copy()
    elsewhere[:, :2] = rotated_by(elsewhere[:, :2], np.full(len(elsewhere), yaw))
    there = motions.estimate(
        estimator,
        replace(noisy, expected=elsewhere),
        turned_world(here.memories[500], yaw, shift),
        500,
    )
    expected = turned_world(here.memories[-1], yaw, shift).base
    for name in ("orientation", "velocity", "position", "feet", "bias"):
        assert there.memories[-1].base[name] == pytest.approx(expected[name], abs=1e-9), name
    assert there.qvel[:, 3:] == pytest.approx(here.qvel[500:, 3:], abs=1e-9)


def mirrored(motion: motions.Motion, multibody: Multibody) -> motions.Motion:
    """The motion in a mirror: left is right, and what turns about x or z turns the other way."""
    names = [multibody.model.joint(1 + k).name for k in range(12)]
    sign = np.array([-1.0 if "yaw" in name or "roll" in name else 1.0 for name in names])

    def swap(joints: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(sign * np.roll(joints, 6, axis=-1))

    polar, axial = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    senses = [
        s._replace(
            joint_angles=swap(s.joint_angles),
            joint_velocities=swap(s.joint_velocities),
            gyro=axial * s.gyro,
            accelerometer=polar * s.accelerometer,
            foot_force=s.foot_force[::-1].copy(),
        )
        for s in motion.senses
    ]
    base = np.hstack([polar, axial])
    expected = np.hstack([base * motion.expected[:, :6], swap(motion.expected[:, 6:])])
    feet = np.ascontiguousarray(motion.feet[:, ::-1])
    return replace(motion, senses=senses, expected=expected, feet=feet)


def test_left_is_as_good_as_right(
    multibody: Multibody, estimator: BodyEstimator, motion: motions.Motion
) -> None:
    noisy = motions.disturbed(motion)
    here = motions.estimate(estimator, noisy)
    there = motions.estimate(estimator, mirrored(noisy, multibody))
    flip = np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0])
    assert there.qpos[:, :7] == pytest.approx(here.qpos[:, :7] * flip, abs=1e-9)
    flip = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    assert there.qvel[:, :6] == pytest.approx(here.qvel[:, :6] * flip, abs=1e-9)


@pytest.mark.parametrize(
    "name", ["joint_angles", "joint_velocities", "gyro", "accelerometer", "foot_force"]
)
def test_a_sensor_may_fail_for_a_while(
    estimator: BodyEstimator, motion: motions.Motion, name: str
) -> None:
    senses = motions.disturbed(motion).senses
    for k in range(900, 920):
        values = getattr(senses[k], name).copy()
        values[0] = math.nan if k % 2 else math.inf
        senses[k] = senses[k]._replace(**{name: values})
    found = motions.estimate(estimator, replace(motion, senses=senses))
    assert np.isfinite(found.qpos).all()
    assert np.isfinite(found.memories[-1].base["covariance"]).all()
    assert np.abs(found.qvel - motion.qvel)[400:].max() < 0.25
    assert np.abs(found.qpos - motion.qpos)[400:].max() < 0.01


def test_what_is_expected_may_be_nonsense(estimator: BodyEstimator, motion: motions.Motion) -> None:
    expected = motion.expected.copy()
    expected[900:905] = math.nan
    found = motions.estimate(estimator, replace(motion, expected=expected))
    assert np.isfinite(found.qvel).all()
    assert np.abs(found.qvel - motion.qvel).max() < 0.1


def test_a_memory_is_a_value(estimator: BodyEstimator, motion: motions.Motion) -> None:
    noisy = motions.disturbed(motion)
    once, twice = (motions.estimate(estimator, noisy) for _ in range(2))
    assert once.qpos.tobytes() == twice.qpos.tobytes()
    assert once.qvel.tobytes() == twice.qvel.tobytes()
    again = motions.estimate(estimator, noisy, once.memories[700], 700)
    assert again.qvel.tobytes() == once.qvel[700:].tobytes()


def test_a_foot_that_slips_is_found_out(estimator: BodyEstimator, motion: motions.Motion) -> None:
    """All of the robot slides to the left by 50 mm, while it stands on its left foot."""
    slide = np.zeros(len(motion.qpos))
    slide[450:550] = 0.05 * 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, 100)))
    slide[550:] = 0.05
    qpos = motion.qpos.copy()
    qpos[:, 1] += slide
    sliding = motions.sensed(qpos, motion.feet)
    found = motions.estimate(estimator, motions.disturbed(sliding))
    assert np.abs(sliding.qvel - motion.qvel)[:, 1].max() > 0.7
    assert np.abs(found.qvel - sliding.qvel)[450:, 1].max() < 0.15
    assert abs(found.qpos[-1, 1] - qpos[-1, 1]) < 0.02


def test_a_foot_that_twists_turns_nothing_else(
    estimator: BodyEstimator, standing: motions.Motion
) -> None:
    """Standing on the left foot, which turns by 0.3 rad in 0.15 s under a base that does not."""
    qpos, yaw = standing.qpos.copy(), 7
    qpos[600:750, yaw] += np.linspace(0.0, 0.3, 150)
    qpos[750:, yaw] += 0.3
    feet = np.tile((1, 0), (len(qpos), 1))
    found = motions.estimate(estimator, motions.disturbed(motions.sensed(qpos, feet)))
    assert abs(2.0 * math.asin(found.qpos[-1, 6])) < 0.03


def test_soles_that_twist_in_every_step_pass_for_no_offset(
    estimator: BodyEstimator, standing: motions.Motion
) -> None:
    """After a stand, one foot and the other in turn, by 20 mrad outward, as G1's soles do. The
    true offset is found in the stand, and stays."""
    step, stand, twist = 250, 900, 0.02
    walk = np.tile(standing.qpos[0], (stand + 13 * step, 1))
    feet = np.ones((len(walk), 2), np.int64)
    turned = twist * np.clip(np.arange(step) / 100.0, 0.0, 1.0)
    for n in range(13):
        here, foot = slice(stand + n * step, stand + (n + 1) * step), n % 2
        feet[here, 1 - foot] = 0
        # The first joint of a leg, of six, turns it about the vertical.
        walk[here, 7 + 6 * foot] += (1 - 2 * foot) * turned
    noisy = motions.disturbed(motions.sensed(walk, feet), bias=(0.0, 0.0, 0.0042))
    found = motions.estimate(estimator, noisy)
    offsets = np.array([memory.base["bias"][0, 2] for memory in found.memories[stand:]])
    assert np.abs(offsets - 0.0042).max() < 0.0008
    assert abs(2.0 * math.asin(found.qpos[-1, 6])) < 0.006


@pytest.mark.parametrize("bump", [0.01, -0.01])
def test_a_bump_moves_the_floor_a_little(
    multibody: Multibody, motion: motions.Motion, bump: float
) -> None:
    """The floor's height is that of most landings, not of the last one."""
    qpos = np.tile(motion.qpos[0], (600, 1))
    lifted = np.array([0.0, 0.0, bump])
    feet = np.ones((600, 2), np.int64)
    feet[200:400] = 1, 0
    found = motions.estimate(BodyEstimator(multibody), motions.sensed(qpos, feet))
    memory = found.memories[400]
    memory.base["feet"][0, 0] -= lifted
    memory.base["position"][0] -= lifted
    after = motions.estimate(BodyEstimator(multibody), motions.sensed(qpos, feet), memory, 400)
    moved = (after.qpos[-1, 2] - (qpos[0, 2] - bump)) / bump
    assert 0.0 < moved < 0.5


def test_in_physics_it_follows_a_squat(multibody: Multibody) -> None:
    """With what MuJoCo's own sensors tell, of a robot whose joints are held by springs."""
    plant, estimator = BodyPlant(multibody), BodyEstimator(multibody)
    command = JointCommand(len(multibody.motors), multibody.model.nv)
    command.stiffness[:], command.damping[:] = 3000.0, 60.0
    nominal = multibody.nominal[multibody.motor_positions]
    bent = [("pitch" in n) * -1.0 + ("knee" in n) * 2.0 for n in multibody.joint_names]
    senses = measure_standing(plant)
    memory, errors = estimator.start(senses), []
    for _ in range(800):
        qpos, qvel, memory = estimator.step(
            memory, senses, np.ones(2, np.int64), np.zeros(multibody.model.nv)
        )
        errors.append(np.hstack([qpos[:3] - plant.position[:3], qvel[:6] - plant.velocity[:6]]))
        bend = 0.1 * math.sin(6.0 * plant.time) * min(plant.time / 0.2, 1.0)
        command.position[:] = nominal + bend * np.array(bent)
        plant.act(command)
        senses = measure(plant)
    assert np.abs(errors)[:, :3].max() < 0.003
    assert np.abs(errors)[:, 3:].max() < 0.03
    assert senses.foot_force.sum() == pytest.approx(multibody.mass * 9.81, rel=0.2)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"rate": 0.0}, "`rate` above 0"), ({"delay": 0.0015}, "whole number of periods")],
)
def test_wrong_parameters_are_refused(multibody: Multibody, wrong: dict, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        BodyEstimator(multibody, **wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"joint_angles": np.zeros(10)}, r"`joint_angles` of shape \(12,\)"),
        ({"accelerometer": np.full(3, math.nan)}, r"`accelerometer` .* finite"),
    ],
)
def test_readings_that_nothing_can_start_from_are_refused(
    estimator: BodyEstimator, standing: motions.Motion, wrong: dict, message: str
) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        estimator.start(standing.senses[0]._replace(**wrong))
