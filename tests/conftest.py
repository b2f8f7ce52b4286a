"""What the tests share: presets, controllers, and the paper's push."""

from __future__ import annotations

import os
from dataclasses import dataclass

import pytest
from hypothesis import settings

import surefoot as sf

pytest.register_assert_rewrite("surefoot.conformance")

# Compiled kernels make the first example slow, and the machine may be busy: no deadlines.
settings.register_profile("surefoot", deadline=None, max_examples=60, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "surefoot"))


@dataclass(frozen=True)
class InPython:
    """A compiled controller that hides its kernel, so that a batch walks it in Python."""

    inner: sf.HybridController
    kernel: None = None

    def __getattr__(self, name: str):
        return getattr(self.inner, name)


PAPER_PUSH = sf.Push(start=1.1, duration=0.2, force=(176.0, 0.0))


@pytest.fixture(scope="session")
def robot() -> sf.Robot:
    return sf.load_robot("paper-biped")


@pytest.fixture(scope="session")
def robot_70kg(robot: sf.Robot) -> sf.Robot:
    """The paper's headline mass."""
    return robot.replace(mass=70.0)


@pytest.fixture(scope="session")
def pushed_walk(robot_70kg: sf.Robot) -> sf.Rollout:
    """The paper's push in the third step."""
    return sf.simulate(sf.HybridController(robot_70kg, (0.5, 0.0)), 6.0, [PAPER_PUSH])


@pytest.fixture(scope="session")
def multibody(robot: sf.Robot) -> sf.Multibody:
    """The mechanism of the paper's biped; nothing may change it."""
    return sf.load_multibody(robot)


@pytest.fixture(scope="session")
def body_control(multibody: sf.Multibody) -> sf.BodyControl:
    """The paper's biped in physics, with the unified controller at 0.3 m/s."""
    controller = sf.body_controller("unified", sf.walking_robot(multibody), (0.3, 0.0))
    return sf.body_control(controller, multibody)
