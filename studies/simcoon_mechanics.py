"""The mechanics of the simulated wire beside SMADI, the shape-memory law of simcoon, parameters matched.

simcoon (https://github.com/3MAH/simcoon) is a C++ library of constitutive laws under GPL-3.0-or-later: no dependency of
musclewire and no part of its tests. See checks/README.md for how to run this.

Two phases, as SMADI has no R-phase. Under constant stress the wire is cooled and heated; at constant temperature it is
loaded. Exits 1 where parts that can agree do not. Prints a table, or one JSON document with --json.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

try:
    from simcoon import solver
except ImportError:
    sys.exit("simcoon is not installed: `pip install simcoon` beside musclewire, in an environment of its own")

from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire import WireConstants, isobaric_path, total_strain

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/unit/wire"))

from wire_makers import constants

Array = NDArray[np.float64]

STRESSES_MPA = (50.0, 100.0, 200.0)
CALIBRATION_STRESS_MPA = 100.0
HOT_K, COLD_K, STEP_K = 450.0, 280.0, 0.25
LOADING_INCREMENTS = 20
POISSON_RATIO = 0.33
STATE_VARIABLES, MARTENSITE_VARIABLE = 17, 1


class Row(NamedTuple):
    """One comparison; ``tolerance`` is None where the two laws differ by construction."""

    name: str
    simcoon: float
    ours: float
    unit: str
    tolerance: float | None


class Branches(NamedTuple):
    """A cooling and a heating under one stress: temperature, strain from 20 C, martensite."""

    temperature_k: Array
    strain: Array
    martensite: Array


def two_phase_wire() -> WireConstants:
    """Return a wire of round numbers with a symmetric spread and no R-phase."""
    return constants(r_phase_temperature_k=100.0, grain_tail=0.0, grain_skew=0.0)


def smadi_properties(wire: WireConstants) -> list[float]:
    """Return SMADI's 28 properties, in MPa and K, for the wire.

    Its slopes follow from ours and from the barrier's share in stress, dT/dsigma = 1/C -+ dh/dsigma. Its start and
    finish temperatures stand one spread from ours in the middle, with linear hardening.
    """
    middle, spread = wire.martensite_temperature_k, wire.martensite_spread_k
    barrier, barrier_per_pa = wire.martensite_barrier_k, wire.martensite_barrier_per_pa
    per_pa = 1.0 / wire.martensite_stress_rate_pa_per_k
    moduli = [1e-6 * wire.austenite_modulus_pa, 1e-6 * wire.martensite_modulus_pa, POISSON_RATIO, POISSON_RATIO]
    expansions = [wire.austenite_expansion_per_k, wire.martensite_expansion_per_k]
    strains = [wire.strain_at_no_stress, wire.strain_saturated, 1e6 / wire.strain_stress_scale_pa, 0.0]
    slopes = [1e-6 / (per_pa + barrier_per_pa), 1e-6 / (per_pa - barrier_per_pa)]
    cooling, heating = middle - barrier, middle + barrier
    temperatures = [cooling + spread, cooling - spread, heating - spread, heating + spread]
    hardening_and_symmetry = [1.0, 1.0, 1.0, 1.0, CALIBRATION_STRESS_MPA, 0.0, 2.0]
    penalty = [1e-6, 1e-3, 1.0, 1e8]
    return [0.0, *moduli, *expansions, *strains, *slopes, *temperatures, *hardening_and_symmetry, *penalty]


def steps(*targets: tuple[float, float, int]) -> list[Any]:
    """Return simcoon's steps to each (stress in MPa, temperature in K, increments)."""
    return [
        solver.StepMeca(control="stress", value=[stress, 0, 0, 0, 0, 0], T_final=kelvin, ninc=increments)
        for stress, kelvin, increments in targets
    ]


def strain_from_20_degc(wire: WireConstants, strain: Array, martensite: Array) -> Array:
    """Return strains of simcoon, which count expansion from the temperature of the start, from 20 C as ours do."""
    expansion = wire.austenite_expansion_per_k * (1.0 - martensite) + wire.martensite_expansion_per_k * martensite
    return strain + expansion * (HOT_K - REFERENCE_TEMPERATURE_K)


def simcoon_branches(wire: WireConstants, stress_mpa: float) -> Branches:
    """Return the cooling and heating of SMADI. It starts hot, as SMADI starts as austenite."""
    increments = round((HOT_K - COLD_K) / STEP_K)
    path = steps(
        (stress_mpa, HOT_K, LOADING_INCREMENTS), (stress_mpa, COLD_K, increments), (stress_mpa, HOT_K, increments)
    )
    found = solver.solve(path, "SMADI", smadi_properties(wire), STATE_VARIABLES, T_init=HOT_K)
    temperature, strain = found["Temp"], found["Strain"][0]
    martensite = found["Statev"][MARTENSITE_VARIABLE]
    isobaric = slice(LOADING_INCREMENTS - 1, None)
    return Branches(
        temperature[isobaric], strain_from_20_degc(wire, strain, martensite)[isobaric], martensite[isobaric]
    )


