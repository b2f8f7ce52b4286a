"""The reports beside the paper: of its point mass, and of its pushes on a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields
from functools import partial

from matplotlib.figure import Figure as Picture

from surefoot.robot.robot import Robot
from surefoot.show.walk_figure import walk_figure
from surefoot.studies.engine.pushed_body import body_method, mechanism_of
from surefoot.studies.engine.report import Details, Figure, Part, Report, Table, Text
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row
from surefoot.studies.reproduce.body import (
    FELL,
    FOOT,
    METHODS,
    PAPER_PUSHES,
    PHASE,
    STEP_COLUMNS,
    body_answer,
)
from surefoot.studies.reproduce.figures import PICTURES
from surefoot.studies.reproduce.measure import paper_parameters
from surefoot.studies.reproduce.one_step import limits_table
from surefoot.studies.reproduce.question import Paper, PaperOnBody
from surefoot.studies.reproduce.walks import NOT_REPRODUCED, VELOCITY, Claim

COLUMNS = ("where", "what", "paper", "ours", "verdict", "why")
"""Of the table of claims."""


def claims_of(rows: Sequence[Row]) -> list[Claim]:
    """The claims that rows of a study hold."""
    return [Claim(**{one.name: row[one.name] for one in fields(Claim)}) for row in rows]


def paper_report(found: Measured[Paper]) -> Report:
    """The paper on its point mass."""
    robot = found.study.robot
    pictures = [
        Figure(
            f"pictures/{name}.png", caption, partial(draw, robot),
            page="link" if name == "decision-time" else "inside",
        )
        for name, (caption, draw) in PICTURES.items()
    ]  # fmt: skip
    parts = _parts("surefoot reproduce", paper_parameters(robot), claims_of(found.rows), pictures)
    heading = "The paper, figure by figure and number by number"
    return Report("paper", heading, (), (*parts, limits_table(found.study.limits)))


def body_report(found: Measured[PaperOnBody]) -> Report:
    """The paper's pushes on a body."""
    robot, drawn = found.study.robot, [row for row in found.rows if row["steps"]]
    pictures = [
        Figure(
            f"pictures/body-{row['method']}-{row['impulse']:g}-{row['direction']}.png",
            f"{row['figure']}: {row['text']}. {row['ours']}.",
            partial(_draw_body_walk, robot, row["method"], row["impulse"], row["direction"]),
        )
        for row in drawn
    ]
    steps = Table(
        "Step by step",
        "From the pushed step on. The last column is how far the DCM is, when the foot lands, "
        "from where it is without a push.",
        STEP_COLUMNS,
        [step for row in drawn for step in row["steps"]],
    )
    command = "surefoot reproduce --simulator mujoco"
    parts = _parts(command, _body_parameters(robot, found.rows), claims_of(found.rows), pictures)
    return Report("paper_body", "The paper's pushes on a body", (), (*parts, steps))


def _draw_body_walk(robot: Robot, method: str, impulse: float, direction: str) -> Picture:
    """The walk of a row, which is walked again if another process measured it."""
    (push,) = (one for one in PAPER_PUSHES if (one.impulse, one.direction) == (impulse, direction))
    return walk_figure(body_answer(robot, method, push).rollout)


def _body_parameters(robot: Robot, rows: Sequence[Row]) -> list[tuple[str, str]]:
    """What every number depends on: name and value."""
    used = {row["method"]: row["parameters"] for row in rows}
    return [
        ("robot", f"{robot.name}, {mechanism_of(robot).mass:.4g} kg with motors; the paper's 85 "
                  "N s are on 70 kg"),
        ("velocity", f"{VELOCITY} m/s"),
        ("pushes", f"on the trunk for 0.2 s, from {PHASE:.0%} of a step on the {FOOT} foot on"),
        ("surroundings", "; ".join(sorted({row["surroundings"] for row in rows}))),
        ("state", "the true one of the body"),
        ("seed", "none: nothing is random"),
        *((body_method(one).label, used.get(one, "not asked")) for one in METHODS),
    ]  # fmt: skip


def _parts(
    command: str,
    parameters: Sequence[tuple[str, str]],
    claims: Sequence[Claim],
    pictures: Sequence[Figure],
) -> list[Part]:
    verdicts = [claim.verdict for claim in claims]
    counts = ", ".join(f"{verdicts.count(one)} {one}" for one in dict.fromkeys(verdicts))
    return [
        Text(
            f"Claims: {counts}. Everything is simulated anew by `{command}`; no number of ours is "
            "written down beforehand."
        ),
        Table("", "", ("parameter", "value"), parameters),
        Table(
            "Claims",
            "",
            COLUMNS,
            [astuple(claim) for claim in claims],
            alarming=(NOT_REPRODUCED, FELL),
        ),
        Details("Figures", pictures),
    ]
