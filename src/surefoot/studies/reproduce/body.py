"""The pushes of [OnlineGait] on a body in physics, in the same phase of the same step.

In the paper a point mass walks at 0.5 m/s in steps of 0.5 s and is pushed at 1.1 s: 0.1 s into its
third step, when the right foot stands. A body steps within other durations, so what is kept is the
foot and the part of the step that is over.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from surefoot.robot.feet import Footstep, Side
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.studies.engine.body_recovery import used_after
from surefoot.studies.engine.pushed_body import PushedBody, body_method
from surefoot.studies.reproduce.walks import NOT_REPRODUCED, REPRODUCED, VELOCITY, Claim

IN_PART, BEYOND, FELL = "reproduced in part", "survived, beyond the paper", "not survived"
"""Of a body that walks on, but not as the paper says; and of pushes that the paper has not."""

PHASE, FOOT = 0.2, "right"
"""Part of the step that is over, and the foot that stands: those of 1.1 s in the paper."""

METHODS = ("hybrid", "unified")
"""The paper's controller, and ours."""

BACK = 0.02
"""A DCM at touchdown that is this close to that of the walk without a push is back [m]."""

SHORTER = 0.9
"""Of the step without a push: one that lasts less is shorter in time [-]."""


@dataclass(frozen=True)
class PaperPush:
    """A push of the paper.

    Attributes:
        figure: where.
        impulse: forward or sideways [N s].
        direction: one of `dcm.pushes.DIRECTIONS`.
        paper: what it reports of a point mass.
        steps: after how many the DCM is nominal again, as far as the paper says; 0 if the push is
            ours.
        shorter: whether the pushed step is to be shorter in time.
    """

    figure: str
    impulse: float
    direction: str
    paper: str
    steps: int | None = None
    shorter: bool = False


_NINE = "third step much shorter in time; d = d_nom again after that one step"
_ONE_STEP = "the largest push that one step recovers from"

PAPER_PUSHES = (
    PaperPush("Figs. 9, 10", 35.2, "forward", _NINE, 1, True),
    PaperPush("Figs. 9, 10", 35.2, "outward", "no such push in the paper", 0),
    PaperPush("Figs. 9, 10", 35.2, "inward", "no such push in the paper", 0),
    PaperPush("IV-B, one step", 70.56, "forward", _ONE_STEP, 1),
    PaperPush("IV-B, one step", 58.8, "outward", _ONE_STEP, 1),
    PaperPush("IV-B, one step", 58.8, "inward", _ONE_STEP, 1),
    PaperPush(
        "Figs. 11, 12", 82.32, "forward",
        "longest step at the third, d > d_nom; d and both velocities return over several steps",
    ),
    PaperPush(
        "abstract", 85.0, "forward", "85 N s on 70 kg, where adapting the landing alone bears 20"
    ),
)  # fmt: skip
"""All with the paper's 0.2 s; outward is towards the swing foot."""

DRAWN = {
    ("hybrid", 35.2, "forward"),
    ("unified", 35.2, "forward"),
    ("unified", 35.2, "inward"),
    ("unified", 82.32, "forward"),
}
"""Walks that are drawn, and listed step by step."""


@dataclass(frozen=True)
class BodyAnswer:
    """What a body did with a push.

    Attributes:
        method: key of the controller's.
        push: of the paper.
        rollout: the walk, from its stand on.
        usual: the same walk without a push.
        begin: when the push began [s].
        alive: whether it walked on for 5 s.
    """

    method: str
    push: PaperPush
    rollout: Rollout
    usual: Rollout
    begin: float
    alive: bool

    @property
    def steps(self) -> tuple[Footstep, ...]:
        """The pushed step and all after it."""
        return self._since(self.rollout)

    def _since(self, walk: Rollout) -> tuple[Footstep, ...]:
        return tuple(step for step in walk.footsteps if step.start + step.duration > self.begin)

    @property
    def usual_step(self) -> Footstep:
        """The pushed step as it would have been."""
        return self._since(self.usual)[0]

    @property
    def off(self) -> list[float]:
        """How far the DCM is, step by step, from where it usually is when that foot lands [m]."""
        usual = {
            side: np.mean([s.dcm_offset for s in self._since(self.usual) if s.side == side], axis=0)
            for side in Side
        }
        return [float(np.hypot(*(step.dcm_offset - usual[step.side]))) for step in self.steps]

    @property
    def back_after(self) -> int | None:
        """How many landings it took until the DCM was back for good; None if it never was."""
        away = [index for index, off in enumerate(self.off) if off > BACK]
        after = away[-1] + 2 if away else 1
        return after if self.alive and after <= len(self.off) else None


