"""A comparison that nobody measured, for tests of pictures, tables and the page: nine methods."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import surefoot as sf
from surefoot.studies.compare.question import Comparison
from surefoot.studies.engine.study import Measured

SPEEDS = (2.0, 3.0, 4.0, 6.0, math.inf)
DURATIONS = (0.1, 0.2, 0.4)
MASS = 70.0

METHODS: list[dict[str, Any]] = [
    {"key": key, "label": label, "source": source, "adapts": adapts, "cannot": cannot,
     "decision_p50": p50, "decision_p99_9": p999, "period": 0.001}
    for key, label, adapts, p50, p999, source, cannot in [
        ("unified", "Unified, leg-speed aware", "ZMP, step location, timing", 2.1e-6, 9e-6,
         "This package; docs/unified.md", "uses every freedom that is given"),
        ("hybrid", "Hybrid of the paper", "step location, timing; then ZMP", 1.3e-6, 6e-6,
         "Khadiv, Herzog, Moosavian, Righetti, 2020", "knows no leg-speed limit"),
        ("step_timing", "Step and timing QP", "step location, timing", 1.1e-6, 4e-6,
         "Khadiv, Herzog, Moosavian, Righetti, 2016", "cannot move the ZMP within the sole"),
        ("step_location", "Step location only", "step location", 0.8e-6, 3e-6,
         "Herdt, Diedam, Wieber et al., 2010", "cannot change the timing of a step"),
        ("capture_point", "Capture point, swing to the point", "step location", 0.3e-6, 1e-6,
         "Pratt, Carff, Drakunov, Goswami, 2006", "knows neither step limits nor leg speed"),
        ("linear_mpc", "Linear MPC, free steps", "ZMP, step location", 1.4e-4, 9.1e-4,
         "Wieber, 2006; Herdt et al., 2010", "cannot change the timing of a step"),
        ("dcm_tracking", "DCM tracking", "ZMP", 0.4e-6, 1.6e-6,
         "Englsberger, Ott, Albu-Schäffer, 2015", "cannot step elsewhere"),
        ("preview", "Preview control", "ZMP", 3.2e-6, 1.2e-5,
         "Kajita, Kanehiro, Kaneko et al., 2003", "cannot step elsewhere"),
        ("open_loop", "Open loop", "–", 0.1e-6, 0.4e-6, "no control at all", "reacts to nothing"),
    ]
]  # fmt: skip
"""In order of display."""

_STRENGTH = {
    "unified": 0.97, "hybrid": 0.85, "step_timing": 0.74, "step_location": 0.55,
    "capture_point": 0.5, "linear_mpc": 0.62, "dcm_tracking": 0.2, "preview": 0.17,
    "open_loop": 0.03,
}  # fmt: skip

PROVENANCE = {
    "version": "0.3.0",
    "sources": "sha256 7f3a9c0d51",
    "python": "3.11.2",
    "numpy": "2.3.1",
    "machine": "x86_64, 2 cores",
    "date": "2026-01-01",
    "robot": "paper-biped",
    "velocity": "0.5 m/s forward",
    "command": "surefoot compare --directions 8 --phases 8",
}


def comparison(
    rows: Sequence[dict[str, Any]],
    methods: Sequence[dict[str, Any]] = METHODS,
    provenance: dict[str, str] = PROVENANCE,
) -> Measured[Comparison]:
    """Rows as if a study had measured them."""
    study = Comparison(sf.load_robot("paper-biped"))
    return Measured(study, list(rows), [], provenance, {"methods": list(methods)})


def measured_rows(
    directions: int = 8,
    phases: int = 8,
    speeds: tuple[float, ...] = SPEEDS,
    durations: tuple[float, ...] = DURATIONS,
) -> list[dict[str, Any]]:
    """Rows as a study would give them; the same each time."""
    return [
        row
        for speed in speeds
        for duration in durations
        for phase in range(phases)
        for direction in range(directions)
        for method in METHODS
        if (row := _row(method["key"], 360.0 * direction / directions, phase / phases, duration,
                        speed)) is not None
    ]  # fmt: skip


def _row(
    key: str, angle: float, phase: float, duration: float, speed: float
) -> dict[str, Any] | None:
    if key == "preview" and (speed != 3.0 or phase not in (0.0, 0.5)):
        return None
    if key == "capture_point" and phase == 0.25 and angle in (135.0, 180.0):
        return None
    if key == "linear_mpc" and duration != 0.2:
        return None
    sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    reach = 1.0 if math.isinf(speed) else 1.0 - math.exp(-0.55 * speed)
    ellipse = 1.0 / math.hypot(cosine / (86.0 if cosine > 0 else 64.0),
                               sine / (95.0 if sine > 0 else 34.0))  # fmt: skip
    shape = ellipse * (1.0 - 0.45 * phase**2) * reach * (1.0 - 0.5 * duration)
    finite = round(shape + 9.0, 3)
    strength = _STRENGTH[key] * (1.0 - 0.2 * phase * (key != "unified"))
    strength *= 1.0 - 0.12 * (1.0 + math.sin(2.0 * math.radians(angle) + len(key))) / 2.0
    survived = math.floor(max(strength, 0.0) * finite)
    unbroken = key == "unified" and angle == 90.0 and survived > 75
    impulse = math.inf if unbroken else survived + 1.0
    slow = key in ("step_location", "linear_mpc") and cosine < -0.5
    failure = "none" if unbroken else "unsettled" if slow else "fell"
    return {
        "method": key, "angle": angle, "phase": phase, "push_duration": duration,
        "leg_speed": speed, "impulse": impulse, "delta_v": impulse / MASS, "step": 1.0,
        "scanned": 75.0 if unbroken else impulse, "failure": failure,
        "limit_point": round(shape, 3), "limit_finite": finite, "limit_fixed": 9.0,
        "limit_causal": round(0.95 * finite, 3),
    }  # fmt: skip
