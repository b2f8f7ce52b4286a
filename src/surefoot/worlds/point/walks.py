"""A table of walks, a row each: start, pushes, controller, plant and disturbance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_seed, closest
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import PUSH, Push, push_records
from surefoot.errors import ParameterError
from surefoot.interface import Controller, Observation
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.progress import new_progress
from surefoot.worlds.point.sensors import PointSensors

CHUNK = 4096
"""So many walks are prepared at once: enough to share, and no memory for a million."""

COLUMNS = (
    "pushes", "starts", "controllers", "durations", "plants", "disturbances", "seeds",
)  # fmt: skip
"""Of a table, beside the parameters."""


KINDS = {
    "starts": Observation, "controllers": Controller, "plants": Robot, "disturbances": Disturbance,
}  # fmt: skip
"""What the rows of some columns are."""


@dataclass(frozen=True)
class Walks:
    """What differs from one walk of a batch to the next; a column that is None is the same for all.

    All columns have a row for each walk.

    Args:
        pushes: lists of `Push`, of any length each; or an array of `PUSH` records, shape (walks,
            pushes), for tables too large for lists.
        starts: the first observations.
        parameters: of the controller, by name: `{"dcm_gain": [1.0, 3.0]}`; what its class takes
            may stand here, `robot` and `velocity` included. Rows that are alike are made once.
        controllers: in the place of the one of all, and of `parameters`; of the same class.
        durations: how long to walk at most [s].
        plants: the robots that are moved, if they are not the ones the controllers believe in.
        disturbances: of what is measured and of landings.
        seeds: of the noise, in the place of those of the disturbances.
        count: how many walks there are; from the columns if None.

    Raises:
        ParameterError: a column has another length, a row another type, or nothing says how many
            walks there are.
    """

    pushes: Sequence[Sequence[Push]] | NDArray[np.void] | None = None
    starts: Sequence[Observation] | None = None
    parameters: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    controllers: Sequence[Controller] | None = None
    durations: Sequence[float] | None = None
    plants: Sequence[Robot] | None = None
    disturbances: Sequence[Disturbance] | None = None
    seeds: Sequence[int] | NDArray[np.int64] | None = None
    count: int | None = None

    def __post_init__(self) -> None:
        columns: dict[str, Sized | None] = {name: getattr(self, name) for name in COLUMNS}
        columns |= {f"parameters[{name!r}]": rows for name, rows in self.parameters.items()}
        for name, rows in columns.items():
            if rows is not None and not isinstance(rows, Sized):
                raise ParameterError(
                    f"`{name}`: a list with an entry for each walk", repr(rows), "write [...]"
                )
        lengths = {name: len(rows) for name, rows in columns.items() if rows is not None}
        if self.count is not None:
            whole = isinstance(self.count, (int, np.integer)) and not isinstance(self.count, bool)
            if not whole or self.count < 0:
                raise ParameterError(
                    "a number of walks", repr(self.count), "give a whole number, such as 1000"
                )
            lengths["count"] = int(self.count)
        if not lengths:
            raise ParameterError(
                "a table with at least one column", "none", "give `pushes`, or `count=1000`"
            )
        if len(set(lengths.values())) > 1:
            said = ", ".join(f"{name} of {length}" for name, length in lengths.items())
            raise ParameterError("columns with a row for each walk", said, "make them equally long")
        object.__setattr__(self, "count", next(iter(lengths.values())))
        for name, kind in KINDS.items():
            rows = getattr(self, name)
            for one in () if rows is None else rows:
                if not isinstance(one, kind):
                    raise ParameterError(
                        f"`{name}` with a {kind.__name__} for each walk", repr(one), "make it one"
                    )
        for duration in self.durations if self.durations is not None else ():
            check_number("durations", duration, 0.0, "s", above=True)
        for seed in self.seeds if self.seeds is not None else ():
            check_seed(seed.item() if isinstance(seed, np.generic) else seed)

    def __len__(self) -> int:
        return int(self.count or 0)

    def push_table(self) -> NDArray[np.void]:
        """The pushes as `PUSH` records, shape (walks, most of a walk); a row is filled up with
        records that never begin.

        Raises:
            ParameterError: a row holds anything but pushes.
        """
        if self.pushes is None:
            return np.zeros((len(self), 0), PUSH)
        if isinstance(self.pushes, np.ndarray):
            if self.pushes.dtype != PUSH or self.pushes.ndim != 2:
                raise ParameterError(
                    "an array of PUSH records, shape (walks, pushes)",
                    f"{self.pushes.dtype}, shape {self.pushes.shape}",
                    "make it with np.zeros((walks, pushes), surefoot.dcm.pushes.PUSH)",
                )
            table = np.ascontiguousarray(self.pushes)
            start, end, force = table["start"], table["end"], table["force"]
            sound = np.isfinite(start) & (end >= start) & np.isfinite(force).all(axis=-1)
            if not sound.all():
                raise ParameterError(
                    "PUSH records with a finite start and force, and an end not before the start",
                    f"{table[~sound][0]}",
                    "leave a row of zeros for no push",
                )
            return table
        for pushes in self.pushes:
            if not isinstance(pushes, Sequence):
                raise ParameterError(
                    "a list of pushes for each walk", repr(pushes), "write [[push], [push]]"
                )
        table = np.zeros((len(self), max(map(len, self.pushes), default=0)), PUSH)
        for row, pushes in zip(table, self.pushes, strict=True):
            row[: len(pushes)] = push_records(pushes)
        return table

    def deciders(self, controller: Controller) -> Sequence[Controller]:
        """The controller of each walk; those with the same parameters are the same object.

        Args:
            controller: what all have in common.

        Raises:
            ParameterError: its class takes no parameter of such a name, or the controllers of the
                table are of several classes.
            SurefootError: it refuses a value.
        """
        if self.controllers is not None:
            classes = {type(one).__name__ for one in self.controllers}
            if len(classes) > 1 or self.parameters:
                raise ParameterError(
                    "controllers of one class, and no `parameters` beside them",
                    f"{', '.join(sorted(classes))}; parameters {sorted(self.parameters)}",
                    "walk each class in a batch of its own",
                )
            return self.controllers
        if not self.parameters:
            return [controller] * len(self)
        takes = [one.name for one in fields(controller) if one.init]  # type: ignore[arg-type]
        for name in self.parameters:
            if name not in takes:
                raise ParameterError(
                    f"parameters of {type(controller).__name__} ({', '.join(takes)})",
                    repr(name),
                    closest(name, takes, "correct the name"),
                )
        made: dict[Any, Controller] = {}
        rows = zip(*self.parameters.values(), strict=True)
        return [self._made(controller, row, made) for row in rows]

    def _made(
        self, controller: Controller, row: tuple[Any, ...], made: dict[Any, Controller]
    ) -> Controller:
        values = tuple(
            tuple(map(float, value)) if isinstance(value, (list, np.ndarray)) else value
            for value in (one.item() if isinstance(one, np.generic) else one for one in row)
        )
        # A robot is compared by what it says, which takes its time; by identity it does not.
        key = tuple(id(value) if isinstance(value, Robot) else value for value in values)
        try:
            known = key in made
        except TypeError:
            raise ParameterError(
                f"numbers, words or pairs for {', '.join(self.parameters)}",
                repr(row),
                "pass `controllers` for anything else",
            ) from None
        if not known:
            changes = dict(zip(self.parameters, values, strict=True))
            made[key] = replace(controller, **changes)  # type: ignore[type-var]
        return made[key]


class Scene(NamedTuple):
    """What walks have in common that differ in their pushes and seeds only."""

    controller: Controller
    simulator: LipmSimulator
    sensors: PointSensors
    start: Observation
    progress: NDArray[np.void]


class Question(NamedTuple):
    """What all walks of a batch have in common."""

    controller: Controller
    duration: float
    ends_early: bool
    first_support: Side | None
    plant: Robot | None
    disturbance: Disturbance | None
    estimator: Estimator | None

    def scene(
        self,
        controller: Controller,
        plant: Robot | None,
        disturbance: Disturbance | None,
        duration: float,
    ) -> Scene:
        """The scene of one walk from the usual start; what is None is that of all."""
        plant = plant or self.plant or controller.robot
        disturbance = disturbance or self.disturbance
        return Scene(
            controller,
            LipmSimulator(
                plant, controller.period, disturbance=disturbance, believed=controller.robot
            ),
            PointSensors(controller, plant, disturbance, self.estimator),
            controller.first_observation(self.first_support),
            new_progress(plant, controller, duration, ends_early=self.ends_early),
        )


class Chunk(NamedTuple):
    """Some walks of a table: which, their scenes, and by walk the scene, seed (-1 for that of the
    disturbance) and `PUSH` records."""

    where: slice
    scenes: list[Scene]
    scene: NDArray[np.int64]
    seeds: NDArray[np.int64]
    pushes: NDArray[np.void]


def chunks_of(question: Question, table: Walks) -> Iterator[Chunk]:
    """The walks of a table, ready to be walked, so many at once."""
    controllers, pushes = table.deciders(question.controller), table.push_table()
    starts, plants = table.starts, table.plants
    disturbances = table.disturbances
    seeds = np.full(len(table), -1) if table.seeds is None else np.asarray(table.seeds, np.int64)
    for first in range(0, len(table), CHUNK):
        where = slice(first, min(first + CHUNK, len(table)))
        usual: dict[tuple[float, ...], Scene] = {}
        scenes: dict[tuple[float, ...], Scene] = {}
        numbers: dict[tuple[float, ...], int] = {}
        scene = np.zeros(where.stop - first, np.int64)
        for i in range(first, where.stop):
            row = (
                controllers[i],
                None if plants is None else plants[i],
                None if disturbances is None else disturbances[i],
            )
            duration = question.duration if table.durations is None else table.durations[i]
            kind = (*map(id, row), duration)
            if kind not in usual:
                usual[kind] = question.scene(*row, duration)
            start = usual[kind].start if starts is None else starts[i]
            key = (*kind, id(start))
            if key not in scenes:
                scenes[key], numbers[key] = usual[kind]._replace(start=start), len(scenes)
            scene[i - first] = numbers[key]
        yield Chunk(where, list(scenes.values()), scene, seeds[where], pushes[where])


def last_ends(pushes: NDArray[np.void]) -> NDArray[np.float64]:
    """When the last push of each walk is over, 0 without any [s].

    Args:
        pushes: `PUSH` records, shape (walks, pushes).
    """
    return np.max(pushes["end"], axis=1, initial=0.0)


def first_starts(pushes: NDArray[np.void]) -> NDArray[np.float64]:
    """When the first push of each walk begins, inf without any [s]; arguments as of `last_ends`."""
    real = pushes["end"] > pushes["start"]
    return np.min(np.where(real, pushes["start"], math.inf), axis=1, initial=math.inf)
