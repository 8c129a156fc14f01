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
    ConstantRules,
    FuzzyPidSettings,
    RuleBase,
    ZhaoRules,
    infer_ratios,
    input_grades,
    load_rule_base,
)
from musclewire.errors import MusclewireError
from musclewire.extras.live._server.socket_messages import FiredRule


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
    rules = rule_base.rules
    if isinstance(rules, ConstantRules):
        return []
    error, change = as_read(rule_base, inputs)
    rows, columns = input_grades(rule_base, error), input_grades(rule_base, change)
    product = isinstance(rules, ZhaoRules)
    found = []
    for row, (row_name, row_grade) in enumerate(rows.items()):
        for column, (column_name, column_grade) in enumerate(columns.items()):
            weight = row_grade * column_grade if product else min(row_grade, column_grade)
            if weight > 0.0:
                cells = cells_of(rules, row, column)
                found.append(FiredRule(error=row_name, change=column_name, weight=weight, **cells))
    return sorted(found, key=lambda rule: -rule.weight)


def as_read(rule_base: RuleBase, inputs: InputRatios) -> InputRatios:
    """Return the inputs at which the tables are read: of a mirrored rule base, those of one half."""
    half = {"no": 0.0, "positive-error": 1.0, "negative-error": -1.0}[rule_base.mirrored]
    if half == 0.0:
        return inputs
    sign = 0.0 if inputs.error == 0.0 else half * math.copysign(1.0, inputs.error)
    return InputRatios(sign * inputs.error, sign * inputs.change)


def cells_of(rules: Any, row: int, column: int) -> dict[str, str]:
    """Return what a cell of the tables says of K_p, K_I and K_D; Zhao's alpha as a number."""
    ki = f"{rules.alpha[row][column]:g}" if isinstance(rules, ZhaoRules) else rules.ki[row][column]
    return {"kp": str(rules.kp[row][column]), "ki": str(ki), "kd": str(rules.kd[row][column])}


class FiredRules:
    """Follows the rows of a fuzzy PID and knows the inputs of its rules.

    Parameters
    ----------
    settings
        Settings of the controller.
    sample_period_s
        Time [s] between two samples.
    """

    def __init__(self, settings: FuzzyPidSettings, sample_period_s: float) -> None:
        """Load the rule base; nothing is known before the first row."""
        self.settings, self.rule_base = settings, load_rule_base(settings.rule_base)
        self.inputs: InputRatios | None = None
        weight = sample_period_s / (settings.derivative_filter_s + sample_period_s)
        self._dt_s, self._weight = sample_period_s, weight
        self._estimate: float | None = None
        self._error: float | None = None
        self._error_rate = 0.0

    def warm_up(self) -> None:
        """Compile what is computed for a row, so that no viewer waits for it."""
        infer_ratios(self.rule_base, 0.0, 0.0)
        fired(self.rule_base, InputRatios(0.0, 0.0))

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
            self._complete(target - self._estimate)
        if held or not math.isfinite(estimate):
            self._estimate = None
            self._error_rate, self._error = 0.0, None
            return
        self._estimate = estimate

    def _complete(self, error: float) -> None:
        if self._error is None:
            self._error_rate = 0.0
        else:
            rate = (error - self._error) / self._dt_s
            self._error_rate += self._weight * (rate - self._error_rate)
        self._error = error
        unit = self.settings.error_unit
        self.inputs = InputRatios(
            error / unit / self.settings.error_range, self._error_rate / unit / self.settings.change_range
        )

    def forget(self) -> None:
        """Begin again: a loop has ended."""
        self._estimate, self._error, self._error_rate, self.inputs = None, None, 0.0, None

    def rules(self) -> list[FiredRule]:
        """Return the rules that fired last, the strongest first."""
        return [] if self.inputs is None else fired(self.rule_base, self.inputs)