@lru_cache(maxsize=len(METHODS) * len(PAPER_PUSHES))
def body_answer(robot: Robot, method: str, push: PaperPush) -> BodyAnswer:
    """Walk at the paper's velocity, and be pushed as there; each push comes at the same moment of
    the same walk.

    Args:
        robot: with a body.
        method: one of `engine.pushed_body.BODY_METHODS`.
        push: of the paper.

    Raises:
        SurefootError: the robot has no body, or does not walk at that velocity.
    """
    walk = PushedBody(robot, method, FOOT, PHASE, VELOCITY)
    rollout, end = walk.rollout(walk.push(push.direction, push.impulse))
    return BodyAnswer(method, push, rollout, _usual(walk), walk.start.time, end.survived)


@lru_cache(maxsize=1)
def _usual(walk: PushedBody) -> Rollout:
    """The walk that is not pushed."""
    return walk.rollout(walk.push("forward", 0.0))[0]


def body_claim(answer: BodyAnswer) -> Claim:
    """The paper's words of a point mass beside what the body did."""
    push, first = answer.push, answer.steps[0] if answer.steps else None
    label = body_method(answer.method).label
    where = f"{push.impulse:g} N s, {push.direction}; {label}"
    fall = answer.rollout.body_fall
    if not answer.alive or first is None:
        cause = "it stopped stepping" if fall is None else fall.sentence
        verdict = FELL if push.steps == 0 else NOT_REPRODUCED
        return Claim(push.figure, where, push.paper, "falls", verdict, cause)
    usual, after = answer.usual_step, answer.back_after
    used = used_after(answer.rollout, answer.begin)
    x, y = np.subtract(first.step, usual.step)
    late = 1000.0 * used["latest landing"]
    ours = (
        f"walks on; the pushed step lasts {first.duration:.2f} s (without the push "
        f"{usual.duration:.2f}) and lands {x:+.2f} m in x and {y:+.2f} m in y from where it would "
        f"have; {back_words(answer)}; feet within {100.0 * used['largest landing error']:.1f} cm "
        f"of their targets, the last by {abs(late):.0f} ms {'early' if late < 0.0 else 'late'}"
    )
    short = not push.shorter or first.duration < SHORTER * usual.duration
    in_time = after is not None and (not push.steps or after <= push.steps)
    why = [
        "" if short else "it steps further rather than much sooner: a heavy leg needs its time",
        ""
        if in_time
        else "legs that swing carry momentum of their own, and a sole that rolls "
        "freely takes up nothing sideways",
    ]
    if after is None:
        last = answer.steps[-1]
        why.append(f"its last steps are {abs(last.step[1]):.2f} m wide ({abs(usual.step[1]):.2f})")
    reasons = "; ".join(words for words in why if words)
    verdict = REPRODUCED if short and in_time else IN_PART
    if push.steps == 0:
        verdict = BEYOND
    return Claim(
        push.figure, where, push.paper, ours, verdict, reasons or "on the body as on the point mass"
    )


def back_words(answer: BodyAnswer) -> str:
    """When the DCM was back."""
    after = answer.back_after
    if after is None:
        return f"the DCM does not come back within {100.0 * BACK:g} cm at touchdowns"
    landings = "the first landing" if after == 1 else f"landing {after}"
    return f"the DCM is back within {100.0 * BACK:g} cm at touchdowns from {landings} on"


SHOWN_STEPS = 6
"""So many steps of a walk are listed, from the pushed one on."""


def step_rows(answer: BodyAnswer) -> list[list[str]]:
    """Steps from the pushed one on: walk, foot, duration, length, width and error of the DCM."""
    push = answer.push
    walk = f"{body_method(answer.method).label}, {push.impulse:g} N s {push.direction}"
    return [
        [
            walk, str(number), step.side.name.lower(), f"{step.duration:.3f}",
            f"{step.step[0]:.3f}", f"{abs(step.step[1]):.3f}", f"{100.0 * off:.1f}",
        ]
        for number, (step, off) in enumerate(zip(answer.steps, answer.off, strict=False), start=1)
        if number <= SHOWN_STEPS
    ]  # fmt: skip


STEP_COLUMNS = ("walk", "step", "foot", "duration [s]", "length [m]", "width [m]", "DCM off [cm]")
"""Of `step_rows`."""
