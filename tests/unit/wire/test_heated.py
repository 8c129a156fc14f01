"""A wire heated by its measured power shows what the simulator's wire shows in its circuit."""

from __future__ import annotations

import numpy as np

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import RunningWire, advance_heated, constants_from, drive_path, resting_state

PERIOD_S = 0.05
WIRE = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))


def heated(power_w: np.ndarray) -> np.ndarray:
    """Resistance, contraction and force of the wire at mean powers, (3, n_samples)."""
    constants, cells, load = WIRE.step_arrays()
    state = resting_state(WIRE)
    wire = RunningWire(state.row[0], constants[0], cells[0], load[0])
    return np.array([advance_heated(wire, power, PERIOD_S) for power in power_w]).T


def test_the_measured_power_gives_the_resistance_and_the_contraction_of_the_circuit() -> None:
    time_s = PERIOD_S * np.arange(1, 601)
    drive_v = 1.8 + 1.3 * np.sin(2.0 * np.pi * time_s / 12.0)
    drive_v[300:340] = 3.2  # a step, as a controller makes one
    path, _ = drive_path(WIRE, drive_v, sample_s=PERIOD_S)
    resistance_ohm, contraction, force_n = heated(path.wire_voltage_v * path.shunt_voltage_v / 1.0)
    # Step control of the simulator keeps 0.5 mohm and 0.001 points of strain; one step a sample may be ten times worse.
    assert np.sqrt(np.mean((resistance_ohm - path.wire_voltage_v / path.shunt_voltage_v) ** 2)) < 5e-3
    assert np.abs(contraction - path.displacement_m / 0.07).max() < 3e-4
    assert np.abs(force_n - path.force_n).max() < 0.02


def test_a_long_sample_is_divided_into_steps_of_no_more_than_50_ms() -> None:
    constants, cells, load = WIRE.step_arrays()
    once, often = resting_state(WIRE), resting_state(WIRE)
    wire = RunningWire(once.row[0], constants[0], cells[0], load[0])
    advance_heated(wire, 0.2, 0.2)
    again = RunningWire(often.row[0], constants[0], cells[0], load[0])
    for _ in range(4):
        advance_heated(again, 0.2, 0.05)
    assert once.temperature_k == often.temperature_k
