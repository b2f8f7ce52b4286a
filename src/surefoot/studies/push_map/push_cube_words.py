"""The words of a push map: how it was measured, what it shows, and numbers as people read them."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.studies.engine.words import RECOVERED_WORDS, angle_words, percent
from surefoot.studies.push_map.cube import PushCube

HEADING = "How hard a push is survived, from any side at any time"
"""Of page and pictures."""


def origin(cube: PushCube) -> str:
    """Whose map it is, in one line."""
    known = cube.provenance
    parts = [
        known.get("controller", ""), known.get("robot", ""), known.get("velocity", ""),
        f"leg {known['leg speed']}" if "leg speed" in known else "",
        f"pushes of {cube.push_duration:g} s",
    ]  # fmt: skip
    return "  ·  ".join(part for part in parts if part)


def summary(cube: PushCube) -> dict[str, Any]:
    """The map in a few numbers; SI, JSON has no word for what is not there but None."""
    share, survived = cube.share, cube.survived
    worst = np.unravel_index(np.argmin(np.nan_to_num(share, nan=2.0)), share.shape)
    known = bool(np.isfinite(share).any())
    return {
        "cells": int(share.size),
        "walks": cube.walks,
        "survived_least": float(survived.min()),
        "survived_mean": float(survived.mean()),
        "survived_most": float(survived.max()),
        "fraction_mean": float(np.nanmean(share)) if known else None,
        "fraction_worst": float(share[worst]) if known else None,
        "fraction_causal_mean": float(np.nanmean(cube.share_causal)) if known else None,
        "fraction_causal_worst": float(np.nanmin(cube.share_causal)) if known else None,
        "worst_phase": float(cube.phases[worst[0]]),
        "worst_angle": float(cube.angles[worst[1]]),
        "cells_with_holes": int((cube.holes > 0).sum()),
        "cells_without_failure": int(np.isinf(cube.impulse).sum()),
    }


def finding(cube: PushCube) -> str:
    """The map in a few sentences."""
    found = summary(cube)
    words = (
        f"Survives {found['survived_least']:g} to {found['survived_most']:g} N s, on average "
        f"{found['survived_mean']:.0f}"
    )
    if found["fraction_mean"] is not None:
        words += (
            f": {percent(found['fraction_mean'])} of the limit, and "
            f"{percent(found['fraction_worst'])} where it is weakest, "
            f"{angle_words(found['worst_angle'])} at {found['worst_phase']:.3g} of the step. Of "
            "what can be survived without knowing when the push ends it is "
            f"{percent(found['fraction_causal_mean'])}, at least "
            f"{percent(found['fraction_causal_worst'])}"
        )
    holes = found["cells_with_holes"]
    words += f". In {holes} of {found['cells']} cells " if holes else ". In no cell "
    return words + "a push is survived that is harder than one that fails."


def protocol(cube: PushCube) -> list[str]:
    """What was measured and how, a paragraph each."""
    scan = (
        f"Every impulse was walked, in steps of {cube.step:g} N s."
        if cube.whole
        else f"Walked was every impulse that is a multiple of {cube.coarse:g} N s, and between two "
        f"of which one is survived and the other not every one in steps of {cube.step:g} N s. A "
        f"failure between two survived neighbours, a hole narrower than {cube.coarse:g} N s, may "
        "have been missed: then the smallest failing impulse is lower than it says here."
    )
    return [
        f"The robot walks steadily and is pushed once, for {cube.push_duration:g} s, in one of "
        f"{len(cube.angles)} directions and at one of {len(cube.phases)} phases of the step, by "
        "impulses from zero to the first above the limit. " + scan,
        f"{RECOVERED_WORDS} What is survived is the largest impulse below which every push is. "
        "Survival is "
        "not monotone: where a harder push than the smallest failing one is survived, the cell is "
        "marked.",
        "Directions are from forward (0°) to outward, towards the swing foot (90°), back (180°) "
        "and inward, over the standing foot to the other side (270°). The phase is the fraction of "
        "the nominal step at which the push begins; 0 is the touchdown.",
        "The limit is the largest impulse that any policy could survive that learns of the push "
        "when it starts, with the same sole, steps, times and leg. Who does not know when the push "
        "ends has to be viable at every instant of it; that limit is the thin line. That of fixed "
        "steps is by the ZMP alone.",
        "Steps to recover are those finished from the end of the push to the first touchdown at "
        "which the robot is back. The margin is the least, over all touchdowns, of how far the DCM "
        "offset was inside of what stepping can save with a whole sole and a leg without limits; "
        "a slow leg falls with a margin that is still positive.",
    ]
