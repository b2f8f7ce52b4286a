"""What a person can do on the page: push, steer, choose, look; every tab has the same."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from surefoot.live.panels import Layers, framed
from surefoot.live.run import LARGEST_IMPULSE, Choice, LiveRun
from surefoot.worlds.steering import Steering

PAD = (("↖", "↑", "↗"), ("←", "→"), ("↙", "↓", "↘"))
"""The push pad: where it pushes, up is forward."""

ANGLES = {"↑": 0, "↖": 45, "←": 90, "↙": 135, "↓": 180, "↘": -135, "→": -90, "↗": -45}
"""Of the pad, counter-clockwise from forward [deg]."""

KEYS = {"I": "↑", "J": "←", "K": "↓", "L": "→"}
"""As arrow keys; those turn the camera."""

FIRST_PUSH = 0.5
"""Where the slider begins, for the robot's mass [m/s]."""

NO_GHOST = "none"


@dataclass(frozen=True)
class Menu:
    """What there is to choose from.

    Attributes:
        robots: presets and files.
        controllers: keys of methods, by simulator.
        simulators: names.
    """

    robots: Sequence[str]
    controllers: Mapping[str, Sequence[str]]
    simulators: Sequence[str]


class Controls:
    """The panel at the left.

    Args:
        gui: of viser.
        run: what is controlled.
        menu: what there is to choose from.
        save: called with the client that asks for the walk as a file.
    """

    def __init__(self, gui: Any, run: LiveRun, menu: Menu, save: Callable[[Any], None]) -> None:
        self._run, self._menu, self._lock = run, menu, threading.RLock()
        self._setting = False
        self._sentence = gui.add_html(framed(run.sentence()))
        self._said = ""
        self._push(gui)
        self._steer(gui)
        self._time(gui, save)
        self._choose(gui)
        self.layers = Layers(gui)

    def say(self) -> None:
        """Show what happens, if it is not what is shown already."""
        words, fallen = self._run.sentence(), self._run.walk.fallen
        notice = self._run.notice
        content = framed(words, fallen, notice)
        if content != self._said:
            self._sentence.content = self._said = content

    def _push(self, gui: Any) -> None:
        run = self._run
        with gui.add_folder("Push it"):
            self.impulse = gui.add_slider(
                "impulse [N s]", 0.0, LARGEST_IMPULSE, 1.0, _first_push(run),
                hint="of a push of 0.2 s; the force is five times that, in N",
            )  # fmt: skip
            self.angle = gui.add_slider(
                "direction [deg]", -180.0, 180.0, 5.0, 0.0,
                hint="counter-clockwise from forward: 90 is to the left",
            )  # fmt: skip
            for row in PAD:
                pad = gui.add_button_group(" " if row is not PAD[0] else "push now", row)
                pad.on_click(lambda event: self._push_towards(ANGLES[event.target.value]))
            button = gui.add_button("Push", color="yellow", icon=None, hint="key: P")
            button.on_click(lambda _: self._push_towards(self.angle.value))
        for key, arrow in KEYS.items():
            command = gui.add_command(f"push {arrow}", hotkey=key)
            command.on_trigger(lambda _, arrow=arrow: self._push_towards(ANGLES[arrow]))
        gui.add_command("push", hotkey="P").on_trigger(
            lambda _: self._push_towards(self.angle.value)
        )
        gui.add_command("reset", hotkey="R").on_trigger(lambda _: run.reset())

    def _push_towards(self, degrees: float) -> None:
        self._run.push(math.radians(degrees), float(self.impulse.value))

    def _steer(self, gui: Any) -> None:
        start = self._run.steering
        with gui.add_folder("Steer it"):
            self.forward = gui.add_slider(
                "forward [m/s]", -0.6, 0.8, 0.05, _within(start.velocity[0], -0.6, 0.8)
            )
            self.left = gui.add_slider(
                "left [m/s]", -0.3, 0.3, 0.05, _within(start.velocity[1], -0.3, 0.3)
            )
            self.turning = gui.add_slider(
                "turn left [rad/s]", -0.6, 0.6, 0.05, _within(start.turning, -0.6, 0.6)
            )
        for slider in (self.forward, self.left, self.turning):
            slider.on_update(lambda _: self._steered())

    def _steered(self) -> None:
        with self._lock:
            if not self._setting:
                velocity = (float(self.forward.value), float(self.left.value))
                self._run.steer(Steering(velocity, float(self.turning.value)))
                if self._run.notice:
                    self._set(self._run.choice, self._run.steering)

    def _time(self, gui: Any, save: Callable[[Any], None]) -> None:
        run = self._run
        with gui.add_folder("Time"):
            self.pause = gui.add_button("Pause", hint="key: space")
            self.pause.on_click(lambda _: self._paused())
            step = gui.add_button("Single step", hint="one control cycle, 1 ms; key: N")
            step.on_click(lambda _: self._stepped())
            self.pace = gui.add_slider("speed [x]", 0.05, 1.0, 0.05, 1.0, hint="slow motion")
            self.pace.on_update(lambda _: setattr(run, "pace", float(self.pace.value)))
            gui.add_button("Reset", hint="key: R").on_click(lambda _: run.reset())
            gui.add_button("Save the last minute", hint="for surefoot replay").on_click(
                lambda event: save(event.client)
            )
        gui.add_command("pause", hotkey="space").on_trigger(lambda _: self._paused())
        gui.add_command("single step", hotkey="N").on_trigger(lambda _: self._stepped())

    def _paused(self) -> None:
        with self._lock:
            self._run.paused = not self._run.paused
            self.pause.label = "Go on" if self._run.paused else "Pause"

    def _stepped(self) -> None:
        with self._lock:
            self._run.paused, self.pause.label = True, "Go on"
        self._run.advance(self._run.walk.controller.period)

    def _choose(self, gui: Any) -> None:
        choice, menu = self._run.choice, self._menu
        with gui.add_folder("Who walks"):
            self.robot = gui.add_dropdown("robot", tuple(menu.robots), initial_value=choice.robot)
            self.simulator = gui.add_dropdown(
                "simulator", tuple(menu.simulators), initial_value=choice.simulator,
                hint="lipm: the point mass; mujoco: the body in physics",
            )  # fmt: skip
            keys = tuple(menu.controllers[choice.simulator])
            self.controller = gui.add_dropdown("controller", keys, initial_value=choice.controller)
            self.ghost = gui.add_dropdown(
                "ghost", (NO_GHOST, *keys), initial_value=choice.ghost or NO_GHOST,
                hint="a second controller beside it, under the same pushes",
            )  # fmt: skip
        for one in (self.robot, self.simulator, self.controller, self.ghost):
            one.on_update(lambda _: self._chosen())

    def _chosen(self) -> None:
        with self._lock:
            if self._setting:
                return
            keys, ghost = self._menu.controllers[self.simulator.value], self.ghost.value
            choice = Choice(
                self.robot.value,
                self.controller.value if self.controller.value in keys else keys[-1],
                ghost if ghost in keys else "",
                self.simulator.value,
            )
            before = self._run.choice
            if choice != before:
                self._run.choose(choice)
                self._set(self._run.choice, self._run.steering)
            if self._run.choice.robot != before.robot:
                self.impulse.value = _first_push(self._run)

    def _set(self, choice: Choice, steering: Steering) -> None:
        """Show who walks and where to: not who was asked for, if that could not be."""
        keys = tuple(self._menu.controllers[choice.simulator])
        # What is set here calls back as if a person had set it.
        self._setting = True
        try:
            self.robot.value, self.simulator.value = choice.robot, choice.simulator
            if keys != tuple(self.controller.options):
                self.controller.options, self.ghost.options = keys, (NO_GHOST, *keys)
            self.controller.value, self.ghost.value = choice.controller, choice.ghost or NO_GHOST
            for slider, value in zip(
                (self.forward, self.left, self.turning),
                (*steering.velocity, steering.turning),
                strict=True,
            ):
                slider.value = _within(value, slider.min, slider.max)
        finally:
            self._setting = False


def _first_push(run: LiveRun) -> float:
    return float(round(FIRST_PUSH * run.walk.robot.mass))


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
