"""The closed loop as a run of a study: compiled or in Python the same numbers, those of ``control`` on the same rig."""

from __future__ import annotations

import pytest
from tests.extras.studies.unit.study_parts import study_of

import musclewire as mw
from musclewire.extras.studies import Workers, sweep
from musclewire.extras.studies._design import run_seed

RUN = {
    "kind": "control",
    "cycles": 1,
    "period": "60 s",
    "stop": 0.018,
    "hold": "3 s",
    "keep": ["mae_mean_pct", "mae_mean_approached_pct", "rms_pct", "model_gap", "valid_fraction", "strain"],
}


def test_a_run_is_the_closed_loop_on_the_rig_of_its_values_and_its_seed() -> None:
    study = study_of(run=RUN, parameters={"run.in_python": {"values": [False, True]}, "pretension": {"values": [1.8]}})
    result = sweep(study, workers=Workers(processes=1))
    assert result.errors == ("", "")
    for number in (0, 1):
        with mw.open_rig("simulated", seed=run_seed(1, number), pretension_n=1.8) as rig:
            model = mw.fit(mw.characterize(rig, cycles=1, period_s=60.0, minor_loop=False))
            run = mw.control(rig, model, mw.staircase(stop=0.018, hold_s=3.0))
        assert result.columns["mae_mean_pct"][number] == run.metrics.mae_mean_pct
        assert result.columns["mae_mean_approached_pct"][number] == run.metrics.mae_mean_approached_pct
        assert result.columns["rms_pct"][number] == run.metrics.rms_pct
        assert result.columns["model_gap"][number] == model.hysteresis_gap
        assert result.columns["strain"][number].tolist() == (run["displacement_m"] / 0.07).tolist()


def test_moving_air_and_a_second_wire_run_in_python() -> None:
    rig = {"surroundings": {"draught": 0.05}}
    result = sweep(study_of(rig=rig, run=RUN, parameters={}), workers=Workers(processes=1))
    assert result.failed == 0
    assert result.columns["valid_fraction"][0] > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("key", ["estimator", "controller"])
def test_an_unknown_name_fails_each_run_with_the_nearest_one(key: str) -> None:
    study = study_of(run={**RUN, key: "polynomal" if key == "estimator" else "fuzzy-pd"})
    result = sweep(study, workers=Workers(processes=1))
    assert result.failed == 2
    assert "did you mean" in result.errors[0]
