"""The FMU of a simulated wire on its load."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.board import literal, rows
from musclewire.extras.interfaces._fmu.contents import FmuContents, FmuVariable, FmuVariables, c_files
from musclewire.physics import ELASTIC_POISSON_RATIO, REFERENCE_TEMPERATURE_K
from musclewire.rigs import FingerTendon, RigConfiguration, open_simulated
from musclewire.wire import (
    CLASSES,
    MAX_STEP_ERROR_K,
    Field,
    OneWire,
    Row,
    StepConstants,
    StepControl,
    WireConstants,
    WireState,
)

NO_FINGER = "/* Written by musclewire (musclewire export fmu): no finger at the connector. */\n#define MW_FINGER 0\n"
FINGER_START = "/* Written by musclewire (musclewire export fmu): the finger at the connector. */"


def finger_header(tendon: FingerTendon | None) -> str:
    """Return the text of ``mw_finger_numbers.h``."""
    if tendon is None:
        return NO_FINGER
    curve, obstacle = tendon.curve, tendon.obstacle
    numbers = {
        "SLACK_M": tendon.slack_m,
        "START_M": tendon.start_m,
        "OBJECT_N_PER_M": obstacle.stiffness_n_per_m if obstacle else 0.0,
        "CLEARANCE_M": obstacle.clearance_m if obstacle else 0.0,
    }
    lines = [
        FINGER_START,
        "#define MW_FINGER 1",
        f"#define MW_FINGER_POINTS {len(curve.tendon_travel_m)}",
        *(f"#define MW_FINGER_{name} {literal(value)}" for name, value in numbers.items()),
        *column("travel_m", curve.tendon_travel_m),
        *column("endpoint_m", curve.endpoint_displacement_m),
        *column("compliance_m_per_n", curve.endpoint_compliance_m_per_n),
    ]
    return "\n".join([*lines, ""])


def column(name: str, values: Sequence[float]) -> list[str]:
    """Return the definition of a column of the curve."""
    body = "\n".join(f"    {line}" for line in rows(literal(value) for value in values))
    return [f"static const double mw_finger_{name}[MW_FINGER_POINTS] = {{", body, "};"]


# Parameters of a wire that its user may change before it starts. All others follow from them, or from its geometry.
NOT_NEGATIVE = (
    "pretension_n",
    "spring_stiffness_n_per_m",
    "friction_n",
    "convection_factor",
    "martensite_barrier_k",
    "r_phase_barrier_k",
    "r_to_m_barrier_k",
    "r_phase_strain",
    "shakedown_strain",
    "shakedown_resistivity",
    "shakedown_barrier",
)
POSITIVE = (
    "series_resistance_ohm",
    "shunt_resistance_ohm",
    "friction_presliding_m",
    "martensite_temperature_k",
    "martensite_stress_rate_pa_per_k",
    "r_phase_temperature_k",
    "r_phase_stress_rate_pa_per_k",
    "r_phase_entropy_ratio",
    "strain_saturated",
    "strain_stress_scale_pa",
    "austenite_modulus_pa",
    "martensite_modulus_pa",
    "austenite_resistivity_ohm_m",
    "r_phase_resistivity_ohm_m",
    "martensite_resistivity_ohm_m",
    "shakedown_cycles",
    "martensite_spread_k",
    "r_phase_spread_k",
)
SIGNED = (
    "martensite_barrier_per_pa",
    "strain_at_no_stress",
    "austenite_expansion_per_k",
    "martensite_expansion_per_k",
    "austenite_resistivity_per_k",
    "r_phase_resistivity_per_k",
    "martensite_resistivity_per_k",
    "martensite_spread_per_pa",
)
SHOWN = (
    "wire_length_m",
    "leg_length_m",
    "legs",
    "area_m2",
    "surface_m2",
    "heat_capacity_j_per_k",
    "latent_heat_j",
)
# A positive parameter may be changed by this factor: more is a wrong unit.
MAX_CHANGE = 1e3
LARGE = 1e12


def wire_variables(
    constants: WireConstants, stepping: StepControl, maximum_voltage_v: float, *, finger: bool
) -> FmuVariables:
    """Return the variables of a wire, stepped like its rig, whose drive may reach a voltage [V]."""
    of_all = FmuVariables.from_files("wire", *(("finger",) if finger else ()))
    whole = of_all.changed(
        {
            "drive_voltage_v": {"maximum": maximum_voltage_v},
            "ambient_temperature_k": {"start": constants.ambient_temperature_k},
            "step_s": {"start": stepping.fixed_s},
            "tolerance_k": {"start": stepping.temperature_k},
            "resistance_tolerance": {"start": stepping.resistance},
            "strain_tolerance": {"start": stepping.strain},
        }
    ).and_also((*parameters(constants), *derived_parameters(constants)))
    fixed = tuple(variable.name for variable in whole.ordered if variable.role == "fixed")
    at_rest = {one.name: {"starts_with": (*fixed, *one.starts_with)} for one in whole.ordered if one.role == "output"}
    return whole.changed(at_rest)


def parameters(constants: WireConstants) -> Iterator[FmuVariable]:
    """Yield the parameters of wire, load and circuit."""
    for item in WireConstants.fields:
        value = getattr(constants, item.name)
        if item.name in POSITIVE:
            highest = min(value * MAX_CHANGE, 1.0) if item.name == "r_phase_entropy_ratio" else value * MAX_CHANGE
            yield parameter(item, value, value / MAX_CHANGE, highest)
        elif item.name in NOT_NEGATIVE:
            yield parameter(item, value, 0.0, LARGE)
        elif item.name in SIGNED:
            yield parameter(item, value, -LARGE, LARGE)


def parameter(item: Field, value: float, minimum: float, maximum: float) -> FmuVariable:
    """Return the parameter of a field."""
    return FmuVariable(item.name, "fixed", item.meaning, unit_of(item), start=value, minimum=minimum, maximum=maximum)


def derived_parameters(constants: WireConstants) -> Iterator[FmuVariable]:
    """Yield the numbers of the wire that follow from its geometry: they are shown and cannot be changed."""
    for item in WireConstants.fields:
        if item.name in SHOWN:
            yield FmuVariable(item.name, "constant", item.meaning, unit_of(item), start=getattr(constants, item.name))


def unit_of(item: Field) -> str:
    """Return the unit of a field as variables have it."""
    return "" if item.unit == "1" else item.unit


START = """/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Written by musclewire {version} (musclewire export fmu): {what}. */
"""
# Tables are outside the structures: many wires would share them.
TABLES_DECLARED = (
    "extern const mw_wire_constants mw_constants_of_the_wire;",
    "extern const double mw_cells[MW_CLASSES][MW_CELLS][4]; /* cubics of the grains' distribution */",
    "extern const double mw_load_table_n[2][MW_LOAD_POINTS]; /* force and friction over displacement */",
    "extern const double mw_convection_w_per_m2_k[MW_CONVECTION_POINTS]; /* over wall temperature */",
)


def wire_header(constants: WireConstants) -> str:
    """Return the text of ``mw_wire_numbers.h``: structures of the rows, and lengths of the tables."""
    lines = [
        start("rows and numbers of one wire on its load"),
        "#ifndef MW_WIRE_NUMBERS_H",
        "#define MW_WIRE_NUMBERS_H",
        "",
        *(f"#define MW_{name} {value}" for name, value in shared_numbers(constants).items()),
        "",
        *structure("mw_wire_constants", "What does not change while a wire runs.", WireConstants),
        *structure("mw_step_constants", "What a step reads, derived from it.", StepConstants),
        *structure("mw_wire_state", "What a wire remembers from one step to the next.", WireState),
        *TABLES_DECLARED,
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def shared_numbers(constants: WireConstants) -> dict[str, str | int]:
    """Return the numbers that all wires share, and the lengths of a wire's tables."""
    return {
        "REFERENCE_TEMPERATURE_K": literal(REFERENCE_TEMPERATURE_K),
        "ELASTIC_POISSON_RATIO": literal(ELASTIC_POISSON_RATIO),
        "MAX_STEP_ERROR_K": literal(MAX_STEP_ERROR_K),
        "CLASSES": constants.classes,
        "CELLS": constants.distribution_cells.shape[1],
        "LOAD_POINTS": constants.load_table_n.shape[1],
        "CONVECTION_POINTS": len(constants.convection_table_w_per_m2_k),
    }


