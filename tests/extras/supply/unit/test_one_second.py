"""What a maker needs: currents, supply and shunt, against hand calculation and the simulation they come from."""

from __future__ import annotations

import pytest

from musclewire.extras.supply._catalogue_check import dead_weight_bench, run_catalogue_test
from musclewire.extras.supply._one_second import one_second_current, relaxation_time_s
from musclewire.parameters import load_alloy, load_bench, load_wire

ALLOY = load_alloy("flexinol")


@pytest.mark.parametrize("name", ["flexinol-0.025-ht", "flexinol-0.10-lt", "flexinol-0.31-lt"])
def test_the_one_second_current_gives_nine_tenths_of_the_stroke_in_a_second(name: str) -> None:
    wire = load_wire(name)
    bench = dead_weight_bench(load_bench("dead-weight"), wire.diameter_m.value)
    best = one_second_current(ALLOY, wire, bench)
    run = run_catalogue_test(ALLOY, wire, bench, best.current_a)
    assert run.contraction_fraction == pytest.approx(0.9, abs=0.01)
    # Largest contraction over a coarse and a fine ladder of temperatures.
    assert run.stroke == pytest.approx(best.stroke, abs=1e-4)
    assert run.temperature_k == pytest.approx(best.temperature_k, abs=0.5)
    assert 0.0 < best.holding_current_a <= 1.001 * best.current_a


def test_the_voltage_goes_with_the_length_and_the_current_does_not() -> None:
    wire, bench = load_wire("flexinol-0.10-lt"), load_bench("dead-weight")
    longer = bench.with_values(wire_length_m=0.28)
    short, long = one_second_current(ALLOY, wire, bench), one_second_current(ALLOY, wire, longer)
    assert long.current_a == pytest.approx(short.current_a, rel=1e-3)
    assert long.wire_voltage_v == pytest.approx(2.0 * short.wire_voltage_v, rel=1e-3)


def test_a_hotter_start_takes_longer_to_relax() -> None:
    wire = load_wire("flexinol-0.10-lt")
    bench = dead_weight_bench(load_bench("dead-weight"), wire.diameter_m.value)

    def relaxing(current_a: float) -> float:
        return relaxation_time_s(ALLOY, wire, bench, current_a, 1.0, regulated_current=True, max_s=60.0)

    assert relaxing(0.01) == 0.0
    assert 0.2 < relaxing(0.22) < relaxing(0.3) < 60.0
