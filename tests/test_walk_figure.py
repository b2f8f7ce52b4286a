from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib import rc_context, rcParams, style
from matplotlib.artist import Artist
from matplotlib.colors import to_hex, to_rgba
from matplotlib.patches import FancyArrowPatch, Rectangle

import figure_artists
import surefoot as sf
from surefoot.checks import check_writable
from surefoot.cli.live import make_walk
from surefoot.live.run import Choice
from surefoot.show import palette
from surefoot.show.picture_file import FORMATS
from surefoot.show.stances import stances
from surefoot.show.walk_figure import draw_walk, walk_figure
from surefoot.show.words import push_label, title, velocity_words

ROBOT = sf.load_robot("paper-biped")
FORWARD = sf.HybridController(ROBOT, (0.5, 0.0))
PUSH = sf.Push(1.1, 0.2, (176.0, 0.0))
PLOTS = ("x", "y", "error", "duration")

WALKS: dict[str, Callable[[], sf.Rollout]] = {
    "undisturbed": lambda: sf.simulate(FORWARD, 2.2),
    "pushed": lambda: sf.simulate(FORWARD, 3.6, [PUSH]),
    "pushed left": lambda: sf.simulate(FORWARD, 2.2, [sf.Push(1.1, 0.2, (0.0, 200.0))]),
    "pushed hard": lambda: sf.simulate(FORWARD, 2.5, [sf.Push(1.1, 0.2, (411.6, 0.0))]),
    "several pushes": lambda: sf.simulate(
        FORWARD, 2.2, [sf.Push(0.0, math.inf, (8.0, 5.0)), PUSH, sf.Push(1.2, 0.3, (0.0, -90.0))]
    ),
    "in place": lambda: sf.simulate(
        sf.HybridController(ROBOT, (0.0, 0.0)), 3.2, [sf.Push(1.1, 0.2, (0.0, -200.0))]
    ),
    "sideways": lambda: sf.simulate(
        sf.HybridController(ROBOT, (0.0, 0.3)), 3.0, [sf.Push(1.1, 0.2, (-100.0, 100.0))]
    ),
    "backward": lambda: sf.simulate(sf.HybridController(ROBOT, (-0.4, 0.0)), 2.2, [PUSH]),
    "diagonal": lambda: sf.simulate(sf.HybridController(ROBOT, (0.3, 0.15)), 3.0, [PUSH]),
    "other velocities": lambda: sf.simulate(
        FORWARD, 3.2, velocity_changes=[(0.9, (0.2, 0.0)), (2.1, (0.3, 0.1))]
    ),
    "fall": lambda: sf.simulate(FORWARD, 3.0, [sf.Push(1.1, 0.2, (1200.0, 0.0))]),
    "unprojected": lambda: sf.simulate(
        sf.DcmTracking(ROBOT, (0.5, 0.0), project_zmp=False),
        2.2,
        [sf.Push(1.0, 0.2, (142.0, 0.0))],
    ),
    "double support": lambda: sf.simulate(
        sf.DcmTracking(ROBOT, (0.5, 0.0), project_zmp=False, double_support=0.4),
        2.2,
        [sf.Push(1.0, 0.2, (142.0, 0.0))],
    ),
    "no finished step": lambda: sf.simulate(FORWARD, 0.2, [sf.Push(0.1, 0.2, (300.0, 0.0))]),
    "long": lambda: sf.simulate(
        sf.HybridController(ROBOT, (0.5, 0.0), period=0.01),
        60.0,
        [sf.Push(30.0, 0.2, (0.0, -150.0))],
    ),
    "one cycle": lambda: sf.simulate(FORWARD, 0.001),
}


class Drawn:
    """A walk and its figure, whose artists are found by name."""

    def __init__(self, rollout: sf.Rollout) -> None:
        self.rollout = rollout
        with style.context(["default", palette.STYLE]):
            self.figure = walk_figure(rollout)
            self.figure.draw_without_rendering()

    def all(self, pattern: str) -> list[Artist]:
        return figure_artists.drawn(self.figure, pattern)

    def one(self, pattern: str) -> Artist:
        (artist,) = self.all(pattern)
        return artist

    def line(self, pattern: str) -> np.ndarray:
        return self.one(pattern).get_xydata()

    def texts(self, pattern: str) -> list[str]:
        return [artist.get_text() for artist in self.all(pattern)]

    def legend(self) -> list[str]:
        return [text.get_text() for text in self.figure.legends[0].get_texts()]


