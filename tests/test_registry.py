"""Methods are found by entry point or by the place of a class, and declare themselves once."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.control.capture_point import CapturePointStepping
from surefoot.control.fields import check_fields, declared, documented, setting, weight
from surefoot.control.registry import find_method, method, method_names, methods
from surefoot.plugins import load, places

ROOT = Path(__file__).parents[1]
ROBOT = sf.load_robot("paper-biped")


def test_the_methods_are_those_of_the_project_file() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    own = project["entry-points"]["surefoot.methods"]
    assert set(own) <= set(method_names())
    for name, place in own.items():
        one = find_method(name)
        assert one.key == name
        assert find_method(place) is one
        assert one.source
        assert one.adapts
        assert one.cannot
    orders = [find_method(name).order for name in own]
    assert len(set(orders)) == len(orders)


def test_they_are_shown_from_the_zmp_alone_to_steps_in_place_and_time() -> None:
    own = [one for one in methods() if one.key in places("surefoot.methods")]
    assert [one.order for one in own] == sorted(one.order for one in own)
    assert own[0].adapts == "ZMP"
    assert own[-1].adapts == "ZMP, step location, timing"


def test_listing_them_imports_nothing() -> None:
    code = (
        "from surefoot.control.registry import method_names\n"
        "import sys, json\n"
        "print(json.dumps([method_names(), sorted(sys.modules)]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names, modules = json.loads(done.stdout)
    assert tuple(names) == method_names()
    assert not {"numpy", "numba", "msgspec", "surefoot.control.base"} & set(modules)


def test_the_help_of_walk_lists_them_and_imports_no_kernel() -> None:
    code = (
        "from surefoot.cli import main\nimport sys\n"
        "try: main(['walk', '--help'])\n"
        "finally: assert not {'numpy', 'numba'} & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    words = re.sub(r"\s+", "", done.stdout)
    for name in method_names():
        assert name in words


def test_the_table_of_the_readme_has_every_class() -> None:
    table = (ROOT / "README.md").read_text("utf-8").split("## Methods")[1]
    for one in methods():
        if "METHOD" not in vars(one.make) or vars(one.make)["METHOD"] is not one:
            continue  # a variant is a row of its class
        file = one.make.__module__.removeprefix("surefoot.").replace(".", "/") + ".py"
        (row,) = [line for line in table.splitlines() if f"`{file}`" in line and "walk" in line]
        assert f"--controller {one.key}`" in row or one.key == "unified"


class Plain:
    """Says nothing of itself."""

    def __init__(self, robot: sf.Robot, velocity: tuple[float, float], gain: float = 1.0) -> None:
        self.given = robot, velocity, gain


@method("own", label="own", source="a test", adapts="ZMP", cannot="nothing")
@dataclass(frozen=True)
class Own(CapturePointStepping):
    """Of its own."""

    gain: float = setting(2.0, "1/s", "how fast", least=1.0)


NOTHING = 3.0


def test_any_class_is_a_method_by_its_place() -> None:
    one = find_method(f"{__name__}:Plain")
    assert (one.key, one.label, one.make) == (f"{__name__}:Plain", "Plain", Plain)
    made: Any = one.controller(ROBOT, (0.5, 0.0), gain=3.0)
    assert made.given == (ROBOT, (0.5, 0.0), 3.0)
    assert not one.takes("gain")  # what is no dataclass has no settings


def test_a_declared_class_that_is_not_installed_goes_by_its_place() -> None:
    place = f"{__name__}:Own"
    one = find_method(place)
    assert (one.key, one.label, one.source) == (place, "own", "a test")
    assert find_method(one.key) == one
    assert one.takes("gain")
    assert one.takes("period")


def test_a_subclass_that_declares_nothing_is_not_its_parent() -> None:
    one = find_method("test_registry:Heir")
    assert (one.label, one.source) == ("Heir", "test_registry:Heir")


class Heir(CapturePointStepping):
    """Nothing of its own."""


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("lqr", "a method (tracking, tracking-stiff, "),
        ("no_such_module:Class", "there is no module 'no_such_module'"),
        ("test_registry:Missing", "an object in test_registry"),
        ("test_registry:NOTHING", "a class of controllers at test_registry:NOTHING; got 3.0"),
        (":Class", "MODULE:OBJECT; got ':Class'"),
        ("a:b:c", "MODULE:OBJECT; got 'a:b:c'"),
    ],
)
def test_what_is_no_method_is_refused(key: str, words: str) -> None:
    with pytest.raises(sf.ParameterError) as caught:
        find_method(key)
    assert words in str(caught.value)


def test_a_mistake_inside_a_module_is_not_hidden(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "broken_controllers.py").write_text("import not_there_at_all\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ModuleNotFoundError, match="not_there_at_all"):
        load("broken_controllers:Class")


def test_a_subclass_inherits_the_cycle() -> None:
    made, usual = Own(ROBOT, (0.5, 0.0)), CapturePointStepping(ROBOT, (0.5, 0.0))
    assert made.kernel is usual.kernel
    observation = made.first_observation()
    ours, _ = made.step(made.start(observation), observation)
    theirs, _ = usual.step(usual.start(observation), observation)
    assert ours == theirs


# Settings on fields


def test_a_field_is_checked_and_described_by_what_it_says() -> None:
    with pytest.raises(sf.ParameterError, match=r"`gain` of at least 1 \[1/s\]"):
        Own(ROBOT, (0.5, 0.0), gain=0.5)
    assert "    gain: how fast [1/s].\n" in (Own.__doc__ or "")


@pytest.mark.parametrize("one", methods(), ids=lambda one: one.key)
def test_every_setting_of_a_method_is_declared_with_words_and_unit(one) -> None:
    about = declared(one.make)
    for of in fields(one.make):
        if not of.init:
            continue
        known = about[of.name]
        assert known.words
        assert known.unit or not isinstance(of.default, float)
        assert f"    {of.name}: " in (one.make.__doc__ or "")
        if known.search is not None:
            ends = known.search if isinstance(of.default, tuple) else (known.search,)
            for interval in filter(None, ends):
                assert 0.0 <= interval[0] < interval[1]


def test_weights_of_one_cost_are_compared() -> None:
    @documented
    @dataclass(frozen=True)
    class Weighed:
        """Two weights.

        Raises:
            ParameterError: never.
        """

        first: float = weight(1.0, "-", "one")
        second: tuple[float, float] = weight((1.0, 1.0), "-", "two")

    assert (Weighed.__doc__ or "").splitlines() == [
        "Two weights.", "", "Args:", "    first: one [-].", "    second: two [-].", "",
        "Raises:", "    ParameterError: never.",
    ]  # fmt: skip
    check_fields(Weighed())
    with pytest.raises(sf.ParameterError, match="weights within a factor"):
        check_fields(Weighed(1e-9, (1.0, 1e9)))
    with pytest.raises(sf.ParameterError, match="`second` of at least 0"):
        check_fields(Weighed(1.0, (1.0, -1.0)))
    assert np.isfinite(Weighed().first)
