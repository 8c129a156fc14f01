"""Golden vectors: inputs of a library and Python's outcomes, as a table that a C program reads."""

from __future__ import annotations

from itertools import chain

from musclewire.extras.board._c.exercise import ExerciseRow, exercise
from musclewire.extras.board._c.reference import ReferenceTick, TickOutcome

SEED = 2010
# Ticks without faults first, then faults at the control rate, then a converter that is faster than the controller.
CALM, FAULTY, FAST = 150, 250, 300
COLUMNS = ("start", "wire_voltage_v", "shunt_voltage_v", "target", "tick_s", "control_s", *TickOutcome._fields)


def golden_ticks(reference: ReferenceTick) -> list[ExerciseRow]:
    """Return the ticks of the golden vectors, the same each time."""
    return list(
        chain(
            exercise(reference, SEED, CALM, fault_probability=0.0),
            exercise(reference, SEED + 1, FAULTY, fault_probability=0.05),
            exercise(reference, SEED + 2, FAST, tick_s=0.002, ticks_a_control=10, fault_probability=0.01),
        )
    )


def golden_vectors(reference: ReferenceTick) -> str:
    """Return the golden vectors as comma-separated values; every number reads back as the same double."""
    lines = [",".join(COLUMNS)]
    for tick in golden_ticks(reference):
        values = (*tick[:-1], *tick.outcome)
        lines.append(",".join(_text(value) for value in values))
    return "\n".join(lines) + "\n"


def _text(value: float) -> str:
    return str(int(value)) if isinstance(value, (bool, int)) else repr(float(value))
