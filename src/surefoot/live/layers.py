"""The legend of the scene, and a switch for each of its layers."""

from __future__ import annotations

import html
from typing import Any

from surefoot.live.colours import dot
from surefoot.live.marks import LAYERS


class Layers:
    """The folder of switches.

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
        f"<div>{dot(layer.colour)} <b>{layer.label}</b>: {html.escape(layer.meaning)}</div>"
        for layer in LAYERS
    )
    return f'<div style="font-size:12px;line-height:1.5;padding:0 10px 6px">{rows}</div>'
