"""Scikit-fuzzy's inference for the rules that it can hold, beside one tick of the fuzzy PID."""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from musclewire.controllers import SET_NAMES, MamdaniRules, load_rule_base

__all__ = ["RULE_BASES", "scikit_fuzzy_is_there", "scikit_fuzzy_inferences"]

RULE_BASES = ("zhao-1993", "liu-7x7", "fixed")
GAINS = ("kp", "ki", "kd")
# scikit-fuzzy imports the other two without declaring them.
NEEDED = ("skfuzzy", "networkx", "packaging")


def scikit_fuzzy_is_there() -> bool:
    """Return whether scikit-fuzzy is installed."""
    return all(find_spec(name) is not None for name in NEEDED)


def scikit_fuzzy_inferences(inferences: int) -> Callable[[object], None]:
    """Return a call of so many inferences of scikit-fuzzy, inputs fresh: it answers repeated ones from a cache."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        simulation = scikit_fuzzy_simulation()
    source = random.Random(2)

    def run(_: object) -> None:
        for _ in range(inferences):
            simulation.input["error"] = source.uniform(-3.0, 3.0)
            simulation.input["change"] = source.uniform(-3.0, 3.0)
            simulation.compute()

    return run


def scikit_fuzzy_simulation() -> Any:
    """Return scikit-fuzzy's simulation of the liu-7x7 tables on the same universes."""
    import skfuzzy as fuzz
    from skfuzzy import control

    rule_base = load_rule_base("liu-7x7")
    rules = rule_base.rules
    assert isinstance(rules, MamdaniRules)
    universe = np.linspace(-3.0, 3.0, 101)

    def named_sets(variable: Any, sets: Any) -> Any:
        for name, fuzzy_set in sets.items():
            points = fuzzy_set.points
            shape = {"triangle": lambda u, *p: fuzz.trimf(u, p), "z": fuzz.zmf, "s": fuzz.smf}[fuzzy_set.shape]
            variable[name] = shape(universe, *points)
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
