"""What goes into a compiled loop is what a rig in Python has, and what cannot go in is named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from musclewire.controllers import staircase
from musclewire.errors import RigError
from musclewire.experiment import control_many, drive_wire
from musclewire.rigs._compiled_loop.running import run_known_drive, uncompiled
from musclewire.rigs._configuration import RigConfiguration, open_rig
from musclewire.rigs._guarded import GuardedRig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording


def test_what_has_no_compiled_form_says_why() -> None:
    lost = RigConfiguration.model_validate({"fault": [{"kind": "wire_open", "at": "3 s"}]})
    with open_rig() as fresh, open_rig(lost) as faulty, open_rig("gripper") as two, open_rig(real_time=True) as paced:
        assert uncompiled(fresh) == ""
        assert "faults" in uncompiled(faulty)
        assert "two wires" in uncompiled(two)
        assert "clock" in uncompiled(paced)
        fresh.exchange(0.3)
        assert "being driven" in uncompiled(fresh)
        fresh.make_safe()
        assert uncompiled(fresh) == ""


# 4 % at 13.5 ohm, nothing at 17.5 ohm: any wire will do for a few samples.
MODEL = SensingModel(13.5, 17.5, (0.0405, -0.04), (0.0395, -0.04), 0.05, 0.95, resistance_noise_ohm=0.005)


OTHER_WIRE = replace(MODEL, resistance_min_ohm=30.0, resistance_max_ohm=40.0)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["polynomial", "gated"])
@pytest.mark.parametrize(
    ("model", "limits"),
    [(MODEL, {}), (OTHER_WIRE, {}), (MODEL, {"maximum_current": 0.05}), (MODEL, {"maximum_temperature": 299.0})],
    ids=["to its end", "a wire that is not the model's", "over-current", "too warm"],
)
def test_a_few_samples_of_a_compiled_loop_are_those_in_python(
    model: SensingModel, limits: dict[str, float], estimator: str
) -> None:
    """Short enough to be run without compilation, too."""
    fast, slow = (
        control_many(
            RigConfiguration(surroundings={"draught": 0.1}, limits=limits),
            model,
            staircase(start=0.015, stop=0.018, hold_s=0.2),
            seeds=[7],
            estimator=estimator,
            approach_s=0.3,
            keep_recordings=True,
            in_python=in_python,
        ).outcomes[0]
        for in_python in (False, True)
    )
    assert (fast.ended, slow.compiled) == (slow.ended, False)
    assert fast.compiled is (model is MODEL and not limits)
    assert fast.run is not None
    assert slow.run is not None
    for name in slow.run.columns:
        np.testing.assert_array_equal(fast.run.columns[name], slow.run.columns[name], err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("limits", [{}, {"maximum_current": 0.05}])
def test_a_few_samples_of_a_known_drive_are_those_in_python(limits: dict[str, float]) -> None:
    rigs = [open_rig(RigConfiguration(limits=limits)) for _ in range(2)]

    def driven(rig: GuardedRig, **how: Any) -> Recording:
        with rig:
            return drive_wire(rig, on_s=0.3, duration_s=0.5, supply_v=3.0, **how)

    runs = []
    for rig, how in zip(rigs, ({}, {"on_sample": lambda _row: None}), strict=True):
        try:
            runs.append(driven(rig, **how))
        except RigError as error:
            runs.append(str(error))
    assert all(isinstance(run, str) for run in runs) is bool(limits)
    if limits:
        assert runs[0] == runs[1]
    else:
        for name in runs[1].columns:
            np.testing.assert_array_equal(runs[0].columns[name], runs[1].columns[name], err_msg=name)
    assert rigs[0].protection == rigs[1].protection


def test_after_compiled_samples_the_last_drive_is_out() -> None:
    with open_rig("simulated") as rig:
        run_known_drive(rig, np.linspace(0.5, 2.0, 20))
        assert rig.drive_voltage_v == pytest.approx(2.0, abs=0.002)  # the step of the output's converter
        assert rig.protection.drive_voltage_v == pytest.approx(2.0, abs=0.002)
