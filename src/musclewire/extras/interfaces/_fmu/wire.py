"""The FMU of a simulated wire on its load."""

from __future__ import annotations

from collections.abc import Iterator

from musclewire.errors import CallerError
from musclewire.extras.interfaces._fmu.contents import FmuContents, c_files
from musclewire.extras.interfaces._fmu.finger_header import finger_header
from musclewire.extras.interfaces._fmu.variables import FmuVariables
from musclewire.extras.interfaces._fmu.wire_header import wire_header, wire_tables
from musclewire.extras.interfaces._fmu.wire_variables import wire_variables
from musclewire.rigs import RigConfiguration, open_simulated
from musclewire.wire import OneWire, WireConstants

MODEL_FILE = "mw_wire_model.c"
PARAMETERS_START = (
    "/* Written by musclewire (musclewire export fmu): the parameters that change a wire's constants. */\n"
)


def wire_contents(configuration: RigConfiguration, where: str) -> FmuContents:
    """Return what is in the FMU of a simulated rig's wire. Raises CallerError for a rig with two wires."""
    device = open_simulated(configuration, where, None, None, None, False, {})
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
    if configuration.fault:
        yield "the faults of [[fault]]"
