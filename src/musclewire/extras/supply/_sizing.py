"""Sizing a wire's supply before anything is wired: the effect of a supply on the wire, and the supply it needs.

A simulated drive under a dead weight or on a spring, its numbers, and the parts with which the same wire would
contract in one second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, argument
from musclewire.experiment import (
    ALWAYS,
    OnSample,
    PulseTrain,
    drive_wire,
    friction_warnings,
    pulses_of,
    step_warnings,
)
from musclewire.extras.supply._catalogue_check import PULL_STRESS_PA, UNCOUNTED_STRAIN, run_catalogue_test
from musclewire.extras.supply._one_second import OneSecondDrive, one_second_current, relaxation_time_s
from musclewire.extras.supply._wire_table import ShuntChoice, rated_shunt
from musclewire.identify import extrapolation_warnings
from musclewire.parameters import (
    Bench,
    CatalogueRow,
    Wire,
    catalogue_names,
    catalogue_row,
    class_of,
    load_alloy,
    load_bench,
    load_wire,
    require_seed,
)
from musclewire.rigs import (
    OVERHEATED_K,
    LimitsTable,
    OwnCircuit,
    RigConfiguration,
    StatedCircuit,
    confirmed_beyond,
    open_rig,
    own_circuit,
    refuse_beyond_catalogue,
    with_settings,
)
from musclewire.signals import Recording
from musclewire.wire import HeatBalance

BENCH = "dead-weight"
DEFAULT_LENGTH_M = 0.14
# The fate of the wire is to be shown: a protection that switches off before would hide it.
SIZING_LIMITS = LimitsTable(maximum_temperature=1e9, resistance_low=1e-6, resistance_high=1e6, jump_share=1.0)
# Dynalloy, Technical Characteristics of Flexinol Actuator Wires (F1140): melting point 1300 C.
MELTING_K = 1573.15
AMBIENT_K = 295.15
# The shunt of the paper's bench, for a request without one.
PAPER_SHUNT_OHM = 1.0
# After switching off the larger of these currents remains for measuring:
SENSE_FRACTION = 0.01  # of the drive's current, whose heat is 1/10000 of the drive's
MIN_SENSE_A = 1.5e-3  # [A] that resistance needs to be measured
# Voltage limit of a current source over the voltage of the cold wire.
SOURCE_HEADROOM = 1.5
# Input ranges a card or a divider in front of it may have.
RANGES_V = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 10000.0)
RELAXING_MULTIPLE = 1.25  # of the time the wire takes to relax: the cooling of a run
MIN_COOLING_S = 1.0  # [s], bounds of that
MAX_COOLING_S = 120.0


@dataclass(frozen=True)
class SupplyRequest:
    """A wire, its load and its drive; None is chosen.

    Without supply and current, a wire of the catalogue gets the catalogue's one-second current.
    """

    wire: str
    supply_v: float | None = None
    current_a: float | None = None
    on_s: float = 1.0
    duty: float | None = None  # with it the drive is a square wave until ``on_s``, on for this fraction of each period
    duty_period_s: float = 1.0
    duration_s: float | None = None
    length_m: float = DEFAULT_LENGTH_M
    load_n: float | None = None  # the weight, or the pretension of the spring; without it ``stress_pa`` sets it
    stress_pa: float | None = None
    spring_n_per_m: float = 0.0
    shunt_ohm: float | None = None
    ambient_k: float = AMBIENT_K
    seed: int = 1


@dataclass(frozen=True)
class SupplyPlan:
    """A request with everything chosen, and the rig it needs."""

    request: SupplyRequest
    wire: Wire
    row: CatalogueRow | None
    current_a: float | None
    supply_v: float | None
    load_n: float
    shunt_ohm: float
    duration_s: float
    configuration: RigConfiguration

    @property
    def pulses(self) -> PulseTrain:
        """The square wave of the drive; one without pauses if no duty was given."""
        return requested_pulses(self.request)


@dataclass(frozen=True)
class DriveNumbers:
    """Results of a recorded drive, from the instruments; only the temperature is known from the simulation alone."""

    contraction: float
    max_contraction: float
    final_contraction: float
    last_period_lowest: float
    last_period_highest: float
    contracted_s: float | None
    cooling_s: float | None
    current_mean_a: float
    current_peak_a: float
    voltage_peak_v: float
    power_peak_w: float
    power_end_w: float
    energy_j: float
    temperature_peak_k: float

    @property
    def melted(self) -> bool:
        """Whether the wire exceeded its melting point, so that the simulation is meaningless."""
        return self.temperature_peak_k > MELTING_K


@dataclass(frozen=True)
class SupplySizing:
    """The simulated drive, and the parts with which the same wire contracts in one second."""

    plan: SupplyPlan
    recording: Recording
    numbers: DriveNumbers
    settled_k: float
    one_second: OneSecondDrive
    shunt: ShuntChoice
    warnings: tuple[str, ...]

    @property
    def supply_needed_v(self) -> float:
        """Supply [V] for the one-second current through the wire and the suggested shunt."""
        return self.one_second.wire_voltage_v + self.one_second.current_a * self.shunt.resistance_ohm


def requested_pulses(request: SupplyRequest) -> PulseTrain:
    """Return the square wave that a request asks for. Raises CallerError for one that samples cannot make."""
    if request.duty is None:
        return ALWAYS
    return pulses_of(request.duty, request.duty_period_s, load_bench(BENCH).sample_period_s.value)


def plan_supply(request: SupplyRequest) -> SupplyPlan:
    """Return the request with everything chosen. Raises CallerError if it is inconsistent."""
    wire = load_wire(request.wire)
    row = catalogue_row(request.wire) if request.wire in catalogue_names() else None
    require_plausible(request)
    load = load_of(request, wire)
    current = current_of(request, row)
    cold_ohm = wire.resistance_per_metre_ohm_per_m.value * request.length_m
    expected = current if current is not None else (request.supply_v or 0.0) / cold_ohm
    shunt = own_circuit_of(request).shunt_ohm if request.shunt_ohm is None else request.shunt_ohm
    settings: dict[str, float | str] = {
        "wire_length_m": request.length_m,
        "pretension_n": load,
        "spring_stiffness_n_per_m": request.spring_n_per_m,
        "shunt_resistance_ohm": shunt,
        "ambient_temperature_k": request.ambient_k,
        **drive_settings(request.supply_v, expected, cold_ohm + shunt),
    }
    configuration = RigConfiguration(
        wire=request.wire,
        bench=BENCH,
        seed=request.seed,
        settings=settings,
        limits=SIZING_LIMITS,
        beyond_catalogue=True,
    )
    duration = request.duration_s or chosen_duration_s(request, configuration, current)
    return SupplyPlan(request, wire, row, current, request.supply_v, load, shunt, duration, configuration)


def own_circuit_of(request: SupplyRequest) -> OwnCircuit:
    """Return what the wire of a request is given on a board."""
    return own_circuit(request.wire, wire_length_m=request.length_m, ambient_temperature_k=request.ambient_k)


def current_of(request: SupplyRequest, row: CatalogueRow | None) -> float | None:
    """Return the current to hold [A]: given, or the catalogue's; None for a supply. CallerError without any."""
    if request.current_a is not None or request.supply_v is not None:
        return request.current_a
    if row is None:
        raise CallerError(
            f"{request.wire} is not in the catalogue: give " + argument("supply_v") + " or " + argument("current_a")
        )
    return row.current_a


