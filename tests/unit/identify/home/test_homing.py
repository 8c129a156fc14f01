"""A home sweep of a wire whose resistance is changed by a known amount gives that amount back, or says why not."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError, FitRejectedError, RecordingError
from musclewire.experiment import HomeSweep, characterize, plan_for, run_on_rig
from musclewire.identify import fit, has_levelled, homed_model
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

AIR_K = 295.15


class Swept(NamedTuple):
    """A fitted model and a home sweep of the same wire."""

    model: SensingModel
    sweep: Recording


@pytest.fixture(scope="module")
def swept() -> Swept:
    with open_rig("simulated") as rig:
        model = fit(characterize(rig))
        plan = plan_for(rig, model)
        return Swept(model, run_on_rig(rig, HomeSweep(rig, plan), plan.duration_s))


def aged(sweep: Recording, scale: float = 1.0, lead_ohm: float = 0.0) -> Recording:
    """Return the sweep of the same wire at the same powers, with another resistance: Ohm's law, sample by sample."""
    shunt_ohm = float(sweep.facts.shunt_resistance_ohm)
    current = sweep["shunt_voltage_v"] / shunt_ohm
    power = sweep["wire_voltage_v"] * current
    resistance = scale * sweep["wire_voltage_v"] / current + lead_ohm
    columns = dict(sweep.columns)
    columns["wire_voltage_v"] = np.sqrt(power * resistance)
    columns["shunt_voltage_v"] = shunt_ohm * np.sqrt(power / resistance)
    return Recording(columns, sweep.metadata)


def in_warmer_air(sweep: Recording, change_k: float) -> Recording:
    """Return the sweep in air that is warmer: at each temperature the power is less by loss times the change."""
    loss = float(sweep.facts.number("limit_heat_loss_w_per_k", "loss"))
    current = sweep["shunt_voltage_v"] / sweep.facts.shunt_resistance_ohm
    resistance = sweep["wire_voltage_v"] / current
    power = np.maximum(sweep["wire_voltage_v"] * current - loss * change_k, 1e-4)
    columns = dict(sweep.columns)
    columns["wire_voltage_v"] = np.sqrt(power * resistance)
    columns["shunt_voltage_v"] = sweep.facts.shunt_resistance_ohm * np.sqrt(power / resistance)
    return Recording(columns, sweep.metadata)


def test_an_unchanged_wire_keeps_its_curve_and_the_file_says_when_it_was_checked(swept: Swept) -> None:
    found = homed_model(swept.model, swept.sweep, ambient_k=AIR_K)
    assert not found.home.corrected
    assert replace(found.model, home=None) == swept.model
    assert abs(found.resistance_max_moved_ohm) < 2.0 * found.resistance_max_moved_std_ohm
    assert found.home.time == swept.sweep.facts.text_or_none("start_time")
    assert "stays as it was" in found.notes[-1]


@pytest.mark.parametrize("ambient_k", [None, AIR_K])
@pytest.mark.parametrize(("scale", "lead_ohm"), [(1.01, 0.0), (0.99, 0.0), (1.0, 0.5), (1.02, -0.1)])
def test_scale_and_offset_come_back(swept: Swept, scale: float, lead_ohm: float, ambient_k: float | None) -> None:
    found = homed_model(swept.model, aged(swept.sweep, scale, lead_ohm), ambient_k=ambient_k)
    b_ohm, c_ohm = swept.model.resistance_max_ohm, swept.model.resistance_min_ohm
    assert found.home.corrected
    assert found.model.resistance_max_ohm == pytest.approx(scale * b_ohm + lead_ohm, abs=6e-4 * b_ohm)
    assert found.model.resistance_min_ohm == pytest.approx(scale * c_ohm + lead_ohm, abs=0.01 * (b_ohm - c_ohm))
    assert found.home.resistance_scale * b_ohm + found.home.resistance_offset_ohm == pytest.approx(
        found.model.resistance_max_ohm
    )


@settings(max_examples=12, deadline=None)
@given(st.floats(-0.02, 0.02))
def test_the_corrected_model_is_nearer_to_the_aged_wire_than_the_old_one(swept: Swept, drift: float) -> None:
    model = swept.model
    found = homed_model(model, aged(swept.sweep, 1.0 + drift), ambient_k=AIR_K)
    middle_ohm = 0.5 * (model.resistance_min_ohm + model.resistance_max_ohm)
    true, today = model.strain(middle_ohm), (1.0 + drift) * middle_ohm
    before, after = abs(model.strain(today) - true), abs(found.model.strain(today) - true)
    assert after <= before + 1e-12
    assert after < 0.02 * model.quantity_max


def test_a_second_home_move_counts_from_the_characterization(swept: Swept) -> None:
    first = homed_model(swept.model, aged(swept.sweep, 1.01), ambient_k=AIR_K)
    second = homed_model(first.model, aged(swept.sweep, 1.02), ambient_k=AIR_K, cycles=500.0)
    at_b = second.home.resistance_scale * swept.model.resistance_max_ohm + second.home.resistance_offset_ohm
    assert at_b == pytest.approx(1.02 * swept.model.resistance_max_ohm, rel=1e-3)
    assert (second.home.moves, second.home.cycles) == (2, 500.0)


@pytest.mark.parametrize("change_k", [10.0, -10.0])
def test_warmer_air_moves_the_power_and_not_the_curve(swept: Swept, change_k: float) -> None:
    sweep = in_warmer_air(swept.sweep, change_k)
    unknown = homed_model(swept.model, sweep)
    assert not unknown.home.corrected
    assert unknown.warming_moved_k == pytest.approx(-change_k, abs=2.0)
    known = homed_model(swept.model, sweep, ambient_k=AIR_K + change_k)
    assert not known.home.corrected
    assert known.warming_moved_k == pytest.approx(0.0, abs=2.0)
    assert known.home.transformation_shift_std_k < unknown.home.transformation_shift_std_k


