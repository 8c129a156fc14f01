"""The board's circuit in ngspice, from the parts list's own netlist: no single failed part burns the wire."""

from __future__ import annotations

import sys

import pytest
from tests.places import CHECKOUT
from tests.tools import require_tool

sys.path.insert(0, str(CHECKOUT / "hardware/board"))
import spice

pytestmark = pytest.mark.emulated
FOR_LONG_A, SECOND_LIMIT_A = 0.225, 0.32  # of flexinol-0.10-lt, by musclewire simulate --table; T2 with RCL


@pytest.fixture(scope="module")
def cases() -> dict[str, spice.Steady]:
    require_tool("ngspice", "ngspice")
    return {name: spice.steady(case) for name, case in spice.FAULTS.items()}


def test_the_output_follows_the_drive_and_both_channels_read_it(cases: dict[str, spice.Steady]) -> None:
    at = cases["drive of 3 V"]
    assert at.output_v == pytest.approx(3.0, rel=0.01)
    assert at.current_a == pytest.approx(at.output_v / (spice.WIRE_OHM + 1.0), rel=0.001)
    assert at.a0_v == pytest.approx(at.output_v, rel=0.001)
    assert at.a1_v == pytest.approx(20.0 * at.current_a, rel=0.01)


@pytest.mark.parametrize(
    "name",
    ["at reset, the pin floats", "S1 pressed, full drive", "adapter the other way round, full drive"],
)
def test_off_is_less_than_50_mv(cases: dict[str, spice.Steady], name: str) -> None:
    assert abs(cases[name].output_v) < 0.05
    assert abs(cases[name].current_a) < 1e-3


@pytest.mark.parametrize("name", ["program at full drive", "T1 shorted, drive off", "T1 shorted, wire shorted"])
def test_neither_a_program_nor_a_failed_transistor_exceeds_what_the_wire_may_carry_for_long(
    cases: dict[str, spice.Steady], name: str
) -> None:
    assert cases[name].current_a < FOR_LONG_A


@pytest.mark.parametrize("name", ["U3 shorted, full drive", "U3 shorted, wire shorted, full drive"])
def test_the_second_limit_holds_where_the_first_has_failed(cases: dict[str, spice.Steady], name: str) -> None:
    assert cases[name].current_a < SECOND_LIMIT_A


def test_a_broken_tap_reads_nothing(cases: dict[str, spice.Steady]) -> None:
    assert cases["tap broken, drive of 3 V"].a0_v < 0.01


def test_no_pulse_is_left_for_the_converter_to_see() -> None:
    require_tool("ngspice", "ngspice")
    left_v, mean_v = spice.ripple_v(0.6)
    assert mean_v == pytest.approx(3.0, rel=0.005)
    assert left_v < 1e-3  # a step of the converter is 4.9 mV


def test_the_guide_names_the_most_that_flows_after_a_single_failure(cases: dict[str, spice.Steady]) -> None:
    most_a = max(at.current_a for name, at in cases.items() if "both" not in name)
    page = (CHECKOUT / "docs/how-to/wire_the_circuit.md").read_text("utf-8")
    assert f"no single failure passes {most_a:.2f} A" in page
