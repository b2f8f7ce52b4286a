"""What happened in a walk: every cycle, every step, the outcome and its evidence."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.pushes import Push
from surefoot.dcm.support import distances_to_support
from surefoot.dcm.viability import viable_offsets
from surefoot.errors import MissingExtraError
from surefoot.geometry import rotated_by
from surefoot.interface import OBSERVATION, Mode
from surefoot.plugins import load, places
from surefoot.robot.feet import Footstep, Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.files import read_rollout, same_bits, write_rollout
from surefoot.rollout.outcome import (
    MONITOR,
    Fall,
    Outcome,
    is_settled,
    mean_velocity,
    settled_rule,
    watch_all,
)

if TYPE_CHECKING:
    # Of the walks of bodies only, and loaded with these.
    from surefoot.rollout.fall import BodyFall
    from surefoot.rollout.trace import BodyTrace, HeldSpeed


@dataclass(frozen=True, eq=False)
class Rollout:
    """A finished walk; arrays are time-first, SI, world frame.

    Attributes:
        robot: the plant.
        controller: name of the controller's class.
        controller_parameters: its parameters, as text.
        velocities: (time, (v_x, v_y)) of every velocity command, the first at time 0 [s, m/s].
        pushes: forces on the CoM.
        fallen: whether the run ended with a fall; not known, and False, if its end is lost.
        observations: what the world did, one `OBSERVATION` record a cycle; all arrays, the outcome
            and the pictures are of it.
        seen: what the controller was given, likewise; the very same array, if left out: the truth.
        commands: what it answered, one `COMMAND` record a cycle; the last one was not carried out.
        decision_time: how long each answer took, wall clock [s]; not part of a comparison.
        disturbance: of what was measured, and of its landings.
        estimator: parameters of the one between, as text; empty if there was none.
        version: of Surefoot.
        body: what the mechanism did, if it was a body in physics; None for a point mass.
        lost_cycles: how many at the end were lost with that of the file it was read from.
        settled_error: largest DCM error of a step that is settled, see `rollout.outcome`; 0
            of a body in physics, which has another rule [m].
    """

    robot: Robot
    controller: str
    controller_parameters: str
    velocities: tuple[tuple[float, tuple[float, float]], ...]
    pushes: tuple[Push, ...]
    fallen: bool
    observations: NDArray[np.void] = field(repr=False)
    commands: NDArray[np.void] = field(repr=False)
    decision_time: NDArray[np.float64] = field(repr=False, compare=False)
    seen: NDArray[np.void] = field(default_factory=lambda: np.empty(0, OBSERVATION), repr=False)
    disturbance: Disturbance | None = None
    estimator: str = ""
    version: str = ""
    body: BodyTrace | None = field(default=None, repr=False)
    lost_cycles: int = 0
    settled_error: float = 0.0

    def __post_init__(self) -> None:
        if not len(self.seen):
            object.__setattr__(self, "seen", self.observations)

    @property
    def time(self) -> NDArray[np.float64]:
        """Instants of the cycles, shape (n,) [s], touchdowns among them.

        A foot that lands at once lands in a cycle of no length: an instant may occur twice.
        """
        return self.observations["time"]

    @property
    def com(self) -> NDArray[np.float64]:
        """Centre of mass, shape (n, 2) [m]."""
        return self.observations["com"]

    @property
    def com_velocity(self) -> NDArray[np.float64]:
        """Its velocity, shape (n, 2) [m/s]."""
        return self.observations["com_velocity"]

    @property
    def dcm(self) -> NDArray[np.float64]:
        """Divergent component of motion, shape (n, 2) [m]."""
        return self.observations["dcm"]

    @property
    def dcm_plan(self) -> NDArray[np.float64]:
        """DCM of the plan, shape (n, 2) [m]."""
        return self.commands["dcm_plan"]

    @property
    def dcm_error(self) -> NDArray[np.float64]:
        """dcm - dcm_plan, shape (n, 2) [m]."""
        return self.dcm - self.dcm_plan

    @property
    def zmp(self) -> NDArray[np.float64]:
        """Zero-moment point, shape (n, 2) [m].

        On a point mass the one that was commanded; of a body that of the floor's forces, NaN in
        the air.
        """
        return self.commands["zmp"] if self.body is None else self.body.zmp

    @property
    def support_foot(self) -> NDArray[np.float64]:
        """Centre of the sole on the ground, shape (n, 2) [m]."""
        return self.observations["support_foot"]

    @property
    def support_side(self) -> NDArray[np.int64]:
        """The foot on the ground, a `Side`, shape (n,)."""
        return self.observations["support_side"]

    @property
    def swing_foot(self) -> NDArray[np.float64]:
        """Centre of the sole in the air, shape (n, 3) [m]."""
        return self.observations["swing_foot"]

    @property
    def adapting(self) -> NDArray[np.bool_]:
        """Whether the step was being decided anew, shape (n,)."""
        return self.commands["mode"] == Mode.ADAPTING

    @property
    def zmp_excess(self) -> NDArray[np.float64]:
        """How far the ZMP lies outside the soles on the ground, 0 inside, shape (n,) [m]."""
        excess = np.empty(len(self.time))
        distances_to_support(self.observations, self.commands, *self.robot.foot.half, excess)
        # A ZMP projected onto the edge differs from it by the rounding of the world coordinates.
        return np.where(excess > 1e-11 * self.robot.foot.length, excess, 0.0)

    @property
    def velocity(self) -> tuple[float, float]:
        """The velocity that was commanded last (x, y) [m/s]."""
        return self.velocities[-1][1]

    def _steps(self) -> list[tuple[int, int]]:
        """First cycle of every finished step, and that of its touchdown."""
        side = self.support_side
        touchdowns = np.flatnonzero(side[1:] != side[:-1]) + 1
        if self.body is None:
            starts = np.concatenate(([0], touchdowns[:-1])) if len(touchdowns) else touchdowns
            return list(zip(starts.tolist(), touchdowns.tolist(), strict=True))
        # A body stands on both feet before its first step and after its last.
        walking = self.body.walking
        changes = np.flatnonzero(walking[1:] != walking[:-1]) + 1
        cuts = np.union1d(changes, touchdowns).tolist()
        return [(first, last) for first, last in pairwise(cuts) if walking[first]]

    @cached_property
    def footsteps(self) -> tuple[Footstep, ...]:
        """The finished steps."""
        side = self.support_side
        steps = []
        for index, (first, last) in enumerate(self._steps()):
            stands = self.body is None or self.body.walking[last]
            # The step before a stand ends on the foot that swung, which carries no step after it.
            landing = self.support_foot[last] if stands else self.swing_foot[last, :2]
            start = self.time[first] - self.observations["elapsed"][first]
            steps.append(
                Footstep(
                    index=index,
                    side=Side(int(side[first])),
                    support_foot=_pair(self.support_foot[first]),
                    start=float(start),
                    duration=float(self.time[last] - start),
                    landing=_pair(landing),
                    dcm_offset=_pair(self.dcm[last] - landing),
                    adapted=bool(self.adapting[first:last].any()),
                )
            )
        return tuple(steps)

    @cached_property
    def _monitor(self) -> NDArray[np.void]:
        monitor = np.zeros(1, MONITOR)
        watch_all(monitor, self.observations, self.commands)
        return monitor

    @property
    def mass(self) -> float:
        """What a push moves: of a body all its links and its payload, else the robot's [kg]."""
        if self.body is None or self.body.mass is None:
            return self.robot.mass
        return self.body.mass

    @property
    def final_velocity(self) -> tuple[float, float]:
        """Mean velocity over the last two finished steps, NaN before there are two (x, y) [m/s]."""
        return _pair(mean_velocity(self._monitor[0]))

    @cached_property
    def outcome(self) -> Outcome:
        """How the walk ended."""
        if self.lost_cycles:
            return Outcome.CUT_SHORT
        if self.fallen:
            return Outcome.FELL
        if self.body is not None:
            return self.body.outcome(self)
        rule = settled_rule(self.robot, self.velocity, self.settled_error)
        if not is_settled(self._monitor[0], rule[0]):
            return Outcome.UNSETTLED
        end = float(self.time[-1])
        pushed = any(push.start < end for push in self.pushes)
        if any(push.start < end < push.end + rule["time"][0] for push in self.pushes):
            return Outcome.UNSETTLED
        return Outcome.RECOVERED if pushed else Outcome.WALKED

    @cached_property
    def held_speed(self) -> HeldSpeed | None:
        """How a body held its commanded speed; None for a point mass, or if it is too soon."""
        if self.body is None:
            return None
        return self.body.held_speed(self)

    @cached_property
    def fall(self) -> Fall | None:
        """The evidence, if it fell; viability is that of a finite foot and an unlimited leg."""
        if not self.fallen:
            return None
        lost = viable = None
        for step, (_, last) in zip(self.footsteps, self._steps(), strict=True):
            # The limits are those along the sole that the offset belongs to.
            offset = rotated_by(np.array(step.dcm_offset), -self.observations["support_yaw"][last])
            margin = viable_offsets(self.robot, step.side, self.robot.foot.half).margin(
                _pair(offset)
            )
            if margin < 0.0:
                lost = (step, margin)
                break
            viable = (step, margin)
        away = rotated_by(
            self.dcm[-1] - self.support_foot[-1], -self.observations["support_yaw"][-1]
        )
        return Fall(
            time=float(self.time[-1]),
            distance=float(np.hypot(*away)),
            last_viable_time=viable[0].start + viable[0].duration if viable else None,
            last_margin=viable[1] if viable else None,
            lost_time=lost[0].start + lost[0].duration if lost else None,
            lost_margin=lost[1] if lost else None,
            limit=_direction(away),
        )

    @cached_property
    def body_fall(self) -> BodyFall | None:
        """Why the body fell, if one did."""
        if not self.fallen or self.body is None:
            return None
        return self.body.fall(self)

    def plot(self, path: str | Path) -> None:
        """Draw the walk: top view, and x and y over time.

        The picture comes from the viewer that is registered as "walk" in the entry-point group
        "surefoot.figures".

        Args:
            path: file to write; its ending names the format (.png, .pdf, .svg).

        Raises:
            MissingExtraError: the extra `plot` is not installed.
            FileError: the file cannot be written.
        """
        try:
            draw = load(places("surefoot.figures")["walk"])
        except ModuleNotFoundError as error:
            if error.name != "matplotlib":
                raise
            raise MissingExtraError("pictures", "plot") from error
        draw(self, Path(path))

    def save(self, path: str | Path, **beside: NDArray[Any]) -> None:
        """Write everything to a file.

        Args:
            path: file to write, ending in .npz (a NumPy archive) or .mcap (a log for ROS 2, which
                Foxglove and PlotJuggler open too; `load_rollout` reads what is whole of a part).
            **beside: other arrays that an archive is to hold.

        Raises:
            FileError: another ending, or the file cannot be written.
            MissingExtraError: a log, and the extra `log` is not installed.
        """
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        write_rollout(Path(path), values, beside)

    def __eq__(self, other: object) -> bool:
        return type(other) is Rollout and all(
            same_bits(getattr(self, item.name), getattr(other, item.name))
            for item in fields(self)
            if item.compare
        )

    __hash__ = None  # type: ignore[assignment]


def describe(value: Any) -> str:
    """The parameters of a controller or an estimator as text, but for robot and velocity."""
    parts = []
    for parameter in fields(value):
        if parameter.init and parameter.name not in ("robot", "velocity", "multibody"):
            parts.append(f"{parameter.name}={getattr(value, parameter.name)!r}")
    return ", ".join(parts)


def load_rollout(path: str | Path) -> Rollout:
    """Read a rollout that `Rollout.save` wrote.

    Of a log (.mcap) that was cut short, by a full disk for example, all whole cycles are read and
    a warning says so; the outcome of such a rollout is `Outcome.CUT_SHORT`.

    Args:
        path: the file.

    Raises:
        FileError: there is no such file, it is damaged, no whole cycle is in it, or another version
            wrote it.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    values, remark = read_rollout(Path(path))
    if remark:
        warnings.warn(remark, stacklevel=2)
    return Rollout(**values)


def _pair(values: Any) -> tuple[float, float]:
    x, y = values
    return float(x), float(y)


def _direction(away: NDArray[np.float64]) -> str:
    """The name of the dominant direction of a vector."""
    if abs(away[0]) >= abs(away[1]):
        return "forward" if away[0] > 0.0 else "backward"
    return "left" if away[1] > 0.0 else "right"
