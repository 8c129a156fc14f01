"""The comparisons of many closed loops, and of environments for reinforcement learning."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from time import perf_counter, process_time
from typing import Any

import numpy as np
from benchmarks.speed.easier_wire import SENSE_V, ScipyLoop
from benchmarks.speed.measuring import PreparedComparison, TimedProgram

from musclewire.controllers import staircase
from musclewire.experiment import characterize, control_many, run_warnings
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.signals import Recording

__all__ = ["PlainLoop", "loop_cases"]

SAMPLE_S = 0.05
LOOPS, QUICK_LOOPS = 100, 8
WIRES, QUICK_WIRES = 1024, 128
STEPS, QUICK_STEPS = 100, 20
THEIR_STEPS = 400
MAXIMUM_V = 3.2


class PlainLoop:
    """A closed loop of one's own: SciPy for each sample of the easier wire, and a PID in a few lines of Python."""

    def __init__(self) -> None:
        """Start cold, at the sense voltage."""
        self.wire = ScipyLoop(SAMPLE_S)
        self.drive_v, self._sum_v, self._before = SENSE_V, 0.0, 0.0

    def sample(self, target: float) -> float:
        """Take one sample and choose the next drive; return the transformed fraction that was reached."""
        self.wire.advance(self.drive_v)
        reached = 1.0 - self.wire.state[1]
        error = target - reached
        self._sum_v = min(max(self._sum_v + 2.0 * error * SAMPLE_S, 0.0), MAXIMUM_V)
        wanted_v = SENSE_V + 4.0 * error + self._sum_v - 0.2 * (reached - self._before) / SAMPLE_S
        self.drive_v, self._before = min(max(wanted_v, SENSE_V), MAXIMUM_V), reached
        return reached


def loop_cases() -> Iterator[PreparedComparison]:
    """Yield the comparison of closed loops, and that of a vector of environments."""
    work = (
        f"50 ms of one of {LOOPS} closed loops (--quick: {QUICK_LOOPS}), all cores; ours has noise, protection, "
        "filter and the inverse of the model, theirs a PID on the true state of an easier wire"
    )
    other = "a loop in Python: solve_ivp and a PID for each sample"
    yield PreparedComparison("closed_loops", work, other, closed_loop_sides, clock=perf_counter)
    work = "50 ms of a closed loop; ours finds in its recording what is wrong and what to warn of, as theirs does, too"
    other = f"control_many with {LOOPS} loops (--quick: {QUICK_LOOPS}), one thread: rigs, loops, metrics and judging"
    yield PreparedComparison("judging", work, other, judging_sides, clock=process_time)
    work = (
        f"50 ms of one of {WIRES:,} environments (--quick: {QUICK_WIRES}), one thread; ours has noise, protection, "
        "reward and restarts; theirs is an easier wire"
    )
    needs = "" if find_spec("gymnasium") is not None else "gym"
    other = "an environment of one's own around solve_ivp"
    yield PreparedComparison("vector_environment", work, other, environment_sides, needs, perf_counter)


def closed_loop_sides(quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of closed loops; a unit is a sample of one loop."""
    with open_rig("simulated") as rig:
        model = fit(characterize(rig, cycles=1, minor_loop=False))
    loops, reference = QUICK_LOOPS if quick else LOOPS, staircase()
    samples = round(reference.duration_s / SAMPLE_S)
    seeds = range(1, loops + 1)
    targets = [0.3 if number % 200 < 100 else 0.7 for number in range(THEIR_STEPS)]

    def theirs(loop: PlainLoop) -> None:
        for target in targets:
            loop.sample(target)

    def ours(_: object) -> None:
        control_many("simulated", model, reference, seeds=seeds)

    return (
        TimedProgram(ours, loops * samples),
        TimedProgram(theirs, THEIR_STEPS, PlainLoop),
    )


def judging_sides(quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of judging; a unit is a sample of the loop."""
    with open_rig("simulated") as rig:
        model = fit(characterize(rig, cycles=1, minor_loop=False))
    seeds = range(1, 1 + (QUICK_LOOPS if quick else LOOPS))
    loop = control_many("simulated", model, seeds=[1], keep_recordings=True).outcomes[0].run
    assert loop is not None

    def fresh() -> list[Recording]:
        # What a recording was asked before it keeps.
        return [Recording(loop.columns, loop.metadata) for _ in seeds]

    units = len(seeds) * len(loop)
    return (
        TimedProgram(lambda runs: [run_warnings(run) for run in runs], units, fresh),
        TimedProgram(lambda _: control_many("simulated", model, seeds=seeds, threads=1), units),
    )


def environment_sides(quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of environments; a unit is a step of one environment."""
    from musclewire.extras.interfaces import WireVectorEnv

    wires, steps = (QUICK_WIRES, QUICK_STEPS) if quick else (WIRES, STEPS)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, wires, 1))
    ours = WireVectorEnv(wires, episode="random")
    ours.reset(seed=1)

    def run(_: object) -> None:
        for action in actions:
            ours.step(action)

    return TimedProgram(run, wires * steps), TimedProgram(
        partial(plain_steps, actions.ravel()), THEIR_STEPS, plain_environment
    )


def plain_environment() -> Any:
    """Return an environment that one writes around SciPy in an afternoon."""
    import gymnasium

    class PlainEnvironment(gymnasium.Env[Any, Any]):
        """The easier wire: the action is a drive voltage, the reward the distance from half of its way."""

        action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))
        observation_space = gymnasium.spaces.Box(0.0, 1.0, (1,))

        def reset(
            self, *, seed: int | None = None, options: dict[str, Any] | None = None
        ) -> tuple[Any, dict[str, Any]]:
            """Start cold."""
            super().reset(seed=seed, options=options)
            self.wire = ScipyLoop(SAMPLE_S)
            return np.zeros(1), {}

        def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
            """Take one sample at a drive."""
            self.wire.advance(SENSE_V + 0.5 * (MAXIMUM_V - SENSE_V) * (float(action) + 1.0))
            reached = 1.0 - self.wire.state[1]
            return np.array([reached]), -abs(reached - 0.5), False, False, {}

    made = PlainEnvironment()
    made.reset(seed=1)
    return made


def plain_steps(actions: Any, environment: Any) -> None:
    """Take steps of the environment around SciPy."""
    for number in range(THEIR_STEPS):
        environment.step(actions[number % len(actions)])
