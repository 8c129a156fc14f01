"""Readings that stand alone are found in any column and unit, by their rows alone; those of sound wires are not."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.random import Generator
from tests.labs.drawn_layouts import FACTORS, QUANTITIES, UNITS
from tests.labs.loops import DEFECTS, LOOPS, Array, loop

from musclewire.judge import judge_readings

# Marks of instruments and full scales of converters, as a file writes them, in any unit.
MARKS = (-9999.0, 1e9, 8388607.0, 8388.607, 65535.0, 32767.0, 4095.0, 8190.0, 999.999, -1.0)
SEEDS = st.integers(0, 2**32 - 1)
Recorded = dict[str, Array]


def drawn(random: Generator) -> tuple[Recorded, Mapping[str, float], float]:
    """Return a loop with some of its columns in five digits of a unit, the unit of each, and what rounding leaves."""
    found, units = loop(str(random.choice(LOOPS))), UNITS[str(random.choice(list(UNITS)))]
    names = QUANTITIES[str(random.choice(list(QUANTITIES)))]
    factors = {name: FACTORS[units[name]] for name in names}
    rounded = {name: np.array([float(f"{each:.5g}") for each in found[name] / factors[name]]) for name in names}
    return {"time_s": found["time_s"], **{name: rounded[name] * factors[name] for name in names}}, factors, 1e-4


def judged(columns: Recorded) -> np.ndarray:
    return ~judge_readings(columns, {"shunt_resistance_ohm": 0.47}).usable


@given(SEEDS)
def test_a_mark_in_six_rows_of_any_column_is_left_out_and_nothing_else(seed: int) -> None:
    random = np.random.default_rng(seed)
    columns, factors, part = drawn(random)
    name = str(random.choice(list(factors)))
    rows = np.sort(random.choice(np.arange(10, columns[name].size - 10), 6, replace=False))
    mark = float(random.choice(MARKS)) * factors[name]
    true, columns[name] = columns[name], columns[name].copy()
    columns[name][rows] = mark
    size = np.abs(true).max()
    # A mark within what the column does anyway, as 1 V, is one only where it leaves it, and then in all of its rows.
    far = np.abs(mark - true[rows]) > 0.25 * np.ptp(true) + part * size
    found = judged(columns)
    assert not np.delete(found, rows).any()
    if np.ptp(true) > part * size and far.sum() > 3:
        assert found[rows].all(), (name, mark)


@given(SEEDS)
def test_eighteen_spikes_are_left_out_and_nothing_else(seed: int) -> None:
    random = np.random.default_rng(seed)
    columns, factors, _ = drawn(random)
    name = str(random.choice(list(factors)))
    rows = np.sort(random.choice(np.arange(10, columns[name].size - 10), 18, replace=False))
    assume((rows[5:] - rows[:-5] > 20).all())
    size = columns[name].max() * random.uniform(2.0, 20.0, 18) * random.choice([-1, 1], 18)
    columns[name] = columns[name].copy()
    columns[name][rows] = size
    assert np.flatnonzero(judged(columns)).tolist() == rows.tolist()


@pytest.mark.parametrize("defect", [None, *DEFECTS], ids=lambda one: "sound" if one is None else one.__name__)
def test_no_reading_of_a_wire_stands_alone(defect: object) -> None:
    for seed in range(40):
        random = np.random.default_rng(seed)
        for name in LOOPS:
            found = dict(loop(name)) if defect is None else dict(defect(loop(name), random))  # type: ignore[operator]
            steps = {"wire_voltage_v": 0.01, "wire_current_a": 0.002, "displacement_m": 1e-5, "force_n": 0.01}
            if seed % 2:
                found |= {column: np.round(found[column] / step) * step for column, step in steps.items()}
            for names in QUANTITIES.values():
                columns = {column: found[column] for column in ("time_s", *names)}
                said = judge_readings(columns, {"shunt_resistance_ohm": 0.47}).findings
                assert not [text for text in said if "alone" in text or "sign" in text], (seed, name, said)


def pulses(every: int, on: int, noise: float = 1e-3) -> Recorded:
    """Return pulses of 3 V on a wire whose motion follows them within 0.3 s and decays within 1 s, at 10 Hz."""
    random = np.random.default_rng(every)
    is_on = np.arange(900) % every < on
    volts = np.where(is_on, 3.0, 0.0) + noise * random.standard_normal(900)
    amperes = np.where(is_on, 0.19, 0.0) + 0.1 * noise * random.standard_normal(900)
    moved = np.zeros(900)
    for row in range(1, 900):
        moved[row] = moved[row - 1] + (0.3 if is_on[row] else 0.1) * (0.0025 * is_on[row] - moved[row - 1])
    return {
        "time_s": 0.1 * np.arange(900), "wire_voltage_v": volts, "wire_current_a": amperes,
        "displacement_m": moved + 2e-6 * random.standard_normal(900),
    }  # fmt: skip


@pytest.mark.parametrize(("every", "on"), [(100, 1), (100, 3), (60, 6), (40, 12), (10, 1), (10, 8), (7, 3), (2, 1)])
def test_pulses_and_what_follows_them_stand_not_alone(every: int, on: int) -> None:
    columns = pulses(every, on)
    found = judge_readings(columns, {}).found
    assert not [item.why for item in found if not item.is_real]
    held = columns | {
        "wire_voltage_v": columns["wire_voltage_v"] + 0.3,
        "wire_current_a": columns["wire_current_a"] + 0.02,
    }
    assert judge_readings(held, {}).usable.all()


@pytest.mark.parametrize("columns", [("displacement_m",), ("wire_voltage_v", "wire_current_a", "displacement_m")])
@pytest.mark.parametrize("rows", [slice(300, 312), slice(5, 700, 53)], ids=["in a row", "here and there"])
def test_a_mark_in_several_columns_at_once_is_no_pulse_of_the_wire(columns: tuple[str, ...], rows: slice) -> None:
    found = loop("grains")
    marked = {name: found[name].copy() for name in ("time_s", "wire_voltage_v", "wire_current_a", "displacement_m")}
    for name in columns:
        marked[name][rows.start // 3 : rows.stop // 3 : rows.step] = -9999.0
    expected = np.isin(np.arange(301), np.arange(301)[rows.start // 3 : rows.stop // 3 : rows.step])
    judgement = judge_readings(marked, {})
    assert (judgement.usable == ~expected).all()
    assert len(judgement.found) == len(columns)
    assert all("stands alone there at -9999" in item.why for item in judgement.found)


@given(st.floats(0.55, 0.95), SEEDS)
def test_a_current_that_wraps_its_sign_is_left_out_where_it_wrapped(part: float, seed: int) -> None:
    found = loop(LOOPS[seed % 3])
    end_a = part * found["wire_current_a"].max()
    beyond = found["wire_current_a"] > end_a
    wrapped = np.where(beyond, found["wire_current_a"] - 2.0 * end_a, found["wire_current_a"])
    columns = {name: found[name] for name in ("time_s", "wire_voltage_v", "displacement_m")} | {
        "wire_current_a": wrapped
    }
    if 2 * beyond.sum() < beyond.size:
        judgement = judge_readings(columns, {})
        assert (judgement.usable == ~beyond).all()
        assert "wire_current_a has the other sign there" in judgement.findings[0]


def test_no_row_is_judged_by_the_largest_reading() -> None:
    columns = pulses(10, 3)
    columns["wire_voltage_v"][55], columns["wire_current_a"][77] = 8388.607, -9999.0
    judgement = judge_readings(columns, {})
    off = np.arange(900) % 10 >= 3
    assert (judgement.usable == ~(off | np.isin(np.arange(900), [55, 77]))).all()


def test_more_than_a_tenth_of_a_column_alone_is_refused_with_column_and_values() -> None:
    found = loop("grains")
    columns = {name: found[name] for name in ("time_s", "wire_voltage_v", "wire_current_a", "force_n")}
    columns["force_n"] = columns["force_n"].copy()
    columns["force_n"][4::8] = 8388.607
    said = judge_readings(columns, {}).contradiction
    assert said.startswith("38 of 301 rows, too many to leave them out: force_n stands alone there at 8389 N")


def driven(name: str, late_rows: float, random: Generator) -> Recorded:
    """Return a loop with the drive before leads of 0.1 to 1 ohm and the shunt, recorded later by some rows."""
    found = loop(name)
    drive_v = found["wire_voltage_v"] + (random.uniform(0.1, 1.0) + 0.47) * found["wire_current_a"]
    noise = {key: 1e-3 * found[key].max() * random.standard_normal(301) for key in ("wire_voltage_v", "wire_current_a")}
    late_v = np.interp(found["time_s"] - 0.2 * late_rows, found["time_s"], drive_v)
    return {"time_s": found["time_s"], "drive_voltage_v": late_v, **{key: found[key] + noise[key] for key in noise}}


@pytest.mark.parametrize("late_rows", [-30, -8, -1, 1, 3, 8, 40])
def test_a_drive_that_is_recorded_late_or_early_is_named_with_its_delay(late_rows: int) -> None:
    by = f"{abs(late_rows)} samples ({0.2 * abs(late_rows):.3g} s) {'later' if late_rows > 0 else 'earlier'} than the"
    for seed in range(12):
        columns = driven(LOOPS[seed % 3], late_rows, np.random.default_rng(seed))
        judgement = judge_readings(columns, {})
        assert judgement.usable.all()
        assert any(f"drive_voltage_v is recorded {by}" in said for said in judgement.notes), seed


@pytest.mark.parametrize("late_rows", [-0.5, 0.0, 0.5])
def test_half_a_sample_is_no_delay(late_rows: float) -> None:
    for seed in range(12):
        assert not judge_readings(driven(LOOPS[seed % 3], late_rows, np.random.default_rng(seed)), {}).notes
