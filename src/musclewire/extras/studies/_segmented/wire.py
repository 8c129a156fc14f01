"""A wire in segments on its spring, in Python: built from parameters, surrounded by conditions, advanced by samples."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.studies._segmented.conditions import Conditions
from musclewire.extras.studies._segmented.kernel import SegmentPlace, SegmentSums, advance_segments
from musclewire.extras.studies._segmented.structure import WireStructure, fin_length_m
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.wire import (
    CHOSEN,
    WireState,
    are_resolved,
    constants_of,
    convection_table,
    measured_grains,
    plan_of,
    require_resolved,
    resting_state,
    total_strain,
)

# Half of it changes resistance and strain by less than the instruments show (tests/extras/studies/unit/segmented).
DEFAULT_STEP_S = 2.5e-3
# The ends of a clamped wire are resolved at the convection of a wire this much above the air.
WARM_K = 70.0
# Another table of convection is looked up when the air has changed by as much.
SAME_AIR_K = 2.0


class SegmentMeans(NamedTuple):
    """Means over a sample, as averaging instruments measure them: [V], [V], [m], [N], and strain."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float
    strain: float


class SegmentedState(NamedTuple):
    """The true state of a wire in segments, for judging a result and never for an estimator."""

    time_s: float
    temperature_k: float  # mean over the length
    hottest_temperature_k: float
    coldest_temperature_k: float
    resistance_ohm: float
    cycles: float
    # Displacement of the connector over the leg's length now, from the zero of the bench; positive when contracted.
    strain: float
    mean_strain: float  # over the last sample: what an ideal displacement sensor would have read
    stress_pa: float  # of a leg
    force_n: float  # of all legs
    martensite_fraction: float  # volume fractions, means over the length
    r_phase_fraction: float
    segment_temperatures_k: FloatArray  # (n_segments,)


