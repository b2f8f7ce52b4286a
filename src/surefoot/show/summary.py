"""A walk in words and numbers: a short table for people, a dictionary for machines."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from surefoot.robot.feet import Side
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.show.stances import Commanded, commanded, walks_on_footholds
from surefoot.show.words import closest_call, counted, fall_evidence, finite, margin_sentence

if TYPE_CHECKING:
    # Of the walks of bodies only, and loaded with these.
    from surefoot.rollout.measures import BodyMeasures
    from surefoot.rollout.trace import BodyTrace

_SENTENCES = {
    Outcome.WALKED: "walked: on the nominal gait",
    Outcome.RECOVERED: "recovered: back on the nominal gait",
    Outcome.UNSETTLED: "unsettled: still walking, but not on the nominal gait when the run ended",
    Outcome.CUT_SHORT: "cut short: the end of the walk is lost",
}


_BODY_SENTENCES = {
    Outcome.WALKED: "walked",
    Outcome.RECOVERED: "recovered: walked on",
    Outcome.UNSETTLED: "unsettled: not back in its gait when the run ended; walked",
    Outcome.CUT_SHORT: "cut short: its end is lost; walked",
}
"""How the time that a body walked is introduced."""


def walk_summary(
    rollout: Rollout,
    decided: NDArray[np.void] | None = None,
    measures: BodyMeasures | None = None,
) -> dict[str, Any]:
    """The walk as plain numbers, strings, lists and dictionaries; SI.

    A number that does not exist (no two finished steps, an endless push) is None.

    Args:
        rollout: the walk.
        decided: its decisions (`surefoot.decisions`), for `smallest_margin`, which else is None.
        measures: how well a body walked (`surefoot.measure_body`), for `body`, which a point mass
            does not have.
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
                "duration": finite(push.duration),
                "force": list(push.force),
                "impulse": [finite(component) for component in push.impulse],
                "delta_v": [finite(component) for component in push.delta_v(mass)],
            }
            for push in rollout.pushes
        ],
        "largest_dcm_error": float(np.hypot(*rollout.dcm_error.T).max()),
        "largest_zmp_excess": float(rollout.zmp_excess.max()),
        "final_velocity": [finite(component) for component in rollout.final_velocity],
        "decision_time": {"p50": float(decision[0]), "p99": float(decision[1])},
        "smallest_margin": None if decided is None else closest_call(rollout, decided),
        "fall": None if rollout.fall is None else asdict(rollout.fall),
    }
    if rollout.body is not None and measures is not None:
        summary["body"] = _body_numbers(rollout, rollout.body, measures)
    return summary


def _body_numbers(rollout: Rollout, trace: BodyTrace, measures: BodyMeasures) -> dict[str, Any]:
    numbers, fall = asdict(measures), rollout.body_fall
    numbers["cycle_time"] = dict(zip(("p50", "p99"), measures.cycle_time, strict=True))
    speed = numbers.pop("speed")
    return {
        "senses": trace.senses,
        "surroundings": trace.surroundings,
        "speed_held": None if speed is None else list(speed),
        "commanded": list(numbers.pop("commanded")),
        "makes_way": holds_course(rollout),
        **numbers,
        "fall_cause": None if fall is None else fall.cause.value,
        "fall": None if fall is None else {**asdict(fall), "cause": fall.cause.value},
    }


def holds_course(rollout: Rollout) -> bool:
    """Whether a body walks at the commanded speed, as far as its walk shows."""
    return rollout.held_speed is None or rollout.held_speed.is_held


def print_walk(
    rollout: Rollout,
    console: Console,
    decided: NDArray[np.void] | None = None,
    measures: BodyMeasures | None = None,
) -> None:
    """The walk as a short table and a few sentences; arguments as of `walk_summary`."""
    robot, trace = rollout.robot, rollout.body
    who = f"[bold]{robot.name}[/] ({robot.mass:g} kg)"
    if trace is None or measures is None:
        console.print(f"{who} {_course(rollout)} with {rollout.controller}")
        _print_pushes(rollout, console)
        _print_point_mass(rollout, console, decided)
        return
    state = "an estimate from its sensors" if len(trace.told_position) else "the truth"
    console.print(f"{who} in physics with {rollout.controller}, given {state}")
    for command in commanded(rollout):
        console.print(f"from {command.time:g} s: {_command_sentence(command)}")
    _print_pushes(rollout, console)
    for name, value in _body_rows(rollout, measures):
        console.print(f"  {name:<17}{value}", soft_wrap=True, highlight=False)
    console.print(_body_end(rollout), soft_wrap=True)