@pytest.fixture(scope="module")
def walks() -> dict[str, Drawn]:
    return {}


@pytest.fixture
def drawn(walks: dict[str, Drawn]) -> Callable[[str], Drawn]:
    """The figure of one of `WALKS`, made once."""

    def get(name: str) -> Drawn:
        if name not in walks:
            walks[name] = Drawn(WALKS[name]())
        return walks[name]

    return get


Get = Callable[[str], Drawn]


def box(patch: Artist) -> tuple[float, float, float, float]:
    """Left, bottom, right, top of a rectangle."""
    assert isinstance(patch, Rectangle)
    return (*patch.get_xy(), patch.get_x() + patch.get_width(), patch.get_y() + patch.get_height())


def sole(centre: tuple[float, float]) -> tuple[float, float, float, float]:
    half_x, half_y = ROBOT.foot.half
    return (centre[0] - half_x, centre[1] - half_y, centre[0] + half_x, centre[1] + half_y)


def test_every_foot_leaves_a_print_of_true_size(drawn: Get) -> None:
    walk = drawn("pushed")
    steps = walk.rollout.footsteps
    assert len(steps) == 7
    assert len(walk.all("footprint-.*")) == len(steps) + 2
    for step in steps:
        print_of = walk.one(f"footprint-{step.index + 1}")
        assert box(print_of) == pytest.approx(sole(step.landing))
        colour = to_hex(print_of.get_facecolor())
        assert colour == palette.SOLE[step.side.other]
    assert box(walk.one("footprint-0")) == pytest.approx(sole(steps[0].support_foot))
    start = walk.rollout.swing_foot[0]
    assert box(walk.one("footprint-start")) == pytest.approx(sole((start[0], start[1])))


def test_prints_carry_the_numbers_of_the_steps_to_them(drawn: Get) -> None:
    assert sorted(drawn("pushed").texts("number-.*")) == list("01234567")
    assert sorted(drawn("pushed").texts("step-[0-9]+")) == list("12345678")
    in_place = Drawn(sf.simulate(sf.HybridController(ROBOT, (0.0, 0.0)), 6.2))
    assert sorted(in_place.texts("number-.*")) == ["0, 2 … 12", "1, 3 … 11"]


def test_turned_soles_are_drawn_turned() -> None:
    footholds = [
        sf.Foothold(sf.Side.LEFT, 0.0, 0.1, 0.0, 0.0),
        sf.Foothold(sf.Side.RIGHT, 0.0, -0.1, 0.0, 0.0),
        sf.Foothold(sf.Side.LEFT, 0.2, 0.15, 0.4, 0.5),
        sf.Foothold(sf.Side.RIGHT, 0.4, 0.05, 0.6, 1.0),
    ]
    walk = Drawn(sf.simulate(sf.FootholdTracking(ROBOT, footholds, double_support=0.2), 1.6))
    toe = np.array(ROBOT.foot.half)
    for number, foothold in enumerate(footholds[2:], start=1):
        print_of = walk.one(f"footprint-{number}")
        corners = print_of.get_patch_transform().transform(print_of.get_path().vertices)
        cos, sin = math.cos(foothold.yaw), math.sin(foothold.yaw)
        corner = np.array([[cos, -sin], [sin, cos]]) @ toe + (foothold.x, foothold.y)
        assert np.hypot(*(corners - corner).T).min() < 1e-9
        _, low, _, high = box(walk.one(f"support-y-{number + 1}"))
        assert high - low == pytest.approx(2.0 * (sin * toe[0] + cos * toe[1]))
    assert title(walk.rollout)[0] == "paper-biped, on footholds"


