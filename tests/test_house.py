"""The house: imports go down the ladder, files stay short, the front door stays open."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import surefoot as sf

SOURCE = Path(sf.__file__).parent
FILES = sorted(SOURCE.rglob("*.py"))
LONGEST_FILE = 400
LONGEST_FUNCTION = 60

LADDER = [
    {"errors", "version"},
    {"plugins"},
    {"checks", "compiled", "record"},
    {"geometry"},
    {"robot"},
    {"interface"},
    {"dcm"},
    {"control"},
    {"rollout"},
    {"worlds"},
    {"options", "conformance"},
    {"show"},
    {"live"},
    {"studies"},
    {"cli", "__init__", "__main__"},
]
"""Rungs from the ground up; neighbours on a rung do not see each other."""

MAY_WAIT = {"cli", "options", "__init__"}
"""Rooms that import inside functions, beside the command of a study: to start at once."""


def room(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def rung(name: str) -> int:
    return next(level for level, rooms in enumerate(LADDER) if name in rooms)


SIBLINGS = ("studies", "worlds")
"""Rooms whose folders do not see each other, but for what is made to be shared."""

SHARED = {"studies.engine"}
"""Folders of such a room that all others see, and which see none of them."""

NOT_YET: set[tuple[str, str]] = set()
"""What is left to be taken apart."""


def folder(module: str) -> str | None:
    """The folder among siblings that a module lies in, or none: "studies.compare"."""
    parts = module.removeprefix("surefoot.").split(".")
    inner = parts[0] in SIBLINGS and len(parts) > 1 and (SOURCE / parts[0] / parts[1]).is_dir()
    return ".".join(parts[:2]) if inner else None


def imported(tree: ast.AST) -> list[tuple[str, int]]:
    """All that a file imports of Surefoot, "surefoot.room.file.name", with the line."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        found += [(name, node.lineno) for name in names if name.split(".")[0] == "surefoot"]
    return found


def imported_siblings(module: str, tree: ast.AST) -> set[tuple[str, str]]:
    """Which other folders of its room a file of a folder imports."""
    own = folder(module)
    if own is None:
        return set()
    others = {folder(name) for name, _ in imported(tree)} - {None, own} - SHARED
    beside = own.partition(".")[0] + "."
    return {(own, other) for other in others if other is not None and other.startswith(beside)}


def imported_rooms(tree: ast.AST) -> list[tuple[str, int]]:
    """The rooms of Surefoot that a file imports, with the line."""
    return [((*name.split("."), "__init__")[1], line) for name, line in imported(tree)]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_go_down(path: Path) -> None:
    own = room(path)
    for other, line in imported_rooms(ast.parse(path.read_text())):
        assert other == own or rung(other) < rung(own), f"{path}:{line} imports {other}"


def test_the_ladder_test_can_fail() -> None:
    tree = ast.parse("from surefoot.control.hybrid import HybridController\nimport surefoot.cli")
    assert imported_rooms(tree) == [("control", 1), ("cli", 2)]
    assert rung("cli") > rung("control") > rung("robot")


def test_siblings_do_not_see_each_other() -> None:
    found: set[tuple[str, str]] = set()
    for path in FILES:
        module = ".".join(("surefoot", *path.relative_to(SOURCE).with_suffix("").parts))
        found |= imported_siblings(module, ast.parse(path.read_text()))
    assert found == NOT_YET


