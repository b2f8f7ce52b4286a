"""Hashes of what the package computes: write them before a refactoring, check them after it.

    python benchmarks/same_numbers.py --write FILE.json
    python benchmarks/same_numbers.py --check FILE.json [--only PREFIX]

Only public names and the command line are used, so that modules may move. Every number counts to
the last bit; every text counts but for what a second run changes: see `normalised` and `VOLATILE`.
"""

from __future__ import annotations

import argparse
import difflib
import hashlib
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf

COMMAND = (sys.executable, "-c", "import sys; from surefoot.cli import main; sys.exit(main())")

CONTROLLERS: dict[str, Callable[..., Any]] = {
    "tracking": sf.DcmTracking,
    "tracking-stiff": partial(sf.DcmTracking, dcm_gain=30.0),
    "preview-control": sf.PreviewControl,
    "linear-mpc": sf.LinearMpc,
    "capture-point": sf.CapturePointStepping,
    "foot-placement-mpc": sf.FootPlacementMpc,
    "foot-placement-mpc-100ms": partial(sf.FootPlacementMpc, solve_period=math.inf),
    "ankle-hip-step-mpc": sf.AnkleHipStepMpc,
    "step-timing": sf.StepTiming,
    "timing-nlp": sf.TimingNlp,
    "hybrid": sf.HybridController,
    "unified": sf.UnifiedController,
}
"""By their keys on the command line; used from Python where the command line has no option."""

WALKS = {
    "nominal": "--velocity 0.5 0 --duration 3",
    "forward": "--push 300,0@1.1+0.2 --leg-speed 3 --duration 4",
    "sideways": "--push 0,420@1.1+0.2 --leg-speed 3 --duration 4",
    "talos-backwards": "--robot talos --velocity -0.2 0.05 --push 150,-60@0.9+0.2 --duration 3",
}
"""Of every method, with `surefoot walk`; the fifth, with noise, is made from Python."""

OTHER_WALKS = {
    "point/double-support": "--controller tracking --double-support 0.2 --unprojected "
    "--then 0.3,0.1@1.5 --push 40,0@0.5+0.8 --duration 4",
    "point/footholds": "--footholds feet.csv --duration 4",
    "body/paper-biped-pushed": "--simulator mujoco --push 150,0@1.5+0.2 --duration 4",
    "body/talos-turning": "--simulator mujoco --robot talos --truth --turning 0.3 --stand-at 2.5 "
    "--duration 4",
    "body/g1-noisy": "--simulator mujoco --robot g1 --push 60,60@1.4+0.2 --delay 0.005 "
    "--bumps 0.01 --seed 3 --duration 4",
}

STUDIES = {
    "compare": "compare --directions 2 --phases 1 --step 20 --workers 1 --out out",
    "budget": "compare --method hybrid --method unified --disturbance all --directions 2 "
    "--phases 1 --step 40 --workers 1 --out out",
    "body-pushes": "compare --simulator mujoco --method unified --phases 1 --step 60 --explain "
    "--workers 1 --out out",
    "body-walks": "compare --simulator mujoco --method unified --disturbance all-at-once "
    "--seeds 1 --duration 3 --workers 1 --out out",
    "push-map": "push-map --directions 4 --phases 2 --step 20 --workers 1 --out out",
    "sweep-walks": "sweep walks.toml --workers 1 --out out",
    "sweep-limits": "sweep limits.toml --workers 1 --out out",
    "tune": "tune --controller tracking --velocity 0.3 0 --prefer gentleness --quick --trials 12 "
    "--workers 1 --out out",
    "gentleness": "gentleness --impulse 10",
    "limits": "limits --phases 2 --leg-speed 3 --leg-speed inf",
    "reproduce": "reproduce --out out",
    "walk": "walk --push 300,0@1.1+0.2 --leg-speed 3 --duration 4",
    "walk-in-physics": "walk --simulator mujoco --push 150,0@1.5+0.2 --duration 4",
    "robots": "robots",
    "robots-check": "robots check g1",
}
"""All but `reproduce` and `robots check` run twice: for --json and for the printed text."""

