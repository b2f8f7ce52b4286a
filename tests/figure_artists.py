"""The artists of a figure, found by the names that the picture gave them; where words lie."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text


def drawn(figure: Figure, pattern: str) -> list[Any]:
    """All artists whose name matches."""
    return figure.findobj(lambda artist: re.fullmatch(pattern, artist.get_gid() or "") is not None)


def one(figure: Figure, name: str) -> Any:
    """The only artist of this name."""
    (artist,) = drawn(figure, re.escape(name))
    return artist


def line(figure: Figure, name: str) -> np.ndarray:
    """The points of the only line of this name, shape (n, 2)."""
    return one(figure, name).get_xydata()


def assert_words_stand_apart(figure: Figure, words: Iterable[Text]) -> None:
    """Every word of a figure that was drawn lies on the page, and no two overlap by 2 pixels."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [(word.get_text(), word.get_window_extent(renderer)) for word in words]
    boxes = [(text, box) for text, box in boxes if text and box.width > 0.0]
    assert boxes
    width, height = figure.get_size_inches() * figure.dpi
    for text, box in boxes:
        inside = box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert inside, text
    for (text, box), (other, second) in combinations(boxes, 2):
        assert not box.padded(-1.0).overlaps(second), (text, other)
