"""What keeps a text readable on lines and areas."""

from __future__ import annotations

from matplotlib.patheffects import withStroke

HALO = [withStroke(linewidth=2.2, foreground="white")]
"""Path effects of such a text."""