def wire_tables(constants: WireConstants) -> str:
    """Return the text of ``mw_wire_tables.c``: every number of the wire and its tables."""
    lines = [start("numbers and tables of one wire on its load"), '#include "mw_wire.h"', ""]
    lines += ["const mw_wire_constants mw_constants_of_the_wire = {"]
    for item in own_fields(WireConstants):
        value = getattr(constants, item.name)
        text = literal(value) if item.length is None else braced(value)
        lines.append(f"    .{item.name} = {text},")
    lines += ["};", ""]
    lines += table("mw_cells[MW_CLASSES][MW_CELLS][4]", constants.distribution_cells)
    lines += table("mw_load_table_n[2][MW_LOAD_POINTS]", constants.load_table_n)
    lines += table("mw_convection_w_per_m2_k[MW_CONVECTION_POINTS]", constants.convection_table_w_per_m2_k)
    return "\n".join(lines)


def start(what: str) -> str:
    """Return the first lines of a file."""
    from importlib.metadata import version

    return START.format(version=version("musclewire"), what=what)


def own_fields(row: type[Row]) -> list[Field]:
    """Return the fields of a row that its C structure has: all but tables."""
    return [item for item in row.fields if not isinstance(item.length, int)]


def structure(name: str, meaning: str, row: type[Row]) -> list[str]:
    """Return the C structure of a row."""
    lines = [f"/* {meaning} */", "typedef struct {"]
    for item in own_fields(row):
        length = "" if item.length is None else f"[{'MW_CLASSES' if item.length == CLASSES else '6 * MW_CLASSES'}]"
        lines.append(f"    double {item.name}{length}; /* {item.unit}: {item.meaning} */")
    return [*lines, f"}} {name};", ""]