def under_another_load(swept: Swept) -> Recording:
    """Half a load more makes a wire transform 9 K warmer; B moves by 5 % of the fall, and C by a fifth of that."""
    model = swept.model
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    stretched = 1.04
    at_b_ohm = model.resistance_max_ohm + 0.05 * span_ohm
    return in_warmer_air(aged(swept.sweep, stretched, at_b_ohm - stretched * model.resistance_max_ohm), -9.0)


def test_another_load_is_refused_whoever_says_what(swept: Swept) -> None:
    loaded = under_another_load(swept)
    with pytest.raises(FitRejectedError, match=r"at B and by \+0\.0.* at C; .*another load.*say so \(load_n\)"):
        homed_model(swept.model, loaded, ambient_k=AIR_K)
    with pytest.raises(FitRejectedError, match=r"which is not what age, leads or a shift of the transformation do"):
        homed_model(swept.model, in_warmer_air(loaded, 9.0), load_n=1.9, ambient_k=AIR_K)


def shifted_by_five_kelvin(swept: Swept) -> Recording:
    """Martensite that is 5 K warmer before it transforms reads 0.25 % more at B, and at C there is none of it."""
    model = swept.model
    more_ohm = 0.0025 * model.resistance_max_ohm
    scale = 1.0 + more_ohm / (model.resistance_max_ohm - model.resistance_min_ohm)
    return in_warmer_air(aged(swept.sweep, scale, -(scale - 1.0) * model.resistance_min_ohm), -5.0)


def test_the_users_word_tells_a_shifted_transformation_from_a_load(swept: Swept) -> None:
    sweep = shifted_by_five_kelvin(swept)
    with pytest.raises(FitRejectedError, match="another load, or a shifted transformation"):
        homed_model(swept.model, sweep, ambient_k=AIR_K)
    found = homed_model(swept.model, sweep, load_n=1.9, ambient_k=AIR_K)
    assert not found.home.corrected
    assert found.home.transformation_shift_k == pytest.approx(5.0, abs=2.0)
    assert "under which the curve holds" in found.notes[-1]


def test_numbers_that_no_wire_has_are_refused(swept: Swept) -> None:
    with pytest.raises(FitRejectedError, match=r"transforms \+3\d K away, and no wire's transformation moves"):
        homed_model(swept.model, in_warmer_air(swept.sweep, -35.0))
    model = swept.model
    stretched = aged(swept.sweep, 0.95, 0.05 * model.resistance_max_ohm)
    with pytest.raises(FitRejectedError, match="which no ageing and no load does"):
        homed_model(model, stretched, load_n=1.9)


def test_an_incomplete_sweep_is_refused_and_not_taken_for_another_c(swept: Swept) -> None:
    resistance = swept.sweep["wire_voltage_v"] / swept.sweep["shunt_voltage_v"]
    middle = 0.5 * (swept.model.resistance_min_ohm + swept.model.resistance_max_ohm)
    driven = swept.sweep["drive_voltage_v"] > 1.5
    half = Recording(
        {name: column[(resistance > middle) | ~driven] for name, column in swept.sweep.columns.items()},
        swept.sweep.metadata,
    )
    with pytest.raises(RecordingError, match="the sweep is not complete: the resistance fell by"):
        homed_model(swept.model, half)


def test_a_sweep_that_began_warm_and_another_wire_are_refused(swept: Swept) -> None:
    warm = Recording({name: column[260:] for name, column in swept.sweep.columns.items()}, swept.sweep.metadata)
    with pytest.raises(RecordingError, match=r"began above point B|no transformation"):
        homed_model(swept.model, warm)
    with pytest.raises(FitRejectedError, match="another wire"):
        homed_model(swept.model, aged(swept.sweep, 1.10))


def test_another_load_and_a_model_without_power_are_the_callers(swept: Swept) -> None:
    with pytest.raises(CallerError, match=r"the load is 2.5 N and was 1.9 N at the characterization"):
        homed_model(swept.model, swept.sweep, load_n=2.5)
    with pytest.raises(CallerError, match="does not contain the power of its loop"):
        homed_model(replace(swept.model, slow_loop=()), swept.sweep)
    with pytest.raises(CallerError, match=r"air of -251 degC"):
        homed_model(swept.model, swept.sweep, ambient_k=22.15)


def test_a_model_with_a_home_move_is_the_same_after_a_file(swept: Swept, tmp_path: object) -> None:
    from pathlib import Path

    from musclewire.sensing import load_model

    assert isinstance(tmp_path, Path)
    found = homed_model(swept.model, aged(swept.sweep, 1.01), ambient_k=AIR_K)
    found.model.save(tmp_path / "model.json")
    assert load_model(tmp_path / "model.json") == found.model
    assert found.model.drift_resistance_ohm == found.home.drift_resistance_ohm
    assert swept.model.drift_resistance_ohm == pytest.approx(
        0.003 * (swept.model.resistance_max_ohm - swept.model.resistance_min_ohm)
    )


def test_a_fall_has_levelled_off_where_its_slope_ends() -> None:
    power = np.linspace(0.0, 1.0, 400)
    whole = 17.0 - 2.0 / (1.0 + np.exp(-(power - 0.5) / 0.05))
    assert has_levelled(power, whole)
    assert not has_levelled(power[:230], whole[:230])
    assert not has_levelled(power, np.full(power.size, 17.0))
