"""A walk in words and numbers: a short table for people, a dictionary for machines."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from surefoot.robot.feet import Side
from surefoot.rollout.measures import BodyMeasures, measure_body
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show.stances import Commanded, commanded, walks_on_footholds
from surefoot.show.words import closest_call, margin_sentence

_SENTENCES = {
    Outcome.WALKED: "walked: on the nominal gait",
    Outcome.RECOVERED: "recovered: back on the nominal gait",
    Outcome.UNSETTLED: "unsettled: still walking, but not on the nominal gait when the run ended",
    Outcome.FELL: "fell",
    Outcome.CUT_SHORT: "cut short: the end of the walk is lost",
}


_BODY_SENTENCES = {
    Outcome.WALKED: "walked",
    Outcome.RECOVERED: "recovered: walked on",
    Outcome.UNSETTLED: "unsettled: not back in its gait when the run ended; walked",
    Outcome.FELL: "fell",
    Outcome.CUT_SHORT: "cut short: its end is lost; walked",
}


def walk_summary(rollout: Rollout, decided: NDArray[np.void] | None = None) -> dict[str, Any]:
    """The walk as plain numbers, strings, lists and dictionaries; SI.

    A number that does not exist (no two finished steps, an endless push) is None. What a body adds
    is `body`, which a point mass has not.

    Args:
        rollout: the walk.
        decided: its decisions (`surefoot.decisions`), for `smallest_margin`, which else is None.
    """
    mass = rollout.mass
    decision = np.percentile(rollout.decision_time, (50, 99))
    summary = {
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
    return summary if rollout.body is None else {**summary, "body": _body(rollout, rollout.body)}


def _body(rollout: Rollout, trace: BodyTrace) -> dict[str, Any]:
    measures, fall = asdict(measure_body(rollout, trace)), rollout.body_fall
    measures["cycle_time"] = dict(zip(("p50", "p99"), measures["cycle_time"], strict=True))
    speed = measures.pop("speed")
    return {
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


def holds_course(rollout: Rollout) -> bool:
    """Whether a body walks at the commanded speed, as far as its walk shows."""
    return rollout.held_speed is None or rollout.held_speed.is_held


def print_walk(rollout: Rollout, console: Console, decided: NDArray[np.void] | None = None) -> None:
    """The walk as a short table and a few sentences; arguments as of `walk_summary`."""
    if rollout.body is not None:
        _print_body(rollout, rollout.body, console)
        return
    summary = walk_summary(rollout, decided)
    console.print(
        f"[bold]{rollout.robot.name}[/] ({rollout.robot.mass:g} kg) {_course(rollout)} with "
        f"{rollout.controller}"
    )
    _print_pushes(rollout, console)
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
    return _command_sentence(last).replace("walk", "walks") + ("," if last.turning else "")


def _command_sentence(command: Commanded) -> str:
    if command.standing:
        return "stand"
    x, y = command.velocity
    turning = f", turning at {command.turning:g} rad/s" if command.turning else ""
    return f"walk at ({x:g}, {y:g}) m/s{turning}"


def _print_body(rollout: Rollout, trace: BodyTrace, console: Console) -> None:
    state = "an estimate from its sensors" if len(trace.told_position) else "the truth"
    console.print(
        f"[bold]{trace.robot.name}[/] ({trace.robot.mass:g} kg) in physics with "
        f"{rollout.controller}, given {state}"
    )
    for command in commanded(rollout):
        console.print(f"from {command.time:g} s: {_command_sentence(command)}")
    _print_pushes(rollout, console)
    for name, value in _rows(rollout, measure_body(rollout, trace)):
        console.print(f"  {name:<17}{value}", soft_wrap=True, highlight=False)
    fall = rollout.body_fall
    if fall is None and not holds_course(rollout):
        console.print(f"[bold]unsettled[/]: {_off_speed(rollout)}", soft_wrap=True)
    elif fall is None:
        ends = (push.end for push in rollout.pushes)
        ended = max((end for end in ends if end < rollout.time[-1]), default=0.0)
        lasted = f"{rollout.time[-1] - ended:.3g} s{' after the push' if ended else ''}"
        sentence = _BODY_SENTENCES[rollout.outcome]
        console.print(f"[bold]{sentence}[/] for {lasted}", soft_wrap=True)
    else:
        console.print(f"[bold]fell[/]: {fall.sentence}", soft_wrap=True)


def _print_pushes(rollout: Rollout, console: Console) -> None:
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
