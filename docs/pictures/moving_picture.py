"""Film the live page for the README: a walk, a push, the recovery, and a second robot that falls.

Run: python docs/pictures/moving_picture.py docs/pictures/walk.gif
It needs the extras `live` and `plot`, Pillow, Playwright and a Chromium.
"""

from __future__ import annotations

import shutil
import sys
import textwrap
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import get_data_path
from PIL import Image, ImageDraw, ImageFont
from playwright.sync_api import sync_playwright

from surefoot.cli.live import figure_of, live_menu, make_walk
from surefoot.live.page import LivePage, page_server, stop, url_of
from surefoot.live.run import Choice, LiveRun
from surefoot.worlds.steering import Steering

CHOICE, VELOCITY = Choice(controller="unified", ghost="tracking"), (0.4, 0.0)
PUSHES = {0.8: (0.0, 60.0), 2.8: (90.0, 40.0)}
"""Time [s]: direction, counter-clockwise from forward [deg], and impulse [N s]."""

LASTS, SLOWER, FRAMES_PER_SECOND = 4.4, 2.0, 10
"""Length of the walk [s]; seconds of the film for one of the walk; pictures a second."""

WIDTH, HEIGHT, CAPTION = 640, 330, 56
"""Size of the picture, height of the sentence below it [pixel]."""

CAMERA, LOOK_AT = (1.2, -1.75, 0.8), (0.05, 0.2, 0.47)

SWITCHES = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Of a Chromium without a graphics card."""


def main(path: str) -> None:
    """Walk, push, film, write the GIF."""
    run = LiveRun(make_walk, CHOICE, Steering(VELOCITY))
    server = page_server("127.0.0.1", 8600)
    page = LivePage(server, run, figure_of, live_menu(CHOICE))
    server.initial_camera.position, server.initial_camera.look_at = CAMERA, LOOK_AT
    page.draw()
    with sync_playwright() as browsers:
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = browsers.chromium.launch(
            executable_path=chromium, args=[*SWITCHES, "--no-sandbox"]
        )
        tab = browser.new_page(viewport={"width": WIDTH + 700, "height": HEIGHT + 200})
        tab.goto(url_of(server))
        frames = film(tab, server, run, page)
        browser.close()
    stop(server)
    write(frames, Path(path))


def film(tab: Any, server: Any, run: LiveRun, page: LivePage) -> list[Image.Image]:
    """A picture of the scene, with the sentence of the page, for every frame."""
    while not server.get_clients():
        tab.wait_for_timeout(200)
    tab.wait_for_timeout(5000)
    (client,) = server.get_clients().values()
    frames, pending = [], dict(PUSHES)
    seconds = 1.0 / (FRAMES_PER_SECOND * SLOWER)
    for _ in range(round(LASTS / seconds)):
        for when in [when for when in pending if run.walk.time >= when]:
            direction, impulse = pending.pop(when)
            run.push(np.radians(direction), impulse)
        run.advance(seconds)
        page.draw()
        # The browser works while Playwright waits for it, and only then.
        picture = rendered(tab, client)
        frames.append(captioned(Image.fromarray(picture), run.sentence()))
    return frames


def rendered(tab: Any, client: Any) -> np.ndarray:
    """The picture of the tab after all updates."""
    found: list[np.ndarray] = []
    one = threading.Thread(
        target=lambda: found.append(
            client.get_render(HEIGHT, WIDTH, transport_format="png", timeout=120.0)
        )
    )
    one.start()
    while one.is_alive():
        tab.wait_for_timeout(20)
        time.sleep(0.001)
    return found[0]


def captioned(scene: Image.Image, words: str) -> Image.Image:
    """The scene above its sentence."""
    frame = Image.new("RGB", (WIDTH, HEIGHT + CAPTION), "white")
    frame.paste(scene, (0, 0), scene)
    font = ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", 15)
    text = "\n".join(textwrap.wrap(words, 76))
    ImageDraw.Draw(frame).multiline_text((14, HEIGHT + 9), text, "#222222", font, spacing=6)
    return frame


def write(frames: list[Image.Image], path: Path) -> None:
    """One palette for all frames, so that no colour flickers."""
    some = frames[:: max(len(frames) // 6, 1)]
    sheet = Image.new("RGB", (WIDTH, (HEIGHT + CAPTION) * len(some)))
    for row, frame in enumerate(some):
        sheet.paste(frame, (0, row * (HEIGHT + CAPTION)))
    # Maximum coverage keeps the few pixels of the colours that matter; floor and ghost are grey.
    colours = sheet.quantize(48, method=Image.Quantize.MAXCOVERAGE).getpalette() or []
    greys = [level for k in range(16) for level in [255 - 11 * k] * 3]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours[: 48 * 3] + greys)
    small = [frame.quantize(64, palette=palette, dither=Image.Dither.NONE) for frame in frames]
    small[0].save(
        path, save_all=True, append_images=small[1:], duration=1000 // FRAMES_PER_SECOND, loop=0
    )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "docs/pictures/walk.gif")
