"""One controller tick against scikit-fuzzy's inference for the same 49 rules, in one process.

Prints JSON: [{name, ours_us, theirs_us, theirs, ratio}]. Ours is the whole tick from Python (inference, PID,
limits, checks); theirs is the inference alone, with fresh inputs each time because scikit-fuzzy answers
repeated ones from a cache. ``--quick`` measures fewer repetitions.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
import warnings
from collections.abc import Callable

import numpy as np

from musclewire.controllers import DriveLimits, FuzzyPid, FuzzyPidSettings, load_rule_base
from musclewire.controllers.rules import SET_NAMES, MamdaniRules

GAINS = ("kp", "ki", "kd")


def scikit_fuzzy_simulation():
    """Return scikit-fuzzy's simulation of the liu-7x7 tables on the same universes."""
    import skfuzzy as fuzz
    from skfuzzy import control

    rule_base = load_rule_base("liu-7x7")
    rules = rule_base.rules
    assert isinstance(rules, MamdaniRules)
    universe = np.linspace(-3.0, 3.0, 101)

    def named_sets(variable, sets):
        for name, fuzzy_set in sets.items():
            points = fuzzy_set.points
            make = {"triangle": lambda u, *p: fuzz.trimf(u, p), "z": fuzz.zmf, "s": fuzz.smf}[fuzzy_set.shape]
            variable[name] = make(universe, *points)
        return variable

    error = named_sets(control.Antecedent(universe, "error"), rule_base.input_sets)
    change = named_sets(control.Antecedent(universe, "change"), rule_base.input_sets)
    outputs = {gain: named_sets(control.Consequent(universe, gain), rules.output_sets) for gain in GAINS}
    made = [
        control.Rule(
            error[row_name] & change[column_name],
            [outputs[gain][getattr(rules, gain)[row][column]] for gain in GAINS],
        )
        for row, row_name in enumerate(SET_NAMES)
        for column, column_name in enumerate(SET_NAMES)
    ]
    return control.ControlSystemSimulation(control.ControlSystem(made))


def microseconds_per_call(call: Callable[[], object], calls: int, rounds: int) -> float:
    """Return the best mean of several rounds."""
    best = float("inf")
    for _ in range(rounds):
        begin = time.perf_counter()
        for _ in range(calls):
            call()
        best = min(best, (time.perf_counter() - begin) / calls)
    return best * 1e6


def our_tick(rule_base: str) -> Callable[[], object]:
    """Return a call that advances a controller by one tick with a fresh measurement."""
    controller = FuzzyPid(FuzzyPidSettings(rule_base=rule_base), DriveLimits(0.3, 3.2))
    source = random.Random(1)
    measurements = [source.uniform(0.014, 0.022) for _ in range(4096)]
    state = controller.start(1.0, 0.015, 0.018)
    index = 0

    def call() -> None:
        nonlocal state, index
        index = (index + 1) & 4095
        state = controller.step(state, 0.018, measurements[index], 0.05).state

    return call


def their_evaluation() -> Callable[[], object]:
    """Return a call that evaluates scikit-fuzzy's system for inputs it has not seen."""
    simulation = scikit_fuzzy_simulation()
    source = random.Random(2)

    def call() -> None:
        simulation.input["error"] = source.uniform(-3.0, 3.0)
        simulation.input["change"] = source.uniform(-3.0, 3.0)
        simulation.compute()

    return call


def main(arguments: list[str]) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer repetitions")
    quick = parser.parse_args(arguments).quick
    warnings.simplefilter("ignore")
    theirs = microseconds_per_call(their_evaluation(), calls=5 if quick else 20, rounds=2 if quick else 5)
    rows = []
    for rule_base in ("zhao-1993", "liu-7x7", "fixed"):
        ours = microseconds_per_call(our_tick(rule_base), calls=20_000 if quick else 100_000, rounds=5)
        rows.append(
            {
                "name": f"fuzzy_pid_tick[{rule_base}]",
                "ours_us": round(ours, 3),
                "theirs_us": round(theirs, 1),
                "theirs": "scikit-fuzzy ControlSystemSimulation, liu-7x7 rules, fresh inputs",
                "ratio": round(theirs / ours, 1),
            }
        )
    print(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main(sys.argv[1:])
