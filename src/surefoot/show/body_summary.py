"""A walk in physics in words and numbers: what a body adds to those of the point mass."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from rich.console import Console

from surefoot.rollout.measures import BodyMeasures, measure_body
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show.stances import commanded
from surefoot.show.summary import command_sentence, holds_course, print_pushes, walk_summary

_SENTENCES = {
    Outcome.WALKED: "walked",
    Outcome.RECOVERED: "recovered: walked on",
    Outcome.UNSETTLED: "unsettled: not back in its gait when the run ended; walked",
    Outcome.FELL: "fell",
    Outcome.CUT_SHORT: "cut short: its end is lost; walked",
}


def body_summary(rollout: Rollout, trace: BodyTrace) -> dict[str, Any]:
    """A `walk_summary` with the measures of a body as `body`; None is what does not exist.

    Args:
        rollout: the walk.
        trace: its `body`.
    """
    measures, fall = asdict(measure_body(rollout, trace)), rollout.body_fall
    measures["cycle_time"] = dict(zip(("p50", "p99"), measures["cycle_time"], strict=True))
    speed = measures.pop("speed")
    body = {
        "senses": trace.senses,
        "surroundings": trace.surroundings,
        "speed_held": None if speed is None else list(speed),
        "commanded": list(measures.pop("commanded")),
        "makes_way": holds_course(rollout),
        **measures,
        "fall_cause": None if fall is None else fall.cause.value,
        "fall": None
        if fall is None
        else {
            "cause": fall.cause.value,
            "time": fall.time,
            "words": fall.words,
            "part": fall.part,
            "evidence": fall.evidence,
            "end": fall.end,
            "ending": fall.ending,
        },
    }
    return {**walk_summary(rollout), "body": body}


def print_body(rollout: Rollout, trace: BodyTrace, console: Console) -> None:
    """The walk as a short table; arguments as of `body_summary`."""
    state = "an estimate from its sensors" if len(trace.told_position) else "the truth"
    console.print(
        f"[bold]{trace.robot.name}[/] ({trace.robot.mass:g} kg) in physics with "
        f"{rollout.controller}, given {state}"
    )
    for command in commanded(rollout):
        console.print(f"from {command.time:g} s: {command_sentence(command)}")
    print_pushes(rollout, console)
    for name, value in _rows(rollout, measure_body(rollout, trace)):
        console.print(f"  {name:<17}{value}", soft_wrap=True, highlight=False)
    fall = rollout.body_fall
    if fall is None and not holds_course(rollout):
        console.print(f"[bold]unsettled[/]: {_off_speed(rollout)}", soft_wrap=True)
    elif fall is None:
        ends = (push.end for push in rollout.pushes)
        ended = max((end for end in ends if end < rollout.time[-1]), default=0.0)
        lasted = f"{rollout.time[-1] - ended:.3g} s{' after the push' if ended else ''}"
        sentence = _SENTENCES[rollout.outcome]
        console.print(f"[bold]{sentence}[/] for {lasted}", soft_wrap=True)
    else:
        console.print(f"[bold]fell[/]: {fall.sentence}", soft_wrap=True)


def _off_speed(rollout: Rollout) -> str:
    held = rollout.held_speed
    if held is None:
        return ""
    (x, y), (want_x, want_y) = held.velocity, held.commanded
    return (
        f"it steps, but goes at ({x:.3f}, {y + 0.0:.3f}) m/s where ({want_x:g}, {want_y:g}) was "
        f"commanded, in steps of {held.duration:.3g} s that were to take {held.planned:.3g} s"
    )


def _rows(rollout: Rollout, measures: BodyMeasures) -> list[tuple[str, str]]:
    rows = [("steps", f"{len(rollout.footsteps)}")]
    if measures.speed is not None:
        (x, y), (want_x, want_y) = measures.speed, measures.commanded
        held = f"({x:.3f}, {y + 0.0:.3f}) m/s, commanded ({want_x:g}, {want_y:g})"
        rows.append(("speed held", held))
    if measures.lateral_drift is not None and measures.heading_error is not None:
        drift, turn = 1e3 * measures.lateral_drift, math.degrees(measures.heading_error)
        side = "left" if drift >= 0.0 else "right"
        rows.append(("off course", f"{abs(drift):.0f} mm to the {side}, heading {turn:+.1f}°"))
    if measures.knees is not None:
        bends = " and ".join(
            f"{math.degrees(low):.0f}–{math.degrees(high):.0f}°" for low, high in measures.knees
        )
        rows.append(("knees", f"{bends}, left and right"))
    if measures.clearance is not None:
        least, median = (1e3 * value for value in measures.clearance)
        scuffs = f"; {measures.scuffs} steps scuffed" if measures.scuffs else ""
        rows.append(("clearance", f"{median:.0f} mm mid-swing, at least {least:.0f} mm{scuffs}"))
    busiest = sorted(measures.torque_part.items(), key=lambda item: -item[1])[:3]
    if busiest:
        parts = ", ".join(f"{name} {100.0 * part:.0f} %" for name, part in busiest)
        rows.append(("largest torques", parts))
    if measures.estimate:
        dcm, tilt = 1e3 * measures.estimate["dcm"], math.degrees(measures.estimate["tilt"])
        place = 1e3 * measures.estimate["place"]
        rows.append(
            ("estimate off by", f"DCM {dcm:.1f} mm, tilt {tilt:.2f}°, place {place:.0f} mm")
        )
    p50, p99 = (1e3 * value for value in measures.cycle_time)
    rows.append(
        (
            "control cycle",
            f"{p50:.2f} ms (median), {p99:.2f} ms (99 %); "
            f"{measures.real_time_factor:.1f} × real time with physics",
        )
    )
    return rows
