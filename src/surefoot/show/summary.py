"""A walk in words and numbers: a short table for people, a dictionary for machines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from surefoot.robot.feet import Side
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.show.stances import Commanded, commanded, walks_on_footholds
from surefoot.show.words import closest_call, margin_sentence

_SENTENCES = {
    Outcome.WALKED: "walked: on the nominal gait",
    Outcome.RECOVERED: "recovered: back on the nominal gait",
    Outcome.UNSETTLED: "unsettled: still walking, but not on the nominal gait when the run ended",
    Outcome.FELL: "fell",
    Outcome.CUT_SHORT: "cut short: the end of the walk is lost",
}


def walk_summary(rollout: Rollout, decided: NDArray[np.void] | None = None) -> dict[str, Any]:
    """The walk as plain numbers, strings, lists and dictionaries; SI.

    A number that does not exist (no two finished steps, an endless push) is None. What a body adds
    is in `show.body_summary`, which a walk of a point mass does not load.

    Args:
        rollout: the walk.
        decided: its decisions (`surefoot.decisions`), for `smallest_margin`, which else is None.
    """
    mass = rollout.mass
    decision = np.percentile(rollout.decision_time, (50, 99))
    return {
        "version": rollout.version,
        "robot": rollout.robot.name,
        "controller": rollout.controller,
        "controller_parameters": rollout.controller_parameters,
        "velocity": list(rollout.velocity),
        "duration": float(rollout.time[-1]),
        "outcome": rollout.outcome.value,
        "steps": [
            {
                "side": step.side.name.lower(),
                "start": step.start,
                "location": list(step.landing),
                "step": list(step.step),
                "duration": step.duration,
                "dcm_offset": list(step.dcm_offset),
                "adapted": step.adapted,
            }
            for step in rollout.footsteps
        ],
        "pushes": [
            {
                "start": push.start,
                "duration": _finite(push.duration),
                "force": list(push.force),
                "impulse": [_finite(component) for component in push.impulse],
                "delta_v": [_finite(component) for component in push.delta_v(mass)],
            }
            for push in rollout.pushes
        ],
        "largest_dcm_error": float(np.hypot(*rollout.dcm_error.T).max()),
        "largest_zmp_excess": float(rollout.zmp_excess.max()),
        "final_velocity": [_finite(component) for component in rollout.final_velocity],
        "decision_time": {"p50": float(decision[0]), "p99": float(decision[1])},
        "smallest_margin": None if decided is None else closest_call(rollout, decided),
        "fall": _fall(rollout),
    }


def holds_course(rollout: Rollout) -> bool:
    """Whether a body walks at the commanded speed, as far as its walk shows."""
    return rollout.held_speed is None or rollout.held_speed.is_held


def print_walk(rollout: Rollout, console: Console, decided: NDArray[np.void] | None = None) -> None:
    """The walk as a short table and a few sentences; arguments as of `walk_summary`."""
    summary = walk_summary(rollout, decided)
    console.print(
        f"[bold]{rollout.robot.name}[/] ({rollout.robot.mass:g} kg) {_course(rollout)} with "
        f"{rollout.controller}"
    )
    print_pushes(rollout, console)
    console.print(_step_table(rollout))
    console.print(f"[bold]{_SENTENCES[rollout.outcome]}[/]{_evidence(rollout)}")
    if summary["smallest_margin"] is not None:
        console.print(margin_sentence(summary["smallest_margin"]), soft_wrap=True)
    final_x, final_y = rollout.final_velocity
    console.print(
        f"final velocity ({_round(final_x)}, {_round(final_y)}) m/s; "
        f"largest DCM error {1e3 * summary['largest_dcm_error']:.1f} mm; "
        f"ZMP outside the foot by at most {1e3 * summary['largest_zmp_excess']:.1f} mm; "
        f"decision {1e6 * summary['decision_time']['p50']:.1f} µs (median), "
        f"{1e6 * summary['decision_time']['p99']:.1f} µs (99 %)",
        soft_wrap=True,
    )


def _course(rollout: Rollout) -> str:
    """What a point mass was to do, by its last command."""
    if walks_on_footholds(rollout):
        return "walks on footholds"
    last = commanded(rollout)[-1]
    return command_sentence(last).replace("walk", "walks") + ("," if last.turning else "")


def command_sentence(command: Commanded) -> str:
    """A command as what the robot is to do."""
    if command.standing:
        return "stand"
    x, y = command.velocity
    turning = f", turning at {command.turning:g} rad/s" if command.turning else ""
    return f"walk at ({x:g}, {y:g}) m/s{turning}"


def print_pushes(rollout: Rollout, console: Console) -> None:
    """A line for every push."""
    for push in rollout.pushes:
        console.print(f"pushed {describe_push(push.force, push.start, push.end, rollout)}")


def describe_push(force: tuple[float, float], start: float, end: float, rollout: Rollout) -> str:
    """A push in words: force, interval, impulse and the change of velocity."""
    strength = math.hypot(*force)
    if math.isinf(end):
        return f"with {strength:.4g} N towards ({force[0]:g}, {force[1]:g}) from {start:g} s on"
    impulse = strength * (end - start)
    return (
        f"with ({force[0]:g}, {force[1]:g}) N from {start:g} s to {end:g} s: "
        f"{impulse:.4g} N s, {impulse / rollout.mass:.3g} m/s"
    )


def _step_table(rollout: Rollout) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name, justify in (
        ("step", "right"), ("stands", "left"), ("duration [s]", "right"),
        ("step x, y [m]", "right"), ("DCM offset x, y [mm]", "right"), ("decided", "left"),
    ):  # fmt: skip
        table.add_column(name, justify=justify, no_wrap=True)  # type: ignore[arg-type]
    for step in rollout.footsteps:
        table.add_row(
            str(step.index + 1),
            "right" if step.side is Side.RIGHT else "left",
            f"{step.duration:.3f}",
            f"{step.step[0]:+.3f} {step.step[1]:+.3f}",
            f"{1e3 * step.dcm_offset[0]:+.1f} {1e3 * step.dcm_offset[1]:+.1f}",
            "online" if step.adapted else "planned",
            style="yellow" if step.adapted else None,
        )
    return table


def _evidence(rollout: Rollout) -> str:
    fall = rollout.fall
    if fall is None:
        return ""
    text = f" at {fall.time:.2f} s: the DCM ran away, mostly {fall.limit}"
    if fall.lost_time is not None and fall.lost_margin is not None:
        text += (
            f"; past saving since the touchdown at {fall.lost_time:.2f} s "
            f"({-1e3 * fall.lost_margin:.0f} mm outside what a leg of any speed could save)"
        )
    if fall.last_viable_time is not None and fall.last_margin is not None:
        text += (
            f"; last touchdown that such a leg could have saved at {fall.last_viable_time:.2f} s "
            f"({1e3 * fall.last_margin:.0f} mm inside)"
        )
    return text


def _fall(rollout: Rollout) -> dict[str, Any] | None:
    fall = rollout.fall
    if fall is None:
        return None
    return {name: getattr(fall, name) for name in fall.__dataclass_fields__}


def _round(value: float) -> str:
    """Three decimals, and no minus before a zero."""
    return f"{round(value, 3) + 0.0:.3f}"


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
