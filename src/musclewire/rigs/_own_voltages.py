"""A wire's own drive voltages, for a rig file without them; for a board its shunt, sense voltage and pretension too.

A wire's amplitude and highest voltage are for one length behind one shunt. A shorter or thicker wire, or another
circuit, takes the voltage that holds it as warm as that, and never one that holds it above what the alloy was measured
up to: its own resistance as austenite, and its loss to still air, say so without a simulation. The same balance says
which current it may carry for long, and that current is what the shunt is chosen for.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import lru_cache
from typing import NamedTuple

from musclewire.errors import CallerError
from musclewire.parameters import Alloy, Wire, bench_known_with, load_alloy, load_bench, load_wire
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire import HeatBalance

# Flexinol's isobars (maestrolab/calibrating) end there: nothing is gained beyond, and 60 K remain to the protection's
# limit for what a wire's file, its clamps and its air leave open.
HOTTEST_K = 413.15
# A working limit, assumed: the vendor warns of overheating, but no number of the vendor's could be checked. 150 C is
# above the end of the transformation of 90 C wire under 172 MPa, and far below what anneals NiTi.
OVERHEATED_K = 423.15
# The bench for which a shipped wire's voltages are; that of the paper if it is not here.
BENCH_OF = {"finger-100um": "finger"}
PAPER_BENCH = "paper"
WARMEST_K = 1000.0  # [K] above the air, up to which a temperature is searched: more than any wire survives
HALVINGS = 40  # of that range, after which the temperature is known to far less than a kelvin
# A voltage that was carried over is rounded down to steps of a millivolt.
STEPS_PER_VOLT = 1000.0
# Of a channel's range, so that noise and a gain stay within.
READABLE_FRACTION = 0.95
SHUNT_RANGE_V = 0.25  # [V] that the boards' amplifiers read at the shunt: 5 V over a gain of 20
SHUNT_STEPS = (1.0, 1.5, 2.2, 3.3, 4.7, 6.8)  # the usual values of a shunt in a decade (E6)
# An eighth of the drive heats by a sixtieth of the power, two kelvins, and is many steps of a board's ten-bit output.
SENSE_FRACTION = 0.125


class HotWire(NamedTuple):
    """A hot wire behind its shunt and leads, in SI; ``in_series`` and ``in_parallel`` count like wires."""

    alloy: Alloy
    diameter_m: float
    wire_length_m: float
    series_ohm: float
    in_series: int
    in_parallel: int
    ambient_temperature_k: float
    convection_factor: float
    resistivity_factor: float

    @property
    def heat(self) -> HeatBalance:
        """The heat balance of one wire in still air, with a loss that grows with temperature."""
        air_k, factor = self.ambient_temperature_k, self.convection_factor
        return HeatBalance.of_wire(self.alloy, self.diameter_m, self.wire_length_m, air_k, factor)


class OwnVoltages(NamedTuple):
    """A wire's own voltages, and the wire and circuit for which they are."""

    amplitude_v: float
    maximum_v: float
    diameter_m: float
    resistance_per_metre_ohm_per_m: float
    wire_length_m: float
    series_ohm: float


def own_voltages(name: str) -> OwnVoltages:
    """Return the voltages of a wire, by name or wire file, with what they are for. Raises CallerError as load_wire."""
    wire, known = load_wire(name), bench_known_with(name)
    bench = load_bench(BENCH_OF.get(name, PAPER_BENCH)).model_copy(update=known)
    return OwnVoltages(
        wire["drive_amplitude_v"],
        wire["maximum_voltage_v"],
        wire["diameter_m"],
        wire["resistance_per_metre_ohm_per_m"],
        bench["wire_length_m"],
        bench["shunt_resistance_ohm"] + bench["lead_resistance_ohm"],
    )


def hot_wire(
    wire: Wire,
    alloy: Alloy,
    *,
    wire_length_m: float,
    series_ohm: float,
    ambient_temperature_k: float,
    in_series: int = 1,
    in_parallel: int = 1,
) -> HotWire:
    """Return a hot wire behind its shunt and leads, ``series_ohm`` together."""
    return HotWire(
        alloy=alloy,
        diameter_m=wire["diameter_m"],
        wire_length_m=wire_length_m,
        series_ohm=series_ohm,
        in_series=in_series,
        in_parallel=in_parallel,
        ambient_temperature_k=ambient_temperature_k,
        convection_factor=wire["convection_factor"],
        resistivity_factor=wire["resistivity_factor"],
    )


