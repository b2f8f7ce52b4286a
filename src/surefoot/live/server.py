"""The server of the page: for this machine alone unless --host names an address, and quiet.

The library's own would publish itself to the internet if a tab asked it to, and would listen to any
web page that a browser on this machine has open.
"""

from __future__ import annotations

import contextlib
import io
import ipaddress
import socket
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server as sockets

from surefoot.errors import ParameterError

TITLE = "Surefoot"

PORTS = 100
"""How many are tried."""

CAMERA, LOOK_AT, ANGLE = (1.5, -1.75, 1.05), (0.0, -0.1, 0.42), 1.05
"""Where a tab begins to look from, and at what, from the robot [m]; angle of view [rad]."""


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
    """What is served from here on looks at who asks; the library has no argument for it."""
    plain = sockets.serve

    def serve(*arguments: Any, process_request: Any = None, **options: Any) -> Any:
        def look(connection: Any, request: Any) -> Any:
            headers = request.headers
            if not is_welcome(headers.get("Origin"), headers.get("Host"), host):
                return connection.respond(403, "asked by another page\n")
            return None if process_request is None else process_request(connection, request)

        return plain(*arguments, process_request=look, **options)

    sockets.serve = serve  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        sockets.serve = plain


def look_from(server: viser.ViserServer) -> None:
    """Set where new tabs begin to look from."""
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
