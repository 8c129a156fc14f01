"""TOML as it is written here: wire, gains and mapping files; tomllib only reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

__all__ = ["toml_text", "toml_value"]


def toml_text(content: Mapping[str, Any], place: str = "") -> str:
    """Return nested tables as TOML, without what is None or an empty text; numbers keep every bit."""
    stated = {key: value for key, value in content.items() if value is not None and value != ""}
    own = [f"{key} = {toml_value(value)}\n" for key, value in stated.items() if not isinstance(value, Mapping)]
    head = [f"[{place}]\n"] if place and own else []
    tables = (
        toml_text(value, f"{place}.{key}" if place else key)
        for key, value in stated.items()
        if isinstance(value, Mapping)
    )
    return "\n".join(filter(None, ("".join(head + own), *tables)))


def toml_value(value: Any) -> str:
    """Return a text, a number, a yes or no, or a list of them as TOML."""
    if isinstance(value, (str, bool)):
        # JSON's texts are TOML's, but for the character that JSON leaves as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(float(value) if isinstance(value, float) else value)
