"""How warm a wire is by its heat balance, against closed forms and SciPy's integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from musclewire.errors import RecordingError
from musclewire.parameters import load_alloy
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.signals import RunFacts
from musclewire.wire import HeatBalance, warmed_k

CONSTANT = HeatBalance(capacity_j_per_k=5.4e-3, loss_w_per_k=6e-3, air_k=295.15)
GROWING = HeatBalance.of_wire(load_alloy("flexinol"), 1e-4, 0.14, 295.15)


@given(st.floats(305.0, 900.0))
def test_a_wire_settles_where_it_gives_off_what_it_gets(wall_k: float) -> None:
    given_off_w = convection_coefficient_w_per_m2_k(wall_k, 295.15, 1e-4) * math.pi * 1e-4 * 0.14 * (wall_k - 295.15)
    assert GROWING.power_w(wall_k) == pytest.approx(given_off_w)
    assert GROWING.steady_k(given_off_w) == pytest.approx(wall_k, abs=1e-6)
    assert CONSTANT.steady_k(CONSTANT.power_w(wall_k)) == pytest.approx(wall_k)


def test_heat_capacity_is_that_of_the_metal_and_wires_add_up() -> None:
    alloy = load_alloy("flexinol")
    metal = alloy["density_kg_per_m3"] * alloy["specific_heat_j_per_kg_k"]
    assert GROWING.capacity_j_per_k == pytest.approx(metal * math.pi / 4.0 * 1e-8 * 0.14)
    half_as_calm = HeatBalance.of_wire(alloy, 1e-4, 0.14, 295.15, 0.5, wires=3)
    assert half_as_calm.lag_s == pytest.approx(2.0 * GROWING.lag_s)
    assert half_as_calm.loss_w_per_k == pytest.approx(1.5 * GROWING.loss_w_per_k)


@given(st.floats(0.0, 300.0), st.floats(0.0, 2.0), st.floats(1e-3, 20.0))
def test_the_protections_step_is_the_exponential_to_second_order_and_never_colder(
    above_k: float, power_w: float, dt_s: float
) -> None:
    capacity, loss, air_k = CONSTANT[:3]
    exact_k = CONSTANT.after_k(air_k + above_k, power_w, dt_s) - air_k
    lags, settled_k = dt_s / CONSTANT.lag_s, power_w / loss
    step_k = warmed_k(above_k, power_w, dt_s, capacity, loss)
    assert abs(step_k - exact_k) <= abs(above_k - settled_k) * min(lags**3 / 6.0, 0.07) + 1e-9
    assert warmed_k(above_k, 0.0, dt_s, capacity, loss) >= CONSTANT.after_k(air_k + above_k, 0.0, dt_s) - air_k - 1e-9


@pytest.mark.parametrize("heat", [CONSTANT, GROWING])
def test_along_a_course_of_uneven_times_the_wire_is_as_warm_as_by_integration(heat: HeatBalance) -> None:
    time_s = np.sort(np.random.default_rng(1).uniform(0.0, 20.0, 4000))
    power_w = 0.6 * np.sin(math.pi * time_s / 20.0) ** 2

    def slope_k_per_s(at_s: float, temperature_k: np.ndarray) -> float:
        given_w = float(np.interp(at_s, time_s, power_w))
        return (given_w - heat.power_w(float(temperature_k[0]))) / heat.capacity_j_per_k

    exact = solve_ivp(slope_k_per_s, time_s[[0, -1]], [350.0], t_eval=time_s, max_step=0.05, rtol=1e-6).y[0]
    assert heat.along_k(time_s, power_w, power_w, 0.0, 350.0) == pytest.approx(exact, abs=0.15)


def test_what_a_transformation_takes_is_missing_until_it_comes_back() -> None:
    time_s = np.linspace(0.0, 1e-3, 3)
    found_k = CONSTANT.along_k(time_s, np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.054, 295.15)
    assert found_k == pytest.approx([295.15, 285.15, 295.15], abs=0.02)
    same_time = CONSTANT.along_k(np.zeros(3), np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.054, 295.15)
    assert same_time == pytest.approx([295.15, 285.15, 295.15])


@pytest.mark.parametrize("left_out", ["heat_capacity_j_per_k", "heat_loss_w_per_k", "ambient_temperature_k"])
def test_a_rig_states_its_balance_whole_or_not_at_all(left_out: str) -> None:
    stated = {f"limit_{left_out}": 0.0}
    numbers = zip(("heat_capacity_j_per_k", "heat_loss_w_per_k", "ambient_temperature_k"), CONSTANT[:3], strict=True)
    whole = {f"limit_{key}": number for key, number in numbers}
    assert HeatBalance.stated_in(RunFacts(whole)) == CONSTANT
    for facts in (whole | stated, {key: one for key, one in whole.items() if key not in stated}):
        with pytest.raises(RecordingError, match=left_out):
            HeatBalance.stated_in(RunFacts(facts))