FILES = {
    "feet.csv": "side,x,y,yaw,time\nright,0,-0.1,0,0\nleft,0.25,0.1,0,0.5\n"
    "right,0.45,-0.12,-0.1,1.1\nleft,0.6,0.05,-0.2,1.6\nright,0.6,-0.18,-0.2,2.2\n",
    "walks.toml": 'controller = "hybrid"\n[set]\nrobot.swing.max_speed = 3.0\npush.phase = 0.25\n'
    "[vary]\npush.impulse = [0.0, 60.0]\npush.angle = [0.0, 90.0]\ngait.velocity.x = [0.5, 9.0]\n",
    "limits.toml": 'measure = "push-limit"\ncontroller = "hybrid"\nstep = 20.0\n'
    'sampling = "latin-hypercube"\nsamples = 3\nseed = 3\n[vary]\npush.angle = [180.0]\n'
    "controller.threshold = { from = 0.02, to = 0.03 }\n",
}
"""That commands read, in the folder that they run in."""

VOLATILE = {
    "commit", "casadi", "cycle_time", "daqp", "date", "decision_p50", "decision_p99_9",
    "decision_time", "machine", "mujoco", "numba", "numpy", "optuna", "physics_time", "provenance",
    "python", "real_time_factor", "robot file", "scipy", "seconds", "sense_time", "sources",
    "version",
}  # fmt: skip
"""What another run, machine or version changes: fields of rollouts, keys of --json and rows of
reports that are left out."""

Answer = Iterator[tuple[str, Any]]
"""Names with numbers (arrays, records, dataclasses) or texts."""


def run(command: str, folder: Path) -> str:
    """Output of a command: its exit status and standard output, or its errors if it is misused."""
    for name, text in FILES.items():
        (folder / name).write_text(text)
    done = subprocess.run(
        [*COMMAND, *command.split()], cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "COLUMNS": "200", "NO_COLOR": "1"},
    )  # fmt: skip
    said = done.stdout if done.returncode in (0, 1) and done.stdout else done.stderr
    return f"exit status {done.returncode}\n{normalised(said)}"


def normalised(text: str) -> str:
    """A text without what a second run changes.

    JSON: without the keys `VOLATILE`, the others sorted. Else: without decision times and columns
    of them, rows `VOLATILE`, the version and spaces that only align columns.
    """
    if text.lstrip().startswith("{"):
        kept = json.loads(text, object_pairs_hook=_kept)
        return json.dumps(kept, indent=1, sort_keys=True, ensure_ascii=False)
    text = re.sub(r"Surefoot \d+\.\d+\.\d+", "Surefoot VERSION", text)
    text = re.sub(r"[\d.]+ × real", "FACTOR × real", text)
    lines, timed = [], set[int]()
    for line in text.splitlines():
        if "µs" in line or "(median)" in line:  # A row of decision times; a slow one is in ms.
            line = re.sub(r"[\d.]+ [µm]s", "TIME", line)
        cells = line.split(" | ")
        if not line.startswith("|"):
            timed = set()
        elif "p99" in line:
            timed = {i for i, one in enumerate(cells) if "p50" in one or "p99" in one}
        else:
            cells = ["TIME" if i in timed else one for i, one in enumerate(cells)]
        if cells[0].removeprefix("| ") not in VOLATILE:
            lines.append(" | ".join(cells))
    return re.sub(r"[ \t]+", " ", re.sub(r"[─━-]{3,}", "---", "\n".join(lines)))


