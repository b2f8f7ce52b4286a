from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.dcm.footholds import plan_footholds
from surefoot.dcm.pendulum import dcm_flow

ROBOT = sf.load_robot("paper-biped")
LEFT, RIGHT = sf.Side.LEFT, sf.Side.RIGHT

CSV = """side,x,y,yaw,time
left,0.0,0.1,0.0,0.0
right,0.0,-0.1,0.0,0.0
left,0.25,0.1,0.0,0.5
right,0.45,-0.12,-0.1,1.1
left,0.6,0.05,-0.2,1.6
right,0.6,-0.18,-0.2,2.2
"""


def curve(steps: int = 10, turn: float = 0.15, length: float = 0.2) -> list[sf.Foothold]:
    """A walk on a circle to the left, half a second a step."""
    footholds = [sf.Foothold(LEFT, 0.0, 0.1, 0.0, 0.0), sf.Foothold(RIGHT, 0.0, -0.1, 0.0, 0.0)]
    x = y = yaw = 0.0
    for k in range(steps):
        yaw += turn
        x, y = x + length * math.cos(yaw), y + length * math.sin(yaw)
        side = footholds[-1].side.other
        aside = -0.1 * side
        place = x - aside * math.sin(yaw), y + aside * math.cos(yaw)
        footholds.append(sf.Foothold(side, *place, yaw, 0.5 * (k + 1)))
    return footholds


def mirrored(footholds) -> list[sf.Foothold]:
    return [replace(f, side=f.side.other, y=-f.y, yaw=-f.yaw) for f in footholds]


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    path.write_text(CSV)
    return path


def test_a_table_and_a_list_say_the_same(table: Path, tmp_path: Path) -> None:
    footholds = sf.load_footholds(table, ROBOT)
    assert [f.side for f in footholds] == [LEFT, RIGHT, LEFT, RIGHT, LEFT, RIGHT]
    assert footholds[3] == sf.Foothold(RIGHT, 0.45, -0.12, -0.1, 1.1, line=5)
    toml = tmp_path / "walk.toml"
    toml.write_text(
        "\n".join(
            f'[[foothold]]\nside = "{f.side.name.lower()}"\nx = {f.x}\ny = {f.y}\n'
            f"yaw = {f.yaw}\ntime = {f.time}\n"
            for f in footholds
        )
    )
    again = sf.load_footholds(toml, ROBOT)
    assert [replace(f, line=0) for f in again] == [replace(f, line=0) for f in footholds]
    assert again[3].line == 22


def test_yaw_may_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "walk.csv"
    path.write_text("time,side,x,y\n0,left,0,0.1\n0,right,0,-0.1\n0.5,left,0.2,0.1\n")
    assert {f.yaw for f in sf.load_footholds(path, ROBOT)} == {0.0}


@pytest.mark.parametrize("double_support", [0.0, 0.2, 0.4])
@pytest.mark.parametrize("turn", [0.0, 0.15, -0.15])
def test_the_feet_land_where_and_when_the_footholds_say(double_support: float, turn: float) -> None:
    footholds = curve(turn=turn) if turn >= 0.0 else mirrored(curve(turn=-turn))
    controller = sf.FootholdTracking(ROBOT, footholds, double_support=double_support)
    rollout = sf.simulate(controller, 9.0)
    assert rollout.outcome is sf.Outcome.WALKED  # in place, in the end
    steps = rollout.footsteps
    for wanted, step in zip(footholds[2:], steps, strict=False):
        assert step.landing == pytest.approx((wanted.x, wanted.y), abs=1e-9)
        assert step.start + step.duration == pytest.approx(wanted.time, abs=1e-9)
    touchdowns = np.flatnonzero(np.diff(rollout.support_side)) + 1
    yaws = rollout.observations["support_yaw"][touchdowns]
    assert yaws[: len(footholds) - 2] == pytest.approx([f.yaw for f in footholds[2:]], abs=1e-12)
    assert rollout.zmp_excess.max() == 0.0
    assert np.hypot(*rollout.dcm_error.T).max() < 1e-3
    # Then it steps in place, beside its last foothold, in its heading.
    aside = np.array(steps[-1].landing) - steps[-2].landing
    heading = footholds[-1].yaw
    assert abs(aside @ (math.cos(heading), math.sin(heading))) < 1e-9
    assert math.hypot(*aside) == pytest.approx(ROBOT.hip)


