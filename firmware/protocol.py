"""Write the serial protocol's messages for Python and C from their one definition, and its tables for the site.

    python firmware/protocol.py

The definition is data/protocol.toml in src/musclewire/extras/board/_serial. From it follow message_types.py beside that
folder and firmware/src/messages.h, which a test compares with it, and the tables that the site adds to
docs/reference/firmware_protocol.md.
"""

from __future__ import annotations

import struct
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

ROOT = Path(__file__).resolve().parent.parent
DEFINITION = ROOT / "src/musclewire/extras/board/_serial/data/protocol.toml"
PYTHON = ROOT / "src/musclewire/extras/board/_serial/message_types.py"
HEADER = ROOT / "firmware/src/messages.h"
MONITORS = DEFINITION.with_name("monitors.toml")
MONITORS_HEADER = ROOT / "firmware/src/monitors.h"
# What the firmware reads of a current monitor's row: the members of mw_ina_kind in sense_ina.h.
MONITOR_MEMBERS = (
    *("address_lowest", "address_highest"),
    *("maker_register", "kind_register", "configuration_register", "flags_register", "clear_register"),
    *("maker", "kind", "kind_mask", "settings", "flags_setting", "ready_mask", "overflow_mask"),
    *("shunt_register", "shunt_bytes", "shunt_shift", "bus_register", "bus_bytes", "bus_shift"),
    *("shunt_lowest", "shunt_highest", "shunt_step_v", "bus_step_v"),
)
PAGE = ROOT / "docs/reference/firmware_protocol.md"
# The letters of Python's struct, and the types of Python.
LETTERS = {"u8": "B", "u16": "H", "u32": "I", "f32": "f"}
FROM_BOARD = 0x80
# version, type, sequence, CRC-32
OUTSIDE_THE_PAYLOAD_BYTES = 8


class Part(BaseModel):
    """A part of the definition; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class FieldRow(Part):
    """One field of a payload."""

    name: str
    type: Literal["u8", "u16", "u32", "f32", "text"]
    unit: str
    meaning: str
    bytes: int | None = Field(default=None, ge=1)

    @model_validator(mode="after")
    def _length_with_text(self) -> FieldRow:
        if (self.bytes is None) is (self.type == "text"):
            raise ValueError(f"field {self.name}: a text, and nothing else, has its length in bytes")
        return self

    @property
    def letters(self) -> str:
        """Format characters of the field for Python's struct."""
        return f"{self.bytes}s" if self.type == "text" else LETTERS[self.type]

    @property
    def size(self) -> int:
        """Length in bytes."""
        return struct.calcsize(f"<{self.letters}")


class MessageRow(Part):
    """One type of message."""

    name: str
    number: int = Field(ge=1, le=0xFF)
    sender: Literal["host", "board"]
    does: str
    c_name: str = ""
    type_name: str = Field(default="", alias="class")
    only_with: str = ""
    field: tuple[FieldRow, ...] = ()

    @property
    def in_c(self) -> str:
        """The name in C and on the page, in capitals."""
        return (self.c_name or self.name).upper()

    @property
    def layout(self) -> str:
        """Format of the payload for Python's struct."""
        return "<" + "".join(field.letters for field in self.field)

    @property
    def size(self) -> int:
        """Length of the payload in bytes."""
        return struct.calcsize(self.layout)

    def offsets(self) -> list[tuple[FieldRow, int]]:
        """Return each field with the byte it begins at."""
        return [(field, sum(before.size for before in self.field[:at])) for at, field in enumerate(self.field)]


class ValueRow(Part):
    """One number of an enumeration."""

    name: str
    number: int = Field(ge=0, le=0xFF)
    meaning: str


class EnumerationRow(Part):
    """Numbers that a field may have."""

    name: str
    type_name: str = Field(alias="class")
    c_prefix: str
    meaning: str
    values: tuple[ValueRow, ...]


