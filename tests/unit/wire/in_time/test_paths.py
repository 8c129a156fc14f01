"""A whole history in one call is the same wire as sample by sample."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire._building import constants_from, resting_state
from musclewire.wire._paths import drive_path, isobaric_path
from musclewire.wire._stepping import StepControl, fixed_steps
from musclewire.wire._wires import advance

CONSTANTS = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
FIVE_MS = fixed_steps(5e-3)
DRIVE_V = np.concatenate([np.linspace(0.3, 3.2, 60), np.linspace(3.2, 0.3, 60)])


def test_a_driven_path_is_the_wire_sample_by_sample_to_the_bit() -> None:
    path, end = drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)
    state = resting_state(CONSTANTS)
    for sample, drive in enumerate(DRIVE_V):
        state, means = advance(state, CONSTANTS, float(drive), 0.1, FIVE_MS)
        assert path.displacement_m[sample] == means.displacement_m
        assert path.wire_voltage_v[sample] == means.wire_voltage_v
        assert path.temperature_k[sample] == state.temperature_k
        assert path.resistance_ohm[sample] == state.resistance_ohm
    assert end.row.tobytes() == state.row.tobytes()


def test_a_path_cut_in_two_is_the_path_in_one() -> None:
    whole, _ = drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)
    first, between = drive_path(CONSTANTS, DRIVE_V[:50], sample_s=0.1, stepping=FIVE_MS)
    rest, _ = drive_path(CONSTANTS, DRIVE_V[50:], sample_s=0.1, stepping=FIVE_MS, state=between)
    assert np.array_equal(np.concatenate([first.resistance_ohm, rest.resistance_ohm]), whole.resistance_ohm)


def test_wires_on_threads_do_not_disturb_each_other() -> None:
    alone, _ = drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)
    with ThreadPoolExecutor(4) as threads:
        paths = list(threads.map(lambda _: drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)[0], range(8)))
    assert all(np.array_equal(path.displacement_m, alone.displacement_m) for path in paths)


def test_a_regulated_current_is_the_current_asked_for() -> None:
    path, _ = drive_path(CONSTANTS, np.full(200, 0.18), sample_s=0.001, regulated_current=True)
    assert path.shunt_voltage_v / CONSTANTS.shunt_resistance_ohm == pytest.approx(0.18, rel=1e-12)


def test_an_isobaric_loop_closes_and_is_longer_when_cold() -> None:
    kelvin = np.concatenate([np.linspace(300.0, 420.0, 200), np.linspace(420.0, 300.0, 200)])
    path = isobaric_path(CONSTANTS, 100e6, kelvin)
    assert path.strain[0] == pytest.approx(path.strain[-1], abs=1e-4)
    assert path.strain[0] - path.strain[199] > 0.03
    # At one temperature amid the transformation the cooling wire is still short.
    assert path.strain[250] < path.strain[149]


@pytest.mark.parametrize("step_s", [0.0, -0.1, float("nan"), float("inf")])
def test_a_step_that_leads_nowhere_is_refused(step_s: float) -> None:
    with pytest.raises(CallerError, match="give a positive number of seconds"):
        fixed_steps(step_s)
    with pytest.raises(CallerError, match="give a positive number of seconds"):
        drive_path(CONSTANTS, DRIVE_V, sample_s=step_s)


@pytest.mark.parametrize(("sample_s", "step_s"), [(0.05, 0.03), (0.05, 0.1), (0.01, 3e-3)])
def test_a_fixed_step_divides_its_sample(sample_s: float, step_s: float) -> None:
    with pytest.raises(CallerError, match="must divide a sample"):
        drive_path(CONSTANTS, DRIVE_V, sample_s=sample_s, stepping=fixed_steps(step_s))


@pytest.mark.parametrize("name", ["temperature_k", "resistance", "strain"])
def test_a_tolerance_of_nothing_is_refused(name: str) -> None:
    with pytest.raises(CallerError, match="tolerances must be above 0"):
        drive_path(CONSTANTS, DRIVE_V, sample_s=0.05, stepping=StepControl()._replace(**{name: 0.0}))


def test_a_wire_cannot_be_pushed() -> None:
    with pytest.raises(CallerError, match="cannot be pushed"):
        isobaric_path(CONSTANTS, -1.0, np.array([300.0, 310.0]))
