"""The page reference/hardware_rig_files of the site, from the schemas of its rig files, and of simulated faults."""

from __future__ import annotations

from typing import get_args

from key_tables import default_of, described, first_line, meanings, section, type_in_words, unit_in
from pydantic import BaseModel

from musclewire.extras.board import (
    DisplacementInput,
    ForceInput,
    NiDaqConfiguration,
    Output,
    SerialConfiguration,
    VoltageInput,
)
from musclewire.extras.studies import (
    AgeingTable,
    BarrierTable,
    ConditionsTable,
    GrainsTable,
    InstrumentsTable,
    SegmentedConfiguration,
)
from musclewire.rigs import LimitsTable, MountedWire, PulseWidth, ReplayConfiguration, SimulatedFault

HEAD = """# Rig files of real hardware

For those who connect a card or a board. Rig files of the simulated rig are on the page on [files](files.md).

With a wire on a bench one word changes: a command takes the rig file's name instead of `simulated`. Numbers
are SI, or text with a unit (`"14 cm"`). An unknown key is an error that names the nearest. Four files are included as
templates: `ni-pci-6229`, `ni-usb-6001`, `serial-board` and `arduino-uno`, in `src/musclewire/extras/board/rig_files`.
"""
SECTIONS = {
    "The wire and its circuit": (
        MountedWire,
        "Every rig has these keys, at the top of the file; a simulated one may leave them to its wire and bench.",
    ),
    "`[limits]`": (
        LimitsTable,
        "The limits of the [protection](protection.md) follow from wire and circuit; these keys are for what you know "
        "better. A simulated rig's file takes the same table.",
    ),
    '`kind = "serial"`': (SerialConfiguration, "A board with the firmware: [how to](../how-to/drive_a_board.md)."),
    '`kind = "nidaq"`': (NiDaqConfiguration, "A data acquisition card: [how to](../how-to/drive_an_ni_card.md)."),
    "`[output]` of a card": (Output, ""),
    "`[inputs.wire_voltage]` and `[inputs.shunt_voltage]` of a card": (VoltageInput, ""),
    "`[inputs.displacement]` and `[inputs.endpoint_displacement]` of a card": (DisplacementInput, ""),
    "`[inputs.force]` and `[inputs.endpoint_force]` of a card": (ForceInput, ""),
    '`kind = "replay"`': (
        ReplayConfiguration,
        "[A recording as a rig](../how-to/change_the_simulated_rig.md#a-recording-as-a-rig). The keys of wire and "
        "circuit are needed where the recording's metadata lack them.",
    ),
}
SEGMENTED = {
    "`[pwm]` of a simulated rig": (
        PulseWidth,
        "[Heating by pulses](../how-to/change_the_simulated_rig.md#heating-by-pulses), and when the voltages are read.",
    ),
    '`kind = "segmented"`': (
        SegmentedConfiguration,
        "[A simulated wire in segments](../how-to/change_the_simulated_rig.md#a-wire-in-segments). It has the keys "
        "of wire and circuit, too, each by default that of wire or bench.",
    ),
    "`[[grains]]` of a wire in segments": (GrainsTable, ""),
    "`[[barriers]]` of a wire in segments": (BarrierTable, ""),
    "`[ageing]` of a wire in segments": (AgeingTable, ""),
    "`[conditions]` of a wire in segments": (ConditionsTable, ""),
    "`[instruments]` of a wire in segments": (InstrumentsTable, ""),
}
FAULTS_HEAD = """## `[[fault]]` of a simulated rig

What may go wrong, at a time, to see what the protection and your script do:

| Fault | Fault keys | What happens |
|---|---|---|
"""


def page() -> str:
    """Return the whole page."""
    sections = [keys_section(title, *content) for title, content in {**SECTIONS, **SEGMENTED}.items()]
    return "\n".join([HEAD, *sections, FAULTS_HEAD + "\n".join(fault_rows()) + "\n"])


def keys_section(title: str, model: type[BaseModel], text: str) -> str:
    """Return the table of a rig file's keys, without those that every real rig has."""
    shared = (
        set() if model is MountedWire else set(MountedWire.model_fields) - set(vars(model).get("__annotations__", {}))
    )
    # A replay may leave out what a rig must say, but its keys mean the same.
    said = {**described(MountedWire), **meanings(MountedWire), **meanings(model)}
    rows = [
        (f"`{name}`", unit_in(field), default_of(field), said.get(name) or type_in_words(field))
        for name, field in model.model_fields.items()
        if name not in shared
    ]
    return section(title, text, ("Rig key", "Unit", "Default", "Meaning"), rows)


def fault_rows() -> list[str]:
    """Return a row for each fault of a simulated rig."""
    rows = []
    for kind in get_args(get_args(SimulatedFault)[0]):
        name = get_args(kind.model_fields["kind"].annotation)[0]
        keys = [f"`{key}` ({default_of(field)})" for key, field in kind.model_fields.items() if key != "kind"]
        rows.append(f"| `{name}` | {', '.join(keys)} | {first_line(kind)} |")
    return rows