class Protocol(Part):
    """The whole definition. Raises ValueError for a number or name that is there twice, and for a payload too long."""

    version: int = Field(ge=1, le=0xFF)
    maximum_body_bytes: int
    message: tuple[MessageRow, ...]
    enumeration: tuple[EnumerationRow, ...]

    @model_validator(mode="after")
    def _nothing_twice(self) -> Protocol:
        groups = {"messages": self.message, **{row.name: row.values for row in self.enumeration}}
        groups.update({f"fields of {row.name}": row.field for row in self.message})
        for where, rows in groups.items():
            for key in ("name", "number"):
                found = [getattr(row, key) for row in rows if hasattr(row, key)]
                if len(set(found)) != len(found):
                    raise ValueError(f"{where}: a {key} is there twice")
        for message in self.message:
            if (message.number >= FROM_BOARD) is not (message.sender == "board"):
                raise ValueError(
                    f"message {message.name}: the board's numbers, and only they, begin at {FROM_BOARD:#x}"
                )
            if message.size > self.maximum_body_bytes - OUTSIDE_THE_PAYLOAD_BYTES:
                raise ValueError(f"message {message.name}: {message.size} bytes do not fit into a body")
        return self


def protocol() -> Protocol:
    """Return the definition, checked."""
    return Protocol.model_validate(tomllib.loads(DEFINITION.read_text(encoding="utf-8")))


def python_text(of: Protocol) -> str:
    """Return the text of message_types.py."""
    made = [row for row in of.message if row.type_name]
    parts = [
        '"""Messages of the serial protocol: numbers, fields and layouts.\n\n'
        'Written by `python firmware/protocol.py` from data/protocol.toml; a test holds this file to it.\n"""\n\n'
        "from __future__ import annotations\n\n"
        "import struct\nfrom enum import IntEnum\nfrom typing import NamedTuple\n\n"
        + f"PROTOCOL_VERSION = {of.version}\nMAXIMUM_BODY_BYTES = {of.maximum_body_bytes}\n",
        'class MessageKind(IntEnum):\n    """Types of frames; those of the board have the highest bit set."""\n\n'
        + "".join(f"    {row.name.upper()} = 0x{row.number:02X}\n" for row in of.message),
    ]
    for row in of.enumeration:
        values = "".join(f"    {value.name.upper()} = {value.number}\n" for value in row.values)
        parts.append(f'class {row.type_name}(IntEnum):\n    """{row.meaning}"""\n\n{values}')
    parts += [_named_tuple(row) for row in made]
    layouts = "".join(f'    MessageKind.{row.name.upper()}: struct.Struct("{row.layout}"),\n' for row in of.message)
    parts.append(f"# Payloads, little endian.\nLAYOUTS: dict[MessageKind, struct.Struct] = {{\n{layouts}}}\n")
    return "\n\n".join(parts)


def _named_tuple(row: MessageRow) -> str:
    types = {"f32": "float", "text": "str"}
    does = row.does.partition(":")[0]
    lines = [f"class {row.type_name}(NamedTuple):", f'    """{does[0].upper()}{does[1:]}."""', ""]
    for field in row.field:
        lines.append(f"    {field.name}: {types.get(field.type, 'int')}  # {field.meaning}{_in_unit(field)}")
    return "\n".join(lines) + "\n"


def _in_unit(field: FieldRow) -> str:
    return f" [{field.unit}]" if field.unit not in ("", "quantity") else ""


def header_text(of: Protocol) -> str:
    """Return the text of messages.h."""
    guard = "MW_MESSAGES_H"
    lines = [
        "/* What the frames mean: numbers of messages, places of their fields, results, reset causes.",
        " * Written by `python firmware/protocol.py` from the host's data/protocol.toml; a test holds this file to it.",
        " * docs/reference/firmware_protocol.md */",
        *(f"#ifndef {guard}", f"#define {guard}", "", "#include <stdint.h>", ""),
        f"#define MW_PROTOCOL_VERSION {of.version}u",
        f"#define MW_BODY_MAX {of.maximum_body_bytes}u",
        *("", "enum {"),
        *_entries([(row.in_c, f"0x{row.number:02x}", row.only_with) for row in of.message]),
        "};",
    ]
    for row in of.enumeration:
        numbers = [(f"{row.c_prefix}{value.name}".upper(), str(value.number), "") for value in row.values]
        lines += ["", f"/* {row.meaning} */", "enum {", *_entries(numbers), "};"]
    lines += ["", "/* Lengths of payloads, and the byte at which each field begins. */"]
    for message in (row for row in of.message if row.field):
        lines.append(f"#define MW_{message.in_c}_BYTES {message.size}u")
        for field, at in message.offsets():
            lines.append(f"#define MW_AT_{message.in_c}_{field.name.upper()} {at}u /* {field.type}: {field.meaning} */")
            if field.type == "text":
                lines.append(f"#define MW_{message.in_c}_{field.name.upper()}_BYTES {field.bytes}u")
    return "\n".join([*lines, "", "#endif", ""])


