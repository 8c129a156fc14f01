"""A wire of grains as tests use it: built from plain numbers, moved on by drives, temperatures or stresses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from grain_wire import paths
from grain_wire.numbers import CONSTANTS, STATE, Load, body, convection_table, from_alloy, record, spread_grains, spring
from grain_wire.numbers import surroundings as surroundings_of
from grain_wire.paths import Grip, Pair
from grain_wire.stepping import TWENTY_DEGC_K, resistance_ohm, total_strain
from grain_wire.switching import Array, Grains, cool_from_hot


class GrainPath(NamedTuple):
    """Response to a drive, each (n_samples,): means over each sample, then the true state at its end."""

    wire_voltage_v: Array
    shunt_voltage_v: Array
    displacement_m: Array
    force_n: Array
    temperature_k: Array
    stress_pa: Array
    martensite_fraction: Array
    r_phase_fraction: Array
    resistance_ohm: Array


class GrainWalk(NamedTuple):
    """Response to prescribed temperatures and stresses, each (n_points,); strain from stress-free austenite."""

    strain: Array
    resistance_ohm: Array
    martensite_fraction: Array
    r_phase_fraction: Array


class GrainWire:
    """A wire of grains on its load, cold and at rest at first; its methods move it on.

    ``state`` and ``constants`` are arrays of one record, (1,), with the fields of ``numbers.STATE`` and ``CONSTANTS``.
    """

    def __init__(self, state: Any, constants: Any, grains: Grains, convection: Array, load_n: Array) -> None:
        """Take the parts of a wire, which this object owns from now on."""
        self.state, self.constants, self.grains = state, constants, grains
        self._convection, self._load_n = convection, load_n

    @property
    def parts(self) -> tuple[Any, ...]:
        """What compiled code takes."""
        return self.state, self.constants, self.grains, self._convection, self._load_n

    def copy(self) -> GrainWire:
        """Return an independent wire in the same state."""
        grains = Grains(*(np.copy(item) for item in self.grains))
        return GrainWire(self.state.copy(), self.constants.copy(), grains, self._convection, self._load_n)

    def with_edges(self, edges: Array) -> GrainWire:
        """Return the wire at rest with grains of equal weight between other edges, in units of the spread, (n + 1,)."""
        nothing = np.zeros(edges.size - 1)
        grains = Grains(edges, 0.5 * (edges[1:] + edges[:-1]), np.diff(edges), nothing, nothing.copy(), np.zeros(7))
        changed = GrainWire(record(STATE), self.constants.copy(), grains, self._convection, self._load_n)
        settle(changed)
        return changed

    def value(self, name: str) -> float:
        """Return a number of the state or of the constants."""
        return float(self.state[name][0] if name in STATE else self.constants[name][0])

    def drive(self, drives: Any, dt_s: float, steps: int, *, regulated_current: bool = False) -> GrainPath:
        """Hold each drive [V], or each regulated current [A], for some steps."""
        held = np.ascontiguousarray(drives, dtype=np.float64)
        return GrainPath(*paths.drive(self.parts, held, dt_s, steps, regulated_current))

    def walk(self, temperature_k: Any, stress_pa: Any) -> GrainWalk:
        """Take the grains through temperatures and stresses, without heat balance and load."""
        kelvin, pascal = np.broadcast_arrays(np.asarray(temperature_k, float), np.asarray(stress_pa, float))
        return GrainWalk(*paths.walk(self.parts, np.ascontiguousarray(kelvin), np.ascontiguousarray(pascal)))

    def cool(self, temperature_k: float, stress_pa: float) -> None:
        """Make the grains those of a wire cooled from hot to a temperature under a stress."""
        cool_from_hot(self.grains, self.constants[0], temperature_k, stress_pa)


def grain_wire(
    material: Mapping[str, float],
    spool: Mapping[str, float],
    bench: Mapping[str, float],
    *,
    load: Load | Any = None,
    grains: int = 160,
    new_wire: bool = False,
    guide_friction: bool = True,
    work: bool = False,
) -> GrainWire:
    """Return a wire at rest from plain numbers by name; ``load`` replaces the bench's spring.

    With ``work`` the wire pays for the work that it does on the load out of its heat, and takes back what it is given.
    """
    attached = load or spring(bench["spring_stiffness_n_per_m"])
    constants = record(
        CONSTANTS,
        **from_alloy(material, spool, new_wire),
        **body(material, spool, bench),
        **surroundings_of(spool, bench, attached, guide_friction),
        work_share=1.0 if work else 0.0,
    )
    wire = GrainWire(
        record(STATE),
        constants,
        spread_grains(grains, material),
        convection_table(spool["diameter_m"], bench["ambient_temperature_k"]),
        np.stack((attached.force_n, attached.friction_n)),
    )
    settle(wire)
    return wire


def settle(wire: GrainWire) -> None:
    """Cool a wire from hot to the air under its pretension; contraction counts from there."""
    c, state = wire.constants[0], wire.state
    stress, ambient = c.pretension_n / (c.legs * c.area_m2), c.ambient_temperature_k
    wire.cool(ambient, stress)
    martensite, r_phase = float(wire.grains.martensite.mean()), float(wire.grains.r_phase.mean())
    cold = total_strain(c, stress, martensite, r_phase, ambient)
    wire.constants["cold_strain"] = cold
    wire.constants["austenite_length_m"] = c.wire_length_m / (1.0 + cold)
    transformed = martensite + c.r_phase_entropy_ratio * r_phase
    at_rest = {
        "temperature_k": ambient,
        "stress_pa": stress,
        "enthalpy_j": c.heat_capacity_j_per_k * (ambient - TWENTY_DEGC_K) - c.latent_heat_j * transformed,
        "martensite_fraction": martensite,
        "r_phase_fraction": r_phase,
        "resistance_ohm": resistance_ohm(wire.constants[0], stress, martensite, r_phase, ambient, 1.0),
        "capacity_j_per_k": c.heat_capacity_j_per_k,
    }
    for name, value in at_rest.items():
        state[name] = value


def drive_pair(
    first: GrainWire, second: GrainWire, pair: Pair, grip: Grip | None, drives: Sequence[float], dt_s: float, steps: int
) -> Array:
    """Drive two wires that meet; return the means over each sample, (7, n_samples).

    In order: voltages of terminals and shunt, displacement and force of the first wire and of the second, the grip's
    force.
    """
    between = grip or Grip(0.0, 0.0, 1.0, np.zeros(2), np.zeros(2), np.zeros(2))
    held = np.ascontiguousarray(drives, dtype=np.float64)
    return paths.drive_pair(first.parts, second.parts, pair, between, held, dt_s, steps)
