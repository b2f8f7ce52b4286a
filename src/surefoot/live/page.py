"""The live page: a server on which everybody watches, pushes and steers the same walk.

Time passes here, in one loop; what changed is sent to each tab by a thread of its own, as fast as
the tab can take it: a slow one sees less and delays nothing.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import viser

from surefoot.live.controls import Controls, Menu
from surefoot.live.panels import dock_panels
from surefoot.live.run import LiveRun
from surefoot.live.server import look_from
from surefoot.live.stage import MakeFigure, Stage
from surefoot.worlds.world import World

FRAME = 1.0 / 30.0
"""Between two pictures [s]."""

MAX_BEHIND = 0.1
"""What a slow machine makes up for at most: beyond it the walk is slower than the clock [s]."""

CHART_FRAMES = 4
"""Pictures for one drawing of the charts."""

MakeFigureOf = Callable[[World], MakeFigure]
"""How a walk is drawn."""


class LivePage:
    """A page that shows a run.

    Args:
        server: of viser.
        run: what is shown.
        figure_of: how a walk is drawn.
        menu: what there is to choose from.
    """

    def __init__(
        self, server: viser.ViserServer, run: LiveRun, figure_of: MakeFigureOf, menu: Menu
    ) -> None:
        self._server, self._run, self._figure_of = server, run, figure_of
        look_from(server)
        self.controls = Controls(server.gui, run, menu, self._save)
        self.charts = dock_panels(server, "The last seconds")
        self.stage = Stage(server.scene, self.controls.layers.shown)
        self._cast, self._frame = -1, 0
        self._charted: float | None = None

    def serve(self, on: Callable[[], bool] = lambda: True) -> None:
        """Let time pass.

        Args:
            on: asked before every picture whether to go on.
        """
        run, last = self._run, time.monotonic()
        while on():
            now = time.monotonic()
            behind, last = min(now - last, MAX_BEHIND), now
            if not run.paused:
                run.advance(behind * run.pace)
            self.draw()
            time.sleep(max(FRAME - (time.monotonic() - now), 0.001))

    def draw(self) -> None:
        """Send the present to all tabs."""
        view, run = self._run.view(), self._run
        controller = view.walk.controller
        with self._server.atomic():
            if view.casts != self._cast:
                self._cast = view.casts
                ghost = None if view.ghost is None else self._figure_of(view.ghost)
                self.stage.cast(controller.robot, self._figure_of(view.walk), ghost)
            self.stage.show(view.seen, view.ghost_seen)
        self.controls.say()
        self._frame += 1
        latest = run.samples[-1].time if run.samples else None
        if self._frame % CHART_FRAMES == 0 and latest != self._charted:
            self._charted = latest
            self.charts.show(list(run.samples), controller.robot, controller.gait.step_duration)

    def _save(self, client: Any) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "walk.npz"
            self._run.rollout().save(path)
            client.send_file_download("walk.npz", path.read_bytes(), save_immediately=True)