def test_only_the_step_decided_online_is_marked(drawn: Get) -> None:
    walk = drawn("pushed")
    edges = {
        artist.get_gid(): to_hex(artist.get_edgecolor()) for artist in walk.all("footprint-.*")
    }
    marked = [name for name, edge in edges.items() if edge == palette.ADAPTED]
    assert marked == ["footprint-3"]
    numbers = {text.get_text(): text.get_fontweight() for text in walk.all("number-.*")}
    assert [number for number, weight in numbers.items() if weight == "bold"] == ["3"]
    assert drawn("undisturbed").all("nominal-landing-.*") == []


def test_the_nominal_landing_is_outlined_where_the_step_went_elsewhere(drawn: Get) -> None:
    walk = drawn("pushed")
    step = walk.rollout.footsteps[2]
    nominal = np.add(step.support_foot, FORWARD.gait.step(step.side))
    outline = walk.one("nominal-landing-3")
    assert walk.all("nominal-landing-.*") == [outline]
    assert box(outline) == pytest.approx(sole((nominal[0], nominal[1])))
    assert outline.get_linestyle() not in ("-", "solid")
    assert to_rgba(outline.get_facecolor())[3] == 0.0


def test_the_nominal_gait_is_that_of_the_controller_and_the_command(drawn: Get) -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0), step_duration=0.4)
    parts = stances(sf.simulate(controller, 2.0, [PUSH]))
    assert {part.gait.step_duration for part in parts if part.gait} == {0.4}
    parts = stances(drawn("other velocities").rollout)
    velocities = [part.gait.velocity for part in parts if part.gait]
    assert [velocities[0], velocities[2], velocities[-1]] == [(0.5, 0.0), (0.2, 0.0), (0.3, 0.1)]


def test_a_plant_that_cannot_walk_the_gait_has_no_nominal_landing() -> None:
    weak = ROBOT.replace(
        gait=sf.robot.gait.GaitLimits(
            step_duration=(0.4, 0.8), step_x=(-0.1, 0.1), step_y=(-0.2, 0.3), dcm_offset=(0.1, 0.05)
        )
    )
    walk = Drawn(sf.simulate(FORWARD, 1.6, [PUSH], plant=weak))
    assert walk.rollout.footsteps[2].adapted
    assert walk.all("nominal-.*") == []


@pytest.mark.parametrize("name", ["com", "dcm", "dcm-plan", "zmp"])
def test_lines_hold_every_sample_and_are_cut_at_touchdowns_if_they_jump(
    drawn: Get, name: str
) -> None:
    walk = drawn("pushed")
    values = getattr(walk.rollout, name.replace("-", "_"))
    cuts = len(walk.rollout.footsteps) if name in ("dcm-plan", "zmp") else 0
    line = walk.line(name)
    gaps = np.isnan(line).any(axis=1)
    assert gaps.sum() == cuts
    assert line[~gaps] == pytest.approx(values)
    for axis in range(2):
        over_time = walk.line(f"{name}-{'xy'[axis]}")[:, 1]
        assert np.isnan(over_time).sum() == cuts
        assert over_time[~np.isnan(over_time)] == pytest.approx(values[:, axis])
    if name == "dcm-plan":
        drawn_steps = np.hypot(*np.diff(line, axis=0).T)
        assert np.nanmax(drawn_steps) < 0.01 < np.hypot(*np.diff(values, axis=0).T).max()


def test_the_push_is_an_arrow_onto_the_com_where_it_begins(drawn: Get) -> None:
    walk = drawn("pushed")
    arrow = walk.one("push-0")
    assert isinstance(arrow, FancyArrowPatch)
    tail, tip = np.array(arrow._posA_posB)
    com = walk.rollout.com[np.argmin(np.abs(walk.rollout.time - PUSH.start))]
    assert tip == pytest.approx(com, abs=1e-3)
    length = ROBOT.com_height * 176.0 / (ROBOT.mass * ROBOT.gravity)
    assert tip - tail == pytest.approx([length, 0.0], abs=1e-9)
    assert walk.texts("push-label-.*") == ["176 N × 0.2 s = 35.2 N s"]
    assert drawn("undisturbed").all("push-.*") == []


