"""Rows that somebody put between the measured ones: found, said, and the same answers as without them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.identify import estimate, fit
from musclewire.judge import measured_rows
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

POINTS = 142
SAID = "lie on straight lines between the"


@pytest.fixture(scope="module")
def model(loop: Recording) -> SensingModel:
    return fit(loop)


def seldom(recording: Recording) -> Recording:
    """Return so many rows of a recording."""
    rows = np.unique(np.linspace(0, len(recording) - 1, POINTS).round().astype(int))
    return Recording({name: values[rows] for name, values in recording.columns.items()}, recording.metadata)


def drawn_out(recording: Recording, rows: int) -> Recording:
    """Return a recording with so many rows at even times, on straight lines between its own."""
    time_s = np.linspace(recording["time_s"][0], recording["time_s"][-1], rows)
    columns = {name: np.interp(time_s, recording["time_s"], values) for name, values in recording.columns.items()}
    return Recording(columns, recording.metadata)


@pytest.mark.parametrize("rows", [20 * (POINTS - 1) + 1, 20 * POINTS - 7, 8 * POINTS + 3])
@pytest.mark.parametrize("estimator", ["filter", "polynomial"])
def test_a_loop_that_was_drawn_out_is_estimated_like_its_measured_rows(
    loop: Recording, model: SensingModel, rows: int, estimator: str
) -> None:
    few = seldom(loop)
    many = drawn_out(few, rows)
    as_measured, drawn = (estimate(model, one, estimator=estimator) for one in (few, many))
    assert not any(SAID in text for text in as_measured.warnings)
    assert [text for text in drawn.warnings if SAID in text]
    assert drawn.rms_pct == pytest.approx(as_measured.rms_pct, abs=0.15)
    assert len(drawn.recording) == rows
    assert drawn.recording["valid"].mean() == pytest.approx(as_measured.recording["valid"].mean(), abs=0.03)
    std = [
        np.interp(few["time_s"], one.recording["time_s"], one.recording["estimate_std"]) for one in (as_measured, drawn)
    ]
    valid = as_measured.recording["valid"] > 0.0
    assert np.median(np.abs(std[1] / std[0] - 1.0)[valid]) < 0.05


def test_a_fit_takes_the_measured_rows_and_says_so(loop: Recording) -> None:
    few = seldom(loop)
    many = fit(drawn_out(few, 20 * (POINTS - 1) + 1))
    assert [text for text in many.warnings if SAID in text]
    assert many.strain(15.5) == pytest.approx(fit(few).strain(15.5), abs=2e-4)


def test_a_product_of_two_drawn_columns_is_found_by_the_other_two(loop: Recording) -> None:
    few = seldom(loop)
    current_a = few["shunt_voltage_v"] / few.facts.shunt_resistance_ohm
    columns = {"time_s": few["time_s"], "wire_resistance_ohm": few["wire_voltage_v"] / current_a}
    drawn = drawn_out(Recording(columns | {"wire_current_a": current_a}, {}), 20 * (POINTS - 1) + 1)
    given = Recording(
        {
            "time_s": drawn["time_s"],
            "wire_current_a": drawn["wire_current_a"],
            "wire_voltage_v": drawn["wire_current_a"] * drawn["wire_resistance_ohm"],
        },
        {},
    )
    rows = measured_rows(given).rows
    assert rows is not None
    assert rows.size == pytest.approx(POINTS, abs=2)


def test_what_was_measured_row_by_row_is_left_alone(loop: Recording) -> None:
    assert measured_rows(loop).rows is None
    assert measured_rows(seldom(loop)).rows is None


@pytest.mark.parametrize(
    ("measured", "where"),
    [(400, "after"), (1_800, "after"), (3_600, "after"), (400, "between"), (1_800, "between")],
)
def test_a_recording_of_which_a_part_was_measured_row_by_row_is_left_as_it_is(
    loop: Recording, measured: int, where: str
) -> None:
    drawn = drawn_out(seldom(loop), len(loop))
    columns = {name: np.array(values) for name, values in drawn.columns.items()}
    if where == "after":
        later_s = drawn["time_s"][-1] + 0.05 * np.arange(1, measured + 1)
        columns = {name: np.append(values, loop[name][:measured]) for name, values in columns.items()}
        columns["time_s"][-measured:] = later_s
    else:
        for name in columns:
            columns[name][-measured:] = loop[name][-measured:]
    assert measured_rows(Recording(columns, loop.metadata)).rows is None


def test_times_that_stand_still_and_readings_that_are_missing_end_in_no_warning_of_numpy(loop: Recording) -> None:
    columns = {name: np.array(values) for name, values in seldom(loop).columns.items()}
    columns["time_s"][5:8] = columns["time_s"][5]
    columns["wire_voltage_v"][20:30] = np.nan
    with np.errstate(all="raise"):
        assert measured_rows(Recording(columns, loop.metadata)).rows is None


def ramps(noise_v: float, step_v: float, slope_v_per_s: float, seed: int) -> Recording:
    """Return two slow ramps as a converter with some step [V] reads them, with some noise [V]."""
    random = np.random.default_rng(seed)
    time_s = 0.05 * np.arange(1_800)
    drive = 0.3 + 2.7 * np.abs((slope_v_per_s / 2.7 * time_s) % 2.0 - 1.0)
    current = drive / (17.0 - 1.2 * drive)
    read = [noise_v * random.standard_normal(time_s.size) + values for values in (drive, current)]
    wire_v, shunt_v = (step_v * np.round(values / step_v) if step_v else values for values in read)
    return Recording(
        {"time_s": time_s, "wire_voltage_v": wire_v, "shunt_voltage_v": shunt_v}, {"shunt_resistance_ohm": 1.0}
    )


@given(
    st.one_of(st.just(0.0), st.floats(1e-6, 0.01)),
    st.sampled_from([0.0, 1e-4, 5e-4, 1e-3, 2e-3, 5e-3]),
    st.one_of(st.sampled_from([0.01, 0.02, 0.04, 0.06, 0.1, 0.2]), st.floats(0.01, 0.2)),
    st.integers(0, 1_000),
)
def test_no_converter_and_no_noise_looks_like_drawn_lines(
    noise_v: float, step_v: float, slope_v_per_s: float, seed: int
) -> None:
    assert measured_rows(ramps(noise_v, step_v, slope_v_per_s, seed)).rows is None