def _kept(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    return {key: value for key, value in pairs if key not in VOLATILE}


def leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """All arrays and texts in a value, by the path of field names to each; robots are left out."""
    parts: list[tuple[str, Any]] = []
    if isinstance(value, np.ndarray | np.void) and value.dtype.names:
        parts = [(one, value[one]) for one in value.dtype.names]
    elif is_dataclass(value) and not isinstance(value, sf.Robot | type):
        parts = [(one.name, getattr(value, one.name)) for one in fields(value)]
    elif isinstance(value, dict):
        parts = list(value.items())
    elif isinstance(value, list | tuple) and any(map(is_dataclass, value)):
        columns = [one.name for one in fields(value[0])]
        parts = [(one, [getattr(row, one) for row in value]) for one in columns]
    elif isinstance(value, list | tuple) and _is_ragged(value):
        parts = [(str(i), one) for i, one in enumerate(value)]
    elif isinstance(value, str | int | float | np.ndarray | np.generic | list | tuple | Enum):
        yield name, value
    for part, one in parts:
        if part not in VOLATILE:
            yield from leaves(f"{name}.{part}" if name else part, one)


def _is_ragged(value: Any) -> bool:
    try:
        np.asarray(value)
    except ValueError:
        return True
    return False


def hashed(value: Any) -> str:
    """Of a text, or of shape and numbers as float64 or int64, so that a width may change."""
    if isinstance(value, str):
        return hashlib.sha256(value.encode()).hexdigest()[:16]
    array = np.asarray(value.value if isinstance(value, Enum) else value)
    if array.dtype.kind not in "biuf":
        return hashed(str(array.tolist()))
    array = array.astype(np.float64 if array.dtype.kind == "f" else np.int64, order="C")
    if array.dtype.kind == "f":
        array[np.isnan(array)] = math.nan
    return hashlib.sha256(repr(array.shape).encode() + array.tobytes()).hexdigest()[:16]


def walked(rollout: sf.Rollout) -> Answer:
    """All numbers of a walk, and what is public about it."""
    parts = {one.name: getattr(rollout, one.name) for one in fields(rollout)}
    if parts.get("seen") is parts.get("observations"):
        parts.pop("seen", None)
    public = ("outcome", "footsteps", "time", "com", "dcm", "zmp", "dcm_error")
    parts |= {f"public.{name}": getattr(rollout, name) for name in public}
    yield "", parts


def walk_of_command(options: str) -> Answer:
    """`surefoot walk`: its JSON and the file that it saves."""
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        yield "json", run(f"walk {options} --json --save walk.npz", where)
        if (where / "walk.npz").exists():  # Not if the command was refused, as the text then says.
            yield from walked(sf.load_rollout(where / "walk.npz"))


def noisy_walk(key: str) -> Answer:
    """Noise, delay, landing errors and an estimator that predicts over the delay."""
    robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)
    controller = CONTROLLERS[key](robot, (0.4, 0.05))
    disturbance = sf.Disturbance(
        dcm_noise=0.002, velocity_noise=0.01, delay=0.01, com_offset=(0.003, -0.002),
        landing_error=0.005, seed=7,
    )  # fmt: skip
    estimator = sf.Estimator(
        robot, delay=0.01, filter_time=0.03, bias_time=1.0, period=controller.period
    )
    rollout = sf.simulate(
        controller, 4.0, [sf.Push(1.3, 0.1, (150.0, 80.0))], disturbance=disturbance,
        estimator=estimator, velocity_changes=[(2.0, (0.2, 0.0))],
    )  # fmt: skip
    yield from walked(rollout)


def step_problems() -> Answer:
    """Two hundred random decisions; some have an empty interval or leave their bounds."""
    random = np.random.default_rng(19)
    names = ("step", "tau", "offset", "multiplier", "violation", "status", "iterations")
    for i in range(200):
        growth, offset = random.normal(0.0, 0.1, 2), random.normal(0.0, 0.05, 2)
        tau, earliest, latest = random.uniform((2.0, 0.3, 1.0), (8.0, 1.1, 2.0))
        problem = sf.StepProblem(
            growth=growth, nominal_step=random.normal(0.1, 0.15, 2), nominal_tau=tau,
            nominal_offset=offset, step_min=(-0.5, 0.0), step_max=(0.5, 0.5),
            tau_min=tau * earliest, tau_max=tau * latest,
            offset_min=offset - 0.05, offset_max=offset + random.uniform(0.0, 0.1, 2),
        )  # fmt: skip
        solution = sf.solve_step(problem)
        yield f"{i:03}", np.hstack([np.ravel(getattr(solution, name)) for name in names])


