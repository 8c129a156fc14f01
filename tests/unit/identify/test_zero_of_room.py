"""A warmer room leaves the cold wire shorter: by how much a model knows, and what of it reaches today's zero."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import musclewire as mw
from musclewire import RigConfiguration
from musclewire.errors import CallerError
from musclewire.experiment import run_warnings
from musclewire.identify import zero_of_room
from musclewire.sensing import Correction, SensingModel

PER_K = 1e-4
NOTES = {"ambient_temperature_k": 303.15, "stated_ambient_k": 295.15, "cold_contraction_per_k": PER_K}


def model(**notes: Any) -> SensingModel:
    return SensingModel(15.0, 17.0, (0.042, -0.04), (0.038, -0.04), 0.0, 1.0, wire=NOTES | notes)


@pytest.mark.parametrize(("warmer_k", "said"), [(10.0, "shorter"), (-10.0, "longer")])
@pytest.mark.parametrize(("spring", "share"), [({"spring_stiffness_n_per_m": 600.0}, 0.7), ({}, 0.85)])
def test_the_zero_moves_by_a_part_of_what_cooling_leaves(
    warmer_k: float, said: str, spring: dict[str, float], share: float
) -> None:
    found = zero_of_room(model(**spring), {"limit_ambient_temperature_k": 295.15 + warmer_k})
    assert found is not None
    assert found.correction.zero == pytest.approx(share * PER_K * warmer_k)
    assert found.correction.variance(0.2) == pytest.approx((0.15 * PER_K * warmer_k) ** 2)
    assert said in found.said


@pytest.mark.parametrize("known", [{}, {"limit_ambient_temperature_k": 295.65}])
def test_the_same_room_and_one_that_is_not_known_move_nothing(known: dict[str, Any]) -> None:
    assert zero_of_room(model(), known) is None
    assert zero_of_room(replace(model(), wire={}), {"limit_ambient_temperature_k": 310.0}) is None


def test_a_model_that_does_not_state_it_says_so() -> None:
    without = replace(model(), wire={"stated_ambient_k": 295.15})
    found = zero_of_room(without, {"limit_ambient_temperature_k": 310.15})
    assert found is not None
    assert (found.correction, "fit again" in found.said) == (Correction(), True)


@pytest.mark.parametrize(("warmer_k", "target"), [(15.0, 0.0355), (-15.0, 0.007)])
def test_a_target_beyond_what_this_room_lets_a_wire_show_is_refused(
    ours: SensingModel, warmer_k: float, target: float
) -> None:
    reference = mw.staircase(target, target + 0.0001, 0.0001)
    with mw.open_rig(room(warmer_k), seed=7) as rig:
        with pytest.raises(CallerError, match="from the zero of this room"):
            mw.control(rig, ours, reference, zero_from="today")
        assert rig.drive_voltage_v <= rig.sense_voltage_v


def room(warmer_k: float) -> RigConfiguration:
    return RigConfiguration(settings={"ambient_temperature_k": 295.15 + warmer_k})


@pytest.fixture(scope="module")
def ours() -> SensingModel:
    with mw.open_rig(room(0.0), seed=3) as rig:
        return mw.fit(mw.characterize(rig))


@pytest.mark.parametrize("warmer_k", [-15.0, 15.0])
def test_a_loop_in_another_room_errs_by_a_third_from_todays_zero(ours: SensingModel, warmer_k: float) -> None:
    found = {}
    for zero_from in ("kept", "today"):
        with mw.open_rig(room(warmer_k), seed=7) as rig:
            found[zero_from] = mw.control(rig, ours, mw.staircase(stop=0.021), zero_from=zero_from)
    kept, today = (found[name].metrics.mae_mean_approached_pct or 0.0 for name in ("kept", "today"))
    assert today < 0.33 * kept
    assert today < 2.0
    assert any("15 K" in text for text in run_warnings(found["today"]))
    assert not any("15 K" in text for text in run_warnings(found["kept"]))
