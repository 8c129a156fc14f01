"""A whole history in one call is the same wire as sample by sample."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import StepControl, advance, constants_from, drive_path, fixed_steps, isobaric_path, resting_state

CONSTANTS = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
FIVE_MS = fixed_steps(5e-3)
DRIVE_V = np.concatenate([np.linspace(0.3, 3.2, 60), np.linspace(3.2, 0.3, 60)])


@pytest.mark.parametrize("stepping", [FIVE_MS, StepControl()], ids=["5 ms", "chosen"])
def test_a_driven_path_is_the_wire_sample_by_sample_to_the_bit(stepping: StepControl) -> None:
    path, end = drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=stepping)
    state = resting_state(CONSTANTS)
    for sample, drive in enumerate(DRIVE_V):
        state, means = advance(state, CONSTANTS, float(drive), 0.1, stepping)
        assert path.displacement_m[sample] == means.displacement_m
        assert path.wire_voltage_v[sample] == means.wire_voltage_v
        assert path.temperature_k[sample] == state.temperature_k
        assert path.resistance_ohm[sample] == state.resistance_ohm
    assert end.row.tobytes() == state.row.tobytes()


def test_wires_on_threads_do_not_disturb_each_other() -> None:
    alone, _ = drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)
    with ThreadPoolExecutor(4) as threads:
        paths = list(threads.map(lambda _: drive_path(CONSTANTS, DRIVE_V, sample_s=0.1, stepping=FIVE_MS)[0], range(8)))
    assert all(np.array_equal(path.displacement_m, alone.displacement_m) for path in paths)


@pytest.mark.parametrize(
    ("sample_s", "stepping", "says"),
    [
        (0.0, FIVE_MS, "give a positive number of seconds"),
        (float("nan"), FIVE_MS, "give a positive number of seconds"),
        (0.05, fixed_steps(0.03), "must divide a sample"),
        (0.05, fixed_steps(0.1), "must divide a sample"),
        (0.05, StepControl(temperature_k=0.0), "tolerances must be above 0"),
    ],
)
def test_steps_that_lead_nowhere_are_refused(sample_s: float, stepping: StepControl, says: str) -> None:
    with pytest.raises(CallerError, match=says):
        drive_path(CONSTANTS, DRIVE_V, sample_s=sample_s, stepping=stepping)


def test_a_fixed_step_is_a_positive_number_and_a_wire_cannot_be_pushed() -> None:
    with pytest.raises(CallerError, match="give a positive number of seconds"):
        fixed_steps(0.0)
    with pytest.raises(CallerError, match="cannot be pushed"):
        isobaric_path(CONSTANTS, -1.0, np.array([300.0, 310.0]))