def limits_of(preset: str) -> Answer:
    """Speeds, viable offsets and the push limits of a preset with a leg of 3 m/s."""
    robot = sf.load_robot(preset).with_leg(max_speed=3.0)
    speed = sf.largest_speed(robot, (1.0, 0.0))
    velocity = (0.2 * speed, 0.0)
    gait = sf.nominal_gait(robot, velocity)
    yield "speeds", [speed, sf.largest_speed(robot, (-1.0, 0.5)), gait.step_duration]
    for side in sf.Side:
        yield f"viable.{side.name}", sf.viable_offsets(robot, side, robot.foot.half)
    when = {"velocity": velocity, "elapsed": 0.3 * gait.step_duration, "duration": 0.15}
    for direction in ((1.0, 0.0), (-0.6, 0.8), (0.0, -1.0)):
        for limit in (sf.push_limit, sf.causal_push_limit):
            try:
                found = limit(robot, direction, **when, zmp_reach=robot.foot.half)
                yield f"{limit.__name__}{direction}", found
            except sf.SurefootError as error:
                yield f"{limit.__name__}{direction}", str(error)
        fixed = sf.fixed_steps_limit(robot, direction, duration=0.15)
        yield f"fixed_steps_limit{direction}", fixed


def answers_of(key: str) -> Answer:
    """Smallest failing impulses in four directions, and twelve noisy walks in one batch."""
    controller = CONTROLLERS[key](sf.load_robot("paper-biped").with_leg(max_speed=3.0), (0.5, 0.0))
    for direction in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.5, -1.0)):
        failing = sf.smallest_failing_push(controller, direction, step=5.0, workers=1)
        yield f"fails{direction}", failing
    forces = [(40.0 * i * math.cos(i), 40.0 * i * math.sin(i)) for i in range(12)]
    pushes = [[sf.Push(1.0 + 0.05 * i, 0.2, force)] for i, force in enumerate(forces)]
    walks = sf.Walks(pushes=pushes, seeds=list(range(12)))
    disturbance = sf.Disturbance(dcm_noise=0.001, delay=0.01)
    yield "batch", sf.simulate_batch(controller, walks, 4.0, workers=1, disturbance=disturbance)


def unified_decisions() -> Answer:
    """What the unified controller decided in every cycle of a pushed walk."""
    controller = sf.UnifiedController(sf.load_robot("talos"), (0.3, 0.0))
    rollout = sf.simulate(controller, 3.0, [sf.Push(1.1, 0.2, (200.0, 100.0))])
    yield "decisions", sf.decisions(controller, rollout)


def study(command: str) -> Answer:
    """A command's JSON, its printed text and every .md and .toml that it writes."""
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        if not command.startswith(("reproduce", "robots check")):
            yield "json", run(f"{command} --json", where)
        yield "text", run(command, where)
        out = where / "out"
        for path in sorted([*out.rglob("*.md"), *out.rglob("*.toml")]):
            yield str(path.relative_to(out)), normalised(path.read_text())