def _print_point_mass(rollout: Rollout, console: Console, decided: NDArray[np.void] | None) -> None:
    summary = walk_summary(rollout, decided)
    console.print(_step_table(rollout))
    console.print(_fell(rollout) or f"[bold]{_SENTENCES[rollout.outcome]}[/]", soft_wrap=True)
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
    """A command as what the robot is to do."""
    if command.standing:
        return "stand"
    x, y = command.velocity
    turning = f", turning at {command.turning:g} rad/s" if command.turning else ""
    return f"walk at ({x:g}, {y:g}) m/s{turning}"


def _print_pushes(rollout: Rollout, console: Console) -> None:
    """A line for every push: force, interval, impulse and the change of velocity."""
    for push in rollout.pushes:
        (x, y), strength = push.force, math.hypot(*push.force)
        if math.isinf(push.end):
            words = f"with {strength:.4g} N towards ({x:g}, {y:g}) from {push.start:g} s on"
        else:
            impulse = strength * (push.end - push.start)
            words = (
                f"with ({x:g}, {y:g}) N from {push.start:g} s to {push.end:g} s: "
                f"{impulse:.4g} N s, {impulse / rollout.mass:.3g} m/s"
            )
        console.print(f"pushed {words}")


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


def _fell(rollout: Rollout) -> str:
    """When and how it fell; empty if it did not."""
    return fall_evidence(rollout).replace("fell", "[bold]fell[/]", 1)


def _round(value: float) -> str:
    """Three decimals, and no minus before a zero."""
    return f"{round(value, 3) + 0.0:.3f}"


def _body_end(rollout: Rollout) -> str:
    """How the walk of a body ended."""
    if rollout.fallen:
        return _fell(rollout)
    held = rollout.held_speed
    if held is not None and not held.is_held:
        (x, y), (want_x, want_y) = held.velocity, held.commanded
        return (
            f"[bold]unsettled[/]: it steps, but goes at ({x:.3f}, {y + 0.0:.3f}) m/s where "
            f"({want_x:g}, {want_y:g}) was commanded, in steps of {held.duration:.3g} s that were "
            f"to take {held.planned:.3g} s"
        )
    ends = (push.end for push in rollout.pushes)
    ended = max((end for end in ends if end < rollout.time[-1]), default=0.0)
    lasted = f"{rollout.time[-1] - ended:.3g} s{' after the push' if ended else ''}"
    return f"[bold]{_BODY_SENTENCES[rollout.outcome]}[/] for {lasted}"


def _body_rows(rollout: Rollout, measures: BodyMeasures) -> list[tuple[str, str]]:
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
        scuffs = f"; {counted(measures.scuffs, 'step')} scuffed" if measures.scuffs else ""
        rows.append(("clearance", f"{median:.0f} mm mid-swing, at least {least:.0f} mm{scuffs}"))
    busiest = sorted(measures.torque_part.items(), key=lambda item: -item[1])[:3]
    if busiest:
        parts = ", ".join(f"{name} {100.0 * part:.0f} %" for name, part in busiest)
        rows.append(("largest torques", parts))
    if measures.estimate:
        dcm, tilt = 1e3 * measures.estimate["dcm"], math.degrees(measures.estimate["tilt"])
        place = 1e3 * measures.estimate["place"]
        errors = f"DCM {dcm:.1f} mm, tilt {tilt:.2f}°, place {place:.0f} mm"
        rows.append(("estimate off by", errors))
    p50, p99 = (1e3 * value for value in measures.cycle_time)
    factor = f"{measures.real_time_factor:.1f} × real time with physics"
    rows.append(("control cycle", f"{p50:.2f} ms (median), {p99:.2f} ms (99 %); {factor}"))
    return rows
