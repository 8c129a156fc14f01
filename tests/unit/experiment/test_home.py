"""A home move heats just beyond the transformation, within the rig's limits, and leaves the rig safe."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from musclewire.errors import CallerError, FitRejectedError
from musclewire.experiment import HomeSweep, characterize, home, home_duration_s, plan_for, run_on_rig
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with open_rig("simulated") as rig:
        return fit(characterize(rig))


def test_it_takes_about_twenty_seconds_and_ends_at_the_sense_voltage(model: SensingModel) -> None:
    rows: list[Mapping[str, float]] = []
    with open_rig("simulated", seed=2) as rig:
        found = home(rig, model, on_sample=rows.append)
        assert rig.drive_voltage_v == rig.sense_voltage_v
        assert home_duration_s(rig, model) < 30.0
    driven = [row["time_s"] for row in rows if row["drive_voltage_v"] > 0.31]
    assert 14.0 < driven[-1] - driven[0] < 22.0
    assert found.home.load_n == 1.9
    assert not found.home.corrected


@pytest.mark.parametrize(("convection_factor", "resistivity_factor"), [(0.45, 1.0), (0.817678, 1.01)])
def test_it_turns_where_the_wire_has_transformed_however_it_cools(
    model: SensingModel, convection_factor: float, resistivity_factor: float
) -> None:
    settings = {"convection_factor": convection_factor, "resistivity_factor": resistivity_factor}
    with open_rig("simulated", seed=2, **settings) as rig, rig.holding_back():
        plan = plan_for(rig, model)
        sweep = run_on_rig(rig, HomeSweep(rig, plan), plan.duration_s)
        shunt_ohm = rig.shunt_resistance_ohm
    driven = sweep["drive_voltage_v"] > 1.0
    lowest_ohm = shunt_ohm * float((sweep["wire_voltage_v"] / sweep["shunt_voltage_v"])[driven].min())
    fell = (resistivity_factor * model.resistance_max_ohm - lowest_ohm) / (
        model.resistance_max_ohm - model.resistance_min_ohm
    )
    assert 0.95 < fell < 1.2


def test_an_aged_wire_in_slower_air_is_corrected_and_air_that_hardly_cools_refused(model: SensingModel) -> None:
    with open_rig("simulated", seed=2, convection_factor=0.817678, resistivity_factor=1.01) as rig:
        assert home(rig, model).home.corrected
    with (
        open_rig("simulated", seed=2, convection_factor=0.45) as rig,
        pytest.raises(FitRejectedError, match=r"^no home move, .*: by its power the wire transforms -\d+ K away"),
    ):
        home(rig, model)


def test_a_wire_that_the_drive_cannot_heat_is_named_with_the_limit(model: SensingModel) -> None:
    with (
        open_rig("simulated", seed=2, convection_factor=2.4) as rig,
        pytest.raises(FitRejectedError, match=r"^no home move, the model is as it was: .*limit of 3.6 V\)$"),
    ):
        home(rig, model)


def test_another_load_or_spring_that_the_rig_states_is_refused_before_anything_is_heated(model: SensingModel) -> None:
    with open_rig("simulated", pretension_n=2.5) as rig, pytest.raises(CallerError, match=r"the load is 2\.5 N"):
        home(rig, model)
    with (
        open_rig("simulated", spring_stiffness_n_per_m=1200.0) as rig,
        pytest.raises(CallerError, match=r"the wire pulls 1200 N/m and pulled 588\.6 N/m"),
    ):
        home(rig, model)