def test_the_stretch_under_the_push_is_yellow(drawn: Get) -> None:
    walk = drawn("pushed")
    rollout = walk.rollout
    acting = (rollout.time > 1.1) & (rollout.time < 1.3)
    for name, values in (("com", rollout.com), ("dcm", rollout.dcm)):
        stretch = walk.line(f"push-{name}-0")
        assert stretch[1:-1] == pytest.approx(values[acting][: len(stretch) - 2], abs=2e-3)
        assert abs(len(stretch) - acting.sum()) <= 3


@pytest.mark.parametrize("plot", PLOTS)
def test_every_plot_over_time_shows_push_decision_and_touchdowns(drawn: Get, plot: str) -> None:
    walk = drawn("pushed")
    steps = walk.rollout.footsteps
    left, _, right, _ = box(walk.one(f"push-{plot}-0"))
    assert (left, right) == pytest.approx((1.1, 1.3))
    times = [path[0, 0] for path in walk.one(f"touchdowns-{plot}").get_segments()]
    assert times == pytest.approx([step.start + step.duration for step in steps])
    left, _, right, _ = box(walk.one(f"adapting-{plot}-.*"))
    first = walk.rollout.time[np.flatnonzero(walk.rollout.adapting)[0]]
    assert (left, right) == pytest.approx((first, steps[3].start))


@pytest.mark.parametrize(("axis", "name"), [(0, "x"), (1, "y")])
def test_the_support_bounds_are_those_of_the_sole(drawn: Get, axis: int, name: str) -> None:
    walk = drawn("pushed")
    for step in walk.rollout.footsteps:
        left, low, right, high = box(walk.one(f"support-{name}-{step.index + 1}"))
        assert (left, right) == pytest.approx((step.start, step.start + step.duration))
        centre, half = step.support_foot[axis], ROBOT.foot.half[axis]
        assert (low, high) == pytest.approx((centre - half, centre + half))
    assert len(walk.all(f"support-{name}-.*")) == len(walk.rollout.footsteps) + 1


def test_both_soles_bound_the_zmp_in_double_support(drawn: Get) -> None:
    walk = drawn("double support")
    half = 0.5 * ROBOT.hip + ROBOT.foot.half[1]
    shared = walk.rollout.time[walk.rollout.commands["double_support"] != 0]
    instants: set[float] = set()
    for polygon in walk.one("both-soles-y").get_paths():
        assert set(np.round(polygon.vertices[:, 1], 9)) == {-half, half}
        instants |= set(polygon.vertices[:, 0])
    assert instants == set(shared)
    assert "both soles" in walk.legend()
    assert drawn("unprojected").all("both-soles-.*") == []


@pytest.mark.parametrize("name", ["unprojected", "double support"])
def test_the_zmp_is_red_exactly_where_it_leaves_the_soles(drawn: Get, name: str) -> None:
    walk = drawn(name)
    outside = walk.rollout.zmp_excess > 0.0
    assert outside.any()
    red = walk.line("zmp-outside-x")
    assert np.isfinite(red[:, 1]).sum() == outside.sum()
    assert np.isfinite(walk.line("zmp-outside")).all(axis=1).sum() == outside.sum()
    # Pushed forward, it leaves the sole over the toes, not over the side.
    assert walk.all("zmp-outside-y") == [] or np.isnan(walk.line("zmp-outside-y")[:, 1]).all()
    assert "ZMP outside the sole" in walk.legend()
    assert drawn("pushed").all("zmp-outside.*") == []


def test_dcm_error_and_step_duration(drawn: Get) -> None:
    walk = drawn("pushed")
    error = walk.line("dcm-error")[:, 1]
    assert np.nanmax(error) == pytest.approx(1e3 * np.hypot(*walk.rollout.dcm_error.T).max())
    decided = walk.line("step-duration")[:, 1]
    assert decided[~np.isnan(decided)] == pytest.approx(walk.rollout.commands["step_duration"])
    third = walk.rollout.footsteps[2].duration
    assert third < 0.45
    assert walk.texts("duration-.*") == [f"{third:.2f} s"]


def test_the_durations_named_are_limits_and_plan(drawn: Get) -> None:
    ax = drawn("sideways").figure.axes[4]
    assert [tick.get_text() for tick in ax.get_yticklabels()] == ["0.2", "0.43", "0.8"]


