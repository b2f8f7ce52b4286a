"""What stands beside the scene: the sentence, the switches of what is drawn, and the charts."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from surefoot.live.marks import LAYERS
from surefoot.live.story import Sample
from surefoot.robot.robot import Robot
from surefoot.show import palette

PANEL = 340
"""Width of the panels at both sides [pixel]."""

HEIGHT = 178
"""Of a chart [pixel]."""


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