def pieces() -> dict[str, Callable[[], Answer]]:
    """Everything that is computed, by name."""
    named: dict[str, Callable[[], Answer]] = {}
    for key in CONTROLLERS:
        for name, options in WALKS.items():
            if key == "ankle-hip-step-mpc":  # It needs a trunk.
                options = options.replace("talos", "paper-biped")
            named[f"point/{key}/{name}"] = partial(walk_of_command, f"--controller {key} {options}")
        named[f"point/{key}/noisy"] = partial(noisy_walk, key)
    for name, options in OTHER_WALKS.items():
        named[name] = partial(walk_of_command, options)
    named["decide/steps"] = step_problems
    named["decide/unified"] = unified_decisions
    for preset in sf.preset_names():
        named[f"limits/{preset}"] = partial(limits_of, preset)
    for key in ("tracking", "capture-point", "step-timing", "hybrid", "unified"):
        named[f"many/{key}"] = partial(answers_of, key)
    for name, command in STUDIES.items():
        named[f"study/{name}"] = partial(study, command)
    return named


def collect(prefix: str) -> tuple[dict[str, str], dict[str, str]]:
    """Hashes of everything whose name starts with a prefix, and the texts among it."""
    hashes, texts = dict[str, str](), dict[str, str]()
    for piece, compute in pieces().items():
        if not (piece.startswith(prefix) or prefix.startswith(piece)):
            continue
        start = time.perf_counter()
        found: list[tuple[str, Any]] = []
        try:
            for part, value in compute():
                found += leaves(part, value)
        except Exception:  # A piece that breaks is a difference; the others are still wanted.
            found.append(("error", traceback.format_exc()))
        for part, value in found:
            name = f"{piece}:{part}"
            if name.startswith(prefix):
                hashes[name] = hashed(value)
                if isinstance(value, str):
                    texts[name] = value
        print(f"{time.perf_counter() - start:6.1f} s  {piece}", file=sys.stderr, flush=True)
    return hashes, texts


def compare(before: dict[str, Any], hashes: dict[str, str], texts: dict[str, str]) -> bool:
    """Print all that is not as before; whether nothing differs or is missing.

    A name that is gone while its piece has the same hash under a new name is a renamed one.
    """
    old, lost = before["hashes"], []
    new = {name for name in hashes if name not in old}
    differing = [name for name in old if name in hashes and hashes[name] != old[name]]
    for name in sorted(old.keys() - hashes.keys()):
        piece = name.split(":")[0] + ":"
        twins = [n for n in sorted(new) if n.startswith(piece) and hashes[n] == old[name]]
        if twins:
            new.discard(twins[0])
            print(f"renamed  {name} -> {twins[0]}")
        else:
            lost.append(name)
    for name in differing:
        print(f"differs  {name}")
        if name in texts:
            then, now = before["texts"].get(name, "").splitlines(), texts[name].splitlines()
            print("\n".join(difflib.unified_diff(then, now, "before", "now", "", "", 1, "")))
    for name in lost:
        print(f"missing  {name}")
    for name in sorted(new):
        print(f"new      {name}" + (f"\n{texts[name]}" if name.endswith(":error") else ""))
    same = len(old) - len(differing) - len(lost)
    print(f"{same} as before, {len(differing)} differ, {len(lost)} missing, {len(new)} new")
    return not differing and not lost


def main() -> int:
    """Write or check; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument("--write", type=Path, metavar="FILE.json")
    task.add_argument("--check", type=Path, metavar="FILE.json")
    parser.add_argument("--only", default="", metavar="PREFIX", help="e.g. point/hybrid, study/")
    arguments = parser.parse_args()
    if arguments.check:
        before = json.loads(arguments.check.read_text())
        for table in before.values():
            for name in [one for one in table if not one.startswith(arguments.only)]:
                del table[name]
    hashes, texts = collect(arguments.only)
    if arguments.check:
        return 0 if compare(before, hashes, texts) else 1
    broken = [f"{name}\n{texts[name]}" for name in hashes if name.endswith(":error")]
    print(*broken, sep="\n", end="", file=sys.stderr)
    if not broken:
        text = json.dumps({"hashes": hashes, "texts": texts}, indent=0, ensure_ascii=False)
        arguments.write.write_text(f"{text}\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