def test_the_siblings_test_can_fail() -> None:
    tree = ast.parse("def lazy():\n    from surefoot.studies.compare.question import Protocol")
    assert imported_siblings("surefoot.studies.tune.trials", tree) == {
        ("studies.tune", "studies.compare")
    }
    assert not imported_siblings("surefoot.studies.compare.show", tree)
    assert not imported_siblings("surefoot.cli.walk", tree)
    tree = ast.parse("from surefoot.worlds import body\nimport surefoot.studies.engine.study")
    assert imported_siblings("surefoot.worlds.point.batch", tree) == {
        ("worlds.point", "worlds.body")
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_files_and_functions_stay_short(path: Path) -> None:
    text = path.read_text()
    assert len(text.splitlines()) <= LONGEST_FILE
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        # What a function says about itself does not count, what it does counts.
        docstring = ast.get_docstring(node, clean=False) or ""
        last = node.end_lineno or node.lineno
        length = last - node.body[0].lineno + 1 - len(docstring.splitlines())
        assert length <= LONGEST_FUNCTION, f"{node.name} has {length} lines"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_stand_at_the_top(path: Path) -> None:
    if room(path) in MAY_WAIT or path.name.startswith("command"):
        return
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            for inner in ast.walk(node):
                assert not isinstance(inner, (ast.Import, ast.ImportFrom)), f"{path}:{inner.lineno}"


def test_no_name_without_a_noun() -> None:
    forbidden = {"utils", "helpers", "manager", "core", "misc", "common"}
    assert not [path for path in FILES if path.stem in forbidden]


def test_the_public_names_are_there() -> None:
    promised = {
        "load_robot", "nominal_gait", "HybridController", "DcmTracking", "simulate", "Push",
        "solve_step", "StepProblem", "load_rollout", "Rollout", "Outcome", "Side", "Observation",
        "Command",
    }  # fmt: skip
    assert promised <= set(sf.__all__)
    for name in sf.__all__:
        assert getattr(sf, name) is not None
    assert set(dir(sf)) == set(sf.__all__)
    with pytest.raises(AttributeError, match="no attribute 'walk_away'"):
        sf.walk_away  # noqa: B018


@pytest.mark.parametrize("name", [n for n in sf.__all__ if n != "__version__"])
def test_every_public_name_is_documented(name: str) -> None:
    assert (getattr(sf, name).__doc__ or "").strip()


def test_the_type_checkers_door_and_the_running_one_are_the_same() -> None:
    tree = ast.parse((SOURCE / "__init__.py").read_text())
    (guard,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {alias.name for node in guard.body for alias in node.names}  # type: ignore[attr-defined]
    assert typed == set(sf.__all__) - {"__version__"}


def modules_after(statement: str) -> set[str]:
    code = f"{statement}\nimport sys, json; print(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return {name.split(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


# Not scipy: numba itself loads it where it is installed.
OPTIONAL = {"matplotlib", "click", "rich", "pandas", "polars", "mujoco", "viser", "daqp", "casadi",
            "mcap", "mcap_ros2"}  # fmt: skip


# What needs an extra of its own.
OF_EXTRAS = {
    "BodyControl", "BodyEstimator", "BodyNoise", "InverseDynamics", "Multibody", "Surroundings",
    "body_control", "body_controller", "film_walk", "load_multibody", "simulate_body",
    "walking_robot",
}  # fmt: skip


def test_importing_surefoot_loads_the_core_only() -> None:
    names = sorted(set(sf.__all__) - OF_EXTRAS)
    loaded = modules_after(f"import surefoot\nfor name in {names}: getattr(surefoot, name)")
    assert not loaded & OPTIONAL
    assert {"numpy", "numba", "msgspec"} <= loaded


@pytest.mark.parametrize("name", sorted(OF_EXTRAS))
def test_a_name_without_its_extra_says_how_to_install_it(name: str) -> None:
    code = (
        "import sys; sys.modules['mujoco'] = None; import surefoot\n"
        f"try: surefoot.{name}\n"
        "except surefoot.MissingExtraError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 'run: pip install "surefoot[' in done.stdout


def test_help_loads_next_to_nothing() -> None:
    loaded = modules_after("from surefoot.cli import main\nmain(['--help'], standalone_mode=False)")
    assert not loaded & {"numpy", "numba", "msgspec", "matplotlib", "rich"}
    assert "click" in loaded


OF_A_POINT_MASS = (
    "from click.testing import CliRunner\n"
    "from surefoot.cli import main\n"
    "from surefoot.control.unified.controller import UnifiedController\n"
    "step, decided = UnifiedController.step, []\n"
    "UnifiedController.step = lambda *given: decided.append(1) or step(*given)\n"
    "done = CliRunner().invoke(main, ['walk', '--duration', '0.2', '--json'])\n"
    "assert done.exit_code == 0, done.output\n"
    "assert '\"margin\"' in done.stdout\n"
)


def test_a_walk_of_a_point_mass_loads_nothing_of_bodies_and_decides_once() -> None:
    printed = "import json, sys; print(json.dumps([len(decided), sorted(sys.modules)]))"
    code = OF_A_POINT_MASS + printed
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    decided, loaded = json.loads(done.stdout)
    # 200 cycles, and the instant at their end.
    assert decided == 201
    own = {name.removeprefix("surefoot.") for name in loaded if name.startswith("surefoot.")}
    assert not [name for name in own if name.startswith("worlds.body")]
    rollouts = ("trace", "fall", "fall_signs", "measures", "mcap_log", "ros_messages")
    of_bodies = {f"rollout.{name}" for name in rollouts}
    of_bodies |= {f"robot.{name}" for name in ("multibody", "legs", "floor")}
    # A module that is renamed is renamed here too.
    assert of_bodies <= {".".join(path.relative_to(SOURCE).with_suffix("").parts) for path in FILES}
    assert not own & of_bodies
    assert not {name.split(".")[0] for name in loaded} & (OPTIONAL - {"click", "rich"})
    assert len(own) < 100