def load_of(request: SupplyRequest, wire: Wire) -> float:
    """Return the load [N]: given, or from the stress. Raises CallerError near the breaking force."""
    stress = PULL_STRESS_PA if request.stress_pa is None else request.stress_pa
    load = stress * section_m2(wire) if request.load_n is None else request.load_n
    if load > wire.maximum_force_n.value:
        raise CallerError(
            f"a load of {load:.3g} N is above {wire.maximum_force_n.value:.3g} N, near the breaking force of "
            f"{wire.name}: a lighter load, or a thicker wire"
        )
    return load


def drive_settings(supply_v: float | None, expected_a: float, circuit_ohm: float) -> dict[str, float]:
    """Return the rig's voltages: highest, sense voltage and a range of the converter that holds the highest."""
    highest = supply_v or SOURCE_HEADROOM * expected_a * circuit_ohm
    sense = max(SENSE_FRACTION * expected_a, MIN_SENSE_A) * circuit_ohm
    if sense >= highest:
        raise CallerError(f"{highest:g} V is not above the {sense:.2g} V needed to measure this wire: give more")
    return {
        "maximum_voltage_v": highest,
        "sense_voltage_v": sense,
        "acquisition_range_v": next((size for size in RANGES_V if size >= highest), highest),
    }


def section_m2(wire: Wire) -> float:
    """Return a wire's section."""
    return 0.25 * math.pi * wire.diameter_m.value**2


