"""The row of a wire: one list of fields from which all else follows, and states that stay what they were."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys

import pytest
from wire_makers import constants, stepped

from musclewire.errors import CallerError
from musclewire.wire import WireState, resting_state

WIRE = constants()


def test_a_state_handed_out_cannot_be_written() -> None:
    state = resting_state(WIRE)
    with pytest.raises(AttributeError, match=r"use replace\(temperature_k="):
        state.temperature_k = 400.0
    with pytest.raises(ValueError, match="read-only"):
        state.front_martensite[0] = 0.0
    other = state.replace(temperature_k=400.0)
    assert (state.temperature_k, other.temperature_k) == (WIRE.ambient_temperature_k, 400.0)


def test_fields_are_floats_and_a_missing_or_unknown_one_is_named() -> None:
    state = resting_state(WIRE)
    assert type(state.temperature_k) is float
    with pytest.raises(CallerError, match="no field 'temperatur_k'"):
        state.replace(temperatur_k=1.0)
    values = state.values()
    del values["stress_pa"], values["cycles"]
    with pytest.raises(CallerError, match="needs stress_pa, cycles"):
        WireState.from_values(state.classes, **values)


def test_a_pickled_row_is_the_same_wire() -> None:
    state, wire = pickle.loads(pickle.dumps((resting_state(WIRE), WIRE)))
    after, means = stepped(state, wire, 2.0, 1e-3, 500)
    wanted, same = stepped(resting_state(WIRE), WIRE, 2.0, 1e-3, 500)
    assert means == same
    assert after.row.tobytes() == wanted.row.tobytes()


RUN_UNDER_SIGNALS = """
import signal
import time

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire._wires import advance
from musclewire.wire._building import constants_from, resting_state
from musclewire.wire._stepping import fixed_steps

wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
state, stepping = resting_state(wire), fixed_steps(1e-3)
before, wanted = state.row.tobytes(), advance(state, wire, 2.0, 0.02, stepping)
caught = 0
signal.signal(signal.SIGALRM, signal.default_int_handler)
for turn in range(3000):
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-6 * (1 + turn % 37))
        for _ in range(50):
            after, means = advance(state, wire, 2.0, 0.02, stepping)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        time.sleep(0.0)  # one that is still on its way arrives here
    except KeyboardInterrupt:
        caught += 1
after, means = advance(state, wire, 2.0, 0.02, stepping)
assert caught > 1000, caught
assert state.row.tobytes() == before
assert after.row.tobytes() == wanted[0].row.tobytes() and means == wanted[1]
from musclewire.wire._wires import advance_rows
print(sum(advance_rows.stats.cache_misses.values()))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no interval timers on Windows")
def test_signals_during_a_call_harm_neither_process_nor_state_and_another_process_starts_warm() -> None:
    stepped(resting_state(WIRE), WIRE, 0.0, 1e-3, 1)  # compiled or read from disk by now
    ran = subprocess.run([sys.executable, "-c", RUN_UNDER_SIGNALS], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == "0", "the other process compiled again"


WITHOUT_COMPILATION = """
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire._wires import advance
from musclewire.wire._building import constants_from, resting_state
from musclewire.wire._stepping import fixed_steps

wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
state, means = advance(resting_state(wire), wire, 3.0, 1.5, fixed_steps(0.05))
print(state.temperature_k, state.martensite_fraction, means.displacement_m)
"""


@pytest.mark.slow
def test_the_same_functions_step_a_row_without_compilation() -> None:
    """A debugger sees them as they are written; records must then have their fields as attributes, too."""
    shown = [
        subprocess.run(
            [sys.executable, "-c", WITHOUT_COMPILATION],
            env={**os.environ, "NUMBA_DISABLE_JIT": off},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for off in ("1", "0")
    ]
    plain, compiled = ([float(item) for item in line] for line in shown)
    assert compiled[1] < 0.9, "the wire must have moved to say anything"
    assert plain == pytest.approx(compiled, rel=1e-9)