def table(declared: str, values: FloatArray) -> list[str]:
    """Return the definition of a table."""
    body = rows(inner(np.asarray(values)))
    return [f"const double {declared} = {{", *(f"    {line}" for line in body), "};", ""]


def inner(values: FloatArray) -> Iterable[str]:
    """Return the initialisers of the first dimension of a table."""
    return [finite(value) for value in values.tolist()] if values.ndim == 1 else [braced(row) for row in values]


def braced(values: FloatArray | Sequence[float]) -> str:
    """Return an initialiser in braces."""
    return f"{{{', '.join(inner(np.asarray(values)))}}}"


def finite(value: float) -> str:
    """Return a finite number as a C literal."""
    assert math.isfinite(value)  # every number of a wire has been checked
    return literal(value)


MODEL_FILE = "mw_wire_model.c"
PARAMETERS_START = (
    "/* Written by musclewire (musclewire export fmu): the parameters that change a wire's constants. */\n"
)


def wire_contents(configuration: RigConfiguration, where: str) -> FmuContents:
    """Return what is in the FMU of a simulated rig's wire. Raises CallerError for a rig with two wires."""
    device = open_simulated(configuration, where)
    if not isinstance(device.wires, OneWire):
        raise CallerError(f"{where} has two wires, and an FMU is of one: export a rig without the second")
    constants, tendon = device.wires.constants, device.mechanism.tendon
    variables = wire_variables(
        constants, device.stepping, device.facts.limits.maximum_voltage_v, finger=tendon is not None
    )
    sources = {
        **c_files("c_wire"),
        MODEL_FILE: c_files("c_fmu")[MODEL_FILE],
        "mw_finger_numbers.h": finger_header(tendon),
        "mw_wire_numbers.h": wire_header(constants),
        "mw_wire_tables.c": wire_tables(constants),
        "mw_wire_parameters.h": parameters_header(variables),
    }
    return FmuContents(
        title=f"shape-memory-alloy wire {configuration.wire} on its load, simulated",
        variables=variables,
        sources=sources,
        step_s=device.facts.sample_period_s,
        owners=("caller", "numerics"),
        left_out=tuple(left_out(configuration)),
    )


def parameters_header(variables: FmuVariables) -> str:
    """Return the text of ``mw_wire_parameters.h``: which variable changes which of a wire's constants."""
    known = {item.name for item in WireConstants.fields}
    rows = [
        f"TAKE({variable.name}, MW_REAL_{variable.name.upper()})"
        for variable in variables.ordered
        if variable.role == "fixed" and variable.name in known
    ]
    body = " \\\n".join(f"    {row}" for row in rows)
    return f"{PARAMETERS_START}#define MW_WIRE_PARAMETERS(TAKE) \\\n{body}\n"


def left_out(configuration: RigConfiguration) -> Iterator[str]:
    """Yield what the rig has and the FMU has not."""
    yield "noise, steps and ranges of the instruments: voltages, displacement and force are true"
    yield "the protection: a drive outside the rig's range is refused, and nothing is switched off"
    if not configuration.surroundings.still:
        yield "the moving air of [surroundings]: ambient_temperature_k and convection_ratio are inputs"
    for key in configuration.offered_keys().values():
        yield f"the {key.what} of {key.written}"