def require_plausible(request: SupplyRequest) -> None:
    """Raise CallerError for impossible numbers."""
    require_seed(request.seed)
    requested_pulses(request)
    if request.load_n is not None and request.stress_pa is not None:
        raise CallerError("give the load or the stress, not both: one follows from the other")
    positive = {"length": request.length_m, "shunt": request.shunt_ohm, "supply": request.supply_v,
                "current": request.current_a, "time until switching off": request.on_s}  # fmt: skip
    for name, value in positive.items():
        if value is not None and not 0.0 < value < math.inf:
            raise CallerError(f"{name} is {value:g}: it must be above 0")
    if not confirmed_beyond():
        stated = {"wire_length": request.length_m, "maximum_voltage": request.supply_v}
        refuse_beyond_catalogue(StatedCircuit(request.length_m, request.shunt_ohm or PAPER_SHUNT_OHM, stated), {})
    if request.duration_s is not None and request.duration_s < request.on_s:
        raise CallerError(
            f"the run of {request.duration_s:g} s ends before switching off at {request.on_s:g} s: a longer run, or "
            "off earlier"
        )


def chosen_duration_s(request: SupplyRequest, configuration: RigConfiguration, current_a: float | None) -> float:
    """Return the duration of a run if none was given: until the wire has relaxed, and somewhat longer."""
    wire, bench = with_settings(load_wire(request.wire), load_bench(BENCH), configuration.settings, "simulate")
    drive = current_a if current_a is not None else request.supply_v or 0.0
    relaxing = relaxation_time_s(
        load_alloy(wire.alloy),
        wire,
        bench,
        drive,
        request.on_s,
        regulated_current=current_a is not None,
        max_s=MAX_COOLING_S / RELAXING_MULTIPLE,
    )
    return math.ceil(request.on_s + max(RELAXING_MULTIPLE * relaxing, MIN_COOLING_S))


def size_supply(
    request: SupplyRequest,
    *,
    path: str | Path | None = None,
    overwrite: bool = False,
    on_sample: OnSample | None = None,
) -> SupplySizing:
    """Run the drive on the simulated rig and return its results, with the parts the wire needs."""
    plan = plan_supply(request)
    wire, bench = with_settings(plan.wire, load_bench(BENCH), plan.configuration.settings, "simulate")
    best = usable_one_second_current(wire, bench, request.ambient_k)
    recording = simulated_drive(plan, path, overwrite, on_sample)
    numbers = drive_numbers(recording, request.on_s, best.stroke, plan.pulses.period)
    alloy, factor = load_alloy(wire.alloy), wire["convection_factor"]
    heat = HeatBalance.of_wire(alloy, wire["diameter_m"], request.length_m, request.ambient_k, factor)
    settled = heat.steady_k(numbers.power_end_w)
    shunt = rated_shunt(own_circuit_of(request), best.current_a)
    warnings = (
        *warnings_for(plan, numbers, settled),
        *(() if numbers.melted else extrapolation_warnings(recording)),
        *friction_warnings(recording),
        *step_warnings(recording),
    )
    return SupplySizing(plan, recording, numbers, settled, best, shunt, warnings)


def simulated_drive(
    plan: SupplyPlan, path: str | Path | None, overwrite: bool, on_sample: OnSample | None
) -> Recording:
    """Return the recording of the planned drive on the simulated rig."""
    with open_rig(plan.configuration) as rig:
        return drive_wire(
            rig,
            on_s=plan.request.on_s,
            duration_s=plan.duration_s,
            supply_v=plan.supply_v,
            current_a=plan.current_a,
            pulses=plan.pulses,
            path=path,
            overwrite=overwrite,
            on_sample=on_sample,
        )


def usable_one_second_current(wire: Wire, bench: Bench, ambient_k: float) -> OneSecondDrive:
    """Return the one-second current. Raises CallerError for a wire already contracted at ambient temperature."""
    best = one_second_current(load_alloy(wire.alloy), wire, bench)
    if best.stroke <= UNCOUNTED_STRAIN:
        raise CallerError(
            f"{wire.name} at {ambient_k - 273.15:g} C under this load has only {100 * best.stroke:.2g} % of "
            "contraction left: it is practically contracted; a cooler place or a larger load stretches it"
        )
    return best


