"""The file mw_variables.h: the variables of an FMU as its C sources read them."""

from __future__ import annotations

import math
from collections.abc import Iterable

from musclewire.extras.board import literal
from musclewire.extras.interfaces._fmu.variables import KINDS, FmuVariable, FmuVariables, Kind

START = """/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Written by musclewire {version} (musclewire export fmu): the variables of modelDescription.xml, in its order. */
#ifndef MW_VARIABLES_H
#define MW_VARIABLES_H

#include <float.h>

#define MW_GUID {guid}
"""
LARGEST = "DBL_MAX"


def variables_header(variables: FmuVariables, guid: str) -> str:
    """Return the text of ``mw_variables.h``."""
    from importlib.metadata import version

    lines = [START.format(version=version("musclewire"), guid=c_text(guid))]
    for kind in KINDS:
        lines += kind_lines(variables, kind)
    for variable in variables.ordered:
        if variable.names:
            lines += names_lines(variable)
    return "\n".join([*lines, "#endif", ""])


def kind_lines(variables: FmuVariables, kind: Kind) -> list[str]:
    """Return the places and the table of all variables of one kind."""
    upper, members = kind.upper(), variables.of_kind(kind)
    return [
        f"#define MW_FIRST_{upper} {variables.first(kind)}u",
        f"#define MW_{upper}S {len(members)}u",
        *(f"#define MW_{upper}_{variable.name.upper()} {place}" for place, variable in enumerate(members)),
        table(f"MW_{upper}_TABLE", [row(variable) for variable in members] or ["{0, MW_INPUT, 0, 0, 0}"]),
        "",
    ]


def row(variable: FmuVariable) -> str:
    """Return the initialiser of one variable."""
    numbers = ", ".join(bounded(value) for value in (variable.start, variable.minimum, variable.maximum))
    return f"{{{c_text(variable.name)}, MW_{variable.role.upper()}, {numbers}}}"


def names_lines(variable: FmuVariable) -> list[str]:
    """Return the names of an enumeration's values, by value."""
    named = {number: name for number, name, _ in variable.names}
    texts = [c_text(named.get(number, "reserved")) for number in range(max(named) + 1)]
    return [table(f"MW_{variable.type_name.upper()}_NAMES", texts), ""]


def table(name: str, rows: Iterable[str]) -> str:
    """Return a macro with an initialiser, one row a line."""
    body = ", \\\n".join(f"    {text}" for text in rows)
    return f"#define {name} {{ \\\n{body} \\\n}}"


def bounded(value: float) -> str:
    """Return a number as a C literal; an infinite one as the largest finite number."""
    if math.isinf(value):
        return LARGEST if value > 0.0 else f"-{LARGEST}"
    return literal(value)


def c_text(text: str) -> str:
    """Return a text as a C string literal."""
    plain = text.encode("ascii", "replace").decode().replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain}"'
