"""The generated header: every constant of a library as C text."""

from __future__ import annotations

import math
import zlib

from musclewire.extras.board._c.constants import CONTROL_HEADINGS, CConstant, CConstants
from musclewire.extras.board._c.loops import ControllerSettings, rules_text
from musclewire.extras.board._c.numbers import literal, rows

START = """/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Written by musclewire {version} (musclewire export c): numbers of one wire, its controller, its limits.
 * Model: {model}
 * Rule base: {rules}
 * Export it again instead of editing it: the golden vectors next to it were computed with these numbers. */
#ifndef MW_CONSTANTS_H
#define MW_CONSTANTS_H
{double}
#define MW_LIBRARY_NAME "{name}"
#define MW_QUANTITY "{quantity}"
#define MW_MODEL_CHECKSUM 0x{checksum:08x}u /* crc32 of model, controller and rules: what a host compares */
"""


def constants_header(
    constants: CConstants, *, name: str, model: str, settings: ControllerSettings, quantity: str, double: bool
) -> str:
    """Return the text of ``mw_constants.h``."""
    from importlib.metadata import version

    start = START.format(
        version=version("musclewire"),
        model=_comment(model),
        rules=_comment(rules_text(settings)),
        double="\n/* chosen at export; -DMW_DOUBLE does the same */\n#ifndef MW_DOUBLE\n#define MW_DOUBLE\n#endif\n"
        if double
        else "",
        name=name,
        quantity=quantity,
        checksum=model_checksum(constants),
    )
    return f"{start}{_body(constants)}\n#endif\n"


def model_checksum(constants: CConstants) -> int:
    """Return the crc32 (IEEE 802.3) of model and controller alone: circuit and limits belong to the board."""
    chosen = {heading: group for heading, group in constants.groups.items() if heading in CONTROL_HEADINGS}
    return zlib.crc32(_body(CConstants(chosen)).encode())


def _body(constants: CConstants) -> str:
    lines: list[str] = []
    for heading, group in constants.groups.items():
        lines += ["", f"/* {_comment(heading)} */", *(line for constant in group for line in _lines(constant))]
    return "\n".join(lines) + "\n"


def _lines(constant: CConstant) -> list[str]:
    comment = f" /* {_comment(constant.meaning)} */" if constant.meaning else ""
    if not constant.table:
        return [f"#define MW_{constant.name} {_number(constant, constant.values[0])}{comment}"]
    texts = [_number(constant, value) for value in constant.values]
    if constant.columns:
        groups = [texts[at : at + constant.columns] for at in range(0, len(texts), constant.columns)]
        inner = [line for group in groups for line in _braced(group)]
    else:
        inner = rows(texts)
    body = " \\\n".join(f"    {line}" for line in inner)
    # A comment would end up inside the macro's line continuation, so it precedes the macro.
    return [*([comment.strip()] if comment else []), f"#define MW_{constant.name} {{ \\\n{body} \\\n}}"]


def _braced(texts: list[str]) -> list[str]:
    lines = rows(texts)
    return [f"{{{lines[0]}", *lines[1:-1], f"{lines[-1]}}},"] if len(lines) > 1 else [f"{{{lines[0]}}},"]


def _number(constant: CConstant, value: float) -> str:
    if constant.kind == "integer":
        whole = int(value)
        return str(whole) if whole >= 0 else f"({whole})"
    if math.isinf(value):
        return "MW_LARGEST"
    return f"MW_R({literal(value)})"


def _comment(text: str) -> str:
    """Return a text that is valid inside a C comment on one line."""
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").split())
