"""Sensors of a body that fail for a moment, and their noise: no robot falls or lands over that."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pytest

import body_motion as motions
import surefoot as sf
from surefoot.record import new_array
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.estimator import SETTINGS, BodyEstimator, BodyReadings
from surefoot.worlds.body.readings import DOUBTS, take_forces

INSTANTS = (1500, 2010, 2530, 3060, 3575)
"""Cycles in which a sensor fails, at different parts of a step."""

FAULTS = {
    "gyro": (0, 30.0),
    "accelerometer": (2, 1000.0),
    "joint_angles": (3, 1.0),
    "joint_velocities": (2, 300.0),
    "foot_force": (0, 1e5),
}
"""Which reading of each sensor fails, and by how much, SI."""


@dataclass(frozen=True)
class Faulty:
    """Usual sensors, one of which fails for some cycles, again and again."""

    usual: sf.BodyNoise
    channel: str
    index: int
    size: float
    cycles: int

    def start(self) -> Any:
        return 0, self.usual.start()

    def step(self, memory: Any, senses: BodyReadings) -> tuple[BodyReadings, Any]:
        cycle, inner = memory
        told, inner = self.usual.step(inner, senses)
        if any(first <= cycle < first + self.cycles for first in INSTANTS):
            values = getattr(told, self.channel).copy()
            values[self.index] += self.size
            told = told._replace(**{self.channel: values})
        return told, (cycle + 1, inner)


@pytest.mark.parametrize(
    ("channel", "sign", "cycles"), list(product(FAULTS, (1.0, -1.0), (1, 3))), ids=str
)
def test_a_reading_that_nothing_explains_is_left_out(
    body_control: sf.BodyControl, channel: str, sign: float, cycles: int
) -> None:
    index, size = FAULTS[channel]
    noise = Faulty(
        sf.BodyNoise.of(body_control.multibody.robot), channel, index, sign * size, cycles
    )
    rollout = sf.simulate_body(body_control, 4.6, noise=noise)
    assert not rollout.fallen
    assert rollout.body is not None
    assert sf.measure_body(rollout, rollout.body).estimate["dcm"] < 0.004
    assert 10 <= len(rollout.footsteps) <= 12


def test_a_force_that_may_be_one_is_no_landing_in_the_air(body_control: sf.BodyControl) -> None:
    """As strong as a landing, on both feet in turn: whichever swings is high, or about to land."""
    weight = body_control.multibody.mass * 9.81
    usual = sf.simulate_body(body_control, 4.6)
    for foot, cycles in ((0, 1), (1, 3)):
        noise = Faulty(
            sf.BodyNoise.of(body_control.multibody.robot), "foot_force", foot, weight, cycles
        )
        rollout = sf.simulate_body(body_control, 4.6, noise=noise)
        assert not rollout.fallen
        assert abs(len(rollout.footsteps) - len(usual.footsteps)) <= 1


def turning_motion(multibody: Multibody, rate: float) -> motions.Motion:
    """A robot that suddenly rolls at a rate [rad/s], with no foot on the ground from then on."""
    qpos = np.tile(multibody.nominal, (400, 1))
    angle = rate * motions.PERIOD * np.maximum(np.arange(400) - 199, 0)
    qpos[:, 3], qpos[:, 4] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    height = multibody.nominal[2]
    qpos[:, 1], qpos[:, 2] = -height * np.sin(angle), height * np.cos(angle)
    feet = np.ones((400, 2), np.int64)
    feet[199:] = 0
    motion = motions.sensed(qpos, feet)
    return motions.Motion(
        motion.qpos, motion.qvel, 0.0 * motion.expected, motion.feet, motion.senses
    )


@pytest.mark.parametrize("rate", [3.0, -3.0])
def test_a_turn_that_lasts_is_believed(multibody: Multibody, rate: float) -> None:
    """Nothing foresaw it; until it is believed its readings are kept, and then made up for."""
    motion = turning_motion(multibody, rate)
    found = motions.estimate(BodyEstimator(multibody), motion)
    late = np.abs(found.qvel[:, 3] - motion.qvel[:, 3])
    assert (late[200 : 200 + DOUBTS] > 2.0).all(), "too sudden to be believed at once"
    assert late[200 + DOUBTS : 230].max() < 0.1
    tilt = 2.0 * (found.qpos[220, 4] - motion.qpos[220, 4])
    assert abs(tilt) < 0.002


def settings_of(force: float) -> Any:
    settings = new_array(SETTINGS)
    settings["base"]["force"], settings["jerk"]["force"] = force, 1e4
    return settings[0]


def test_noise_alone_makes_no_load(multibody: Multibody) -> None:
    """Its bound is 3e-9 a cycle; a fifth of the evidence comes in 2 % of the cycles at most."""
    draw = np.random.default_rng(5)
    readings = np.maximum(20.0 * draw.standard_normal((200_000, 2)), 0.0)
    base = BodyEstimator(multibody).start(resting(multibody)).base[0]
    settings, most = settings_of(20.0), 0.0
    often = 0
    for force in readings:
        take_forces(settings, base, force)
        assert not base["load"].any()
        most, often = max(most, base["evidence"].max()), often + (base["evidence"] > 40.0).sum()
    assert most > 40.0, "it was noise"
    assert often / readings.size < np.exp(-1.95 * 2.0)


@pytest.mark.parametrize(("force", "cycles"), [(12.0, 1), (6.5, 2), (5.0, 3), (3.5, 4)])
def test_a_load_is_believed_the_sooner_the_larger_it_is(
    multibody: Multibody, force: float, cycles: int
) -> None:
    """In standard deviations of the noise that the filter is told."""
    base, settings = BodyEstimator(multibody).start(resting(multibody)).base[0], settings_of(1.0)
    for cycle in range(cycles):
        take_forces(settings, base, np.array([force, 0.0]))
        assert base["load"][0] == (force if cycle == cycles - 1 else 0.0)
    assert base["load"][1] == 0.0


def resting(multibody: Multibody) -> BodyReadings:
    still = np.tile(multibody.nominal, (1, 1))
    return motions.sensed(still, np.ones((1, 2), np.int64)).senses[0]


@pytest.mark.parametrize("part", [0.02, 0.05])
def test_noise_of_the_soles_ends_no_step(body_control: sf.BodyControl, part: float) -> None:
    """Of two and five hundredths of the weight; three hundredths once were a landing."""
    weight = body_control.multibody.mass * 9.81
    rollout = sf.simulate_body(body_control, 6.0, noise=sf.BodyNoise(force=part * weight))
    assert rollout.outcome is sf.Outcome.WALKED
    assert 13 <= len(rollout.footsteps) <= 15


def test_steps_on_noise_are_no_walk(body_control: sf.BodyControl) -> None:
    """An estimator that is told of less noise than there is takes it for landings."""
    multibody = body_control.multibody
    noise = sf.BodyNoise(force=0.1 * multibody.mass * 9.81)
    rollout = sf.simulate_body(body_control, 7.0, noise=noise, estimator=BodyEstimator(multibody))
    assert not rollout.fallen
    assert rollout.held_speed is not None
    assert not rollout.held_speed.is_held
    assert rollout.outcome is sf.Outcome.UNSETTLED


def test_the_noise_of_a_robot_is_that_of_its_load_cells(multibody: Multibody) -> None:
    weight = multibody.mass * multibody.robot.gravity
    noise = sf.BodyNoise.of(multibody.robot, seed=4)
    assert noise.force == pytest.approx(0.003 * weight)
    assert (noise.seed, noise.gyro) == (4, sf.BodyNoise().gyro)
    assert sf.BodyNoise.of(multibody.robot, force=7.0).force == 7.0
    assert BodyEstimator(multibody).force == pytest.approx(0.003 * weight)
