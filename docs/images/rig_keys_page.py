"""The page reference/rig_files of the site: every key of every kind of rig file, from the schemas that check them."""

from __future__ import annotations

from typing import get_args

from key_tables import default_of, described, first_line, line, meanings, section, type_in_words, unit_in
from pydantic import BaseModel

from musclewire.extras.board import (
    DisplacementInput,
    ForceInput,
    NiDaqConfiguration,
    Output,
    SerialConfiguration,
    VoltageInput,
)
from musclewire.extras.instruments import PulseWidth, SimulatedFault
from musclewire.extras.studies import (
    AgeingTable,
    BarrierTable,
    ConditionsTable,
    GrainsTable,
    InstrumentsTable,
    SegmentedConfiguration,
)
from musclewire.parameters import Bench, Wire, catalogue_names, load_bench, load_wire
from musclewire.rigs import (
    LOAD_PARTS,
    Arriving,
    LimitsTable,
    MountedWire,
    ReplayConfiguration,
    RigConfiguration,
    Surroundings,
)

HEAD = """# Rig files

For those who write a rig file, or look up a key of one. A rig file describes a rig, and every command takes its name
where it takes `simulated`. Numbers are SI, or text with a unit (`"14 cm"`). An unknown key is an error that names the
nearest.

Names stand for included rigs: `simulated`, the paper's V on a spring; `finger`, the bench of its section IV;
`gripper`, two such fingers with foam between them. `ni-pci-6229`, `ni-usb-6001`, `serial-board` and `arduino-uno` are
templates to copy, from `src/musclewire/extras/board/rig_files`.
"""
SECTIONS: dict[str, tuple[type[BaseModel], str]] = {
    "The wire and its circuit": (
        MountedWire,
        "Every rig has these keys, at the top of the file; a simulated one may leave them to its wire and bench.",
    ),
    "`[limits]`": (
        LimitsTable,
        "The limits of the [protection](protection.md) follow from wire and circuit; these keys are for what you know "
        "better. A simulated rig's file takes the same table.",
    ),
    "`[arrives]`": (Arriving, "Of a real rig that gives its wire less than it orders; otherwise the order counts."),
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
SIMULATED: dict[str, tuple[type[BaseModel], str]] = {
    '`kind = "simulated"`': (
        RigConfiguration,
        "The kind of a file that names none. It has the keys of wire and circuit, too; those that are left out have "
        "the wire's and the bench's own value.",
    ),
    "`[surroundings]` of a simulated rig": (
        Surroundings,
        "Still air without it. Convection's dependence on the air's own temperature is not followed while it swings.",
    ),
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
WIRES_HEAD = """## Wires

`wire` is the paper's `paper-100um`, `paper-125um` or `paper-200um`, the finger's `finger-100um`, `isobar-sample`, a
wire of the Flexinol catalogue, or the file of one, relative to the rig file. Sizes of the catalogue, in millimetres:
{sizes}. Each has a name for 70 C wire (`flexinol-0.10-lt`) and for 90 C wire (`flexinol-0.10-ht`). Resistance, forces
and currents are the catalogue's; LT lies 20 K below HT, the one stated difference between them. `musclewire simulate
--list` names all wires.

`bench` is `paper` (a V on a spring), `finger` (the short V of the finger's bench) or `dead-weight` (one straight wire
that lifts a weight, by default 143 g).
"""
SETTINGS_HEAD = """## `[settings]` of a simulated rig

Any number of wire and bench, in SI or as text with a unit. The largest drives, `drive_amplitude_v` and
`maximum_voltage_v`, are for 14 cm behind 1 ohm: another length, diameter or circuit gets what holds it as warm.

| Setting | Unit | Meaning |
|---|---|---|
"""
PARTS_HEAD = """## `[[load]]` of a simulated rig

Each table names a part. Parts act in parallel at the wire's connector and their forces add up; without any it is the
bench's spring.

- One `finger`, one `contact`, and one second wire: `antagonist`, `parallel wire` or `second finger`. A `second
  finger` needs `finger` and `contact`, the object between the two.
- The stage's pretension rests on `pretensioner`, `spring`, `blocked` or `antagonist`. With none of them the finger
  carries it: it is bent before anything is heated. If nothing but weights hangs on the wire, they are the pretension,
  and the stage cannot be moved.
- Parallel wires share pretension and load according to their contraction, and `force_n` is that of both; a wire that
  contracts less may be slack. With an antagonist `force_n` is the first wire's alone.
- `wire_voltage_v` is the voltage between the two terminals that the drive feeds: across both of two parallel wires,
  and across both fingers' wires in series, which need twice the drive. The antagonist's voltage is not included.
- A finger adds the columns `endpoint_displacement_m` and, with a `contact`, `endpoint_force_n`. Beyond the last
  tendon travel of the finger's file the rig stops with the drive off.

| Part | Part key | Unit | Default | Meaning |
|---|---|---|---|---|
"""
FAULTS_HEAD = """## `[[fault]]` of a simulated rig

What may go wrong, at a time, to see what the protection and your script do:

| Fault | Fault keys | What happens |
|---|---|---|
"""


def page() -> str:
    """Return the whole page."""
    real = [keys_section(title, *content) for title, content in SECTIONS.items()]
    simulated = [keys_section(title, *content) for title, content in SIMULATED.items()]
    lists = (SETTINGS_HEAD, setting_rows()), (PARTS_HEAD, part_rows()), (FAULTS_HEAD, fault_rows())
    tables = [head + "\n".join(rows) + "\n" for head, rows in lists]
    return "\n".join([HEAD, *real, *simulated, *tables, WIRES_HEAD.format(sizes=", ".join(catalogue_sizes()))])


def catalogue_sizes() -> list[str]:
    """Return the diameters of the catalogue's wires [mm], as their names have them."""
    return list(dict.fromkeys(name.split("-")[1] for name in catalogue_names()))


def setting_rows() -> list[str]:
    """Return a row for each number of a bench and of a wire."""
    groups = (Bench, load_bench("paper")), (Wire, load_wire("paper-100um"))
    return [
        line((f"`{name}`", item.unit, str(kind.model_fields[name].description)))
        for kind, group in groups
        for name, item in group.items()
    ]


def part_rows() -> list[str]:
    """Return a row for each key of each part of a load."""
    kinds = {name: LOAD_PARTS.find(name) for name in LOAD_PARTS.names()}
    return [
        line((f"`{part}`", f"`{key}`", unit_in(field), default_of(field), meanings(kind)[key].replace("None", "none")))
        for part, kind in kinds.items()
        for key, field in kind.model_fields.items()
        if key != "part"
    ]


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
