"""The live page: a server on which everybody watches, pushes and steers the same walk.

Time passes here, in one loop; what changed is sent to each tab by a thread of its own, as fast as
the tab can take it: a slow one sees less and delays nothing.

The server is for this machine alone unless --host names an address. The library's own would publish
itself to the internet if a tab asked it to, and would listen to any web page that a browser on this
machine has open.
"""

from __future__ import annotations

import contextlib
import io
import ipaddress
import socket
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server as sockets

from surefoot.errors import ParameterError
from surefoot.live.panels import Controls, Menu, dock_panels
from surefoot.live.run import LiveRun
from surefoot.live.stage import MakeFigure, Stage
from surefoot.worlds.world import World

FRAME = 1.0 / 30.0
"""Between two pictures [s]."""

MAX_BEHIND = 0.1
"""Time that a walk is advanced for one picture at most: on a slow machine it is slower than the
clock [s]."""

CHART_FRAMES = 4
"""Pictures for one drawing of the charts."""

MakeFigureOf = Callable[[World], MakeFigure]
"""How a walk is drawn."""

TITLE = "Surefoot"

PORTS = 100
"""How many are tried."""

CAMERA, LOOK_AT, ANGLE = (1.5, -1.75, 1.05), (0.0, -0.1, 0.42), 1.05
"""Place of the camera of a new tab and where it points, from the robot [m]; angle of view [rad]."""


def let_time_pass(
    pass_by: Callable[[float], None], draw: Callable[[], None], on: Callable[[], bool]
) -> None:
    """Draw a picture every `FRAME`.

    Args:
        pass_by: called before each with the time since the last one [s].
        draw: draws it.
        on: asked before every picture whether to go on.
    """
    last = time.monotonic()
    while on():
        now = time.monotonic()
        passed, last = min(now - last, MAX_BEHIND), now
        pass_by(passed)
        draw()
        time.sleep(max(FRAME - (time.monotonic() - now), 0.001))


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
        set_camera(server)
        self.controls = Controls(server.gui, run, menu, self._save)
        self.charts = dock_panels(server, "The last seconds")
        self.stage = Stage(server.scene, self.controls.layers.shown)
        self._generation, self._frame = -1, 0
        self._charted: float | None = None

    def serve(self, on: Callable[[], bool] = lambda: True) -> None:
        """Let time pass.

        Args:
            on: asked before every picture whether to go on.
        """
        let_time_pass(self._go_on, self.draw, on)

    def _go_on(self, seconds: float) -> None:
        if not self._run.paused:
            self._run.advance(seconds * self._run.pace)

    def draw(self) -> None:
        """Send the present to all tabs."""
        view, run = self._run.view(), self._run
        controller = view.walk.controller
        with self._server.atomic():
            if view.generation != self._generation:
                self._generation = view.generation
                ghost = None if view.ghost is None else self._figure_of(view.ghost)
                self.stage.put(controller.robot, self._figure_of(view.walk), ghost)
            self.stage.show(view.snapshot, view.ghost_snapshot)
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


class PageServer(viser.ViserServer):
    """A server that stays where it is."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """No tunnel to the internet, whoever asks for it."""
        return None


def page_server(host: str, port: int) -> PageServer:
    """A server on the first free port from this one on.

    Args:
        host: address to serve on.
        port: the first to be tried.

    Raises:
        ParameterError: this machine has no such address, or none of its next ports is free.
    """
    free = _free_port(host, port)
    # It announces itself in a box of its own; one line of ours is enough.
    with contextlib.redirect_stdout(io.StringIO()), _guarded(host):
        return PageServer(host=host, port=free, label=TITLE, verbose=False)


def is_welcome(origin: str | None, asked: str | None, host: str) -> bool:
    """Whether a request comes from the page itself, or from no page at all.

    Args:
        origin: of the page that makes it, as its browser says.
        asked: the host that it asked for.
        host: address that is served.
    """
    if _is_loopback(host) and not _is_loopback(urlsplit(f"//{asked}").hostname or ""):
        return False
    return origin is None or urlsplit(origin).netloc == asked


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


def _free_port(host: str, port: int) -> int:
    last = min(port + PORTS, 65536) - 1
    for one in (0, *range(port, last + 1)):
        try:
            with socket.socket(_family(host)) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((host, one))
        except OSError as error:
            if one == 0:
                raise ParameterError(
                    "--host with an address of this machine",
                    f"{host!r}: {error.strerror or error}",
                    "leave it out for 127.0.0.1, which only this machine reaches",
                ) from error
            continue
        if one:
            return one
    raise ParameterError(
        f"a free port from {port} to {last}", "none", "choose another one with --port"
    )


@contextlib.contextmanager
def _guarded(host: str) -> Iterator[None]:
    """A server that is made meanwhile refuses other pages; the library has no argument for it."""
    plain = sockets.serve

    def serve(*arguments: Any, process_request: Any = None, **options: Any) -> Any:
        def check(connection: Any, request: Any) -> Any:
            headers = request.headers
            if not is_welcome(headers.get("Origin"), headers.get("Host"), host):
                return connection.respond(403, "asked by another page\n")
            return None if process_request is None else process_request(connection, request)

        return plain(*arguments, process_request=check, **options)

    sockets.serve = serve  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        sockets.serve = plain


def set_camera(server: viser.ViserServer) -> None:
    """Set the camera of new tabs."""
    camera = server.initial_camera
    camera.position, camera.look_at, camera.fov = CAMERA, LOOK_AT, ANGLE


def stop(server: viser.ViserServer) -> None:
    """End it, without a word."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def url_of(server: viser.ViserServer) -> str:
    """Where the page is."""
    host = server.get_host()
    name = {"0.0.0.0": "localhost", "::": "localhost"}.get(host, host)
    return f"http://{f'[{name}]' if ':' in name else name}:{server.get_port()}"
