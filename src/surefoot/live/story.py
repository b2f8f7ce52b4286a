"""What happens in a walk, in a sentence and as samples: the push, and what became of the step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.dcm.nominal_gait import NominalGait
from surefoot.dcm.pushes import Push
from surefoot.geometry import rotated
from surefoot.interface import Status
from surefoot.robot.feet import Footstep
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.show.words import counted, direction_words, fall_evidence, velocity_words

SAMPLING = 0.02
"""How often a sample is taken [s]."""

SAME_PLACE, SAME_TIME = 0.01, 0.01
"""A landing that differs by less is the same [m, s]."""

BACK, BACK_STEPS = 0.03, 2
"""How near the DCM offset of a touchdown is to the gait's, in so many steps in a row, of a robot
that is back in its gait [m]."""


class Sample(NamedTuple):
    """One instant for the charts: (x, y) along and across the standing sole [m], and times [s]."""

    time: float
    dcm: tuple[float, float]
    zmp: tuple[float, float]
    step_duration: float
    decision_time: float


def sample_of(snapshot: Snapshot, decision_time: float) -> Sample:
    """The sample of an instant, with the longest decision since the last one [s]."""
    observed = snapshot.observation
    foot, yaw = observed["support_foot"], float(observed["support_yaw"])
    zmp = [a - b for a, b in zip(snapshot.floor_zmp, foot, strict=True)]
    return Sample(
        snapshot.time,
        rotated(observed["dcm"] - foot, -yaw),
        rotated(zmp, -yaw),
        float(snapshot.command["step_duration"]),
        decision_time,
    )


@dataclass(frozen=True)
class _Plan:
    """The step under way when a push began: when it began [s], and where and when it was to end."""

    began: float
    landing: np.ndarray
    time: float
    yaw: float


class Story:
    """The sentence of a walk, from its pushes and instants.

    Args:
        gait: nominal.
        robot: who walks.
        velocity: commanded [m/s]; that of a body's gait differs, to make up for errors.

    Attributes:
        sentence: the latest.
    """

    def __init__(self, gait: NominalGait, robot: Robot, velocity: tuple[float, float]) -> None:
        self._gait, self._robot, self._velocity = gait, robot, velocity
        self._push, self._landed = "", ""
        self._plan: _Plan | None = None
        self._acts_until = -math.inf
        self._began, self._steps, self._back = -math.inf, 0, 0
        self.sentence = self._walking()

    def _walking(self) -> str:
        every = f"a step every {self._gait.step_duration:.2f} s"
        return f"Walking: {velocity_words(self._velocity)}, {every}."

    def pushed(self, push: Push, snapshot: Snapshot) -> None:
        """A push begins; the snapshot is of the moment before."""
        impulse, yaw = math.hypot(*push.impulse), float(snapshot.observation["support_yaw"])
        towards = direction_words(math.atan2(push.force[1], push.force[0]) - yaw)
        self._push = f"Pushed {impulse:.0f} N s {towards} ({impulse / self._robot.mass:.2f} m/s)"
        self._plan, self._landed = _plan_of(snapshot), ""
        self._acts_until = push.end
        self._steps = self._back = 0
        self.sentence = f"{self._push}."

    def watch(self, snapshot: Snapshot, gait: NominalGait, velocity: tuple[float, float]) -> None:
        """Time has passed; gait and velocity are those of now."""
        if velocity != self._velocity and not self._push:
            self._landed = ""
        self._gait, self._velocity, began = gait, velocity, _began(snapshot)
        touched = abs(began - self._began) > 1e-6 and math.isfinite(self._began)
        self._began = began
        if not self._push:
            if not self._landed:
                self.sentence = "Standing." if snapshot.both_feet else self._walking()
            return
        if self._plan is not None:
            self._compare(self._plan, snapshot, began)
        elif touched:
            self._steps += 1
            self._count_back(snapshot)

    def _compare(self, plan: _Plan, snapshot: Snapshot, began: float) -> None:
        """The landing as it is planned now, or as it was, against the one before the push."""
        if abs(began - plan.began) < 1e-6:
            place, time = snapshot.command["step_location"], _plan_of(snapshot).time
            verb = ""
        else:
            place, time, verb = snapshot.observation["support_foot"], began, "landed "
            self._plan = None
        change = _changes(np.asarray(place) - plan.landing, time - plan.time, plan.yaw)
        if verb and not change and snapshot.time < self._acts_until:
            # The push began just before this touchdown: the next landing answers it.
            self._plan = self._nominal_plan(snapshot)
            return
        if change:
            words = f"{verb}{change}" if verb else f"landing {change}"
        else:
            words = "landed as planned" if verb else "the ZMP answers it, the landing stays"
        self._landed = f"{self._push}: {words}"
        self.sentence = f"{self._landed}."

    def _nominal_plan(self, snapshot: Snapshot) -> _Plan:
        """The step that begins, as it would be without a push."""
        observed, gait, began = snapshot.observation, self._gait, _began(snapshot)
        yaw = float(observed["support_yaw"])
        landing = observed["support_foot"] + np.array(rotated(gait.step(snapshot.support), yaw))
        return _Plan(began, landing, began + gait.step_duration, yaw)

    def _count_back(self, snapshot: Snapshot) -> None:
        observed, gait = snapshot.observation, self._gait
        yaw = float(observed["support_yaw"])
        wanted = np.array(rotated(gait.start_offset(snapshot.support), yaw))
        away = float(np.linalg.norm(observed["dcm"] - observed["support_foot"] - wanted))
        self._back = self._back + 1 if away < BACK else 0
        if self._back < BACK_STEPS:
            self.sentence = f"{self._landed}; step {self._steps} after that."
            return
        steps = self._steps + 1 - BACK_STEPS
        after = "at once" if steps <= 0 else f"after {counted(steps, 'more step')}"
        self.sentence = f"{self._landed}; back in its gait {after}."
        self._push = ""

    def fell(self, rollout: Rollout) -> None:
        """It is down: why."""
        fall = rollout.body_fall
        words = fall.sentence if fall is not None else fall_evidence(rollout)
        because = "" if fall is not None else self._because(rollout)
        before = f"{self._landed or self._push}. " if self._push else ""
        self.sentence = f"{before}It fell. {words[:1].upper()}{words[1:]}.{because}"

    def _because(self, rollout: Rollout) -> str:
        """Which limits the last steps were at, of a point mass."""
        robot, steps = self._robot, rollout.footsteps[-4:]
        since = rollout.time >= (steps[0].start if steps else -math.inf)
        pressed = Status(int(np.bitwise_or.reduce(rollout.commands["status"][since])))
        said = []
        if pressed & Status.UNREACHABLE:
            said.append(f"the leg, {robot.swing.max_speed:g} m/s, could not be there in time")
        if any(step.duration < robot.gait.step_duration[0] + 2e-3 for step in steps):
            said.append(f"steps cannot be shorter than {robot.gait.step_duration[0]:g} s")
        if any(_at_the_end(robot, step.side, _along_the_sole(rollout, step)) for step in steps):
            said.append("the landing was at the end of what the legs reach")
        if pressed & Status.ZMP_AT_EDGE:
            said.append("the ZMP was at the edge of the sole")
        words = f" At their limits: {'; '.join(said)}." if said else ""
        moved = any(step.adapted for step in steps)
        return words if moved else f" Its controller did not move its steps.{words}"


def _along_the_sole(rollout: Rollout, step: Footstep) -> tuple[float, float]:
    """A step from the sole that stood, along that."""
    row = int(np.searchsorted(rollout.time, step.start + 1e-9, side="right")) - 1
    return rotated(step.step, -float(rollout.observations["support_yaw"][max(row, 0)]))


def _at_the_end(robot: Robot, side: int, step: tuple[float, float]) -> bool:
    x, y = step[0], side * step[1] - robot.hip
    gait, near = robot.gait, 0.005
    return not (
        gait.step_x[0] + near < x < gait.step_x[1] - near
        and gait.step_y[0] + near < y < gait.step_y[1] - near
    )


def _began(snapshot: Snapshot) -> float:
    return float(snapshot.observation["time"] - snapshot.observation["elapsed"])


def _plan_of(snapshot: Snapshot) -> _Plan:
    began, command = _began(snapshot), snapshot.command
    return _Plan(
        began,
        np.array(command["step_location"]),
        began + float(command["step_duration"]),
        float(snapshot.observation["support_yaw"]),
    )


def _changes(away: np.ndarray, late: float, yaw: float) -> str:
    """How a landing differs: "0.18 s early and 0.21 m further forward"; empty if it does not."""
    said = []
    if abs(late) > SAME_TIME:
        said.append(f"{abs(late):.2f} s {'late' if late > 0.0 else 'early'}")
    distance = float(np.linalg.norm(away))
    if distance > SAME_PLACE:
        towards = direction_words(math.atan2(away[1], away[0]) - yaw)
        said.append(f"{distance:.2f} m further {towards}")
    return " and ".join(said)
