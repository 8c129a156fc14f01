"""Rows of a bench as a page is sent them: thinned, with what follows from the voltages, and the rules that fired."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.live._server.fired_rules import FiredRules, settings_of
from musclewire.extras.live._server.socket_messages import FiredRule

# Rows a second of the clock on the wall, at most; at the paper's 20 Hz every row is sent.
ROWS_PER_S = 100.0
COMPUTED = ("current_a", "power_w", "resistance_ohm")
# Below this current [A] a resistance is noise divided by noise.
MIN_CURRENT_A = 1e-4


class RowFrame(NamedTuple):
    """Rows of one layout with its columns, thinned and completed, and the rules that fired last."""

    layout: int
    columns: tuple[str, ...]
    rows: FloatArray
    rules: list[FiredRule] | None


class FrameMaker:
    """Makes frames of one bench's rows, in the order in which they come."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        self._last_time_s = -np.inf
        self._rules: FiredRules | None = None
        self._period_s = 0.0

    def frame(self, layout: int, columns: Sequence[str], rows: FloatArray, state: Mapping[str, Any]) -> RowFrame:
        """Return the frame of rows of one layout, (n_rows, n_columns); thinned it may have none."""
        spacing_s = float(state.get("clock_speed") or 1.0) / ROWS_PER_S
        rules = self._rules_after(columns, rows, state)
        time_s = rows[:, list(columns).index("time_s")]
        kept = rows[thinned(time_s, spacing_s, self._last_time_s)]
        if len(rows):
            self._last_time_s = float(time_s[-1])
        names, complete = with_computed(columns, kept, shunt_of(state))
        return RowFrame(layout, names, complete, rules)

    def _rules_after(
        self, columns: Sequence[str], rows: FloatArray, state: Mapping[str, Any]
    ) -> list[FiredRule] | None:
        settings, rig = settings_of(state.get("gains")), state.get("rig") or {}
        period_s = rig.get("sample_period_s")
        if settings is None or not period_s:
            self._rules = None
            return None
        if self._rules is None or self._rules.settings != settings or self._period_s != period_s:
            self._rules, self._period_s = FiredRules(settings, float(period_s)), float(period_s)
        self._rules.follow(columns, rows)
        return None if self._rules.inputs is None else self._rules.rules()


def shunt_of(state: Mapping[str, Any]) -> float:
    """Return the shunt resistance [ohm] of a bench; NaN if its state does not say it yet."""
    value = (state.get("rig") or {}).get("shunt_resistance_ohm")
    return float("nan") if value is None else float(value)


def thinned(time_s: FloatArray, spacing_s: float, last_time_s: float) -> FloatArray:
    """Return which rows are kept: the first in each interval of ``spacing_s``, as True, shape (n_rows,).

    The intervals are the clock's, so that portions of rows do not matter; ``last_time_s`` is that of the row before
    these. Half a microsecond is added against rounding, as of a period that divides the interval.
    """
    intervals = np.floor((np.concatenate(([last_time_s], time_s)) + 5e-7) / spacing_s)
    kept: FloatArray = intervals[1:] != intervals[:-1]
    return kept


def with_computed(
    columns: Sequence[str], rows: FloatArray, shunt_resistance_ohm: float
) -> tuple[tuple[str, ...], FloatArray]:
    """Return rows with current [A], power in the wire [W] and its resistance [ohm] (Eq. 1), computed from voltages."""
    names = list(columns)
    if "wire_voltage_v" not in names or "shunt_voltage_v" not in names:
        return tuple(columns), rows
    wire_v, shunt_v = rows[:, names.index("wire_voltage_v")], rows[:, names.index("shunt_voltage_v")]
    current_a = shunt_v / shunt_resistance_ohm
    flows = np.abs(current_a) >= MIN_CURRENT_A
    resistance_ohm = np.divide(wire_v, current_a, out=np.full_like(current_a, np.nan), where=flows)
    computed = np.column_stack((current_a, wire_v * current_a, resistance_ohm))
    return (*columns, *COMPUTED), np.hstack((rows, computed))
