"""Which fuzzy rules fire, computed from recorded rows next to the loop and never in it.

A row has the target that held during its sample and the estimate of it. The controller's error is the difference
between the target of the next sample and this estimate, so the rules of a row are known when the next one is here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import (
    GAIN_COLUMNS,
    SET_NAMES,
    DriveLimits,
    FuzzyPidController,
    FuzzyPidSettings,
    RuleBase,
    ZhaoRules,
    rule_weights,
)
from musclewire.errors import MusclewireError
from musclewire.extras.live._server.socket_messages import FiredRule
from musclewire.signals import QuantityEstimate, Reason

# Which rules fire does not depend on the drive, so neither on its range.
ANY_LIMITS = DriveLimits(1.0, 2.0)


class InputRatios(NamedTuple):
    """The two inputs of the fuzzy tables: the error and its rate, each over its range."""

    error: float
    change: float


def settings_of(gains: Mapping[str, Any] | None) -> FuzzyPidSettings | None:
    """Return the settings of a fuzzy PID from a bench's state; None if it shows none."""
    if gains is None:
        return None
    try:
        return FuzzyPidSettings(**{name: gains[name] for name in FuzzyPidSettings.model_fields if name in gains})
    except MusclewireError:
        return None


def fired(rule_base: RuleBase, inputs: InputRatios) -> list[FiredRule]:
    """Return the rules that fire for two inputs, the strongest first; constant rules have none."""
    weights = rule_weights(rule_base, *inputs)
    found = [
        FiredRule(
            error=SET_NAMES[row],
            change=SET_NAMES[column],
            weight=float(weights[row, column]),
            **cells_of(rule_base.rules, row, column),
        )
        for row, column in np.argwhere(weights > 0.0)
    ]
    return sorted(found, key=lambda rule: -rule.weight)


def cells_of(rules: Any, row: int, column: int) -> dict[str, str]:
    """Return what a cell of the tables says of K_p, K_I and K_D; Zhao's alpha as a number."""
    ki = f"{rules.alpha[row][column]:g}" if isinstance(rules, ZhaoRules) else rules.ki[row][column]
    return {"kp": str(rules.kp[row][column]), "ki": str(ki), "kd": str(rules.kd[row][column])}


class FiredRules:
    """Follows the rows of a fuzzy PID and knows the inputs of its rules."""

    def __init__(self, settings: FuzzyPidSettings, sample_period_s: float) -> None:
        """Make the controller whose rules they are; nothing is known before the first row."""
        self.settings, self._dt_s = settings, sample_period_s
        self._controller = FuzzyPidController(settings, ANY_LIMITS)
        self.rule_base = self._controller.rule_base
        self.inputs: InputRatios | None = None
        self._state: tuple[float, ...] = ()
        self._estimate: float | None = None
        self.forget()

    def warm_up(self) -> None:
        """Compile what is computed for a row, so that no viewer waits for it."""
        self.add_sample(0.0, 0.0, held=False)
        self.add_sample(0.0, 0.0, held=False)
        self.rules()
        self.forget()

    def follow(self, columns: Sequence[str], rows: FloatArray) -> None:
        """Take rows of shape (n_rows, n_columns) in, those of a closed loop by this controller."""
        names = {name: place for place, name in enumerate(columns)}
        target = next((place for name, place in names.items() if name.startswith("target_")), None)
        estimate = next((p for n, p in names.items() if n.startswith("estimated_") and not n.endswith("_std")), None)
        if target is None or estimate is None or any(name not in names for name in GAIN_COLUMNS):
            self.forget()
            return
        gains = [names[name] for name in GAIN_COLUMNS]
        for row in rows:
            # Gains of zero: the controller held the drive, because there was no current to sense with.
            self.add_sample(float(row[target]), float(row[estimate]), held=not np.any(row[gains]))

    def add_sample(self, target: float, estimate: float, *, held: bool) -> None:
        """Take one row in: its target completes the inputs of the row before."""
        if self._estimate is not None and math.isfinite(target):
            self._step(target, QuantityEstimate(self._estimate, 0.0, True))
            self.inputs = InputRatios(*self._controller.rule_inputs(self._state))
        self._estimate = estimate if math.isfinite(estimate) and not held else None
        if self._estimate is None:
            self._step(0.0, QuantityEstimate(0.0, 0.0, False, Reason.NO_CURRENT))

    def _step(self, target: float, estimate: QuantityEstimate) -> None:
        self._state = self._controller.step(self._state, target, estimate, self._dt_s).state

    def forget(self) -> None:
        """Begin again: a loop has ended."""
        self._state = self._controller.start(ANY_LIMITS.sense_voltage_v)
        self._estimate = self.inputs = None

    def rules(self) -> list[FiredRule]:
        """Return the rules that fired last, the strongest first."""
        return [] if self.inputs is None else fired(self.rule_base, self.inputs)