def monitors_text() -> str:
    """Return the text of monitors.h."""
    chips: dict[str, dict[str, float]] = tomllib.loads(MONITORS.read_text(encoding="utf-8"))
    rows = []
    for name, row in chips.items():
        values = [f".{key} = {row[key]}{'f' if key.endswith('_v') else ''}" for key in MONITOR_MEMBERS]
        lines = [", ".join(values[at : at + 3]) for at in range(0, len(values), 3)]
        rows.append(f"    [MW_{name.upper()}] = {{ \\\n        " + ", \\\n        ".join(lines) + " \\\n    }, \\\n")
    names = ", ".join(f"MW_{name.upper()}" for name in chips)
    return (
        "/* Current monitors on I2C: registers, settings, steps, by TI's data sheets "
        f"{', '.join(str(row['data_sheet']) for row in chips.values())}.\n"
        " * Written by `python firmware/protocol.py` from the host's data/monitors.toml; a test holds it to that. */\n"
        "#ifndef MW_MONITORS_H\n#define MW_MONITORS_H\n\n"
        f"enum {{ {names}, MW_INA_KINDS }};\n\n#define MW_INA_TABLE {{ \\\n{''.join(rows)}}}\n\n#endif\n"
    )


def _entries(numbers: list[tuple[str, str, str]]) -> list[str]:
    last = len(numbers) - 1
    return [
        f"    MW_{name} = {number}{',' if at < last else ''}{f' /* only with -D{only} */' if only else ''}"
        for at, (name, number, only) in enumerate(numbers)
    ]


def host_table(of: Protocol) -> str:
    """Return the messages of the host as a table."""
    rows = [
        f"| 0x{row.number:02X} | {row.in_c} | {_payload(row)} | {row.does} |"
        for row in of.message
        if row.sender == "host" and not row.only_with
    ]
    return "\n".join(["| type | name | payload | what happens |", "|---|---|---|---|", *rows])


def board_table(of: Protocol) -> str:
    """Return the messages of the board, each with a table of its fields."""
    parts = []
    for row in (row for row in of.message if row.sender == "board"):
        parts.append(f"**0x{row.number:02X} {row.in_c}**, {row.size} bytes: {row.does}.")
        fields = [
            f"| {at} | {_type(field)} | `{field.name}` | {_unit(field)} | {field.meaning} |"
            for field, at in row.offsets()
        ]
        parts.append("\n".join(["| byte | type | field | unit | meaning |", "|---|---|---|---|---|", *fields]))
    return "\n\n".join(parts)


def number_table(of: Protocol) -> str:
    """Return the numbers that fields may have as a table."""
    rows = [
        f"| `{row.name}` | {'; '.join(f'{value.number} {value.meaning}' for value in row.values)} |"
        for row in of.enumeration
    ]
    return "\n".join(["| number of | means |", "|---|---|", *rows])


def _payload(row: MessageRow) -> str:
    return ", ".join(
        f"{_type(field)} {field.name}{f' [{unit}]' if (unit := _unit(field)) else ''}" for field in row.field
    )


def _type(field: FieldRow) -> str:
    return f"{field.bytes} characters" if field.type == "text" else field.type


def _unit(field: FieldRow) -> str:
    return "of the quantity, SI" if field.unit == "quantity" else field.unit


TABLES: dict[str, Callable[[Protocol], str]] = {"host": host_table, "board": board_table, "numbers": number_table}


def page() -> str:
    """Return the page of the site: what is written by hand, with the tables at their places."""
    of, text = protocol(), PAGE.read_text(encoding="utf-8")
    for name, table in TABLES.items():
        before, place, after = text.partition(f"<!-- {name} -->")
        if not place:
            raise ValueError(f"{PAGE.name} has no place for the table '{name}'")
        text = f"{before}{table(of)}{after}"
    return text


def written() -> dict[Path, str]:
    """Return each generated file with its text."""
    of = protocol()
    return {PYTHON: python_text(of), HEADER: header_text(of), MONITORS_HEADER: monitors_text()}


def main() -> int:
    """Write the files and name those that have changed."""
    for file, text in written().items():
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
            print(f"wrote {file.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
