"""Playback of a finished walk: on a page with a slider for time, or as one file to send around."""

from __future__ import annotations

import html
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import viser

from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import FileError, SurefootError
from surefoot.live.page import let_time_pass, set_camera
from surefoot.live.panels import Layers, dock_panels, framed
from surefoot.live.run import REMEMBERED
from surefoot.live.stage import MakeFigure, Stage
from surefoot.live.story import SAMPLING, Sample, Story, sample_of
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot, snapshot_of
from surefoot.show.stances import (
    Commanded,
    acting_pushes,
    command_at,
    commanded,
    gait_at,
    heading_at,
)

PER_FRAME = 2
"""Scenes from one picture of a file to the next."""

_DOCUMENT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body{{margin:0;font-family:"DejaVu Sans",Verdana,sans-serif;color:#222;background:#f6f7f9}}
header{{padding:14px 22px;background:#fff;border-bottom:1px solid #dfe3e8}}
h1{{font-size:18px;margin:0 0 6px}} p{{margin:0;font-size:14px;line-height:1.45;max-width:110ch}}
iframe{{display:block;width:100%;height:68vh;min-height:380px;border:0;background:#fff}}
figure{{margin:18px auto;padding:0 16px;max-width:1200px}}
figure svg{{width:100%;height:auto;background:#fff}}
</style></head><body>
<header><h1>{title}</h1><p>{words}</p></header>
<iframe title="the walk in three dimensions" srcdoc="{scene}"></iframe>
<figure>{plots}</figure>
</body></html>
"""


@dataclass(frozen=True)
class Scenes:
    """A walk from its first cycle to its last, every 20 ms.

    Attributes:
        rollout: the walk.
        robot: the point mass that its controller planned for.
        cycles: of the scenes, shape (n,).
        sentences: what happens, one for each scene.
        samples: for the charts, likewise.
        durations: of a nominal step, likewise [s].
    """

    rollout: Rollout
    robot: Robot
    cycles: np.ndarray
    sentences: tuple[str, ...]
    samples: tuple[Sample, ...]
    durations: tuple[float, ...]

    def snapshot(self, scene: int) -> Snapshot:
        """What is drawn of it."""
        return snapshot_of(self.rollout, int(self.cycles[scene]))

    def at(self, time: float) -> int:
        """The last scene that is not later [s]."""
        times = self.rollout.time[self.cycles]
        return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)


def scenes_of(rollout: Rollout) -> Scenes:
    """The scenes of a walk, the last cycle among them."""
    robot = rollout.robot if rollout.body is None else rollout.body.believed
    times = np.arange(rollout.time[0], rollout.time[-1], SAMPLING)
    cycles = np.unique(np.append(np.searchsorted(rollout.time, times), len(rollout.time) - 1))
    commands, first = commanded(rollout), float(rollout.time[0])
    gait = _gait(rollout, robot, commands, first)
    story = Story(gait, rollout.robot, command_at(commands, first).velocity)
    pending = acting_pushes(rollout)
    sentences, samples, durations, before = [], [], [], 0
    for cycle in cycles:
        snapshot = snapshot_of(rollout, int(cycle))
        while pending and pending[0].start <= snapshot.time:
            push = pending.pop(0)
            before_it = max(int(np.searchsorted(rollout.time, push.start)) - 1, 0)
            story.pushed(push, snapshot_of(rollout, before_it))
        gait = _gait(rollout, robot, commands, snapshot.time)
        story.watch(snapshot, gait, command_at(commands, snapshot.time).velocity)
        if rollout.fallen and cycle == cycles[-1]:
            story.fell(rollout)
        sentences.append(story.sentence)
        durations.append(gait.step_duration)
        slowest = float(rollout.decision_time[before : cycle + 1].max())
        samples.append(sample_of(snapshot, slowest))
        before = int(cycle)
    of_scenes = tuple(sentences), tuple(samples), tuple(durations)
    return Scenes(rollout, robot, cycles, *of_scenes)


def _gait(rollout: Rollout, robot: Robot, commands: list[Commanded], time: float) -> NominalGait:
    """Nominal, for the velocity that was commanded at a time [s]; in place if it has none."""
    if rollout.body is None and heading_at(rollout, time) == 0.0:
        return gait_at(rollout, time) or nominal_gait(robot, (0.0, 0.0))
    try:
        return nominal_gait(robot, command_at(commands, time).velocity)
    except SurefootError:
        return nominal_gait(robot, (0.0, 0.0))


class ReplayPage:
    """A page that shows a finished walk.

    Args:
        server: of viser.
        scenes: the walk.
        figure: how it is drawn.
    """

    def __init__(self, server: viser.ViserServer, scenes: Scenes, figure: MakeFigure) -> None:
        self._server, self._scenes, self._lock = server, scenes, threading.Lock()
        set_camera(server)
        gui, times = server.gui, scenes.rollout.time
        self._sentence = gui.add_html(framed(scenes.sentences[0]))
        with gui.add_folder("Time"):
            self._at = round(float(times[0]), 2)
            last = self._at + SAMPLING * math.ceil((times[-1] - times[0]) / SAMPLING)
            self.time = gui.add_slider("time [s]", self._at, round(last, 2), SAMPLING, self._at)
            self.play = gui.add_button("Pause", hint="key: space")
            self.pace = gui.add_slider("speed [x]", 0.05, 2.0, 0.05, 1.0)
        self.playing, self._shown = True, -1
        # Every tab is sent the position of the slider; only one that moved it has an identity.
        self.time.on_update(
            lambda event: None if event.client_id is None else self._put(float(self.time.value))
        )
        self.play.on_click(lambda _: self._toggle())
        gui.add_command("pause", hotkey="space").on_trigger(lambda _: self._toggle())
        layers = Layers(gui)
        self.charts = dock_panels(server, "Up to now")
        self.stage = Stage(server.scene, layers.shown)
        self.stage.put(scenes.robot, figure, None)

    def _toggle(self) -> None:
        with self._lock:
            self.playing = not self.playing
            self.play.label = "Pause" if self.playing else "Play"

    def _put(self, at: float) -> None:
        with self._lock:
            self._at = at

    def serve(self, on: Callable[[], bool] = lambda: True) -> None:
        """Play; from the start again at the end.

        Args:
            on: asked before every picture whether to go on.
        """
        let_time_pass(self._go_on, self.draw, on)

    def _go_on(self, seconds: float) -> None:
        if not self.playing:
            return
        times = self._scenes.rollout.time
        with self._lock:
            at = self._at + seconds * float(self.pace.value)
            self._at = float(times[0]) if at > times[-1] else at
        self.time.value = round(SAMPLING * round(self._at / SAMPLING), 2)

    def draw(self) -> None:
        """Send what is under the slider to all tabs."""
        scenes, scene = self._scenes, self._scenes.at(float(self.time.value))
        if scene == self._shown:
            return
        with self._server.atomic():
            self.stage.show(scenes.snapshot(scene), None)
        self._shown = scene
        self._sentence.content = framed(
            scenes.sentences[scene], scenes.rollout.fallen and scene == len(scenes.cycles) - 1
        )
        if scene % 6 == 0 or not self.playing:
            first = max(scene - round(REMEMBERED / SAMPLING), 0)
            samples = scenes.samples[first : scene + 1]
            self.charts.show(samples, scenes.robot, scenes.durations[scene])


def write_page(
    server: viser.ViserServer,
    scenes: Scenes,
    figure: MakeFigure,
    title: str,
    plots: str,
    path: Path,
) -> None:
    """One file that plays the walk without a network.

    Args:
        server: of viser; nobody needs to look at it.
        scenes: the walk.
        figure: how it is drawn.
        title: of the page.
        plots: as SVG.
        path: file to write.

    Raises:
        FileError: it cannot be written.
    """
    set_camera(server)
    stage = Stage(server.scene, lambda _: True)
    stage.put(scenes.robot, figure, None)
    # It begins with its end, so that what is the same in all of it is said once after the start.
    stage.show(scenes.snapshot(len(scenes.cycles) - 1), None)
    recording = server.get_scene_serializer()
    for scene in range(0, len(scenes.cycles), PER_FRAME):
        recording.insert_sleep(PER_FRAME * SAMPLING)
        stage.show(scenes.snapshot(scene), None)
    recording.insert_sleep(1.0)
    document = _DOCUMENT.format(
        title=html.escape(title),
        words=html.escape(scenes.sentences[-1]),
        scene=html.escape(recording.as_html(), quote=True),
        plots=plots,
    )
    try:
        path.write_text(document, encoding="utf-8")
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error.strerror}", "choose another place"
        ) from error