def drive_numbers(recording: Recording, on_s: float, stroke: float, period_samples: int = 1) -> DriveNumbers:
    """Return the numbers of a recorded drive whose first sample was cold and which was then on for ``on_s``.

    With pulses, ``power_end_w`` is the mean over the last of their periods, and the wire moves between
    ``last_period_lowest`` and ``last_period_highest`` in it; without pulses both are the contraction at the end.
    """
    period = recording.facts.sample_period_s
    time_s, moved_m = recording["time_s"] - period, recording["displacement_m"]
    contraction = (moved_m - moved_m[0]) / recording.facts.leg_length_m
    current = recording["shunt_voltage_v"] / recording.facts.shunt_resistance_ohm
    power = recording["wire_voltage_v"] * current
    on = (time_s > 1e-9) & (time_s <= on_s + 1e-9)
    end = int(np.flatnonzero(on)[-1])
    last_period = slice(max(end - period_samples + 1, 1), end + 1)
    return DriveNumbers(
        contraction=float(contraction[end]),
        max_contraction=float(contraction.max()),
        final_contraction=float(contraction[-1]),
        last_period_lowest=float(contraction[last_period].min()),
        last_period_highest=float(contraction[last_period].max()),
        contracted_s=first_time(time_s, contraction >= 0.9 * stroke),
        cooling_s=cooling_time(time_s[end:] - time_s[end], contraction[end:]),
        current_mean_a=float(current[on].mean()),
        current_peak_a=float(current[on].max()),
        voltage_peak_v=float(recording["drive_voltage_v"].max()),
        power_peak_w=float(power[on].max()),
        power_end_w=float(power[last_period].mean()),
        energy_j=float(power[on].sum() * period),
        temperature_peak_k=float(recording["wire_temperature_k"].max()),
    )


def first_time(time_s: FloatArray, reached: NDArray[np.bool_]) -> float | None:
    """Return the first time at which a condition holds, None if it never does."""
    where = np.flatnonzero(reached)
    return float(time_s[where[0]]) if where.size else None


def cooling_time(since_off_s: FloatArray, contraction: FloatArray) -> float | None:
    """Return the time until at most 0.5 % of strain is left; None if there never was more, or there still is."""
    if contraction[0] <= UNCOUNTED_STRAIN:
        return None
    return first_time(since_off_s, contraction <= UNCOUNTED_STRAIN)


def warnings_for(plan: SupplyPlan, numbers: DriveNumbers, settled_k: float) -> list[str]:
    """Return warnings about the drive, the most dangerous first."""
    found = []
    limit = OVERHEATED_K - 273.15
    if numbers.melted:
        found.append(
            f"the wire would have melted (NiTi: {MELTING_K - 273.15:.0f} C): nothing is shown of it, drive it less"
        )
    elif numbers.temperature_peak_k > OVERHEATED_K:
        found.append(
            f"overheated: {numbers.temperature_peak_k - 273.15:.0f} C, above a working limit of {limit:.0f} C "
            "(assumed): less current, or off earlier"
        )
    elif settled_k > OVERHEATED_K:
        found.append(f"left on, it would settle at {settled_k - 273.15:.0f} C, above {limit:.0f} C: switch it off")
    if plan.current_a is not None and numbers.current_peak_a < 0.98 * plan.current_a:
        found.append(
            f"the supply does not reach the requested current: {1e3 * numbers.current_peak_a:.0f} mA at most; a "
            "higher supply"
        )
    return found


def catalogue_side(plan: SupplyPlan) -> dict[str, Any] | None:
    """Return the catalogue's numbers for this wire, with ours in its own test (172 MPa, 1 s); None for other wires."""
    if plan.row is None:
        return None
    alloy, bench = load_alloy(plan.wire.alloy), load_bench(BENCH)
    ours = run_catalogue_test(alloy, plan.wire, bench, plan.row.current_a).cooling_s
    cooling = plan.row.cooling_cell(class_of(plan.request.wire))
    cells = {
        "resistance_ohm_per_m": (plan.row.resistance_ohm_per_m, 1.0),
        "one_second_current_a": (plan.row.current_ma, 1e-3),
        "pull_force_n": (plan.row.pull_force_g, 9.80665e-3),
        "cooling_s": (cooling, 1.0),
    }
    printed = {name: cell.model_copy(update={"value": cell.value * to_si}) for name, (cell, to_si) in cells.items()}
    return {**printed, "test_cooling_s": ours}