def test_a_fall_is_marked_with_its_evidence(drawn: Get) -> None:
    walk = drawn("fall")
    fall = walk.rollout.fall
    assert fall is not None
    assert walk.line("fall")[0] == pytest.approx(walk.rollout.dcm[-1])
    (evidence,) = walk.texts("fall-evidence")
    for words in ("fell forward at 1.76 s", "1.85 m", "at 1.40 s, the DCM offset 184 mm outside"):
        assert words in " ".join(evidence.split())
    for name, time in (("lost", 1.4), ("fell", fall.time)):
        lines = walk.one(f"{name}-x").get_segments()
        assert [line[0, 0] for line in lines] == pytest.approx([time])
    assert walk.texts("(lost|fell)-label") == ["lost", "fell"]
    low, high = walk.figure.axes[0].get_xlim()
    assert walk.rollout.dcm[-1, 0] < high < low + 6.0
    assert drawn("pushed").all("fall.*|lost.*|fell.*") == []


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_view_does_not_follow_a_zmp_that_runs_away(way: float) -> None:
    controller = sf.DcmTracking(ROBOT, (0.0, 0.0), project_zmp=False)
    walk = Drawn(sf.simulate(controller, 1.4, [sf.Push(1.0, 0.2, (way * 2000.0, 0.0))]))
    dcm = (way * walk.rollout.dcm[:, 0]).max()
    assert (way * walk.rollout.zmp[:, 0]).max() > dcm + 0.6
    assert max(way * limit for limit in walk.figure.axes[0].get_xlim()) < dcm + 0.6
    assert max(way * limit for limit in walk.figure.axes[1].get_ylim()) < 2.0 * dcm


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pushed", ["pushed forward with 35.2 N s (0.518 m/s)", "recovered"]),
        ("undisturbed", ["paper-biped, 0.5 m/s forward", "HybridController", "walked on"]),
        ("fall", ["pushed forward with 240 N s (3.53 m/s)", "fell"]),
        ("backward", ["paper-biped, 0.4 m/s backward"]),
        ("in place", ["paper-biped, in place", "pushed right with 40 N s (0.588 m/s)"]),
        ("several pushes", ["3 pushes of 82.96 N s (1.22 m/s) in all"]),
        (
            "other velocities",
            ["paper-biped, 3 commanded velocities, the last 0.3 m/s forward, 0.1 m/s left"],
        ),
        ("unprojected", ["DcmTracking"]),
        ("one cycle", ["not settled when the run ended"]),
    ],
)
def test_the_title_says_who_walked_how_and_what_became_of_it(
    drawn: Get, name: str, words: list[str]
) -> None:
    walk = drawn(name)
    assert set(words) <= set(title(walk.rollout))
    (headline,) = walk.texts("title")
    assert re.split(r"\n|  ·  ", headline) == title(walk.rollout)


def test_a_walk_that_turns_has_one_command_and_its_rate_of_turn() -> None:
    walk = make_walk(Choice(), "hybrid", sf.Steering((0.3, 0.0), 0.4))
    while walk.time < 3.2:
        walk.step()
    drawn = Drawn(walk.rollout())
    assert len(drawn.rollout.velocities) > 5
    assert title(drawn.rollout)[0] == "paper-biped, 0.3 m/s forward, turning +0.4 rad/s"
    assert "new velocity" not in drawn.legend()


def test_words() -> None:
    assert push_label(sf.Push(0.5, math.inf, (3.0, 4.0))) == "5 N from 0.5 s on"
    assert push_label(sf.Push(1.1, 0.2, (0.0, -411.6))) == "411.6 N × 0.2 s = 82.32 N s"
    assert velocity_words((-0.2, -0.1)) == "0.2 m/s backward, 0.1 m/s right"
    assert velocity_words((0.0, 0.0)) == "in place"


def test_new_velocities_are_marked(drawn: Get) -> None:
    walk = drawn("other velocities")
    times = [path[0, 0] for path in walk.one("new-velocity-x").get_segments()]
    assert times == pytest.approx([0.9, 2.1])
    assert walk.texts("command-.*") == ["0.2 m/s forward", "0.3 m/s forward, 0.1 m/s left"]


