"""The words of an exported library that the Arduino IDE's editor colours."""

from __future__ import annotations

import re

FUNCTION = re.compile(r"^\w+ \*?(mw_\w+)\(", re.M)
TYPE = re.compile(r"^\} (mw_\w+);", re.M)


def keywords_file(header: str) -> str:
    """Return keywords.txt, which colours types and functions of a header in the IDE's editor."""
    types, functions = sorted(set(TYPE.findall(header))), sorted(set(FUNCTION.findall(header)))
    lines = [f"{name}\tKEYWORD1" for name in types] + [f"{name}\tKEYWORD2" for name in functions]
    return "\n".join(lines) + "\n"
