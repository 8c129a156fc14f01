"""A wire's default voltages follow its length, diameter and circuit, and hold it no warmer than 140 C."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from musclewire.errors import CallerError
from musclewire.experiment import characterize
from musclewire.parameters import catalogue_names, load_alloy, load_bench, load_wire
from musclewire.rigs import (
    OVERHEATED_K,
    MountedWire,
    RigConfiguration,
    open_rig,
    own_circuit,
    parameters_of,
    read_rig_file,
)
from musclewire.rigs._own_voltages import (
    HOTTEST_K,
    SHUNT_RANGE_V,
    HotWire,
    austenite_ohm,
    held_temperature_k,
    holding_voltage_v,
    hot_wire,
    hot_wire_on,
)

NINE = list(itertools.product(("flexinol-0.10-ht", "flexinol-0.15-ht", "flexinol-0.25-ht"), (0.06, 0.1, 0.14)))


def voltages(rig: str | Path | RigConfiguration = "simulated", **settings: float | str) -> tuple[float, float]:
    with open_rig(rig, **settings) as opened:  # type: ignore[arg-type]  # names of wire and bench are among them
        return opened.drive_amplitude_v, opened.maximum_voltage_v


def test_the_papers_benches_keep_their_numbers_to_the_bit() -> None:
    assert voltages() == (3.2, 3.6)
    assert voltages("finger") == (1.65678, 2.025)
    for name in ("paper-125um", "paper-200um", "isobar-sample"):
        wire = load_wire(name)
        assert voltages(wire=name) == (wire["drive_amplitude_v"], wire["maximum_voltage_v"])


def test_at_equal_warmth_the_voltage_is_in_proportion_to_the_resistance_of_the_whole_circuit() -> None:
    # A wire of one diameter at one temperature carries one current, whatever its length and the shunt.
    hot_ohm_per_m = 101.0  # austenite of 126 ohm/m
    for length_m, shunt_ohm in ((0.06, 1.0), (0.3, 1.0), (0.14, 5.0)):
        amplitude_v, maximum_v = voltages(wire_length_m=length_m, shunt_resistance_ohm=shunt_ohm)
        ratio = (hot_ohm_per_m * length_m + shunt_ohm) / (hot_ohm_per_m * 0.14 + 1.0)
        if length_m < 0.3:
            assert amplitude_v / 3.2 == pytest.approx(ratio, rel=0.01)
        else:
            assert amplitude_v == pytest.approx(3.2 * ratio, rel=0.01)
        assert maximum_v / 3.6 == pytest.approx(amplitude_v / 3.2, rel=1e-3)


def on_the_papers_bench(name: str, **settings: float) -> HotWire:
    wire, bench = load_wire(name), load_bench("paper").with_values(**settings)
    return hot_wire(
        wire,
        load_alloy(wire.alloy),
        wire_length_m=bench["wire_length_m"],
        series_ohm=bench["shunt_resistance_ohm"] + bench["lead_resistance_ohm"],
        ambient_temperature_k=bench["ambient_temperature_k"],
    )


@pytest.mark.parametrize("name", ["paper-100um", *catalogue_names()])
def test_whatever_length_and_air_the_amplitude_holds_no_wire_above_140_c(name: str) -> None:
    for length_m, ambient_k in itertools.product((0.04, 0.14, 0.5), (290.0, 313.15)):
        settings = {"wire_length_m": length_m, "ambient_temperature_k": ambient_k}
        _, driven, _ = parameters_of(RigConfiguration(wire=name), "rig", settings=settings)
        hot = on_the_papers_bench(name, **settings)
        assert held_temperature_k(hot, driven["drive_amplitude_v"]) <= HOTTEST_K + 0.01
        assert driven["drive_amplitude_v"] <= driven["maximum_voltage_v"]


def test_temperature_and_voltage_are_each_others_inverse() -> None:
    hot = on_the_papers_bench("flexinol-0.25-ht")
    for kelvins in (310.0, 373.15, 413.15, 600.0):
        assert held_temperature_k(hot, holding_voltage_v(hot, kelvins)) == pytest.approx(kelvins, abs=1e-3)


def test_another_diameter_of_the_same_wire_brings_its_resistance_with_it() -> None:
    with open_rig("simulated", diameter_m="0.15 mm", wire_length_m="60 mm") as rig:
        assert rig.protection_limits.resistance_low_ohm == pytest.approx(0.85 * 0.8 * 126.0 / 1.5**2 * 0.06)
        loop = characterize(rig, cycles=1, period_s=30.0)
    assert loop.metadata["ended"] == "done"


def test_what_a_file_states_stands_and_the_other_voltage_follows() -> None:
    assert voltages(RigConfiguration(wire_length=0.1, drive_amplitude=2.0, maximum_voltage=2.2)) == (2.0, 2.2)
    assert voltages(RigConfiguration(wire_length=0.1, maximum_voltage=2.0)) == (2.0, 2.0)
    amplitude_v, maximum_v = voltages(RigConfiguration(wire_length=0.1, drive_amplitude=3.0))
    assert (amplitude_v, maximum_v) == (3.0, 3.0)  # as far as the wire's own 3.6 V go
    assert voltages(RigConfiguration(wire_length=0.1, drive_amplitude=5.0))[1] == 3.6


MOUNTED = {"wire": "paper-100um", "wire_length": "14 cm", "shunt": "1 ohm", "sense_voltage": "0.3 V"}


def test_a_rig_file_of_hardware_may_leave_its_voltages_to_the_wire(tmp_path: Path) -> None:
    own = MountedWire.model_validate(MOUNTED)
    assert own.drive_amplitude == 3.2
    short = MountedWire.model_validate({**MOUNTED, "wire_length": "60 mm"})
    assert short.drive_amplitude == voltages(wire_length_m=0.06)[0]
    for mounted in (own, short):
        hot = hot_wire_on(mounted.wire, mounted.wire_length, mounted.shunt, 295.15)
        assert held_temperature_k(hot, mounted.maximum_voltage) == pytest.approx(OVERHEATED_K, abs=0.2)
    low = MountedWire.model_validate({**MOUNTED, "maximum_voltage": "3 V"})
    assert (low.drive_amplitude, low.maximum_voltage) == (3.0, 3.0)
    text = 'kind = "serial"\nport = "none"\nwire_range = "5 V"\nshunt_range = "1 V"\n'
    file = tmp_path / "board.toml"
    file.write_text(text + "\n".join(f'{key} = "{value}"' for key, value in MOUNTED.items()), "utf-8")
    assert dict(read_rig_file(file))["drive_amplitude"] == 3.2


@pytest.mark.parametrize("wire", [*catalogue_names(), "paper-100um"])
def test_what_a_wire_is_given_on_a_board_fits_the_boards_range_and_its_own_limits(wire: str) -> None:
    own = own_circuit(wire, wire_length_m=0.14)
    assert own.sense_voltage_v < own.amplitude_v <= own.maximum_v
    hot = hot_wire_on(wire, 0.14, own.shunt_ohm, 295.15)
    # For long: a current through a stretched wire, and the highest voltage at a contracted one, settle it at 150 C.
    contracted_ohm, stretched_ohm = austenite_ohm(hot, OVERHEATED_K)
    assert own.lasting_current_a**2 * stretched_ohm == pytest.approx(hot.heat.power_w(OVERHEATED_K))
    assert held_temperature_k(hot, own.maximum_v) <= OVERHEATED_K + 0.1
    read_v = own.shunt_ohm * own.maximum_v / (contracted_ohm + own.shunt_ohm)
    assert 0.6 * SHUNT_RANGE_V < read_v <= 0.96 * SHUNT_RANGE_V
    # Bias of all legs: far below what the vendor allows in motion.
    section_m2 = 0.25 * math.pi * load_wire(wire)["diameter_m"] ** 2
    assert own.pretension_n / 2.0 / section_m2 < 80e6


def test_the_paper_s_wire_gets_the_paper_s_shunt_and_longer_wire_the_same() -> None:
    assert own_circuit("paper-100um", wire_length_m=0.14).shunt_ohm == 1.0
    assert own_circuit("flexinol-0.15-lt", wire_length_m=0.14).shunt_ohm == 0.47
    assert own_circuit("flexinol-0.15-lt", wire_length_m=0.28).shunt_ohm == 0.47


def test_air_as_hot_as_the_limit_leaves_no_current() -> None:
    with pytest.raises(CallerError, match="no current"):
        own_circuit("flexinol-0.15-lt", wire_length_m=0.14, ambient_temperature_k=430.0)


def hottest_k(wire: str, length_m: float, *, until_level: bool, period_s: float) -> float:
    """Return the true temperature that a slow sine with defaults leads to; a trip raises."""
    with open_rig("simulated", wire=wire, wire_length_m=length_m) as rig:
        seen = [0.0]

        def on_sample(_row: object) -> None:
            seen[0] = max(seen[0], rig.device.wire_state.temperature_k)  # type: ignore[attr-defined]  # a simulation

        characterize(rig, cycles=1, period_s=period_s, until_level=until_level, on_sample=on_sample)
    return seen[0]


@pytest.mark.parametrize(("wire", "length_m"), [NINE[0], NINE[-3]])
def test_a_short_wire_with_defaults_is_neither_tripped_nor_burnt(wire: str, length_m: float) -> None:
    assert 373.15 < hottest_k(wire, length_m, until_level=False, period_s=20.0) <= HOTTEST_K


@pytest.mark.slow
@pytest.mark.parametrize(("wire", "length_m"), NINE)
def test_nine_wires_with_defaults_are_neither_tripped_nor_burnt(wire: str, length_m: float) -> None:
    assert 373.15 < hottest_k(wire, length_m, until_level=True, period_s=90.0) <= HOTTEST_K
