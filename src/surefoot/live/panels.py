"""What stands beside the scene: what a person can do, the sentence, the legend and the charts."""

from __future__ import annotations

import html
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import viser
from viser import uplot

from surefoot.live.run import LARGEST_IMPULSE, Choice, LiveRun
from surefoot.live.stage import LAYERS
from surefoot.live.story import Sample
from surefoot.robot.robot import Robot
from surefoot.show import palette
from surefoot.worlds.steering import Steering

PANEL = 340
"""Width of the panels at both sides [pixel]."""

HEIGHT = 178
"""Of a chart [pixel]."""

PAD = (("↖", "↑", "↗"), ("←", "→"), ("↙", "↓", "↘"))
"""The push pad: where it pushes, up is forward."""

ANGLES = {"↑": 0, "↖": 45, "←": 90, "↙": 135, "↓": 180, "↘": -135, "→": -90, "↗": -45}
"""Of the pad, counter-clockwise from forward [deg]."""

KEYS = {"I": "↑", "J": "←", "K": "↓", "L": "→"}
"""As arrow keys; those turn the camera."""

STEERING = (("forward [m/s]", 0.6, 0.8), ("left [m/s]", 0.3, 0.3), ("turn left [rad/s]", 0.6, 0.6))
"""Sliders, and how far each goes back and ahead."""

FIRST_PUSH = 0.5
"""Where the slider begins, for the robot's mass [m/s]."""

NO_GHOST = "none"


class Charts:
    """Four charts of the last seconds: DCM and ZMP with the sole's bounds, step and decision times.

    Args:
        gui: of viser, with the panel they are to be in as its container.
    """

    def __init__(self, gui: Any) -> None:
        bounds = (_line("sole", palette.QUIET, (4, 3)), _line("", palette.QUIET, (4, 3)))
        points = (_line("DCM", palette.DCM), _line("ZMP", palette.ZMP), *bounds)
        self._along = self._chart(gui, "forward of the standing sole [m]", points)
        self._across = self._chart(gui, "left of the standing sole [m]", points)
        self._steps = self._chart(
            gui, "planned duration of the step [s]",
            (_line("planned", palette.DCM_PLAN), _line("nominal", palette.QUIET, (4, 3))),
        )  # fmt: skip
        self._times = self._chart(
            gui, "longest decision in 20 ms [ms]", (_line("decision", palette.COM),)
        )

    @staticmethod
    def _chart(gui: Any, title: str, lines: tuple[Any, ...]) -> Any:
        start = np.array([0.0, 1.0])
        return gui.add_uplot(
            data=(start, *(np.zeros(2) for _ in lines)),
            series=(uplot.Series(label="t [s]"), *lines),
            title=title,
            scales={"x": uplot.Scale(time=False)},
            axes=(uplot.Axis(size=26), uplot.Axis(size=48)),
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(show=False),
            height=HEIGHT,
            padding=(10, 18, 0, 0),
        )

    def show(self, samples: Sequence[Sample], robot: Robot, nominal: float) -> None:
        """Draw the last seconds.

        Args:
            samples: in order of time.
            robot: whose sole bounds the ZMP.
            nominal: duration of a step [s].
        """
        if len(samples) < 2:
            return
        time = np.array([one.time for one in samples])
        dcm = np.array([one.dcm for one in samples])
        zmp = np.array([one.zmp for one in samples])
        for axis, chart in enumerate((self._along, self._across)):
            edge = np.full(len(time), robot.foot.half[axis])
            # A walk in the air has no ZMP; a chart has no gaps.
            there = np.nan_to_num(zmp[:, axis])
            chart.data = (time, dcm[:, axis], there, edge, -edge)
        planned = np.array([one.step_duration for one in samples])
        self._steps.data = (time, planned, np.full(len(time), nominal))
        self._times.data = (time, 1e3 * np.array([one.decision_time for one in samples]))