def test_the_plan_hands_the_dcm_from_step_to_step() -> None:
    footholds = curve()
    in_place = sf.nominal_gait(ROBOT, (0.0, 0.0))
    steps = plan_footholds(footholds, in_place)
    assert len(steps) == len(footholds) - 2 + 2
    for k, (step, standing) in enumerate(zip(steps, footholds[1:-1], strict=False)):
        landing = footholds[k + 2]
        for i, (here, there) in enumerate(((standing.x, landing.x), (standing.y, landing.y))):
            end = dcm_flow(here + step.start_offset[i], here, ROBOT.omega, step.duration)
            assert end == pytest.approx(there + step.end_offset[i], abs=1e-12)
        assert steps[k + 1].start_offset == step.end_offset
    assert steps[-1].end_offset == steps[-2].start_offset


def test_straight_footholds_are_the_nominal_gait() -> None:
    """Two ways to the same plan: from a velocity, and from the footholds it steps on."""
    gait = sf.nominal_gait(ROBOT, (0.5, 0.0))
    walk = sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0)), 20.0)
    begin = gait.observation(RIGHT)
    footholds = [
        sf.Foothold(LEFT, *begin.swing_foot[:2], 0.0, 0.0),
        sf.Foothold(RIGHT, *begin.support_foot, 0.0, 0.0),
        *(sf.Foothold(s.side.other, *s.landing, 0.0, s.start + s.duration) for s in walk.footsteps),
    ]
    steps = plan_footholds(footholds, sf.nominal_gait(ROBOT, (0.0, 0.0)))
    # The end of the walk, forty steps ahead, is forgotten backwards in time.
    assert steps[0].start_offset == pytest.approx(gait.start_offset(RIGHT), abs=1e-9)
    assert steps[1].start_offset == pytest.approx(gait.start_offset(LEFT), abs=1e-9)


def test_it_is_mirrored_with_its_footholds() -> None:
    push = sf.Push(1.1, 0.2, (20.0, 15.0))
    here = sf.simulate(sf.FootholdTracking(ROBOT, curve(), double_support=0.2), 5.0, [push])
    there = sf.simulate(
        sf.FootholdTracking(ROBOT, mirrored(curve()), double_support=0.2),
        5.0,
        [replace(push, force=(20.0, -15.0))],
    )
    for name in ("dcm", "zmp", "com", "support_foot"):
        flipped = getattr(here, name) * np.array((1.0, -1.0))
        assert flipped == pytest.approx(getattr(there, name), abs=1e-9), name


def test_it_turns_with_its_footholds() -> None:
    """Yaw invariance: the whole walk, pushed, in another frame."""
    angle = 0.7
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    turned = []
    for f in curve():
        x, y = turn @ (f.x, f.y)
        turned.append(replace(f, x=x, y=y, yaw=f.yaw + angle))
    force = np.array((30.0, 120.0))  # enough to drive the ZMP to the edge of the sole
    here = sf.simulate(
        sf.FootholdTracking(ROBOT, curve(), double_support=0.2),
        4.0,
        [sf.Push(1.1, 0.2, (30.0, 120.0))],
    )
    there = sf.simulate(
        sf.FootholdTracking(ROBOT, turned, double_support=0.2),
        4.0,
        [sf.Push(1.1, 0.2, tuple(turn @ force))],
    )
    assert (here.commands["status"] & sf.Status.ZMP_AT_EDGE).any()
    for name in ("dcm", "zmp", "com", "support_foot"):
        assert getattr(here, name) @ turn.T == pytest.approx(getattr(there, name), abs=1e-8), name
    assert here.zmp_excess == pytest.approx(there.zmp_excess, abs=1e-9)


def test_what_goes_in_is_not_changed_and_broken_observations_are_held() -> None:
    controller = sf.FootholdTracking(ROBOT, curve())
    observation = controller.first_observation()
    state = controller.start(observation)
    before = state.tobytes(), observation.array.tobytes(), controller.parameters.tobytes()
    first, next_state = controller.step(state, observation)
    assert (state.tobytes(), observation.array.tobytes(), controller.parameters.tobytes()) == before
    held, _ = controller.step(next_state, observation.replace(swing_yaw=math.nan))
    assert held.status == sf.Status.HELD
    assert held.replace(status=0) == first