def austenite_ohm(hot: HotWire, temperature_k: float) -> tuple[float, float]:
    """Return the resistance [ohm] of austenite that contracted by the alloy's whole strain, and of one that did not."""
    alloy = hot.alloy
    per_kelvin = 1.0 + alloy["austenite_resistivity_per_k"] * (temperature_k - REFERENCE_TEMPERATURE_K)
    ohm_m = alloy["austenite_resistivity_ohm_m"] * hot.resistivity_factor * per_kelvin
    stretched = ohm_m / (0.25 * math.pi * hot.diameter_m**2) * hot.wire_length_m
    # A contracted wire is shorter and, at the same volume, thicker.
    return stretched / (1.0 + alloy["strain_saturated"]) ** 2, stretched


def holding_voltage_v(hot: HotWire, temperature_k: float) -> float:
    """Return the least drive voltage [V] that may hold a wire at a temperature in still air.

    Its resistance is that of austenite, contracted by the alloy's whole strain or not at all, whichever takes more
    power.
    """
    lowest, highest = austenite_ohm(hot, temperature_k)
    rest = hot.series_ohm * hot.in_parallel / hot.in_series
    ohm = min(max(rest, lowest), highest)
    return math.sqrt(hot.heat.power_w(temperature_k) / ohm) * (ohm + rest) * hot.in_series


@lru_cache(maxsize=256)
def held_temperature_k(hot: HotWire, drive_voltage_v: float) -> float:
    """Return the highest temperature [K] at which a drive voltage may hold a wire."""
    low_k, high_k = hot.ambient_temperature_k, hot.ambient_temperature_k + WARMEST_K
    for _ in range(HALVINGS):
        middle_k = 0.5 * (low_k + high_k)
        low_k, high_k = (middle_k, high_k) if holding_voltage_v(hot, middle_k) < drive_voltage_v else (low_k, middle_k)
    return high_k


def voltages_on_circuit(own: OwnVoltages, hot: HotWire) -> tuple[float, float]:
    """Return amplitude and highest voltage [V] on a circuit; an amplitude that would hold above 140 C is lowered."""
    at_home = hot._replace(
        diameter_m=own.diameter_m,
        wire_length_m=own.wire_length_m,
        series_ohm=own.series_ohm,
        in_series=1,
        in_parallel=1,
    )
    amplitude_v, maximum_v = own.amplitude_v, own.maximum_v
    if hot != at_home:
        amplitude_v = rounded_down_v(holding_voltage_v(hot, held_temperature_k(at_home, own.amplitude_v)))
        maximum_v = rounded_down_v(own.maximum_v * amplitude_v / own.amplitude_v)
    if hot.ambient_temperature_k < HOTTEST_K:
        amplitude_v = min(amplitude_v, rounded_down_v(holding_voltage_v(hot, HOTTEST_K)))
    return amplitude_v, max(maximum_v, amplitude_v)


def rounded_down_v(voltage_v: float) -> float:
    """Return a voltage in whole millivolts [V]."""
    return math.floor(STEPS_PER_VOLT * voltage_v) / STEPS_PER_VOLT


class GivenVoltages(NamedTuple):
    """What a rig file states of a wire's voltages [V]; None for what it leaves to the wire."""

    amplitude_v: float | None = None
    maximum_v: float | None = None


def completed(given: GivenVoltages, own: OwnVoltages, hot: HotWire) -> tuple[float, float]:
    """Return amplitude and highest voltage [V] of a rig whose file states both, one or neither."""
    if given.amplitude_v is not None and given.maximum_v is not None:
        return given.amplitude_v, given.maximum_v
    amplitude_v, maximum_v = voltages_on_circuit(own, hot)
    if given.maximum_v is not None:
        return min(amplitude_v, given.maximum_v), given.maximum_v
    if given.amplitude_v is not None:
        # Whoever states an amplitude takes it on himself, as far as the wire's own file goes.
        return given.amplitude_v, max(maximum_v, min(given.amplitude_v, own.maximum_v))
    return amplitude_v, maximum_v