class SegmentedWire:
    """A wire in segments on a spring with a guide, cold and at rest at first; ``step_s`` is the longest step."""

    def __init__(
        self,
        alloy: Alloy,
        wire: Wire,
        bench: Bench,
        structure: WireStructure,
        step_s: float = DEFAULT_STEP_S,
    ) -> None:
        """Cool the wire under its pretension."""
        if not 0.0 < step_s < math.inf:
            raise CallerError(f"a step of {step_s} s cannot be: give a positive number of seconds")
        self.structure, self.step_s = structure, step_s
        self._spool, self._bench = wire.values(), bench.values()
        self.constants = constants_of(
            alloy.values(),
            self._spool,
            self._bench,
            distribution=structure.grains or measured_grains(alloy),
            classes=structure.classes,
        )
        derived, self._cells, self._load = self.constants.step_arrays()
        self._air_k = float(self.constants.ambient_temperature_k)
        self._mean_strain, self._aged = 0.0, (0.0, 1.0, 0.0)
        self._weights = structure.fractions(self._end_fraction())
        self._places = self._placed()
        # The load is the wire's as a whole: of their own the segments have none.
        self._on_load: Any = derived.copy()
        self._derived: Any = np.repeat(derived, structure.n_segments)
        self._derived["pretension_n"] = self._derived["spring_n"] = self._derived["friction_n"] = 0.0
        self._derived["surface_factor_m2"] *= structure.along("convection_factors", 1.0)
        for name in ("martensite_temperature_k", "r_phase_temperature_k"):
            self._derived[name] += structure.along("temperature_shifts_k", 0.0)
        self._states, self._whole = self._at_rest()
        self._trials = self._states.copy()
        self._sums: Any = np.zeros(1, SegmentSums.layout())
        self._sums["hottest_k"] = self._air_k
        self._own = self._derived.copy()
        self.surround(Conditions())

    def _at_rest(self) -> tuple[Any, WireState]:
        """Return the segments, (n_segments,), and the whole wire, cooled under the pretension: its zero is there."""
        constants = self.constants
        kept = ("martensite_temperature_k", "r_phase_temperature_k")
        cold = [resting_state(constants.replace(**{name: float(own[name]) for name in kept})) for own in self._derived]
        states: Any = np.concatenate([state.row for state in cold])
        phases = states["martensite_fraction"], states["r_phase_fraction"]
        strains = [
            total_strain(constants.derived.record, one.stress_pa, martensite, r_phase, one.temperature_k)
            for one, martensite, r_phase in zip(cold, *phases, strict=True)
        ]
        self._derived["cold_strain"] = self._weights @ strains
        whole = cold[0].replace(
            **{name: self._weights @ states[name] for name in ("resistance_ohm", "martensite_fraction")},
            r_phase_fraction=self._weights @ phases[1],
        )
        return states, whole

    def _end_fraction(self) -> float:
        """Return how short the segments at clamps are: half of the length over which a clamp cools the wire.

        With 10 segments that leaves 0.3 % of stroke to 200 of them at most; a whole length or a third leave twice that.
        """
        ambient_k, diameter_m = self._air_k, self._spool["diameter_m"]
        convection = convection_coefficient_w_per_m2_k(ambient_k + WARM_K, ambient_k, diameter_m)
        convection *= self._spool["convection_factor"]
        conductivity = self.structure.thermal_conductivity_w_per_m_k
        return 0.5 * fin_length_m(conductivity, diameter_m, convection) / self._bench["wire_length_m"]

    def _placed(self) -> Any:
        """Return the places of the segments, with the conductances between their middles."""
        places = np.zeros(self.structure.n_segments, SegmentPlace.layout())
        places["weight"] = self._weights
        lengths_m = self._weights * self._bench["wire_length_m"]
        conducting = self.structure.thermal_conductivity_w_per_m_k * self.constants.area_m2
        between = conducting / (0.5 * (lengths_m[1:] + lengths_m[:-1]))
        ends = 2.0 * conducting / lengths_m[[0, -1]] if self.structure.clamped else np.zeros(2)
        # As if the whole wire were in a segment's state: each conductance over the segment's part of the length.
        places["before_w_per_k"] = np.concatenate((ends[:1], between)) / self._weights
        places["after_w_per_k"] = np.concatenate((between, ends[1:])) / self._weights
        return places

    def surround(self, conditions: Conditions) -> None:
        """Take other conditions from now on."""
        bench, own, rows = self._bench, self._own, self._derived
        ambient_k = bench["ambient_temperature_k"] if conditions.ambient_k is None else conditions.ambient_k
        self._around = conditions
        self._age()
        load_n = bench["pretension_n"] + conditions.load_force_n + conditions.pretension_force_n
        self._on_load["pretension_n"] = load_n
        self._on_load["spring_n"] = self.constants.derived.spring_n * conditions.stiffness_factor
        rows["surface_factor_m2"] = own["surface_factor_m2"] * conditions.convection_factor
        rows["ambient_temperature_k"] = ambient_k
        if abs(ambient_k - self._air_k) > SAME_AIR_K:
            self._air_k = SAME_AIR_K * round(ambient_k / SAME_AIR_K)
            rows["convection_w_per_m2_k"] = convection_table(self._spool["diameter_m"], self._air_k)

    def _age(self) -> None:
        """Take over what the cycles until now have changed."""
        around, own, rows = self._around, self._own, self._derived
        residual, factor, shift_k = self.structure.ageing.effects(self._whole.cycles)
        factor, shift_k = factor * around.resistance_factor, shift_k + around.transformation_shift_k
        if (residual, factor, shift_k) == self._aged:
            return
        rows["cold_strain"] = own["cold_strain"] - residual
        rows["length_over_area_per_m"] = own["length_over_area_per_m"] * factor
        for name in ("martensite_temperature_k", "r_phase_temperature_k"):
            rows[name] = own[name] + shift_k
        for states in (self._states, self._whole.row):
            states["resistance_ohm"] *= factor / self._aged[1]
        self._aged = (residual, factor, shift_k)

    def advance(self, drive_voltage_v: float, duration_s: float, lead_ohm: float = 0.0) -> SegmentMeans:
        """Advance by a sample, leads in the wire's voltage; NumericsError if a step was not solved or too long."""
        self._age()
        voltage_v, current_a, contraction, stress_pa = advance_segments(
            (self._states, self._trials, self._derived, self._places),
            (self._whole.row, self._on_load, self._cells, self._load),
            self._sums,
            (drive_voltage_v, lead_ohm),
            plan_of(CHOSEN, duration_s),
            self.step_s,
        )
        if not are_resolved(self._whole.row):
            require_resolved(self._whole, CHOSEN, min(self.step_s, duration_s))
        self._mean_strain = contraction
        return SegmentMeans(
            voltage_v,
            current_a * self._bench["shunt_resistance_ohm"],
            contraction * self.leg_length_m,
            stress_pa * self.section_m2,
            contraction,
        )

    @property
    def leg_length_m(self) -> float:
        """Length of a leg [m]."""
        return float(self.constants.leg_length_m)

    @property
    def section_m2(self) -> float:
        """Cross section of all legs [m2]."""
        return float(self.constants.legs * self.constants.area_m2)

    @property
    def time_s(self) -> float:
        """Time since the wire was first at rest [s]."""
        return float(self._whole.time_s)

    @property
    def state(self) -> SegmentedState:
        """The true state now."""
        whole, states, weights = self._whole.record, self._states, self._weights
        temperatures_k = states["temperature_k"].copy()
        return SegmentedState(
            time_s=float(whole["time_s"]),
            temperature_k=float(weights @ temperatures_k),
            hottest_temperature_k=float(temperatures_k.max()),
            coldest_temperature_k=float(temperatures_k.min()),
            resistance_ohm=float(weights @ states["resistance_ohm"]),
            cycles=float(whole["cycles"]),
            strain=float(whole["connector_contraction"]),
            mean_strain=self._mean_strain,
            stress_pa=float(whole["stress_pa"]),
            force_n=float(whole["stress_pa"]) * self.section_m2,
            martensite_fraction=float(weights @ states["martensite_fraction"]),
            r_phase_fraction=float(weights @ states["r_phase_fraction"]),
            segment_temperatures_k=temperatures_k,
        )

    @property
    def sums(self) -> Mapping[str, float]:
        """Energies [J] since the start, counts, the hottest temperature so far [K] and the error of steps [K]."""
        whole, clamps_j = self._whole, float(self._sums["heat_to_clamps_j"][0])
        return {
            "heat_in_j": whole.heat_in_j,
            "heat_to_air_j": whole.heat_out_j - clamps_j,
            "heat_to_clamps_j": clamps_j,
            "hottest_k": float(self._sums["hottest_k"][0]),
            "step_error_k": whole.step_error_k,
            "evaluations": whole.evaluations,
        }

    @property
    def enthalpy_j(self) -> float:
        """Enthalpy of the wire [J], with the heat that the last step still owes."""
        return float(self._weights @ (self._states["enthalpy_j"] + self._states["carried_heat_j"]))

    @property
    def weights(self) -> FloatArray:
        """Fraction of the length of each segment, (n_segments,)."""
        return self._weights.copy()

    def age_like(self, before: SegmentedWire) -> None:
        """Take over clock and cycles from the wire at another pretension."""
        self._whole = self._whole.replace(time_s=before._whole.time_s, cycles=before._whole.cycles)