def dock_panels(server: viser.ViserServer, title: str) -> Charts:
    """The page's own panel at the left, and the charts in one at the right."""
    gui = server.gui
    gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=False)
    gui.main_panel.dock_left()
    gui.main_panel.set_width(PANEL)
    panel = gui.add_panel()
    with panel.add_tab(title):
        charts = Charts(gui)
    panel.dock_right()
    panel.set_width(PANEL)
    return charts


def _line(label: str, colour: str, dash: tuple[float, ...] | None = None) -> Any:
    line = uplot.Series(label=label, stroke=colour, width=1.6)
    if dash is not None:
        line["dash"] = dash
        line["width"] = 1.0
    return line


def framed(words: str, fallen: bool = False, notice: str = "") -> str:
    """The sentence, large; red if it fell.

    Args:
        words: what happens.
        fallen: whether that is the end of it.
        notice: what could not be done; may be empty.
    """
    colour = palette.ALARM if fallen else palette.DCM
    more = f'<div style="color:#8a5a00;margin-top:6px">{html.escape(notice)}</div>'
    return (
        f'<div role="status" aria-live="polite" id="surefoot-sentence" '
        f'style="border-left:4px solid {colour};padding:6px 10px;margin:2px 8px 8px;'
        f'font-size:14px;line-height:1.4;min-height:4.2em">{html.escape(words)}'
        f"{more if notice else ''}</div>"
    )


class Layers:
    """The legend of the scene, and a switch for each of its layers.

    Args:
        gui: of viser.
    """

    def __init__(self, gui: Any) -> None:
        self._switches: dict[str, Any] = {}
        with gui.add_folder("What is drawn"):
            gui.add_html(_legend())
            for layer in LAYERS:
                switch = gui.add_checkbox(layer.label, True, hint=layer.meaning)
                self._switches[layer.key] = switch

    def shown(self, key: str) -> bool:
        """Whether a layer is switched on."""
        return bool(self._switches[key].value)


def _legend() -> str:
    rows = "".join(
        f"<div>{_dot(layer.colour)} <b>{layer.label}</b>: {html.escape(layer.meaning)}</div>"
        for layer in LAYERS
    )
    return f'<div style="font-size:12px;line-height:1.5;padding:0 10px 6px">{rows}</div>'


def _dot(colour: str) -> str:
    """A dot of this colour for HTML."""
    return f'<span style="color:{colour};font-size:1.15em">&#9679;</span>'


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
            _on_key(gui, key, f"push {arrow}", partial(self._push_towards, ANGLES[arrow]))
        _on_key(gui, "P", "push", lambda: self._push_towards(self.angle.value))
        _on_key(gui, "R", "reset", run.reset)

    def _push_towards(self, degrees: float) -> None:
        self._run.push(math.radians(degrees), float(self.impulse.value))

    def _steer(self, gui: Any) -> None:
        start = self._run.steering
        with gui.add_folder("Steer it"):
            self.sliders = [
                gui.add_slider(label, -back, ahead, 0.05, _within(value, -back, ahead))
                for (label, back, ahead), value in zip(STEERING, _values(start), strict=True)
            ]
        for slider in self.sliders:
            slider.on_update(lambda _: self._steered())

    def _steered(self) -> None:
        with self._lock:
            if not self._setting:
                forward, left, turning = (float(slider.value) for slider in self.sliders)
                self._run.steer(Steering((forward, left), turning))
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
        _on_key(gui, "space", "pause", self._paused)
        _on_key(gui, "N", "single step", self._stepped)

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
            for slider, value in zip(self.sliders, _values(steering), strict=True):
                slider.value = _within(value, slider.min, slider.max)
        finally:
            self._setting = False


def _first_push(run: LiveRun) -> float:
    return float(round(FIRST_PUSH * run.walk.robot.mass))


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _values(steering: Steering) -> tuple[float, float, float]:
    """Of the sliders."""
    return (*steering.velocity, steering.turning)


def _on_key(gui: Any, key: str, label: str, action: Callable[[], None]) -> None:
    gui.add_command(label, hotkey=key).on_trigger(lambda _: action())