def with_own_voltages(
    wire: Wire, hot: HotWire, own: OwnVoltages, given: Collection[str], channel_range_v: float
) -> Wire:
    """Return a simulated wire with the voltages of its length and circuit, but for those that its rig file states.

    ``given`` names the numbers that the file or the caller sets. A wire whose diameter is set has the resistance per
    metre of its section, unless that is set, too.
    """
    changed = {}
    if "resistance_per_metre_ohm_per_m" not in given:
        per_section = (own.diameter_m / wire["diameter_m"]) ** 2
        changed["resistance_per_metre_ohm_per_m"] = own.resistance_per_metre_ohm_per_m * per_section
    stated = GivenVoltages(
        *(wire[name] if name in given else None for name in ("drive_amplitude_v", "maximum_voltage_v"))
    )
    amplitude_v, maximum_v = completed(stated, own, hot)
    # A long wire needs more than the channels of its bench read.
    readable_v = max(READABLE_FRACTION * channel_range_v, own.maximum_v)
    for name, value in (("drive_amplitude_v", amplitude_v), ("maximum_voltage_v", maximum_v)):
        if name not in given:
            changed[name] = min(value, readable_v)
    source = "that of the wire's file, for its length, diameter and circuit, and no warmer than 140 C"
    derived = {"kind": "derived", "source": source, "note": ""}
    return wire.model_copy(update={
        name: getattr(wire, name).model_copy(update={"value": value, **derived})
        for name, value in changed.items()
        if value != wire[name]
    })  # fmt: skip


def voltages_of_circuit(
    given: GivenVoltages,
    wire: str,
    *,
    wire_length_m: float,
    shunt_ohm: float,
    ambient_temperature_k: float,
    loss_factor: float = 1.0,
) -> tuple[float, float]:
    """Return amplitude and highest voltage [V] of a real wire whose rig file states both, one or neither.

    A highest voltage that follows from the wire holds it at 150 C at most, however long it stays on. Raises CallerError
    for an unknown wire or a wrong wire file.
    """
    hot = hot_wire_on(wire, wire_length_m, shunt_ohm, ambient_temperature_k)
    hot = hot._replace(convection_factor=loss_factor * hot.convection_factor)
    amplitude_v, maximum_v = completed(given, own_voltages(wire), hot)
    if given.maximum_v is None and ambient_temperature_k < OVERHEATED_K:
        maximum_v = max(amplitude_v, min(maximum_v, rounded_down_v(holding_voltage_v(hot, OVERHEATED_K))))
    return amplitude_v, maximum_v


def hot_wire_on(wire: str, wire_length_m: float, shunt_ohm: float, ambient_temperature_k: float) -> HotWire:
    """Return the heat balance of a wire, by name or wire file, behind a shunt. Raises CallerError as load_wire."""
    known = load_wire(wire)
    return hot_wire(
        known,
        load_alloy(known.alloy),
        wire_length_m=wire_length_m,
        series_ohm=shunt_ohm,
        ambient_temperature_k=ambient_temperature_k,
    )


class OwnCircuit(NamedTuple):
    """What a wire is given on a board; the voltages are those of a rig file that states none."""

    lasting_current_a: float  # settles the wire at 150 C at most in still air
    shunt_ohm: float  # reads that current within 250 mV
    sense_voltage_v: float
    amplitude_v: float
    maximum_v: float
    pretension_n: float  # vendor's force for stretching the cold wire, of all legs together


def own_circuit(wire: str, *, wire_length_m: float, legs: int = 2, ambient_temperature_k: float = 295.15) -> OwnCircuit:
    """Return what a wire, by name or wire file, is given on a board.

    Raises CallerError for an unknown wire, a wrong wire file, or air in which no current settles it at 150 C.
    """
    if not ambient_temperature_k < OVERHEATED_K:
        raise CallerError(f"air of {ambient_temperature_k:g} K leaves a wire no current: it is to stay below 150 C")
    bare = hot_wire_on(wire, wire_length_m, 0.0, ambient_temperature_k)
    lowest, highest = austenite_ohm(bare, OVERHEATED_K)
    # A current heats a stretched wire most; a voltage sends more through a contracted one, and the shunt reads that.
    loss = bare.heat.power_w(OVERHEATED_K)
    shunt_ohm = shunt_for(math.sqrt(loss / lowest))
    amplitude_v, maximum_v = voltages_of_circuit(
        GivenVoltages(),
        wire,
        wire_length_m=wire_length_m,
        shunt_ohm=shunt_ohm,
        ambient_temperature_k=ambient_temperature_k,
    )
    return OwnCircuit(
        lasting_current_a=math.sqrt(loss / highest),
        shunt_ohm=shunt_ohm,
        sense_voltage_v=rounded_down_v(SENSE_FRACTION * amplitude_v),
        amplitude_v=amplitude_v,
        maximum_v=maximum_v,
        pretension_n=round(legs * load_wire(wire)["nominal_force_n"], 3),
    )


def shunt_for(current_a: float) -> float:
    """Return the largest usual shunt [ohm] that reads a current within the boards' range."""
    largest = READABLE_FRACTION * SHUNT_RANGE_V / current_a
    decade = 10.0 ** math.floor(math.log10(largest))
    return float(f"{max(step for step in SHUNT_STEPS if step * decade <= largest) * decade:.3g}")
