"""What [OnlineGait] reports beside what is measured here, with a verdict and a reason for each."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from surefoot.control.hybrid import HybridController
from surefoot.control.tracking import DcmTracking
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.robot.feet import Footstep
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout, describe
from surefoot.studies.engine.scan import PushLimit, smallest_failing_push
from surefoot.studies.reproduce.one_step import PAPER_X, PAPER_Y, OneStepLimit, claim_one_step
from surefoot.studies.reproduce.walks import (
    AXES,
    DOUBLE_SUPPORT,
    FIG_5_PUSH,
    FIG_8_PUSH,
    FIG_11_PUSH,
    HEADLINE_PUSH,
    NOT_REPRODUCED,
    REPLAY_PUSH,
    REPRODUCED,
    SECOND_VELOCITY,
    SMALL_FORCE,
    SMALL_OFFSET_WEIGHT,
    UNDER_ASSUMPTIONS,
    VELOCITY,
    Claim,
    paper_walk,
    replay_fall,
)
from surefoot.version import VERSION

RETURNED = 1e-3
"""An error below this is gone [m]."""

SLOW_RETURN = 0.01
"""A mean velocity this close to the command is the commanded one [m/s]."""


LEG_SPEED = 3.0
"""Of a leg that is not ideal, for the headline [m/s]."""


def paper_parameters(robot: Robot) -> list[tuple[str, str]]:
    """What every number depends on: name and value."""
    hybrid, tracking = HybridController(robot, VELOCITY), DcmTracking(robot, VELOCITY)
    return [
        ("version", VERSION),
        ("robot", f"{robot.name}, {robot.mass:g} kg, CoM at {robot.com_height:g} m, hip "
                  f"{robot.hip:g} m, leg speed {robot.swing.max_speed:g} m/s"),
        ("limits", f"T {robot.gait.step_duration} s, X {robot.gait.step_x} m, Y "
                   f"{robot.gait.step_y} m, d {robot.gait.dcm_offset} m"),
        ("velocity", f"{VELOCITY} m/s, and {SECOND_VELOCITY} m/s in Fig. 4"),
        ("DcmTracking", f"{describe(tracking)}; Figs. 4, 5, 8: double_support={DOUBLE_SUPPORT:g}, "
                        "project_zmp=False"),
        ("HybridController", f"{describe(hybrid)}; Figs. 11, 12: offset_weight="
                             f"{SMALL_OFFSET_WEIGHT}"),
        ("small pushes", f"{SMALL_FORCE} N in every step of Figs. 9, 10"),
        ("seed", "none: nothing is random"),
    ]  # fmt: skip


def claim_fig_4(first: Rollout, second: Rollout) -> Claim:
    """Footholds and step time follow from the velocity."""
    words, follows = [], True
    for walk in (first, second):
        gait, last = _gait(walk), walk.footsteps[-1]
        lengths = [step.step[0] for step in walk.footsteps]
        widths = [step.step[1] for step in walk.footsteps]
        words.append(
            f"v = ({gait.velocity[0]:g}, {gait.velocity[1]:g}) m/s: T = {last.duration:.3f} s, "
            f"X = {np.mean(lengths):.3f} m, steps sideways {min(widths):.3f} to "
            f"{max(widths):.3f} m"
        )
        mean = np.subtract(walk.final_velocity, gait.velocity)
        follows &= bool(np.abs(mean).max() < 1e-3)
        follows &= math.isclose(float(np.mean(lengths)), gait.step_length, abs_tol=1e-6)
    return Claim(
        "Fig. 4",
        "planning at two walking velocities",
        "footholds and step time are found from the velocity, and the plan follows it",
        "; ".join(words),
        UNDER_ASSUMPTIONS if follows else NOT_REPRODUCED,
        "the paper does not print its two velocities; these are ours",
    )


def claim_fig_5(walk: Rollout) -> Claim:
    """Tracking removes the error of a small push, and the ZMP stays under the feet."""
    error = np.hypot(*walk.dcm_error.T)
    late = walk.time[np.flatnonzero(error >= RETURNED)[-1]]
    returned, excess = late < walk.time[-1], walk.zmp_excess.max()
    return Claim(
        "Fig. 5",
        "tracking with continuous double support, 40 N in +x from 0.5 s for 0.8 s",
        "p_c moves in a certain range, the DCM converges to the plan after the push",
        f"largest DCM error {1e3 * error.max():.1f} mm, below 1 mm {late - FIG_5_PUSH.end:.2f} s "
        f"after the push; ZMP outside the support by {1e3 * excess:.1f} mm",
        UNDER_ASSUMPTIONS if returned and excess == 0.0 else NOT_REPRODUCED,
        f"double support is {DOUBLE_SUPPORT:g} of the step and K_f = 3 /s: the paper prints "
        "neither",
    )


def claim_fig_8(walk: Rollout) -> Claim:
    """Under a large push the ZMP of tracking leaves the support polygon, in single support."""
    out = np.flatnonzero(walk.zmp_excess > 0.0)
    starts_shared = _shared_at(walk, 1.0)
    single = len(out) > 0 and not walk.commands["double_support"][out].any()
    ours = "the ZMP stays inside"
    if len(out):
        ours = (
            f"outside from {walk.time[out[0]]:.3f} s to {walk.time[out[-1]]:.3f} s, by up to "
            f"{1e3 * walk.zmp_excess.max():.1f} mm, {'only' if single else 'not only'} in single "
            f"support; the push begins in {'double' if starts_shared else 'single'} support"
        )
    return Claim(
        "Fig. 8",
        "the same, 142 N in +x from 1.0 s for 0.2 s",
        "the push begins in double support; p_c leaves the support polygon in single support",
        ours,
        UNDER_ASSUMPTIONS if single and starts_shared else NOT_REPRODUCED,
        f"the ZMP is not projected; double support {DOUBLE_SUPPORT:g} of the step, K_f = 3 /s. "
        "No foot can push there: the run shows what the law asks for",
    )


def claim_projection(walk: Rollout, limit: PushLimit) -> Claim:
    """The same push when the ZMP is kept under the feet; the paper does not show it."""
    error = np.hypot(*walk.dcm_error.T).max()
    kept = walk.zmp_excess.max() == 0.0
    return Claim(
        "Fig. 8, projected",
        "the same push with the ZMP kept inside the support polygon",
        "not shown; walking on is called precarious",
        f"{ending(walk)}; largest DCM error {1e3 * error:.1f} mm, ZMP "
        f"{'at the edge, never outside' if kept else 'outside'}; the smallest such push that fails "
        f"has {limit.impulse:g} N s, this one {FIG_8_PUSH.impulse[0]:g} N s",
        REPRODUCED if kept else NOT_REPRODUCED,
        "with the ZMP at the edge nothing is left against a larger push: precarious indeed",
    )


def claim_replay(robot: Robot) -> Claim:
    """Replaying the planned ZMP without feedback ends in a fall."""
    noise, shared = replay_fall(robot, 0.0), replay_fall(robot, DOUBLE_SUPPORT)
    return Claim(
        "IV-A, open loop",
        "the planned ZMP replayed without feedback, undisturbed",
        "unstable after a period of time, from numerical imprecision",
        f"falls at {noise:.2f} s from rounding errors alone; at {shared:.2f} s with double support",
        REPRODUCED if max(noise, shared) < math.inf else NOT_REPRODUCED,
        "without double support the ZMP rests during each step, so only rounding (1e-16) is left "
        "to grow; with it, holding a moving ZMP for 1 ms is an error of its own",
    )


def claim_pushed_replay(robot: Robot) -> Claim:
    """With a push it ends sooner."""
    pushed = replay_fall(robot, 0.0, (REPLAY_PUSH,))
    return Claim(
        "IV-A, open loop",
        "the same replay with a push of 1 N for 0.1 s",
        "diverges faster",
        f"falls at {pushed:.2f} s",
        REPRODUCED if pushed < replay_fall(robot, 0.0) else NOT_REPRODUCED,
        "the push is ours: the paper names none",
    )


def claim_fig_9(walk: Rollout, undisturbed: Rollout) -> Claim:
    """One step with the nominal offset at its end absorbs the push."""
    gait = _gait(walk)
    third, alone = walk.footsteps[2], undisturbed.footsteps[2]
    error, alone_error = _offset_error(third, gait), _offset_error(alone, gait)
    one_step = [step.index for step in walk.footsteps if step.adapted] == [2]
    good = one_step and max(error, alone_error) < RETURNED
    return Claim(
        "Fig. 9",
        "hybrid, 176 N in +x at 1.1 s for 0.2 s (35.2 N s), small pushes in every step",
        "a large third step; at its end d = d_nom again: one step is enough",
        f"third step {third.step[0]:.3f} m long (nominal {gait.step_length:.3f}), d within "
        f"{1e3 * error:.2f} mm of d_nom at its end ({1e3 * alone_error:.2f} mm without the small "
        f"pushes); {sum(step.adapted for step in walk.footsteps)} step adapted",
        UNDER_ASSUMPTIONS if good else NOT_REPRODUCED,
        f"small pushes ({SMALL_FORCE[0]:g}, {SMALL_FORCE[1]:g}) N, unlimited leg, threshold "
        "25 mm and weights (20000, 1000) on d: the paper prints none of them",
    )


def claim_fig_10(walk: Rollout) -> Claim:
    """The third step is short in time, and tracking takes care of the small pushes."""
    gait, third = _gait(walk), walk.footsteps[2]
    quiet = ~walk.adapting
    error = np.hypot(*walk.dcm_error[quiet].T).max()
    good = third.duration < 0.9 * gait.step_duration and walk.zmp_excess.max() == 0.0
    return Claim(
        "Fig. 10",
        "the same walk over time",
        "the third step is significantly shorter; tracking compensates the small pushes",
        f"third step {third.duration:.3f} s (nominal {gait.step_duration:.3f} s); DCM error at "
        f"most {1e3 * error:.1f} mm while tracking, ZMP never outside the sole",
        UNDER_ASSUMPTIONS if good else NOT_REPRODUCED,
        "tracking has no integral part, so a constant force leaves a constant error",
    )


def claim_fig_11(walk: Rollout) -> Claim:
    """With a smaller weight on d the third step is the longest and ends with a larger offset."""
    gait, steps = _gait(walk), walk.footsteps
    lengths = [step.step[0] for step in steps]
    third = steps[2]
    longest = lengths[2] >= max(lengths) - 1e-9
    larger = third.dcm_offset[0] - gait.dcm_offset(third.side)[0]
    adapted = sum(step.adapted for step in steps)
    after = _steps_until(steps, gait)
    landed = third.start + third.duration
    during = ", while the push still acts" if landed < FIG_11_PUSH.end else ""
    good = longest and larger > RETURNED and after > 1
    return Claim(
        "Fig. 11",
        "hybrid, smaller weight on d, 411.6 N in +x at 1.1 s for 0.2 s (82.32 N s)",
        "the third step is the longest, d > d_nom at its end; d returns over several steps",
        f"third step {lengths[2]:.3f} m ({'the longest' if longest else 'not the longest'}), "
        f"landing at {landed:.3f} s{during}; "
        f"d_x {1e3 * larger:+.1f} mm from nominal at its end; {adapted} steps adapted; d within "
        f"1 mm {after} steps after the third",
        UNDER_ASSUMPTIONS if good else NOT_REPRODUCED,
        f"weights ({SMALL_OFFSET_WEIGHT[0]:g}, {SMALL_OFFSET_WEIGHT[1]:g}) on d, unlimited leg: "
        "the paper prints neither; the next steps reach the same limit of 0.5 m",
    )


def claim_fig_12(walk: Rollout) -> Claim:
    """Both velocities return to the command."""
    time, after = np.array([step.start for step in walk.footsteps]), 0
    com = np.array([np.interp(time, walk.time, walk.com[:, axis]) for axis in (0, 1)]).T
    # Over two steps, since the body swings from foot to foot.
    mean = (com[2:] - com[:-2]) / (time[2:] - time[:-2])[:, None]
    off = np.flatnonzero(np.abs(mean - walk.velocity).max(axis=1) > SLOW_RETURN)
    # The mean with index k begins with step k.
    after = int(off[-1]) + 1 - 2 if len(off) else 0
    peak = walk.com_velocity[:, 0].max()
    good = bool(after > 1 and walk.outcome is Outcome.RECOVERED)
    return Claim(
        "Fig. 12",
        "CoM velocity of the same walk",
        "both velocities return to their targets through several adjustments",
        f"v_x peaks at {peak:.2f} m/s; the mean over two steps is within {SLOW_RETURN:g} m/s of "
        f"({walk.velocity[0]:g}, {walk.velocity[1]:g}) from {after} steps after the third on",
        UNDER_ASSUMPTIONS if good else NOT_REPRODUCED,
        "assumptions of Fig. 11",
    )


def claim_headline(robot: Robot) -> Claim:
    """85 N s is survived; the smallest impulse that is not, by leg and direction."""
    walk = paper_walk(robot, "headline")
    legs = {"unlimited leg": robot, f"{LEG_SPEED:g} m/s": robot.with_leg(max_speed=LEG_SPEED)}
    limits = "; ".join(
        f"{leg}: " + ", ".join(f"{name} {impulse:g}" for name, impulse in failing.items())
        for leg, failing in ((leg, smallest_failing(one)) for leg, one in legs.items())
    )
    return Claim(
        "abstract",
        f"hybrid, {HEADLINE_PUSH.impulse[0]:g} N s on {walk.robot.mass:g} kg",
        "withstands 85 N s, against 20 N s of foot placement alone",
        f"{ending(walk)} in +x; smallest failing impulses in N s, {limits}",
        UNDER_ASSUMPTIONS if walk.outcome is Outcome.RECOVERED else NOT_REPRODUCED,
        "unlimited leg, as in the paper, +x from 1.1 s for 0.2 s; a leg of 3 m/s fails "
        "earlier, as the numbers show. Foot placement alone (20 N s) is not run here",
    )


def smallest_failing(robot: Robot) -> dict[str, float]:
    """The smallest impulse that fails in each direction [N s]."""
    controller = HybridController(robot, VELOCITY)
    return {name: smallest_failing_push(controller, way).impulse for name, way in AXES.items()}


def tracking_limit(robot: Robot) -> PushLimit:
    """The smallest push like that of Fig. 8 that tracking with a finite foot does not survive."""
    controller = DcmTracking(robot, VELOCITY, double_support=DOUBLE_SUPPORT)
    start, duration = FIG_8_PUSH.start, FIG_8_PUSH.duration
    return smallest_failing_push(
        controller, (1.0, 0.0), start=start, duration=duration, step=0.2, largest=80.0
    )


def ending(walk: Rollout) -> str:
    """Survived or fell."""
    return "survived" if walk.outcome is not Outcome.FELL else "fell"


def _gait(walk: Rollout) -> NominalGait:
    return nominal_gait(walk.robot, walk.velocity)


def _offset_error(step: Footstep, gait: NominalGait) -> float:
    """The larger component of d - d_nom at the end of a step [m]."""
    return float(np.abs(np.subtract(step.dcm_offset, gait.dcm_offset(step.side))).max())


def _steps_until(steps: tuple[Footstep, ...], gait: NominalGait) -> int:
    """How many steps after the third d is nominal again, for good."""
    off = [step.index for step in steps if _offset_error(step, gait) >= RETURNED]
    return off[-1] + 1 - 2 if off else 0


def _shared_at(walk: Rollout, time: float) -> bool:
    index = int(np.searchsorted(walk.time, time - 1e-9))
    return bool(walk.commands["double_support"][index])


def _of_walks(claim: Callable[..., Claim], *names: str) -> Judge:
    """A claim about walks of the paper."""
    return lambda robot, _: claim(*(paper_walk(robot, name) for name in names))


Judge = Callable[[Robot, Sequence[OneStepLimit]], Claim]
"""Makes a claim of the robot and the limits of one step."""

CLAIMS: dict[str, Judge] = {
    "fig-4": _of_walks(claim_fig_4, "fig-4a", "fig-4b"),
    "fig-5": _of_walks(claim_fig_5, "fig-5"),
    "fig-8": _of_walks(claim_fig_8, "fig-8"),
    "fig-8-projected": lambda robot, _: claim_projection(
        paper_walk(robot, "fig-8-projected"), tracking_limit(robot)
    ),
    "replay": lambda robot, _: claim_replay(robot),
    "pushed-replay": lambda robot, _: claim_pushed_replay(robot),
    "fig-9": _of_walks(claim_fig_9, "fig-9", "fig-9-without-small-pushes"),
    "fig-10": _of_walks(claim_fig_10, "fig-9"),
    "one-step-x": lambda _, limits: claim_one_step(limits, PAPER_X, along_x=True),
    "one-step-y": lambda _, limits: claim_one_step(limits, PAPER_Y, along_x=False),
    "fig-11": _of_walks(claim_fig_11, "fig-11"),
    "fig-12": _of_walks(claim_fig_12, "fig-11"),
    "headline": lambda robot, _: claim_headline(robot),
}
"""Every claim of the paper by a name of its own, in the order of the paper."""