def our_branches(wire: WireConstants, stress_mpa: float, temperature_k: Array) -> Branches:
    """Return the cooling and heating of our grains along the same temperatures."""
    path = isobaric_path(wire, 1e6 * stress_mpa, temperature_k)
    return Branches(temperature_k, path.strain, path.martensite_fraction)


def half_transformed_k(branches: Branches) -> tuple[float, float]:
    """Return the temperatures at which half is martensite, on cooling and on heating."""
    coldest = int(branches.temperature_k.argmin())
    temperature, martensite = branches.temperature_k, branches.martensite
    cooling = np.interp(0.5, martensite[: coldest + 1], temperature[: coldest + 1])
    heating = np.interp(0.5, martensite[: coldest - 1 : -1], temperature[: coldest - 1 : -1])
    return float(cooling), float(heating)


def isobaric_rows(wire: WireConstants) -> list[Row]:
    """Return strains, strokes and half-transformation temperatures at each stress, and the slopes between them."""
    rows, halves = [], []
    for stress_mpa in STRESSES_MPA:
        theirs = simcoon_branches(wire, stress_mpa)
        ours = our_branches(wire, stress_mpa, theirs.temperature_k)
        coldest = int(theirs.temperature_k.argmin())
        pair = half_transformed_k(theirs), half_transformed_k(ours)
        halves.append(pair)
        at = f"at {stress_mpa:g} MPa"
        cold = theirs.strain[coldest], ours.strain[coldest]
        hot = theirs.strain[-1], ours.strain[-1]
        rows += [
            Row(f"austenite's strain {at}", hot[0], hot[1], "", 1e-4),
            Row(f"martensite's strain {at}", cold[0], cold[1], "", 1e-4),
            Row(f"stroke {at}", cold[0] - hot[0], cold[1] - hot[1], "", 1e-4),
            Row(f"half transformed on cooling {at}", pair[0][0], pair[1][0], "K", 0.5),
            Row(f"half transformed on heating {at}", pair[0][1], pair[1][1], "K", 0.5),
            Row(
                f"largest difference of fractions {at}",
                float(np.abs(theirs.martensite - ours.martensite).max()),
                0.0,
                "",
                None,
            ),
        ]
    span = STRESSES_MPA[-1] - STRESSES_MPA[0]
    for branch, name in enumerate(("cooling", "heating")):
        slopes = [span / (halves[-1][who][branch] - halves[0][who][branch]) for who in (0, 1)]
        rows.append(Row(f"Clausius-Clapeyron slope, {name}", slopes[0], slopes[1], "MPa/K", 0.3))
    return rows


def loading_rows(wire: WireConstants) -> list[Row]:
    """Return what hot austenite and cold martensite answer to 20 MPa more."""
    more_mpa, low_mpa = 20.0, CALIBRATION_STRESS_MPA
    increments = round((HOT_K - COLD_K) / STEP_K)
    rows = []
    for name, kelvin, martensite in (("austenite", HOT_K, 0.0), ("martensite", COLD_K, 1.0)):
        path = steps(
            (low_mpa, HOT_K, LOADING_INCREMENTS),
            (low_mpa, kelvin, increments),
            (low_mpa + more_mpa, kelvin, LOADING_INCREMENTS),
        )
        found = solver.solve(path, "SMADI", smadi_properties(wire), STATE_VARIABLES, T_init=HOT_K)
        strain = found["Strain"][0]
        theirs = 1e-3 * more_mpa / float(strain[-1] - strain[-1 - LOADING_INCREMENTS])
        elastic = {"austenite": wire.austenite_modulus_pa, "martensite": wire.martensite_modulus_pa}[name]
        rows.append(Row(f"elastic modulus of {name}", theirs, 1e-9 * elastic, "GPa", 1e-3 * 1e-9 * elastic))
        low, high = (
            total_strain(wire.record, 1e6 * stress_mpa, martensite, 0.0, kelvin)
            for stress_mpa in (low_mpa, low_mpa + more_mpa)
        )
        if martensite:
            rows.append(
                Row("stiffness of martensite with H(stress)", theirs, 1e-3 * more_mpa / (high - low), "GPa", None)
            )
    return rows


def main() -> None:
    """Print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    wire = two_phase_wire()
    rows = isobaric_rows(wire) + loading_rows(wire)
    ok = [row.tolerance is None or abs(row.simcoon - row.ours) <= row.tolerance for row in rows]
    if arguments.json:
        print(json.dumps([{**row._asdict(), "ok": holds} for row, holds in zip(rows, ok, strict=True)], indent=2))
    else:
        print(f"{'':46}{'simcoon':>12}{'ours':>12}{'off':>10}{'allowed':>10}")
        for row, holds in zip(rows, ok, strict=True):
            allowed = "any" if row.tolerance is None else f"{row.tolerance:.2g}"
            print(
                f"{row.name:46}{row.simcoon:12.5f}{row.ours:12.5f}{row.simcoon - row.ours:10.1e}{allowed:>10}"
                f" {row.unit}{'' if holds else '  FAILS'}"
            )
    sys.exit(0 if all(ok) else 1)


if __name__ == "__main__":
    main()
