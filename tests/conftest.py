"""What the tests share: presets, controllers, and the paper's push."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from hypothesis import settings
from playwright.sync_api import Browser, Page, sync_playwright

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


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A real one."""
    found = shutil.which("chromium") or shutil.which("chromium-browser")
    if found is None:
        pytest.fail("pages are tested in a browser; run: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A page in it, whose scripts may not fail."""
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
    yield page
    page.close()
    assert wrong == []
