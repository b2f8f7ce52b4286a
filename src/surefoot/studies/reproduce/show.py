"""The reports beside the paper: of its point mass, and of its pushes on a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from functools import partial

from surefoot.robot.robot import Robot
from surefoot.show.walk_figure import walk_figure
from surefoot.studies.engine.report import Details, Figure, Part, Report, Table, Text
from surefoot.studies.reproduce.body import (
    FELL,
    STEP_COLUMNS,
    BodyAnswer,
    body_claim,
    body_parameters,
    step_rows,
)
from surefoot.studies.reproduce.figures import PICTURES
from surefoot.studies.reproduce.measure import PaperResults, paper_parameters
from surefoot.studies.reproduce.one_step import limits_table
from surefoot.studies.reproduce.question import NOT_REPRODUCED, Claim

COLUMNS = ("where", "what", "paper", "ours", "verdict", "why")
"""Of the table of claims."""


def paper_report(robot: Robot, results: PaperResults) -> Report:
    """The paper on its point mass.

    Args:
        robot: that was pushed.
        results: of `measure.reproduce_paper`.
    """
    pictures = [
        Figure(
            f"pictures/{name}.png", caption, partial(draw, results.rollouts),
            page="link" if name == "decision-time" else "inside",
        )
        for name, (caption, draw) in PICTURES.items()
    ]  # fmt: skip
    parts = _parts("surefoot reproduce", paper_parameters(robot), results.claims, pictures)
    heading = "The paper, figure by figure and number by number"
    return Report("paper", heading, (), (*parts, limits_table(results.limits)))


def body_report(robot: Robot, answers: Sequence[BodyAnswer]) -> Report:
    """The paper's pushes on a body.

    Args:
        robot: that was pushed.
        answers: of `body.paper_push_answers`.
    """
    claims, pictures = [body_claim(one) for one in answers], []
    for one, claim in zip(answers, claims, strict=True):
        if one.drawn and one.rollout.body is not None:
            name = f"body-{one.method}-{one.push.impulse:g}-{one.push.direction}"
            caption = f"{claim.figure}: {claim.text}. {claim.ours}."
            draw = partial(walk_figure, one.rollout)
            pictures.append(Figure(f"pictures/{name}.png", caption, draw))
    steps = Table(
        "Step by step",
        "From the pushed step on. The last column is how far the DCM is, when the foot lands, "
        "from where it is without a push.",
        STEP_COLUMNS,
        step_rows([one for one in answers if one.drawn]),
    )
    command = "surefoot reproduce --simulator mujoco"
    parts = _parts(command, body_parameters(robot, answers), claims, pictures)
    return Report("paper_body", "The paper's pushes on a body", (), (*parts, steps))


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
