"""The live page in a real browser: what a person does on it reaches the walk, and is told."""

from __future__ import annotations

import shutil
import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from urllib.parse import urlsplit

import pytest
import viser
from playwright.sync_api import Browser, Page, expect, sync_playwright

import surefoot as sf
from surefoot.cli.live import figure_of, live_menu, make_walk
from surefoot.errors import ParameterError
from surefoot.live import page as live_page
from surefoot.live.page import LivePage, page_server, stop, url_of
from surefoot.live.run import Choice, LiveRun

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")

FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
"""Graphics without a graphics card."""

PATIENCE = 60_000
"""Such graphics are slow on a busy machine [ms]."""

SIZE = {"width": 800, "height": 320}

SENTENCE = "#surefoot-sentence"


@dataclass(frozen=True)
class Live:
    """A page that is served."""

    run: LiveRun
    page: LivePage
    url: str


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = page_server("127.0.0.1", 8123)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def live(server: viser.ViserServer) -> Iterator[Live]:
    choice, on = Choice(), threading.Event()
    run = LiveRun(make_walk, choice, sf.Steering((0.3, 0.0)))
    page = LivePage(server, run, figure_of, live_menu(choice))
    # Fewer pictures than a person gets: a browser without a graphics card would lag behind.
    patch = pytest.MonkeyPatch()
    patch.setattr(live_page, "FRAME", 0.1)
    on.set()
    clock = threading.Thread(target=page.serve, args=(on.is_set,))
    clock.start()
    yield Live(run, page, url_of(server))
    on.clear()
    clock.join()
    patch.undo()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if BROWSER is None:
        pytest.fail("the page is tested in a browser; run: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def requests() -> list[str]:
    """All that any tab has asked for."""
    return []


@pytest.fixture(scope="module")
def open_tab(browser: Browser, live: Live, requests: list[str]) -> Callable[[], Page]:
    def opened() -> Page:
        tab = browser.new_page(viewport=SIZE)
        tab.set_default_timeout(PATIENCE)
        tab.on("request", lambda request: requests.append(request.url))
        tab.goto(live.url)
        expect(tab.locator(SENTENCE)).to_contain_text("m/s", timeout=PATIENCE)
        return tab

    return opened


@pytest.fixture(scope="module")
def tab(open_tab: Callable[[], Page]) -> Page:
    """The one that most tests share: loading it takes longest."""
    return open_tab()


@pytest.fixture(autouse=True)
def walking(live: Live) -> None:
    """Every test begins with the same walk."""
    live.run.paused = False
    live.run.steer(sf.Steering((0.3, 0.0)))
    live.run.choose(Choice())


def wait_until(holds: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + 1e-3 * PATIENCE
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.02)


def says(tab: Page, words: str) -> None:
    expect(tab.locator(SENTENCE)).to_contain_text(words, timeout=PATIENCE)


def choose(tab: Page, label: str, option: str) -> None:
    tab.get_by_label(label, exact=True).first.click()
    tab.get_by_role("option", name=option, exact=True).click()


def test_a_push_moves_the_next_landing(live: Live, tab: Page) -> None:
    says(tab, "Walking: 0.3 m/s forward")
    tab.get_by_role("button", name="Push", exact=True).click()
    says(tab, "Pushed 34 N s forward")
    says(tab, "m further forward")
    wait_until(lambda: "back in its gait" in live.run.sentence(), "it does not recover")
    steps = [step.step[0] for step in live.run.rollout().footsteps]
    assert max(steps) - min(steps) > 0.05


def test_a_key_pushes(live: Live, tab: Page) -> None:
    tab.locator(SENTENCE).click()
    tab.keyboard.press("i")
    says(tab, "Pushed 34 N s forward")
    assert live.run.rollout().pushes[-1].impulse == pytest.approx((34.0, 0.0), abs=1e-9)


def test_the_pad_pushes_where_it_points(live: Live, tab: Page) -> None:
    tab.get_by_text("←", exact=True).first.click()
    says(tab, "Pushed 34 N s left")
    assert live.run.rollout().pushes[-1].impulse[1] == pytest.approx(34.0, abs=1e-9)


def test_it_walks_as_fast_as_the_slider_says(live: Live, tab: Page) -> None:
    number = "//label[starts-with(., 'forward')]/following::input[@inputmode='decimal'][1]"
    tab.locator(number).fill("0.5")
    tab.locator(number).press("Enter")
    says(tab, "Walking: 0.5 m/s forward")
    assert live.run.steering.velocity == (0.5, 0.0)


def test_another_controller_walks(live: Live, tab: Page) -> None:
    choose(tab, "controller", "hybrid")
    wait_until(lambda: live.run.choice.controller == "hybrid", "it is not chosen")
    assert type(live.run.walk.controller) is sf.HybridController


def test_no_controller_is_left_that_physics_does_not_have(live: Live, tab: Page) -> None:
    """One that leans its trunk is of the point mass alone: the menu moves on by itself."""
    choose(tab, "controller", "ankle-hip-step-mpc")
    wait_until(lambda: live.run.choice.controller == "ankle-hip-step-mpc", "it is not chosen")
    choose(tab, "simulator", "mujoco")
    wait_until(lambda: live.run.choice.simulator == "mujoco", "the panel hangs")
    assert live.run.choice.controller == "unified"
    wait_until(lambda: live.page.controls.controller.value == "unified", "the menu tells another")
    wait_until(lambda: live.run.walk.time > 0.5, "the body does not walk")
    choose(tab, "simulator", "lipm")
    wait_until(lambda: live.run.choice.simulator == "lipm", "the panel hangs")


def test_time_stands_still_and_goes_on(live: Live, tab: Page) -> None:
    tab.get_by_role("button", name="Pause", exact=True).click()
    wait_until(lambda: live.run.paused, "it does not pause")
    with_time = live.run.walk.time
    tab.get_by_role("button", name="Single step", exact=True).click()
    wait_until(lambda: live.run.walk.time > with_time, "it makes no step")
    assert live.run.walk.time <= with_time + 1.001 * live.run.walk.controller.period
    tab.get_by_role("button", name="Go on", exact=True).click()
    wait_until(lambda: live.run.walk.time > with_time + 0.1, "it does not go on")


def test_the_walk_is_saved(tab: Page, live: Live) -> None:
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Save the last minute").click()
    rollout = sf.load_rollout(
        download.value.path().rename(download.value.path().with_suffix(".npz"))
    )
    assert rollout.robot.name == "paper-biped"
    assert len(rollout.time) > 0


def test_tabs_come_and_go(live: Live, tab: Page, open_tab: Callable[[], Page]) -> None:
    """Two see the same, one that closes harms nothing, and one that reloads finds the walk."""
    other = open_tab()
    other.get_by_role("button", name="Push", exact=True).click()
    for one in (tab, other):
        says(one, "Pushed 34 N s forward")
    other.close()
    says(tab, "back in its gait")
    before = live.run.walk
    tab.reload()
    says(tab, "Pushed 34 N s forward")
    assert live.run.walk is before
    now = before.time
    wait_until(lambda: before.time > now + 0.1, "it stands still")


def test_no_request_leaves_this_machine(tab: Page, requests: list[str]) -> None:
    assert requests
    assert not tab.is_closed()
    for request in requests:
        url = urlsplit(request)
        assert url.scheme in ("data", "blob") or url.hostname == "127.0.0.1", request


def test_it_is_served_to_this_machine_only(server: viser.ViserServer) -> None:
    assert server.get_host() == "127.0.0.1"
    assert url_of(server) == f"http://127.0.0.1:{server.get_port()}"
    with socket.socket() as probe, pytest.raises(OSError):
        # The whole of 127/8 is this machine; the page is at one address of it.
        probe.connect(("127.0.0.2", server.get_port()))


def answer_to(server: viser.ViserServer, **headers: str) -> int:
    """The status with which a request for a socket is answered."""
    given = {
        "Host": f"127.0.0.1:{server.get_port()}",
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version": "13",
        **headers,
    }
    with socket.create_connection(("127.0.0.1", server.get_port()), timeout=20.0) as one:
        lines = "".join(f"{name}: {value}\r\n" for name, value in given.items())
        one.sendall(f"GET / HTTP/1.1\r\n{lines}\r\n".encode())
        return int(one.recv(100).split()[1])


def test_other_pages_of_the_browser_are_refused(server: viser.ViserServer) -> None:
    own = f"http://127.0.0.1:{server.get_port()}"
    assert answer_to(server, Origin=own) == 101
    assert answer_to(server) == 101
    assert answer_to(server, Origin="https://elsewhere.example") == 403
    assert answer_to(server, Origin="http://127.0.0.1:1") == 403
    # A name that leads here, of somebody else.
    rebound = "elsewhere.example"
    assert answer_to(server, Host=rebound, Origin=f"http://{rebound}") == 403


def test_nobody_opens_a_tunnel_to_the_internet(server: viser.ViserServer) -> None:
    assert server.request_share_url() is None


def test_a_busy_port_is_passed_over_and_no_port_is_told(server: viser.ViserServer) -> None:
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 65535))
        busy.listen()
        with pytest.raises(ParameterError, match="a free port from 65535 to 65535; got none"):
            page_server("127.0.0.1", 65535)
    other = page_server("127.0.0.1", server.get_port())
    assert other.get_port() > server.get_port()
    stop(other)


def test_an_address_of_another_machine_is_refused() -> None:
    with pytest.raises(ParameterError, match="--host with an address of this machine; got '192"):
        page_server("192.0.2.1", 8123)


def test_a_slow_controller_is_in_the_menu_if_it_was_asked_for() -> None:
    assert "timing-nlp" not in live_menu(Choice()).controllers["lipm"]
    menu = live_menu(Choice(controller="timing-nlp", ghost="hybrid"))
    assert "timing-nlp" in menu.controllers["lipm"]
    assert "timing-nlp" not in menu.controllers["mujoco"]
    assert len(set(menu.controllers["lipm"])) == len(menu.controllers["lipm"])
