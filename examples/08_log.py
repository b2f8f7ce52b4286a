"""Log a walk to MCAP and load it again: every cycle is kept, to the bit.

Foxglove, PlotJuggler and `ros2 bag` open the same file walk.mcap without a plugin. The output shows
that the loaded walk equals the original, that a controller decides the same from the log, and what
is left of a log that was cut short, as by a full disk. It needs the extra `log`.
"""

import warnings
from pathlib import Path

import surefoot as sf

robot = sf.load_robot("paper-biped")
controller = sf.HybridController(robot, velocity=(0.5, 0.0))
push = sf.Push(start=1.1, duration=0.2, force=(176.0, 0.0))  # 35.2 N s forward
walked = sf.simulate(controller, duration=4.0, pushes=[push])

walked.save("walk.mcap")
loaded = sf.load_rollout("walk.mcap")
print(f"loaded {len(loaded.time)} cycles of {loaded.controller}, {loaded.outcome.value}")
print("equal to what was walked:", loaded == walked)

# Each row of `seen` is an observation; a controller decides anew what it decided on the walk.
state, same = controller.start(controller.first_observation()), True
for cycle in range(len(loaded.time)):
    seen = sf.Observation.of(loaded.seen[cycle : cycle + 1])
    command, state = controller.step(state, seen)
    same = same and command == sf.Command.of(loaded.commands[cycle : cycle + 1])
print("decided again from the log, to the bit:", same)

file = Path("walk.mcap").read_bytes()
Path("part.mcap").write_bytes(file[: len(file) // 2])
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # that the file is not whole
    part = sf.load_rollout("part.mcap")
first = (part.observations == loaded.observations[: len(part.time)]).all()
print(f"half of the file: {part.outcome.value}; the cycles before the cut are the same: {first}")
