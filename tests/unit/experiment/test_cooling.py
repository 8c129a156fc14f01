"""After a closed loop the wire is watched as it cools: what changed in mid-run is seen then."""

from __future__ import annotations

import numpy as np
import pytest

import musclewire as mw
from musclewire import SensingModel
from musclewire.experiment import control, cooling_time_s
from musclewire.judge import judgement_of
from musclewire.rigs import Answer, HasAnEnd
from musclewire.signals import Command, RawSample

STEPS = mw.staircase(0.015, 0.018, 0.003, 4.0)
BEGINS_S, LASTS_S = 4.0, 2.0


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with mw.open_rig("simulated", seed=3) as rig:
        return mw.fit(mw.characterize(rig, minor_loop=False))


@pytest.mark.parametrize("drift", [0.0, 0.01, -0.01])
def test_a_resistance_that_drifts_in_mid_run_is_named(model: SensingModel, drift: float) -> None:
    with mw.open_rig("simulated", seed=5) as rig:
        measured = rig.device.exchange

        def exchange(command: Command) -> Answer:
            sample = measured(command)
            assert isinstance(sample, RawSample)
            by = 1.0 + drift * float(np.clip((sample.time_s - BEGINS_S) / LASTS_S, 0.0, 1.0))
            return sample._replace(wire_voltage_v=by * sample.wire_voltage_v)

        rig.device.exchange = exchange  # type: ignore[method-assign]  # a resistance that drifts
        run = control(rig, model, STEPS)
    assert ("other_height_of_b" in [one.key for one in judgement_of(run).findings]) == bool(drift)
    assert bool(judgement_of(run).does_not_hold) == bool(drift)


def test_the_loop_ends_where_it_did_and_the_cooling_is_a_segment_of_its_own(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=5) as rig:
        run, cooling_s = control(rig, model, STEPS), cooling_time_s(rig, model, STEPS.duration_s)
    assert run["time_s"][-1] == pytest.approx(STEPS.duration_s)
    assert run.cooling is not None
    assert run.cooling.duration_s == pytest.approx(cooling_s, abs=0.1)
    assert run.cooling["drive_voltage_v"] == pytest.approx(run.metadata["limit_sense_voltage_v"], rel=1e-3)
    assert np.isnan(run.cooling["target_strain"]).all()
    assert np.isfinite(run.cooling["wire_resistance_ohm"]).all()


def test_who_ends_a_loop_does_not_wait_for_it(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=5) as rig:
        run = control(rig, model, STEPS, until=lambda: True)
    assert run.cooling is None


def test_a_recording_that_is_replayed_has_no_more_than_it_has(model: SensingModel) -> None:
    class Ending:
        samples_left = round(STEPS.duration_s / 0.05) + 20

    with mw.open_rig("simulated", seed=5) as rig:
        assert isinstance(Ending(), HasAnEnd)
        assert cooling_time_s(rig, model, STEPS.duration_s) > 0.0
        vars(rig.device)["samples_left"] = Ending.samples_left
        assert cooling_time_s(rig, model, STEPS.duration_s) == 0.0
