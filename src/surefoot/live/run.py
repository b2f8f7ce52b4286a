"""A walk in real time and a ghost beside it: what a page shows, and what it may ask for.

No page is needed for it: requests may come from any thread, time passes in `advance`.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from surefoot.dcm.pushes import Push
from surefoot.errors import SurefootError
from surefoot.live.story import SAMPLING, Sample, Story, sample_of
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.worlds.steering import Steering
from surefoot.worlds.world import World

PUSH_DURATION = 0.2
"""Of every push, as everywhere [s]."""

FASTEST = 2.0
"""Of all paces [-]."""

LARGEST_IMPULSE = 300.0
"""Of all pushes [N s]."""

REMEMBERED = 6.0
"""How much of the past the charts show [s]."""


@dataclass(frozen=True)
class Choice:
    """Who walks.

    Attributes:
        robot: preset or file.
        controller: key of a method.
        ghost: key of the second one's, "" if there is none.
        simulator: "lipm", "three-mass" or "mujoco".
    """

    robot: str = "paper-biped"
    controller: str = "unified"
    ghost: str = ""
    simulator: str = "lipm"


class View(NamedTuple):
    """One instant of a run: how often walks were made anew, both walks, and their instants."""

    generation: int
    walk: World
    ghost: World | None
    snapshot: Snapshot
    ghost_snapshot: Snapshot | None


MakeWalk = Callable[[Choice, str, Steering], World]
"""A walk of the chosen robot with the controller of this key, steered from the start."""


class LiveRun:
    """A walk and its ghost, under the same pushes.

    Args:
        make: makes a walk.
        choice: who walks.
        steering: where to.

    Attributes:
        paused: whether time stands still.
        notice: what could not be done, for people; empty if all could.
        generation: how often walks were made anew.

    Raises:
        SurefootError: that walk cannot be made.
    """

    def __init__(self, make: MakeWalk, choice: Choice, steering: Steering) -> None:
        self._make, self._lock = make, threading.RLock()
        self.paused, self.notice, self.generation, self._pace = False, "", 0, 1.0
        self.samples: deque[Sample] = deque(maxlen=round(REMEMBERED / SAMPLING))
        self._wanted = choice
        self._begin(self._make_walks(choice, steering), choice, steering)

    @property
    def _walks(self) -> list[World]:
        """The walk, and the ghost if there is one."""
        return [self.walk] if self.ghost is None else [self.walk, self.ghost]

    def _make_walks(self, choice: Choice, steering: Steering) -> tuple[World, World | None]:
        """Walk and ghost, after their first cycle; this may take seconds."""
        walk = self._make(choice, choice.controller, steering)
        ghost = self._make(choice, choice.ghost, steering) if choice.ghost else None
        for one in (walk, ghost):
            if one is not None:
                one.step()
        return walk, ghost

    def _begin(self, walks: tuple[World, World | None], choice: Choice, steering: Steering) -> None:
        self.walk, self.ghost = walks
        self.choice, self.steering = choice, steering
        self.story = Story(self.walk.controller.gait, self.walk.robot, steering.velocity)
        self.samples.clear()
        self._slowest, self._next_sample, self._now = 0.0, 0.0, self.walk.time
        self._pushed_until = -math.inf
        self.generation += 1

    @property
    def pace(self) -> float:
        """Simulated seconds in a second of the wall clock [-]."""
        return self._pace

    @pace.setter
    def pace(self, pace: float) -> None:
        # The value comes from a browser, unchecked.
        if math.isfinite(pace):
            self._pace = min(max(pace, 0.0), FASTEST)

    def reset(self) -> None:
        """From the start, as chosen."""
        self.choose(self.choice)

    def choose(self, choice: Choice) -> None:
        """Somebody else walks, from the start; if that cannot be, `notice` says why.

        Meanwhile the old one walks on; of two choices the last one counts.
        """
        with self._lock:
            # A copy: the same choice, made again, is another request.
            self._wanted = wanted = replace(choice)
            steering = asked = self.steering
            self.notice = f"{choice.robot} is made ready"
        notice, made = "", None
        try:
            made = self._make_walks(choice, steering)
        except SurefootError as first:
            try:
                # A robot may be slower than the last one: it begins in place.
                made, steering = self._make_walks(choice, Steering()), Steering()
                notice = f"walks in place: {first}"
            except SurefootError as error:
                notice = str(error)
        with self._lock:
            if self._wanted is not wanted:
                return
            self.notice = notice
            if made is not None:
                since = self.steering
                self._begin(made, choice, steering)
                if since is not asked:
                    self.steer(since)

    def steer(self, steering: Steering) -> None:
        """Walk elsewhere; if it cannot, it goes on as before, and `notice` says why."""
        with self._lock:
            try:
                if not steering.standing:
                    # All of them can walk so, or none is steered.
                    for one in self._walks:
                        one.controller.with_velocity(steering.velocity)
                for one in self._walks:
                    one.steer(steering)
                self.steering, self.notice = steering, ""
            except SurefootError as error:
                self.notice = str(error)

    def push(self, direction: float, impulse: float) -> None:
        """Push both walks now.

        Args:
            direction: counter-clockwise from the robot's own forward [rad].
            impulse: over 0.2 s [N s].
        """
        with self._lock:
            if self.walk.fallen or not math.isfinite(impulse) or not math.isfinite(direction):
                return
            if self.walk.time < self._pushed_until:
                # One push at a time: a key that is held down sends many.
                return
            impulse = min(max(impulse, 0.0), LARGEST_IMPULSE)
            self._pushed_until = self.walk.time + PUSH_DURATION
            snapshot = self.walk.snapshot()
            angle = direction + float(snapshot.observation["support_yaw"])
            towards = math.cos(angle), math.sin(angle)
            push = Push.of_impulse(impulse, towards, self.walk.time, PUSH_DURATION)
            self.story.pushed(push, snapshot)
            for one in self._walks:
                if not one.fallen:
                    one.push(push)

    def advance(self, seconds: float) -> None:
        """Let time pass [s]: of the walks, not of the clock."""
        with self._lock:
            self._now += seconds
            until = self._now
            while self.walk.time < until - 1e-9 and not self.walk.fallen:
                self.walk.step()
                self._slowest = max(self._slowest, self.walk.decision_time)
                if self.paused or self.walk.time >= self._next_sample or self.walk.fallen:
                    self._sample()
            # The ghost goes on after a fall of the walk.
            ghost = self.ghost
            while ghost is not None and not ghost.fallen and ghost.time < until - 1e-9:
                ghost.step()

    def _sample(self) -> None:
        snapshot = self.walk.snapshot()
        self.samples.append(sample_of(snapshot, self._slowest))
        self._slowest, self._next_sample = 0.0, self.walk.time + SAMPLING
        self.story.watch(snapshot, self.walk.controller.gait, self.steering.velocity)
        if self.walk.fallen:
            self.story.fell(self.walk.rollout())

    def view(self) -> View:
        """What there is to see now."""
        with self._lock:
            ghost = None if self.ghost is None else self.ghost.snapshot()
            return View(self.generation, self.walk, self.ghost, self.walk.snapshot(), ghost)

    def sentence(self) -> str:
        """What happens, in plain words."""
        with self._lock:
            words = self.story.sentence
            if self.ghost is not None and self.ghost.fallen:
                words += f" The ghost ({self.choice.ghost}) has fallen."
            elif self.ghost is not None and self.walk.fallen:
                words += f" The ghost ({self.choice.ghost}) walks on."
            return words

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is kept."""
        with self._lock:
            return self.walk.rollout()
