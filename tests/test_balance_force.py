"""Balance force control: the ground gives what the motion needs, and no limit is passed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import daqp
import numpy as np
import pytest
from numpy.typing import NDArray

import surefoot as sf
from body_states import assert_within_limits, mirrored, random_reference, random_state
from scaled_body import scaled_biped
from scales import Scale
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.balance_force import BalanceForce
from surefoot.worlds.body.gait import body_control, body_controller, walking_robot
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.inverse_dynamics import InverseDynamics
from surefoot.worlds.body.mapping import joint_mapping
from surefoot.worlds.body.mechanics import Mechanics
from surefoot.worlds.body.world import simulate_body

SEEDS = range(12)
NO_FORCES = np.zeros(2)


def command_of(
    mapping: BalanceForce | InverseDynamics, mechanics: Mechanics, reference: NDArray[np.void]
) -> JointCommand:
    return mapping.joints(mechanics, reference, NO_FORCES, {})[0]


def standing(mechanics: Mechanics, stands: tuple[int, int]) -> NDArray[np.void]:
    """The reference of a body that moves as little as it can: the ZMP below the CoM."""
    reference = np.zeros(1, BODY_REFERENCE)
    reference["stands"] = stands
    reference["zmp"], reference["com"] = mechanics.com[:2], mechanics.com
    reference["swing_foot"] = mechanics.sole_position[1 - stands.index(1)]
    return reference


@pytest.mark.parametrize("stands", [(1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_ground_gives_what_is_needed(
    multibody: Multibody, seed: int, stands: tuple[int, int]
) -> None:
    rng, mechanics = np.random.default_rng(seed), Mechanics(multibody)
    mapping = BalanceForce(multibody)
    reference = standing(mechanics, stands)
    reference["com_acceleration"] = rng.uniform(-0.3, 0.3, 3)
    if sum(stands) == 1:
        reference["zmp"] = mechanics.sole_position[stands.index(1), :2]
        reference["zmp"][0, 0] += rng.uniform(-0.03, 0.03)
    reference["trunk"] = rng.uniform(-0.01, 0.01, 3)
    command = command_of(mapping, mechanics, reference)
    answer = mapping.answer()
    weight = multibody.mass * multibody.robot.gravity
    lever = weight * multibody.robot.com_height
    assert command.status >= 1
    # Passive ankles of a standing foot are equalities; nothing else binds.
    count = 6 * sum(stands)
    rolls = sum(stands)
    assert np.abs(answer.multipliers[:count]).max() == 0.0
    assert np.abs(answer.multipliers[count + rolls :]).max() == 0.0
    vertical = multibody.mass * (reference["com_acceleration"][0, 2] + multibody.robot.gravity)
    assert answer.given[2] == pytest.approx(vertical, rel=1e-5)
    assert answer.given[3:5] == pytest.approx(answer.needed[3:5], abs=1e-4 * lever)
    if sum(stands) == 2:
        wanted = multibody.mass * reference["com_acceleration"][0, :2]
        assert answer.given[:2] == pytest.approx(wanted, abs=1e-4 * weight)
    else:
        x = -answer.wrenches[0, 4] / answer.wrenches[0, 2]
        side = stands.index(1)
        assert mechanics.sole_position[side, 0] + x == pytest.approx(
            reference["zmp"][0, 0], abs=1e-4
        )


def held_acceleration(mechanics: Mechanics, torque: NDArray[np.float64]) -> NDArray[np.float64]:
    """How a body accelerates whose soles are held by the ground, shape (nv,)."""
    multibody = mechanics.multibody
    nv = multibody.model.nv
    jacobian = mechanics.sole_jacobian.reshape(12, nv)
    effort = -mechanics.bias
    effort[multibody.motor_dofs] += torque
    matrix = np.block([[mechanics.inertia, -jacobian.T], [jacobian, np.zeros((12, 12))]])
    right = np.concatenate([effort, -mechanics.sole_drift.ravel()])
    found = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return np.array(found[:nv], np.float64)


@pytest.mark.parametrize("kind", [BalanceForce, InverseDynamics])
def test_a_stand_is_held(multibody: Multibody, kind: Any) -> None:
    """Torques of two soles are not unique, but what they do to the body is: nothing."""
    mechanics = Mechanics(multibody)
    command = command_of(kind(multibody), mechanics, standing(mechanics, (1, 1)))
    assert np.abs(held_acceleration(mechanics, command.torque)).max() < 0.02
    slack = held_acceleration(mechanics, 0.9 * command.torque)
    assert np.abs(slack).max() > 0.5


@pytest.mark.parametrize("stands", [(1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("seed", SEEDS)
def test_friction_soles_and_torques_are_respected(
    multibody: Multibody, seed: int, stands: tuple[int, int]
) -> None:
    mapping, mechanics = BalanceForce(multibody, friction=0.5), Mechanics(multibody)
    mechanics.update(*random_state(multibody, seed))
    reference = random_reference(seed, stands)
    reference["com_acceleration"] *= 5.0
    command = command_of(mapping, mechanics, reference)
    assert command.status >= 1
    # To the solver's tolerance, a millionth of the weight.
    assert_within_limits(multibody, mapping, mechanics, command.torque, 1e-3)


def test_a_passive_ankle_carries_no_moment(multibody: Multibody) -> None:
    mapping, mechanics = BalanceForce(multibody), Mechanics(multibody)
    mechanics.update(*random_state(multibody, 4))
    command = command_of(mapping, mechanics, random_reference(4, (1, 0)))
    (wrench,) = mapping.answer().wrenches
    axes, jacobian = mechanics.sole_axes[0], mechanics.sole_jacobian[0]
    given = jacobian[:3].T @ (axes @ wrench[:3]) + jacobian[3:].T @ (axes @ wrench[3:])
    roll = next(
        dof
        for dof in multibody.passive_dofs
        if dof >= 6 and np.abs(mechanics.sole_jacobian[0][:, dof]).any()
    )
    needed = np.zeros(multibody.model.nv)
    mechanics.forces(command.acceleration, needed)
    assert given[roll] == pytest.approx(needed[roll], abs=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_left_and_right_are_the_same(multibody: Multibody, seed: int) -> None:
    mechanics, reference = Mechanics(multibody), random_reference(seed, (1, 0))
    position, velocity = random_state(multibody, seed)
    mechanics.update(position, velocity)
    torque = command_of(BalanceForce(multibody), mechanics, reference).torque.copy()
    mirror = reference.copy()
    mirror["stands"] = (0, 1)
    for name in ("zmp", "com_acceleration", "swing_foot", "swing_foot_acceleration"):
        mirror[name][0, 1] *= -1.0
    mechanics.update(mirrored(multibody, position, False), mirrored(multibody, velocity, True))
    other = command_of(BalanceForce(multibody), mechanics, mirror).torque
    names = multibody.joint_names
    for number, name in enumerate(names):
        side, partner = ("left", "right") if name.startswith("left") else ("right", "left")
        sign = -1.0 if "roll" in name or "yaw" in name else 1.0
        expected = sign * torque[names.index(name.replace(side, partner))]
        assert other[number] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("size", [Scale(0.3, 0.027), Scale(2.0, 5.0)], ids=str)
@pytest.mark.parametrize("seed", range(4))
def test_robots_of_all_sizes_give_the_same_torques_in_their_units(
    multibody: Multibody, tmp_path: Path, size: Scale, seed: int
) -> None:
    other = sf.load_multibody(scaled_biped(tmp_path, size))
    position, velocity = random_state(multibody, seed)
    reference = random_reference(seed, (1, 0))
    mechanics = Mechanics(multibody)
    mechanics.update(position, velocity)
    torque = command_of(BalanceForce(multibody), mechanics, reference).torque.copy()
    position[:3] *= size.length
    velocity[:3] *= size.time
    velocity[3:] /= size.time
    for name in ("zmp", "swing_foot"):
        reference[name] *= size.length
    mechanics = Mechanics(other)
    mechanics.update(position, velocity)
    scaled = command_of(BalanceForce(other), mechanics, reference).torque
    assert scaled / size.torque == pytest.approx(torque, rel=1e-3, abs=1e-3)


def rising(multibody: Multibody, bend: float) -> Mechanics:
    """A body that stands on bent knees and rises."""
    mechanics, position = Mechanics(multibody), multibody.nominal.copy()
    velocity = np.zeros(multibody.model.nv)
    for number, name in enumerate(multibody.joint_names):
        if "knee" in name or ("pitch" in name and "hip" in name) or "ankle" in name:
            where, dof = multibody.motor_positions[number], multibody.motor_dofs[number]
            part = 1.0 if "knee" in name else -0.5
            position[where], velocity[dof] = part * bend, -part * 2.0
    mechanics.update(position, velocity)
    return mechanics


def test_a_knee_that_carries_is_kept_bent(multibody: Multibody) -> None:
    """The body is let fall rather than the legs straightened."""
    parts = []
    for bend in (0.13, 0.6):
        mechanics, mapping = rising(multibody, bend), BalanceForce(multibody)
        command_of(mapping, mechanics, standing(mechanics, (1, 1)))
        parts.append(mapping.answer().given[2] / (multibody.mass * multibody.robot.gravity))
    assert parts[0] < 0.8
    assert parts[1] == pytest.approx(1.0, abs=1e-4)


def test_the_paper_biped_walks(multibody: Multibody) -> None:
    controller = body_controller("unified", walking_robot(multibody), (0.3, 0.0))
    control = body_control(controller, multibody, "balance-force")
    assert isinstance(control.mapping, BalanceForce)
    rollout = simulate_body(control, 3.0)
    assert not rollout.fallen
    assert len(rollout.footsteps) >= 5
    assert rollout.body is not None
    assert rollout.body.solver.min() >= 1
    assert np.abs(rollout.body.base_turn[:, :2]).max() < np.radians(3.0)


class Fails(daqp.Model):
    """A solver that finds nothing."""

    def solve(self) -> Any:
        solution, value, _, about = super().solve()
        return np.full_like(solution, np.nan), value, -1, about


def test_the_last_torques_are_kept_if_the_solver_fails(multibody: Multibody) -> None:
    mapping, mechanics = BalanceForce(multibody), Mechanics(multibody)
    before = command_of(mapping, mechanics, standing(mechanics, (1, 1))).torque.copy()
    answer = mapping.answer()
    mapping._workspace.make = Fails
    command = command_of(mapping, mechanics, standing(mechanics, (1, 0)))
    assert command.status == -1
    assert np.abs(before).max() > 1.0
    assert command.torque.tolist() == before.tolist()
    assert mapping.answer().wrenches.tolist() == answer.wrenches.tolist()


def test_a_fresh_one_answers_alike(multibody: Multibody) -> None:
    mechanics, mapping = Mechanics(multibody), joint_mapping("balance-force", multibody)
    mechanics.update(*random_state(multibody, 1))
    reference = random_reference(1, (1, 0))
    first = mapping.joints(mechanics, reference, NO_FORCES, mapping.start())[0].torque.copy()
    again = mapping.fresh().joints(mechanics, reference, NO_FORCES, {})[0].torque
    assert again.tolist() == first.tolist()


@pytest.mark.parametrize(
    "wrong", [{"weights": {"hight": 1.0}}, {"stiffnesses": {"contact": 1.0}}], ids=str
)
def test_a_weight_that_is_not_known_is_refused(multibody: Multibody, wrong: dict[str, Any]) -> None:
    with pytest.raises(sf.ParameterError, match="one of"):
        BalanceForce(multibody, **wrong)


@pytest.mark.parametrize("seed", range(4))
def test_forces_are_those_of_the_inertia_matrix(multibody: Multibody, seed: int) -> None:
    rng, mechanics = np.random.default_rng(seed), Mechanics(multibody)
    mechanics.update(*random_state(multibody, seed))
    acceleration, out = rng.normal(size=multibody.model.nv), np.zeros(multibody.model.nv)
    mechanics.forces(acceleration, out)
    expected = mechanics.inertia @ acceleration + mechanics.bias
    assert out == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert multibody.model.dof_armature.max() > 0.0
