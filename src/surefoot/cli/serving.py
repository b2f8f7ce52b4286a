"""What the commands that serve a page share: where, and until Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    import viser

host_option = click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to serve on; 0.0.0.0 lets other machines watch and push.",
)
port_option = click.option(
    "--port",
    default=8080,
    show_default=True,
    type=click.IntRange(1, 65535),
    help="The first free port from this one on.",
)
open_option = click.option(
    "--open/--no-open",
    "open_page",
    default=True,
    show_default=True,
    help="Open the page in a browser.",
)


def serve_page(
    host: str, port: int, open_page: bool, words: str, make: Callable[[viser.ViserServer], Any]
) -> None:
    """Serve a page until Ctrl-C.

    Args:
        host, port, open_page: as of the options.
        words: what stands before the address when it is printed.
        make: the page, with `draw` and `serve`, on its server.

    Raises:
        ParameterError: this machine has no such address, or no free port.
    """
    from surefoot.live.server import page_server, stop, url_of

    server = page_server(host, port)
    page = make(server)
    page.draw()
    click.echo(f"{words} {url_of(server)} (Ctrl-C ends it)")
    if open_page:
        click.launch(url_of(server))
    try:
        page.serve()
    except KeyboardInterrupt:
        click.echo("ended", err=True)
    finally:
        stop(server)
