"""The file mw_wire_numbers.h and mw_wire_tables.c: the rows of a wire as C structures, its numbers and its tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.board import literal, rows
from musclewire.physics import ELASTIC_POISSON_RATIO, REFERENCE_TEMPERATURE_K
from musclewire.wire import CLASSES, MAX_STEP_ERROR_K, Field, Row, StepConstants, WireConstants, WireState

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
        *(f"#define MW_{name} {value}" for name, value in defined(constants).items()),
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


def defined(constants: WireConstants) -> dict[str, str | int]:
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
