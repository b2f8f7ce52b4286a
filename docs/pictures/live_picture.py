"""The picture of docs/live.md: the page of `surefoot live` right after a push, with a ghost.

Run: python docs/pictures/live_picture.py docs/pictures/live.png

It needs the extras live and test, and a chromium to take the picture in.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

import surefoot as sf
from surefoot.cli.live import figure_of, live_menu, make_walk
from surefoot.live.page import LivePage, page_server, url_of
from surefoot.live.run import Choice, LiveRun

SIZE = {"width": 1400, "height": 860}
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
IMPULSE = 40.0
AFTER = 0.18
"""From the beginning of the push to the picture [s]."""

COLOURS = 255


def push_and_stop(run: LiveRun, page: LivePage) -> None:
    """Pause the walk during the push, so that a slow browser shows that moment."""
    run.paused = True
    while not 0.1 < run.walk.snapshot().observation["elapsed"] < 0.12:
        run.advance(0.01)
    run.push(0.0, IMPULSE)
    run.advance(AFTER)
    controller = run.walk.controller
    page.charts.show(list(run.samples), controller.robot, controller.gait.step_duration)


def take(tab: Page, path: Path) -> None:
    """The tab as a picture, without the notifications of the browser."""
    for button in tab.locator("[class*=Notification-closeButton]").all():
        button.click()
    tab.wait_for_timeout(8000)
    tab.screenshot(path=path)
    # The page has few colours: with a palette the file is a third of the size.
    Image.open(path).convert("RGB").quantize(COLOURS).save(path, optimize=True)


def main(path: str) -> None:
    """Walk, push, and take the picture."""
    choice, done = Choice(ghost="tracking"), threading.Event()
    run = LiveRun(make_walk, choice, sf.Steering((0.3, 0.0)))
    server = page_server("127.0.0.1", 8080)
    page = LivePage(server, run, figure_of, live_menu(choice))
    clock = threading.Thread(target=page.serve, args=(lambda: not done.is_set(),))
    clock.start()
    browser_path = shutil.which("chromium") or shutil.which("chromium-browser")
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=browser_path, args=FLAGS)
            tab = browser.new_page(viewport=SIZE)
            tab.goto(url_of(server))
            tab.get_by_role("button", name="Push", exact=True).wait_for(timeout=60_000)
            while run.walk.time < 6.0:
                time.sleep(0.05)
            push_and_stop(run, page)
            take(tab, Path(path))
            browser.close()
    finally:
        done.set()
        clock.join()
        server.stop()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "docs/pictures/live.png")