def test_what_cannot_be_asked_of_it() -> None:
    controller = sf.FootholdTracking(ROBOT, curve())
    assert isinstance(controller, sf.Controller)
    with pytest.raises(sf.ParameterError, match="the right foot, on which these footholds begin"):
        sf.simulate(controller, 1.0, first_support=LEFT)
    with pytest.raises(sf.ParameterError, match="footholds that stay as they are"):
        controller.with_velocity((0.1, 0.0))


def test_soles_that_meet_at_a_corner_only_are_refused() -> None:
    """Beside each other they are clear; turned towards each other they are not."""
    stand = [sf.Foothold(LEFT, 0.0, 0.1, 0.0, 0.0), sf.Foothold(RIGHT, 0.0, -0.1, 0.0, 0.0)]
    landing = sf.Foothold(LEFT, 0.12, 0.03, 0.0, 0.5)
    sf.FootholdTracking(ROBOT, [*stand, landing])
    with pytest.raises(sf.FootholdError, match="soles that do not overlap"):
        sf.FootholdTracking(ROBOT, [*stand, replace(landing, yaw=0.5)])


def rows(*changes: tuple[int, str]) -> str:
    lines = CSV.splitlines()
    for line, text in changes:
        lines[line - 1] = text
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the columns side, x, y, time, yaw; got an empty file"),
        (rows((1, "side,x,y,jaw,time")), r"got side, x, y, jaw, time \(.*line 1\)"),
        (rows((4, "left,0.25")), r"5 values; got .*line 4"),
        (rows((4, "left,0.25,0.1,0.0,0.5,7")), r"5 values; got .*line 4"),
        (rows((4, "left,far,0.1,0.0,0.5")), r"a number as x; got 'far' \(.*line 4\)"),
        (rows((4, "left,nan,0.1,0.0,0.5")), r"a number as x; got 'nan' \(.*line 4\)"),
        (
            rows((4, "middle,0.2,0.1,0.0,0.5")),
            r'"left" or "right" as side; got \'middle\' .*line 4',
        ),
        (
            rows((4, "right,0.2,0.1,0.0,0.5")),
            r"the left foot to land next; got right again .*line 4",
        ),
        (rows((3, "left,0.0,-0.1,0.0,0.0")), r"one left and one right foot .*line 3"),
        (
            rows((5, "right,0.45,-0.12,0,0.4")),
            r"times that run forward; got 0.4 s after 0.5 s .*line 5",
        ),
        (rows((4, "left,0.2,0.1,0.0,0.1")), r"a step of 0.2 to 0.8 s; got 0.1 s \(.*line 4\)"),
        (rows((4, "left,0.2,0.1,0.0,0.9")), r"a step of 0.2 to 0.8 s; got 0.9 s \(.*line 4\)"),
        (rows((4, "left,0.3,-0.15,0.0,0.5")), r"on its own side; got 50 mm across .*line 4"),
        (rows((4, "left,0.1,0.0,0.0,0.5")), r"soles that do not overlap; .*line 4"),
        (
            rows((4, "left,0.9,0.1,0.0,0.5")),
            r"a step of -0.5 to 0.5 m in x .* got 0.9 m \(.*line 4\)",
        ),
        (rows((4, "left,0.2,0.6,0.0,0.5")), r"a step of 0 to 0.5 m in y .* got 0.7 m \(.*line 4\)"),
        ("side,x,y,time\nleft,0,0.1,0\nright,0,-0.1,0\n", "at least three footholds"),
    ],
)
def test_every_mistake_in_a_table_is_named_with_its_line(tmp_path: Path, text, message) -> None:
    path = tmp_path / "walk.csv"
    path.write_text(text)
    with pytest.raises(sf.FootholdError, match=message):
        sf.load_footholds(path, ROBOT)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("walk.toml", "[[foothold]\n", "a TOML document; got .*line 1"),
        ("walk.toml", "x = 1\n", r"a list of \[\[foothold\]\]"),
        (
            "walk.toml",
            '[[foothold]]\nside = "left"\nx = 0\n',
            "time, y unknown or missing .*line 1",
        ),
        ("walk.txt", CSV, r"a path ending in \.csv or \.toml"),
    ],
)
def test_files_that_are_none(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(sf.FootholdError, match=message):
        sf.load_footholds(path, ROBOT)
    with pytest.raises(sf.FootholdError, match="a readable file of footholds"):
        sf.load_footholds(tmp_path / "none.csv", ROBOT)
