"""A tick of an estimator or a controller as a compiled function: numbers in arrays, for loops that run as a batch.

An implementation that can be compiled declares its tick by a method ``compiled_tick``; it is what ``step`` runs, or
gives the same numbers. ``tests/contract`` compares both for every implementation that has one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.signals._exchange import WireEstimate

# What the arrays `given` and `answer` of a tick hold, in this order; the numbers to record follow the answer.
ESTIMATOR_INPUTS = ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")
ESTIMATOR_ANSWERS = ("value", "std", "valid", "reason", "failed")
# What an estimator does not record of ``WireEstimate`` is NaN.
CONTROLLER_INPUTS = ("target", "value", "std", "valid", "reason", "dt_s", *WireEstimate._fields)
CONTROLLER_ANSWERS = ("drive_voltage_v", "failed")


class CompiledTick(NamedTuple):
    """A compiled tick with the numbers that it reads and the state from which it starts.

    Parameters
    ----------
    function
        ``function(constants, state, given, answer)``, compiled by ``musclewire.compiled.compiled``: four
        one-dimensional arrays of floats. It changes ``state``, writes ``answer`` and returns nothing. An estimator is
        given ``ESTIMATOR_INPUTS`` and answers ``ESTIMATOR_ANSWERS``, a controller ``CONTROLLER_INPUTS`` and
        ``CONTROLLER_ANSWERS``; the numbers of the implementation's ``columns`` follow. ``reason`` is that of
        ``signals.Reason``, ``valid`` and ``failed`` are 0 or 1. Where ``step`` ends a run, by a failure or an
        error, the tick answers ``failed`` and need not say why: the run is then repeated by ``step``.
    constants
        What does not change; of any length. It may be shared by many loops.
    state
        The state of ``start``; of any length. Each loop has a copy.
    """

    function: Callable[[FloatArray, FloatArray, FloatArray, FloatArray], None]
    constants: FloatArray
    state: FloatArray


def declared_tick(implementation: Any, *arguments: Any) -> CompiledTick | None:
    """Return the compiled tick that an estimator or a controller declares in its own class; None without one."""
    # Not an inherited one: a class that changes the step of another would run by the other's tick.
    if "compiled_tick" not in vars(type(implementation)):
        return None
    tick: CompiledTick | None = implementation.compiled_tick(*arguments)
    if tick is None:
        return None
    constants, state = (np.ascontiguousarray(array, dtype=np.float64).reshape(-1) for array in tick[1:])
    return CompiledTick(tick.function, constants, state)
