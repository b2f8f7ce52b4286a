"""A push map that nobody measured, for tests of its page, words and pictures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.studies.engine.study import Measured
from surefoot.studies.push_map.map_numbers import MapNumbers
from surefoot.studies.push_map.measure import FELL, RECOVERED, UNSETTLED
from surefoot.studies.push_map.question import PushMap

HOLED = (0.5, 90.0)
"""Phase and direction of the cell in which a harder push is survived again."""

PROVENANCE = {"robot": "nobody", "controller": "<b>guess</b>", "velocity": "0.5, 0 m/s",
              "leg speed": "3 m/s"}  # fmt: skip


def made_up_rows(directions: int = 8, phases: int = 4) -> list[dict[str, Any]]:
    """One of the cells has a hole, and one push does not settle."""
    rows = []
    for phase in np.arange(phases) / phases:
        for angle in 360.0 * np.arange(directions) / directions:
            limit = 101.0 + 20.0 * math.cos(math.radians(angle)) + 10.0 * phase
            impulse = 2.0 * round(0.3 * limit)
            impulses = [*np.arange(0.0, limit, 4.0), impulse - 2.0, impulse]
            impulses = sorted({*impulses, 2.0 * math.floor(limit / 2.0 + 1.0)})
            fate = [RECOVERED if j < impulse else FELL for j in impulses]
            holed = (phase, angle) == HOLED
            if holed:
                fate[-3] = RECOVERED
            if (phase, angle) == (0.0, 0.0):
                fate[fate.index(FELL)] = UNSETTLED
            rows.append({
                "phase": float(phase), "angle": float(angle), "impulse": impulse,
                "survived": impulse - 2.0, "limit": limit, "limit_causal": 0.9 * limit,
                "limit_fixed": 15.0,
                "fraction": min((impulse - 2.0) / limit, 1.0),
                "fraction_causal": min((impulse - 2.0) / (0.9 * limit), 1.0),
                "holes": int(holed), "impulses": impulses, "fate": fate,
                "recovery_steps": [3 + number // 5 if one == RECOVERED else -1
                                   for number, one in enumerate(fate)],
                "margin": [0.2 - 0.001 * j for j in impulses],
            })  # fmt: skip
    return rows


def arranged(rows: list[dict[str, Any]], **pushes: Any) -> MapNumbers:
    """These rows as a map."""
    controller = sf.HybridController(sf.load_robot("paper-biped"), (0.5, 0.0))
    asked: dict[str, Any] = {"directions": 8, "phases": 4, "step": 2.0, "coarse": 4.0}
    return MapNumbers(Measured(PushMap(controller, **asked | pushes), rows, [], PROVENANCE))
