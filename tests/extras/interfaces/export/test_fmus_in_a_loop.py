"""A wire's FMU and a controller's, coupled: the closed loop that Python computes with both."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.extras.board.export.export_parts import drive_limits
from tests.extras.interfaces.export.fmu_parts import Slave
from tests.tools import require_oracle, require_tool

import musclewire as mw
from musclewire.extras.board import ReferenceTick, limits_of_rig, settings_in_c
from musclewire.rigs import RigConfiguration, open_simulated
from musclewire.sensing import SensingModel
from musclewire.wire import OneWire, advance, resting_state

require_oracle("fmpy")
pytestmark = pytest.mark.oracles
SAMPLE_S, LEG_LENGTH_M = 0.05, 0.07
TARGETS = [level for level in (0.01, 0.02, 0.025, 0.015) for _ in range(120)]


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with mw.open_rig("simulated") as rig:
        return mw.fit(mw.characterize(rig))


def python_loop(model: SensingModel) -> list[tuple[float, float, float]]:
    """Return drive, temperature and displacement after each sample, by Python's wire and Python's tick."""
    wires = open_simulated(RigConfiguration()).wires
    assert isinstance(wires, OneWire)
    constants = wires.constants
    limits = limits_of_rig("simulated")[0]
    tick = ReferenceTick(model, settings_in_c(model), drive_limits(limits), limits, estimator="filter")
    state, rows = resting_state(constants), []
    for target in TARGETS:
        state, means = advance(state, constants, tick.drive_voltage_v, SAMPLE_S)
        tick.sample(means.wire_voltage_v, means.shunt_voltage_v, SAMPLE_S)
        drive_v = tick.control(target, SAMPLE_S).drive_voltage_v
        rows.append((drive_v, state.temperature_k, state.connector_contraction * constants.leg_length_m))
    return rows


def fmu_loop(model: SensingModel, folder: Path) -> list[tuple[float, float, float]]:
    """Return the same by both FMUs, the wire stepped first."""
    rows = []
    with Slave(mw.export_fmu("simulated", folder).path) as wire, Slave(mw.export_fmu(model, folder).path) as controller:
        wire.start()
        controller.start()
        for target in TARGETS:
            wire.set(drive_voltage_v=controller.get("drive_voltage_v"))
            wire.step(SAMPLE_S)
            voltages = {name: wire.get(f"mean_{name}") for name in ("wire_voltage_v", "shunt_voltage_v")}
            controller.set(target=target, **voltages)
            controller.step(SAMPLE_S)
            rows.append((controller.get("drive_voltage_v"), wire.get("temperature_k"), wire.get("displacement_m")))
    return rows


def test_the_closed_loop_of_two_fmus_is_python_s(model: SensingModel, tmp_path: Path) -> None:
    require_tool("gcc", "gcc libc6-dev")
    python = python_loop(model)
    for one, other in zip(fmu_loop(model, tmp_path), python, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
    assert python[359][2] / LEG_LENGTH_M == pytest.approx(0.025, abs=1e-3)
