"""A body walks in physics: what is recorded is true, the same twice, and survives its file."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import pairwise

import msgspec
import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.control.registry import methods
from surefoot.robot.feet import Footstep
from surefoot.rollout.outcome import has_walked_on
from surefoot.worlds.body.estimator import BodyReadings
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.recording import BodyRecorder, floor_zmp, roll_pitch_yaw

STEERING = [
    (0.0, sf.Steering((0.2, 0.0))),
    (2.0, sf.Steering((0.3, 0.05), turning=0.3)),
    (4.0, sf.Steering(standing=True)),
]


@pytest.fixture(scope="module")
def control(body_control: sf.BodyControl) -> sf.BodyControl:
    return body_control


@pytest.fixture(scope="module")
def steered(control: sf.BodyControl) -> sf.Rollout:
    """Walks, turns, and comes to a stand."""
    return sf.simulate_body(control, 6.5, steering=STEERING)


def body_of(rollout: sf.Rollout) -> sf.BodyTrace:
    assert rollout.body is not None
    return rollout.body


def test_it_walks_from_a_stand_to_a_stand(steered: sf.Rollout) -> None:
    trace = body_of(steered)
    assert steered.outcome is sf.Outcome.WALKED
    assert not trace.walking[0]
    assert not trace.walking[-1]
    assert np.abs(trace.com_velocity[-1]).max() < 0.02
    assert 8 <= len(steered.footsteps) <= 18
    sides = [step.side for step in steered.footsteps]
    assert all(a is b.other for a, b in pairwise(sides))
    assert steered.velocities == ((0.0, (0.2, 0.0)), (2.0, (0.3, 0.05)), (4.0, (0.0, 0.0)))


def test_it_turns(steered: sf.Rollout) -> None:
    # Two seconds at 0.3 rad/s, give or take a step before the command is heard.
    assert body_of(steered).base_turn[-1, 2] == pytest.approx(0.6, abs=0.2)


def test_footsteps_are_where_soles_stand(steered: sf.Rollout) -> None:
    trace = body_of(steered)
    for step in steered.footsteps:
        row = int(np.searchsorted(steered.time, step.start + step.duration + 0.03))
        foot = 1 if step.side is sf.Side.LEFT else 0
        assert trace.sole_position[row, foot, :2] == pytest.approx(step.landing, abs=0.02)
        assert 0.2 <= step.duration <= 0.7


def test_standing_belongs_to_no_step(steered: sf.Rollout) -> None:
    walking = np.flatnonzero(body_of(steered).walking)
    first, last = steered.footsteps[0], steered.footsteps[-1]
    assert first.start == pytest.approx(steered.time[walking[0]])
    assert last.start + last.duration == pytest.approx(steered.time[walking[-1] + 1])
    assert steered.observations["support_side"][0] == first.side
    assert steered.observations["elapsed"][walking[0] - 1] == 0.0
    assert (steered.commands["double_support"] == ~body_of(steered).walking).all()


def test_the_truth_is_that_of_the_mechanism(steered: sf.Rollout) -> None:
    trace = body_of(steered)
    multibody = sf.load_multibody(trace.robot)
    data = mujoco.MjData(multibody.model)
    for row in (0, 1500, 3333):
        data.qpos[:], data.qvel[:] = trace.position[row], trace.velocity[row]
        mujoco.mj_forward(multibody.model, data)
        mujoco.mj_subtreeVel(multibody.model, data)
        base = multibody.base
        assert data.subtree_com[base] == pytest.approx(trace.com[row], abs=1e-6)
        assert data.subtree_linvel[base] == pytest.approx(trace.com_velocity[row], abs=1e-5)
        for foot, site in enumerate(multibody.soles):
            assert data.site_xpos[site] == pytest.approx(trace.sole_position[row, foot], abs=1e-6)


def test_the_zmp_is_that_of_every_contact(control: sf.BodyControl) -> None:
    plant, state = BodyPlant(control.multibody), control.start()
    recorder = BodyRecorder(plant, state, False, 60)
    force = np.zeros(6)
    for row in range(60):
        command, state = control.step(
            state, plant.time, plant.position, plant.velocity, plant.foot_force, sf.Steering()
        )
        recorder.record_state(row, plant.position, plant.velocity)
        if row == 59:
            probe = plant.fork().data
            probe.ctrl[:] = command.torque
            mujoco.mj_step2(plant.model, probe)
            pushed = np.zeros(3)
            for index in range(probe.ncon):
                contact = probe.contact[index]
                mujoco.mj_contactForce(plant.model, probe, index, force)
                up = contact.frame[2] * force[0]
                pushed += (up * contact.pos[0], up * contact.pos[1], up)
        plant.act(command)
        recorder.record_effect(row, (0, 0, 0, 0))
    record = recorder.record(60)
    wrench = np.stack([record["left_wrench"], record["right_wrench"]], axis=1)
    zmp = floor_zmp(record["com"], wrench)[-1]
    assert abs(zmp - pushed[:2] / pushed[2]).max() < 2e-4
    assert wrench[-1, :, 5] == pytest.approx(plant.foot_force, rel=1e-6)


def test_without_the_floor_there_is_no_zmp() -> None:
    zmp = floor_zmp(np.zeros((1, 3)), np.zeros((1, 2, 6)))
    assert np.isnan(zmp).all()


def test_angles_of_a_rotation() -> None:
    axes = np.zeros((3, 3))
    quaternion = np.zeros(4)
    mujoco.mju_euler2Quat(quaternion, np.array([0.3, -0.2, 1.1]), "XYZ")
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, quaternion)
    axes = flat[None]
    assert roll_pitch_yaw(axes)[0] == pytest.approx([0.3, -0.2, 1.1])


def test_the_zmp_follows_the_command(steered: sf.Rollout) -> None:
    walking = body_of(steered).walking
    off = (steered.zmp - steered.commands["zmp"])[walking]
    assert np.sqrt(np.nanmean(off**2)) < 0.03


def test_an_estimate_drives_it_unless_told_otherwise(control: sf.BodyControl, steered) -> None:
    trace = body_of(steered)
    assert len(trace.told_position) == len(trace.position)
    assert "encoder" in trace.senses
    told = sf.simulate_body(control, 0.2, estimator="truth")
    assert body_of(told).senses == "truth"
    assert len(body_of(told).told_position) == 0
    assert told.estimator == ""
    errors = sf.measure_body(steered, trace).estimate
    assert 0.0 < errors["dcm"] < 0.02
    assert errors["tilt"] < 0.02
    assert sf.measure_body(told, body_of(told)).estimate == {}


def test_what_was_told_is_near_the_truth_in_the_world(steered: sf.Rollout) -> None:
    walking = body_of(steered).walking
    away = (steered.seen["dcm"] - steered.dcm)[walking]
    assert np.abs(away).max() < 0.06
    yaw = (steered.seen["support_yaw"] - steered.observations["support_yaw"])[walking]
    assert np.abs(yaw).max() < 0.05


def test_the_same_walk_twice_is_the_same(control: sf.BodyControl) -> None:
    first, second = (sf.simulate_body(control, 2.0) for _ in range(2))
    assert first.observations.tobytes() == second.observations.tobytes()
    assert first.commands.tobytes() == second.commands.tobytes()
    assert first.body == second.body
    assert body_of(first) != replace(body_of(second), fate=3)
    assert body_of(first) != replace(body_of(second), com=body_of(second).com + 1e-9)


def test_measures(steered: sf.Rollout, control: sf.BodyControl) -> None:
    measures = sf.measure_body(steered, body_of(steered))
    assert measures.commanded == (0.3, 0.05)
    assert measures.knees is not None
    assert all(0.12 < low < high < 1.6 for low, high in measures.knees)
    assert measures.clearance is not None
    assert measures.clearance[0] > 0.01
    assert measures.scuffs == 0
    assert set(measures.torque_part) == set(control.multibody.joint_names)
    assert 0.1 < max(measures.torque_part.values()) < 1.0
    assert measures.lateral_drift is not None
    assert abs(measures.lateral_drift) < 0.15
    assert measures.heading_error is not None
    assert abs(measures.heading_error) < 0.2
    assert 0.0 < measures.cycle_time[0] <= measures.cycle_time[1]


def test_speed_is_measured_once_it_is_settled(control: sf.BodyControl) -> None:
    rollout = sf.simulate_body(control, 9.0, estimator="truth")
    measures = sf.measure_body(rollout, body_of(rollout))
    assert measures.speed is not None
    assert measures.speed[0] == pytest.approx(0.3, abs=0.06)
    brief = sf.simulate_body(control, 4.0, estimator="truth")
    assert len(brief.footsteps) > 4
    assert sf.measure_body(brief, body_of(brief)).speed is None


def test_a_push_and_a_payload_act(control: sf.BodyControl) -> None:
    push = sf.Push(0.1, 0.1, (60.0, 0.0))
    pushed = sf.simulate_body(control, 0.25, [push], estimator="truth")
    free = sf.simulate_body(control, 0.25, estimator="truth")
    gained = body_of(pushed).com_velocity[200] - body_of(free).com_velocity[200]
    assert gained[0] == pytest.approx(6.0 / 68.0, rel=0.3)
    assert pushed.outcome is sf.Outcome.UNSETTLED  # it is not yet known what comes of it
    loaded = sf.simulate_body(
        control, 0.25, surroundings=sf.Surroundings(payload=5.0), estimator="truth"
    )
    force = body_of(loaded).sole_force[200, :, 2].sum()
    assert force == pytest.approx(73.0 * 9.81, rel=0.05)


class Offset:
    """Sensors whose gyroscope is off: what they tell is what the estimator hears."""

    def start(self) -> int:
        return 0

    def step(self, memory: int, senses: BodyReadings) -> tuple[BodyReadings, int]:
        return senses._replace(gyro=senses.gyro + 0.05), memory + 1


def test_noise_comes_between_sensors_and_estimator(control: sf.BodyControl) -> None:
    clean, noisy = (sf.simulate_body(control, 0.3, noise=noise) for noise in (None, Offset()))
    assert body_of(noisy).told_velocity.tobytes() != body_of(clean).told_velocity.tobytes()
    assert "Offset" in body_of(noisy).senses
    usual = sf.simulate_body(control, 0.3)
    assert body_of(usual).told_velocity.tobytes() != body_of(clean).told_velocity.tobytes()
    assert "BodyNoise(" in body_of(usual).senses
    other = sf.simulate_body(control, 0.3, noise=sf.BodyNoise(seed=1))
    assert body_of(usual).told_velocity.tobytes() != body_of(other).told_velocity.tobytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": 0.0}, "`duration` above 0 [s]"),
        ({"steering": [(1.0, sf.Steering()), (0.5, sf.Steering())]}, "steering in order of time"),
        ({"steering": [(1.0, sf.Steering((9.0, 0.0)))]}, "m/s"),
        ({"estimator": "guess"}, "an estimator, or 'truth' for the true state; got 'guess'"),
        ({"estimator": "truth", "noise": Offset()}, "noise with an estimator"),
    ],
)
def test_misuse_is_told(control: sf.BodyControl, arguments: dict, message: str) -> None:
    with pytest.raises(sf.SurefootError) as caught:
        sf.simulate_body(control, **arguments)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "method", [m for m in methods() if not (m.slow or m.leans)], ids=lambda m: m.key
)
def test_every_method_walks_or_falls_for_a_reason(method, control: sf.BodyControl) -> None:
    brain = sf.body_controller(method.key, sf.walking_robot(control.multibody), (0.3, 0.0))
    rollout = sf.simulate_body(sf.body_control(brain, control.multibody), 2.4, estimator="truth")
    assert np.isfinite(rollout.com).all()
    assert np.isfinite(rollout.commands["zmp"]).all()
    assert (body_of(rollout).solver >= 1).mean() > 0.95
    assert len(rollout.footsteps) >= 2
    assert (rollout.body_fall is None) == (rollout.outcome is not sf.Outcome.FELL)


def test_the_walking_robot_is_that_of_the_body(control: sf.BodyControl) -> None:
    robot = control.multibody.robot
    believed = sf.walking_robot(control.multibody)
    assert believed.foot.length == pytest.approx(0.8 * robot.foot.length)
    # A passive ankle roll cannot push sideways.
    assert believed.foot.width == pytest.approx(0.01)
    assert believed.body is None
    assert robot.body is not None
    own = sf.Swing(height=0.07)
    body = msgspec.structs.replace(robot.body, swing=own)
    other = replace(control.multibody, robot=robot.replace(body=body))
    assert sf.walking_robot(other).swing == own


class SlowNoise:
    """Sensors that take a while to simulate, and tell the truth."""

    def start(self) -> None:
        return None

    def step(self, memory: None, senses: BodyReadings) -> tuple[BodyReadings, None]:
        time.sleep(0.25)
        return senses, None


def test_a_cycle_is_timed_without_the_simulator_s_sensors(control: sf.BodyControl) -> None:
    walk = sf.simulate_body(control, 0.003, noise=SlowNoise())
    assert walk.body is not None
    assert np.median(walk.body.sense_time + walk.decision_time) < 0.2


def step(index: int, offset: tuple[float, float], duration: float = 0.35) -> Footstep:
    side = sf.Side.LEFT if index % 2 else sf.Side.RIGHT
    return Footstep(index, side, (0.0, 0.0), 0.35 * index, duration, (0.0, 0.0), offset, False)


@pytest.mark.parametrize(
    ("count", "offset", "duration", "back"),
    [
        (9, (0.06, 0.05), 0.35, True),
        (8, (0.06, 0.05), 0.35, False),  # too few of them
        (9, (0.04, 0.07), 0.35, False),  # wide
        (9, (0.08, 0.05), 0.35, False),  # fast
        (9, (0.04, 0.05), 0.32, False),  # hurried
        (17, (0.04, 0.09), 0.32, False),  # for 4.2 s
        (18, (0.04, 0.09), 0.32, True),  # for 4.6 s, which is 16 / omega
    ],
)
def test_a_robot_has_recovered_when_it_steps_as_before_or_for_long(
    robot: sf.Robot, count: int, offset: tuple[float, float], duration: float, back: bool
) -> None:
    steps = [step(k, (0.04, 0.05)) for k in range(4)]
    steps += [step(k, offset, duration) for k in range(5, count)]
    push = sf.Push(1.5, 0.2, (100.0, 0.0))
    assert has_walked_on(robot, steps, [push], 0.35 * count) == back


def test_pushes_and_payload_act_where_the_robot_says(robot: sf.Robot) -> None:
    body = robot.body
    assert body is not None
    thigh = robot.replace(body=msgspec.structs.replace(body, trunk="left_thigh"))
    multibody = sf.load_multibody(thigh)
    plant = BodyPlant(multibody, sf.Surroundings(payload=5.0), [sf.Push(0.0, 0.1, (50.0, 0.0))])
    link = plant.model.body("left_thigh").id
    assert multibody.trunk == link != multibody.base
    usual = multibody.model.body_mass
    assert plant.model.body_mass[link] == pytest.approx(usual[link] + 5.0)
    assert plant.model.body_mass.sum() == pytest.approx(usual.sum() + 5.0)
    plant.act(JointCommand(len(multibody.motors), multibody.model.nv))
    assert plant.data.xfrc_applied[link, 0] == 50.0
    assert not plant.data.xfrc_applied[multibody.base].any()
    chest = robot.replace(body=msgspec.structs.replace(body, trunk="chest"))
    with pytest.raises(sf.RobotError, match=r"a body of the model \(.*'chest'"):
        sf.load_multibody(chest)
