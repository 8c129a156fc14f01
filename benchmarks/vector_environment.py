"""Environment steps a second of the vectorised Gymnasium environment, and ratios to fixed work and to others.

A step is one wire through one sample of 50 ms: drive, simulation, converter noise, protection, reward, observation, and
the restart of episodes that have ended. Ratios are taken in turns in one process, so that they are of the same
machine at the same time: to a fixed compiled workload (how many of its rounds an environment step costs), to
Gymnasium's own vector of carts with poles, which needs four sums and two trigonometric functions a step, and to as
many single environments one after the other. What the environment's long steps of the simulation cost in accuracy is
printed as well: against steps of 0.5 ms, for a drive that jumps at every sample, as untrained policies drive. Prints a
table, or one JSON document with --json; --quick takes fewer turns.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numba
import numpy as np

from musclewire.experiment import characterize
from musclewire.extras.interfaces import ENVIRONMENT, MAX_STEP_S, WireVectorEnv, simulated_wire
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.wire import drive_path, fixed_steps

WIRES, SINGLE = 1024, 8
BAR_PER_S = 2e6
ROUNDS = 200_000


@numba.njit(error_model="numpy")
def fixed_rounds(rounds: int) -> float:
    """Return the end of a chain of products, quotients and roots: each round waits for the one before."""
    value = 0.5
    for number in range(rounds):
        value = math.sqrt(1.0 + value * value) / (1.0 + 0.5 * value) + 1e-9 * number
    return value


def seconds(run: Callable[[], object]) -> tuple[float, float]:
    """Return how long a call takes by the clock, and how much processor time its threads take."""
    begin, began = time.perf_counter(), time.process_time()
    run()
    return time.perf_counter() - begin, time.process_time() - began


def stepper(env: Any, shape: tuple[int, ...], steps: int) -> Callable[[], None]:
    """Return a function that takes ``steps`` steps at drives drawn before, and restarts what has ended."""
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, *shape))
    if env.action_space.dtype == np.int64:
        actions = (actions > 0.0).astype(np.int64)

    def run() -> None:
        for action in actions:
            env.step(action)

    return run


def errors_of_steps(samples: int = 2000) -> dict[str, float]:
    """Return root mean square and largest error of strain and resistance that the environment's steps leave."""
    wire = simulated_wire("simulated")
    drive_v = np.random.default_rng(1).uniform(wire.limits.sense_voltage_v, wire.limits.maximum_voltage_v, samples)
    found, exact = (
        drive_path(wire.constants, drive_v, sample_s=wire.sample_period_s, stepping=fixed_steps(step_s))[0]
        for step_s in (MAX_STEP_S, 5e-4)
    )
    strain_pct = 100.0 * (found.displacement_m - exact.displacement_m) / wire.constants.leg_length_m
    ohm = (
        found.wire_voltage_v / found.shunt_voltage_v - exact.wire_voltage_v / exact.shunt_voltage_v
    ) * wire.limits.shunt_resistance_ohm
    return {
        "step_s": MAX_STEP_S,
        "strain_rms_pct": float(np.sqrt(np.mean(strain_pct**2))),
        "strain_largest_pct": float(np.abs(strain_pct).max()),
        "resistance_rms_ohm": float(np.sqrt(np.mean(ohm**2))),
        "resistance_largest_ohm": float(np.abs(ohm).max()),
    }


def measured(turns: int, steps: int) -> dict[str, float]:
    """Return steps a second and ratios, medians over turns."""
    with open_rig("simulated") as rig:
        model = fit(characterize(rig, cycles=1, minor_loop=False))
    kinds = {
        "ours": (stepper(WireVectorEnv(WIRES, episode="random"), (WIRES, 1), steps), WIRES * steps),
        "with estimator": (
            stepper(WireVectorEnv(WIRES, episode="random", model=model), (WIRES, 1), steps),
            WIRES * steps,
        ),
        "carts": (stepper(gymnasium.make_vec("CartPole-v1", WIRES), (WIRES,), steps), WIRES * steps),
        "single": (
            stepper(gymnasium.make_vec(ENVIRONMENT, SINGLE, vectorization_mode="sync"), (SINGLE, 1), steps),
            SINGLE * steps,
        ),
        "fixed": (lambda: fixed_rounds(ROUNDS), ROUNDS),
    }
    took: dict[str, list[float]] = {name: [] for name in kinds}
    processor: list[float] = []
    for turn in range(turns + 1):
        for name, (run, count) in kinds.items():
            clock_s, processor_s = seconds(run)
            if turn:  # the first one compiles
                took[name].append(clock_s / count)
                processor += [processor_s / count] if name == "ours" else []
    ratios = {
        f"{over} over ours": statistics.median(b / a for a, b in zip(took["ours"], took[over], strict=True))
        for over in ("carts", "single", "with estimator")
    }
    return {
        "steps_per_s": 1.0 / statistics.median(took["ours"]),
        "best_steps_per_s": 1.0 / min(took["ours"]),
        "processor_s_per_step": statistics.median(processor),
        "fixed_rounds_per_step": statistics.median(a / b for a, b in zip(took["ours"], took["fixed"], strict=True)),
        "with_estimator_over_ours": ratios["with estimator over ours"],
        "single_over_ours": ratios["single over ours"],
        "carts_over_ours": ratios["carts over ours"],
        "bar_steps_per_s": BAR_PER_S,
        **errors_of_steps(),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--quick", action="store_true", help="fewer turns")
    options = parser.parse_args()
    found = measured(*((3, 20) if options.quick else (9, 200)))
    if options.json:
        print(json.dumps(found))
        return
    print(f"{WIRES} wires, samples of 50 ms: {found['steps_per_s'] / 1e6:.3f} million environment steps a second")
    print(f"  (best {found['best_steps_per_s'] / 1e6:.3f}; the bar is {BAR_PER_S / 1e6:g})")
    print(f"an environment step takes {1e9 * found['processor_s_per_step']:.0f} ns of processor time")
    print(f"one environment step costs {found['fixed_rounds_per_step']:.1f} rounds of the fixed workload")
    print(f"with the estimator's strain in the observation it costs {found['with_estimator_over_ours']:.2f} times that")
    print(f"a step of {SINGLE} single environments one after the other: {found['single_over_ours']:.0f} times ours")
    print(f"a step of {WIRES} carts with poles (Gymnasium's own vector): {found['carts_over_ours']:.2f} times ours")
    print(
        f"steps of {1e3 * found['step_s']:g} ms err by {found['strain_rms_pct']:.4f} points of strain rms "
        f"({found['strain_largest_pct']:.4f} at most) and {1e3 * found['resistance_rms_ohm']:.1f} mohm rms "
        f"({1e3 * found['resistance_largest_ohm']:.1f} at most)"
    )


if __name__ == "__main__":
    main()