def test_the_legend_names_only_what_is_there(drawn: Get) -> None:
    assert {"push", "nominal landing", "deciding online"} <= set(drawn("pushed").legend())
    absent = {"push", "nominal landing", "deciding online", "new velocity", "ZMP outside the sole"}
    assert not absent & set(drawn("undisturbed").legend())
    assert "new velocity" in drawn("other velocities").legend()
    assert "nominal landing" not in drawn("no finished step").legend()


@pytest.mark.parametrize("name", sorted(WALKS))
def test_words_stay_on_the_page_and_do_not_overlap(drawn: Get, name: str) -> None:
    walk = drawn(name)
    words = walk.all("title|fall-evidence|push-label-.*|number-.*|step-[0-9]+")
    words += walk.figure.legends[0].get_texts()
    words += [ax.xaxis.label for ax in walk.figure.axes] + [
        ax.yaxis.label for ax in walk.figure.axes
    ]
    figure_artists.assert_words_stand_apart(walk.figure, words)


@pytest.mark.parametrize("name", sorted(WALKS))
def test_the_top_view_has_true_proportions(drawn: Get, name: str) -> None:
    ax = drawn(name).figure.axes[0]
    assert ax.get_aspect() == 1.0
    place, (width, height) = ax.get_position(), drawn(name).figure.get_size_inches()
    (low_x, high_x), (low_y, high_y) = ax.get_xlim(), ax.get_ylim()
    scale_x = (high_x - low_x) / (place.width * width)
    assert scale_x == pytest.approx((high_y - low_y) / (place.height * height))


@pytest.mark.parametrize("ending", [".PNG", ".pdf", ".svg"])
def test_the_same_walk_gives_the_same_bytes_also_when_it_is_loaded(
    drawn: Get, tmp_path: Path, ending: str
) -> None:
    rollout = drawn("pushed").rollout
    rollout.plot(tmp_path / f"one{ending}")
    rollout.save(tmp_path / "walk.npz")
    rollout = sf.load_rollout(tmp_path / "walk.npz")
    with rc_context({"axes.facecolor": "black", "font.size": 30.0}):
        before = dict(rcParams)
        draw_walk(rollout, tmp_path / f"two{ending}")
        assert dict(rcParams) == before
    data = (tmp_path / f"one{ending}").read_bytes()
    magic = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}[ending.lower()]
    assert data.startswith(magic)
    assert data == (tmp_path / f"two{ending}").read_bytes()
    assert not re.search(rb"Date|Creation", data)


def test_names_in_an_svg_are_unique(drawn: Get, tmp_path: Path) -> None:
    drawn("fall").rollout.plot(tmp_path / "walk.svg")
    names = Counter(re.findall(r' id="([^"]+)"', (tmp_path / "walk.svg").read_text()))
    assert names["footprint-3"] == 1
    assert [name for name, count in names.items() if count > 1] == []


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("walk.bmp", r"expected a path ending in \.png, \.pdf, \.svg; got .*walk\.bmp; rename"),
        ("walk", r"expected a path ending in \.png, \.pdf, \.svg"),
        ("missing/walk.png", "expected a directory that exists; got .*missing; make it first"),
        ("folder.png", "expected a file; got the directory .*folder.png"),
    ],
)
def test_a_path_that_cannot_hold_a_picture_is_refused_at_once(
    drawn: Get, tmp_path: Path, name: str, message: str
) -> None:
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(sf.FileError, match=message):
        drawn("one cycle").rollout.plot(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_checking_a_path_leaves_no_trace(tmp_path: Path) -> None:
    old = tmp_path / "old.png"
    old.write_bytes(b"picture of yesterday")
    written = old.stat().st_mtime_ns
    check_writable(old, FORMATS)
    check_writable(tmp_path / "new.SVG", FORMATS)
    assert old.read_bytes() == b"picture of yesterday"
    assert old.stat().st_mtime_ns == written
    assert list(tmp_path.iterdir()) == [old]


def test_a_disk_that_fails_at_the_end_is_told(
    drawn: Get, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fail(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fail)
    with pytest.raises(sf.FileError, match="No space left on device; choose another place"):
        draw_walk(drawn("one cycle").rollout, tmp_path / "walk.png")
