"""Position servos led by the CoM Jacobian: what is asked of CoM and feet comes about, ZMP and CoM
errors vanish, straight knees are passed, and a body walks on its estimate."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import surefoot as sf
from body_states import mirrored, random_reference, random_state
from small_biped import write_small_biped
from surefoot.record import new_array
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.com_jacobian import DESIRED, LAW, ComJacobian, com_velocity
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.mapping import mapping_names
from surefoot.worlds.body.mechanics import Mechanics
from surefoot.worlds.body.resolved_velocity import ROWS, find_leg_joints, resolve
from surefoot.worlds.body.servos import MOVING, SENT, torques_at_rest, zmp_error
from surefoot.worlds.body.world import BodyWorld
from surefoot.worlds.steering import Steering

STANDS = [(1, 0), (0, 1), (1, 1)]


@pytest.fixture(scope="module")
def actuated(tmp_path_factory: pytest.TempPathFactory) -> Multibody:
    """A robot whose ankles roll by motors."""
    path = write_small_biped(tmp_path_factory.mktemp("small"))
    return sf.load_multibody(sf.load_robot(path))


class Resolver(NamedTuple):
    """`resolve` for one mechanism, without any answer to errors of place."""

    multibody: Multibody
    mechanics: Mechanics
    rate: float = 0.0

    def velocity(self, reference: NDArray[np.void], u: NDArray[np.float64]) -> NDArray[np.float64]:
        multibody, m = self.multibody, self.mechanics
        nv, rows, com = multibody.model.nv, new_array(ROWS), np.zeros((3, multibody.model.nv))
        rows["height"], rows["knee"], rows["guard"] = multibody.robot.com_height, 5.0, 0.03
        rows["rolls"] = len(multibody.passive_dofs) > 6
        rows["swing"] = rows["trunk"] = self.rate
        m.com_jacobian(com)
        out, passive = np.zeros(nv), multibody.passive_dofs[6:].astype(np.int64)
        assert resolve(
            rows[0], find_leg_joints(multibody), passive, multibody.base_dof, reference[0],
            m.motion[0], m.position, m.velocity, m.sole_jacobian, com, u, np.zeros((nv, nv)),
            np.zeros(nv), out,
        )  # fmt: skip
        return out


@pytest.mark.parametrize("stands", STANDS)
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rolls", [True, False])
def test_com_feet_and_trunk_move_as_they_should(
    multibody: Multibody, actuated: Multibody, rolls: bool, seed: int, stands: tuple[int, int]
) -> None:
    """To the millimetre per second, where no knee is nearly straight."""
    mechanism = multibody if rolls else actuated
    mechanics, rng = Mechanics(mechanism), np.random.default_rng(seed)
    mechanics.update(random_state(mechanism, seed)[0], np.zeros(mechanism.model.nv))
    reference, u = random_reference(seed, stands), rng.uniform(-0.3, 0.3, 3)
    reference["swing_foot_velocity"] = rng.uniform(-1.0, 1.0, 3)
    reference["swing_yaw_rate"], reference["trunk_yaw_rate"] = 0.3, -0.2
    velocity = Resolver(mechanism, mechanics).velocity(reference, u)
    com = np.zeros((3, mechanism.model.nv))
    mechanics.com_jacobian(com)
    found = com @ velocity
    assert found[2] == pytest.approx(u[2], abs=1e-3)
    if not rolls or sum(stands) == 2:
        assert found == pytest.approx(u, abs=1e-3)
    else:
        forward = mechanics.sole_axes[stands.index(1), :2, 0]
        forward /= np.linalg.norm(forward)
        assert found[:2] @ forward == pytest.approx(u[:2] @ forward, abs=1e-3)
        assert np.abs(velocity[mechanism.passive_dofs[6:]]).max() < 1e-3
    for side in range(2):
        moved = mechanics.sole_jacobian[side] @ velocity
        wanted = np.zeros(3) if stands[side] else reference["swing_foot_velocity"][0]
        assert moved[:3] == pytest.approx(wanted, abs=1e-3)
    turning = mechanics.base_axes @ velocity[mechanism.base_dof + 3 : mechanism.base_dof + 6]
    assert turning == pytest.approx((0.0, 0.0, -0.2), abs=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_the_zmp_is_known_from_the_ankles(actuated: Multibody, seed: int) -> None:
    mechanics, rng = Mechanics(actuated), np.random.default_rng(seed)
    mechanics.update(random_state(actuated, seed)[0], np.zeros(actuated.model.nv))
    weight, side = actuated.mass * actuated.robot.gravity, seed % 2
    place = mechanics.sole_position[side]
    zmp = place[:2] + rng.uniform(-0.05, 0.05, 2)
    arm = np.array([*zmp, place[2]]) - place
    force = weight * (mechanics.com - place - arm) / (mechanics.com[2] - place[2])
    jacobian = mechanics.sole_jacobian[side]
    torque = -(jacobian[:3].T @ force + jacobian[3:].T @ np.cross(arm, force))
    forces, error = np.zeros(2), np.zeros(2)
    forces[side] = weight
    legs, wanted = find_leg_joints(actuated), zmp + np.array((0.02, -0.01))
    for _ in range(20):
        # The line of the force follows from the last ZMP.
        zmp_error(
            weight, legs, forces, mechanics.motion[0], mechanics.sole_jacobian, torque, wanted,
            error,
        )  # fmt: skip
    assert error == pytest.approx((0.02, -0.01), abs=1e-6)
    zmp_error(
        weight, legs, 0.01 * forces, mechanics.motion[0], mechanics.sole_jacobian, torque, wanted,
        error,
    )  # fmt: skip
    assert error == pytest.approx(0.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_body_at_rest_needs_nothing_of_its_base(actuated: Multibody, seed: int) -> None:
    mechanics, reference = Mechanics(actuated), random_reference(seed, (1, 0))
    mechanics.update(random_state(actuated, seed)[0], np.zeros(actuated.model.nv))
    reference["zmp"] = mechanics.com[:2]
    torque, weight = np.zeros(actuated.model.nv), actuated.mass * actuated.robot.gravity
    torques_at_rest(
        weight, False, np.array((1.0, 0.0)), reference[0], mechanics.motion[0], mechanics.bias,
        mechanics.sole_jacobian, torque,
    )  # fmt: skip
    assert np.abs(torque[:6]).max() < 1e-6 * weight
    assert np.abs(torque[6:]).max() > 0.01 * weight


def pendulum_errors(zmp: float, com: float, time: float) -> NDArray[np.float64]:
    """Errors of CoM and ZMP over time, of a pendulum on a servo, in heights and 1 / omega.

    The servo's spring is 20 m g h; the desired CoM and ZMP are at rest.
    """
    law, reference, desired = new_array(LAW), new_array(BODY_REFERENCE), new_array(DESIRED)
    period, spring = 1e-3, 20.0
    law["zmp"], law["com"], law["period"], law["smoothing"] = zmp, com, period, 32.0
    law["max_error"] = np.inf
    place, speed, sent, errors = 0.05, 0.0, 0.05, []
    for _ in range(round(time / period)):
        force = place - spring * (sent - place)
        desired["zmp_error"][0, 0] = -force
        reference["com_acceleration"][0, 0] = 0.0
        com_velocity(
            law[0], reference[0], np.array((place, 0.0, 0.0)), np.array((speed, 0.0, 0.0)),
            desired[0],
        )  # fmt: skip
        sent += period * desired["velocity"][0, 0]
        speed += period * (place - (place - spring * (sent - place)))
        place += period * speed
        errors.append((place, force))
    return np.array(errors)


@pytest.mark.parametrize(("zmp", "com"), [(0.3, 1.1), (0.65, 1.3), (0.9, 2.0)])
def test_both_errors_vanish_with_rates_on_either_side_of_omega(zmp: float, com: float) -> None:
    errors = np.abs(pendulum_errors(zmp, com, 60.0))
    assert errors[-1].max() < 1e-3 * errors[0, 0]


def test_errors_grow_if_the_rates_are_exchanged() -> None:
    errors = np.abs(pendulum_errors(1.3, 0.65, 20.0))
    assert errors[-1, 0] > 2.0 * errors[0, 0]


@pytest.mark.parametrize(("zmp", "com"), [(1.1, 1.3), (0.65, 0.9), (0.0, 1.3)])
def test_rates_that_are_not_those_of_the_source_are_refused(
    multibody: Multibody, zmp: float, com: float
) -> None:
    omega = multibody.robot.omega
    with pytest.raises(sf.ParameterError, match="zmp_rate < omega < com_rate"):
        ComJacobian(multibody, zmp_rate=zmp * omega, com_rate=com * omega)


def test_servos_without_stiffness_are_refused(multibody: Multibody) -> None:
    with pytest.raises(sf.ParameterError, match="stiffness"):
        ComJacobian(multibody, stiffness=0.0)


@pytest.mark.parametrize("seed", range(6))
def test_left_and_right_are_the_same(multibody: Multibody, seed: int) -> None:
    mechanics, reference = Mechanics(multibody), random_reference(seed, (1, 0))
    position, velocity = random_state(multibody, seed)
    mirror, forces = reference.copy(), np.array((600.0, 40.0))
    mirror["stands"] = (0, 1)
    for name in ("zmp", "com_acceleration", "swing_foot", "swing_foot_acceleration"):
        mirror[name][0, 1] *= -1.0
    found = []
    for turned in (False, True):
        mapping, memory, command = ComJacobian(multibody), {}, None
        if turned:
            position, velocity = (
                mirrored(multibody, position, False),
                mirrored(multibody, velocity, True),
            )
        wanted, loads = (mirror, forces[::-1].copy()) if turned else (reference, forces)
        for _ in range(3):
            mechanics.update(position, velocity)
            command, memory = mapping.joints(mechanics, wanted, loads, memory)
        assert command is not None
        found.append((command.position.copy(), command.velocity.copy()))
    names = multibody.joint_names
    for number, name in enumerate(names):
        side, partner = ("left", "right") if name.startswith("left") else ("right", "left")
        sign = -1.0 if "roll" in name or "yaw" in name else 1.0
        same = names.index(name.replace(side, partner))
        for one, other in zip(*found, strict=True):
            assert other[number] == pytest.approx(sign * one[same], abs=1e-7)


def squat(multibody: Multibody, period: float) -> dict[str, NDArray[np.float64]]:
    """A height that makes the legs straight and back, followed by the kinematics alone.

    Returns:
        Height of the CoM over the first, least bend of the knees, joint velocities, and how far
        soles and horizontal CoM are from where they were, over time.
    """
    mechanics, reference = Mechanics(multibody), new_array(BODY_REFERENCE)
    law, desired, joints = new_array(LAW), new_array(DESIRED), find_leg_joints(multibody)
    omega, mapping = multibody.robot.omega, ComJacobian(multibody)
    law["height"], law["max_lift"] = 1.8 * omega, 0.8 * multibody.robot.gravity
    law["com"], law["period"] = 1.3 * omega, period
    reference["stands"], position = 1, multibody.nominal.copy()
    nv, first = multibody.model.nv, mechanics.com.copy()
    desired["com"] = first
    soles, resolver, rows = mechanics.sole_position.copy(), Resolver(multibody, mechanics), []
    low = mapping.servos["low"]
    for k in range(round(5.5 / period)):
        up = 0.15 if 0.5 < k * period < 3.0 else 0.0
        reference["com"][0, 2] = (1.0 + up) * first[2]
        mechanics.update(position, np.zeros(nv))
        com_velocity(law[0], reference[0], mechanics.com, mechanics.com_velocity, desired[0])
        u = np.array((0.0, 0.0, desired["velocity"][0, 2]))
        velocity = resolver.velocity(reference, u)
        mujoco.mj_integratePos(multibody.model, position, velocity, period)
        angles = position[multibody.motor_positions]
        position[multibody.motor_positions] = np.maximum(angles, low)
        bend = min(leg["sign"] * (position[leg["angle"]] - leg["straight"]) for leg in joints)
        away = np.abs(mechanics.sole_position - soles).max()
        aside = np.abs(mechanics.com[:2] - first[:2]).max()
        rows.append((mechanics.com[2] - first[2], bend, away, aside, *velocity))
    table = np.array(rows)
    return {
        "height": table[:, 0], "bend": table[:, 1], "soles": table[:, 2], "aside": table[:, 3],
        "velocity": table[:, 4:],
    }  # fmt: skip


def test_straight_knees_are_passed_without_a_jump(multibody: Multibody) -> None:
    found, finer = squat(multibody, 2e-3), squat(multibody, 1e-3)
    assert finer["bend"].min() < 0.04
    assert 0.05 < finer["height"].max() < 0.08
    assert finer["height"][-1] == pytest.approx(0.0, abs=1e-3)
    assert finer["bend"][-1] == pytest.approx(0.8, abs=0.02)
    assert finer["soles"].max() < 5e-3
    assert finer["aside"].max() < 4e-3
    # No faster than the motors may turn; and half the period halves the largest change.
    assert np.abs(finer["velocity"]).max() < 0.6 * multibody.speed.min()
    coarse, fine = (np.abs(np.diff(one["velocity"], axis=0)).max() for one in (found, finer))
    assert fine < 0.65 * coarse


def test_a_body_rises_on_straight_legs_and_sinks_again(multibody: Multibody) -> None:
    controller = sf.body_controller("unified", sf.walking_robot(multibody), (0.0, 0.0))
    control = sf.body_control(controller, multibody, "com-jacobian")
    height = float(control.limits["height"][0])
    found: list[tuple[float, ...]] = []
    knees = [int(leg["angle"]) for leg in find_leg_joints(multibody)]

    def watch(world: BodyWorld) -> None:
        control.limits["height"] = height * (1.12 if 1.0 < world.time < 3.0 else 1.0)
        sent = world.state.joints["sent"]
        bend = float(control.mechanics.position[knees].min())
        found.append((control.mechanics.com[2], bend, float(np.abs(sent[MOVING]).max())))

    standing = [(0.0, Steering(standing=True))]
    rollout = sf.simulate_body(control, 5.0, steering=standing, watch=watch)
    assert rollout.outcome is sf.Outcome.WALKED
    places, bends, rates = np.array(found).T
    assert bends.min() < 0.06
    assert places.max() > height + 0.04
    assert places[-1] == pytest.approx(height, abs=0.01)
    assert rates.max() < 0.6 * multibody.speed.min()


def test_a_state_that_is_no_number_leaves_the_servos_where_they_are(multibody: Multibody) -> None:
    mechanics, mapping = Mechanics(multibody), ComJacobian(multibody)
    reference, forces = random_reference(0, (1, 0)), np.array((600.0, 0.0))
    command, memory = mapping.joints(mechanics, reference, forces, {})
    sent = command.position.copy()
    mechanics.com[0] = np.nan
    command, after = mapping.joints(mechanics, reference, forces, memory)
    assert command.status < 1
    assert np.array_equal(command.position, sent)
    assert np.all(command.velocity == 0.0)
    assert np.all(command.torque == 0.0)
    assert np.all(command.stiffness > 0.0)
    assert np.array_equal(after["desired"], memory["desired"])


@pytest.fixture(scope="module")
def control(multibody: Multibody) -> sf.BodyControl:
    controller = sf.body_controller("unified", sf.walking_robot(multibody), (0.2, 0.0))
    return sf.body_control(controller, multibody, "com-jacobian")


def test_it_walks_on_its_estimate(control: sf.BodyControl) -> None:
    sent: list[NDArray[np.float64]] = []

    def watch(world: BodyWorld) -> None:
        sent.append(world.state.joints["sent"][SENT].copy())

    rollout = sf.simulate_body(control, 9.0, watch=watch)
    assert rollout.outcome is sf.Outcome.WALKED
    # No servo is sent further in a cycle than its joint can turn, by much.
    steps = [np.abs(after - before).max() for before, after in pairwise(sent)]
    assert max(steps) < 3.0 * control.multibody.speed.min() * 1e-3
    assert rollout.body is not None
    measures = sf.measure_body(rollout, rollout.body)
    assert measures.speed == pytest.approx((0.2, 0.0), abs=0.04)


def test_a_fork_goes_on_as_the_walk_does(control: sf.BodyControl) -> None:
    world = BodyWorld(control)
    world.steer(Steering((0.2, 0.0)))
    for _ in range(1500):
        world.observe()
        world.decide()
        world.act()
    other = world.fork()
    for _ in range(200):
        for one in (world, other):
            one.observe()
            one.decide()
            one.act()
    assert np.array_equal(world.state.joints["sent"], other.state.joints["sent"])
    assert world.state.walk["steps"][0] > 0


def test_it_walks_on_after_a_push(control: sf.BodyControl) -> None:
    push = sf.Push.of_impulse(0.3 * control.multibody.mass, (1.0, 0.0), start=4.0, duration=0.2)
    rollout = sf.simulate_body(control, 9.0, [push])
    assert rollout.outcome is sf.Outcome.RECOVERED


def test_a_mapping_that_is_not_there_is_refused(control: sf.BodyControl) -> None:
    with pytest.raises(sf.ParameterError, match=r"inverse-dynamics, .*com-jacobian") as error:
        sf.body_control(control.controller, control.multibody, "wishing")
    assert "'wishing'" in str(error.value)
    assert mapping_names()[0] == "inverse-dynamics"


def test_a_mapping_of_ones_own(control: sf.BodyControl) -> None:
    place = "surefoot.worlds.body.com_jacobian:ComJacobian"
    own = sf.body_control(control.controller, control.multibody, place)
    assert isinstance(own.mapping, ComJacobian)
