"""The metadata of a recording: checked values, and their spelling as text in a CSV comment."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from musclewire.errors import CallerError
from musclewire.signals._units import quantity_with_suffix

MetadataValue = str | int | float | bool | None

_KEY = re.compile(r"[a-z][a-z0-9_.]*")

# The HDF5 file keeps these four next to the metadata, as attributes of the same group.
RESERVED = frozenset({"format", "format_version", "columns", "rows"})

# Text even if it looks like a number: version 0.10 is not 0.1, and a wire may be called "125 um".
_ALWAYS_TEXT = frozenset({
    "wire", "rig", "software_version", "start_time", "ended", "operator", "note", "notes", "comment", "title",
    "sample", "date",
})  # fmt: skip

_WORDS: dict[str, MetadataValue] = {"true": True, "false": False, "none": None}


def checked_metadata(metadata: Mapping[str, MetadataValue]) -> Mapping[str, MetadataValue]:
    """Return a read-only copy with plain Python values; raises CallerError for a key or value that no file can keep."""
    return MappingProxyType({_checked_key(key): _checked_value(key, metadata[key]) for key in metadata})


def _checked_key(key: str) -> str:
    if not isinstance(key, str) or not _KEY.fullmatch(key):
        raise CallerError(f"metadata key {key!r} must be lower-case letters, digits, '_' and '.', as wire_length_m")
    if key in RESERVED:
        raise CallerError(f"metadata key '{key}' belongs to the file format; choose another name")
    return key


def _checked_value(key: str, value: object) -> MetadataValue:
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, str):
        # HDF5 strings end at a NUL, and half a surrogate pair has no UTF-8 spelling.
        if "\0" in plain or any("\ud800" <= character <= "\udfff" for character in plain):
            raise CallerError(f"metadata '{key}' holds a character no file can keep; remove it")
        return str(plain)
    if isinstance(plain, int) and not -(2**63) <= plain < 2**63:
        raise CallerError(f"metadata '{key}' = {plain} does not fit in 64 bits; give it as text")
    if plain is None or isinstance(plain, (bool, int, float)):
        return plain
    kind = type(value).__name__
    raise CallerError(f"metadata '{key}' is a {kind}; give text, a number, true or false, or None")


def one_line(text: str) -> str:
    """Return an exception's message, which may hold anything, as a line that every file can keep."""
    return " ".join(text.replace("\0", " ").encode("utf-8", "replace").decode("utf-8").split())


def value_to_text(key: str, value: MetadataValue) -> str:
    """Return a value as text from which ``entry_from_text`` reads the same value."""
    if not isinstance(value, str):
        return str(value).lower() if value is None or isinstance(value, bool) else repr(value)
    survives = value.isprintable() and entry_from_text(key, value) == (key, value)
    return value if survives else json.dumps(value)


def entry_from_text(key_text: str, value_text: str) -> tuple[str, MetadataValue] | None:
    """Return the entry of a comment line ``key = value``; None if the key is not a valid name.

    ``shunt_resistance = 1.0 ohm`` becomes ``("shunt_resistance_ohm", 1.0)``.
    """
    key, unit = _key_and_unit(key_text)
    text = value_text.strip()
    if key is None:
        return None
    if text.startswith('"'):
        return key, _unquoted(text)
    if key in _ALWAYS_TEXT:
        return key, None if text == "none" else text
    quantity = quantity_with_suffix(f"{text} {unit}" if unit else text)
    if quantity is not None:
        value, suffix = quantity
        return (key if key.endswith(suffix) else key + suffix), value
    return key, _plain_value(text)


def _key_and_unit(key_text: str) -> tuple[str | None, str]:
    match = re.fullmatch(r"\s*(.*?)\s*(?:[\[(]([^\[\]()]*)[\])])?\s*", key_text)
    name, unit = (match[1], match[2] or "") if match else (key_text, "")
    key = re.sub(r"[^a-z0-9_.]+", "_", name.lower()).strip("_")
    key = f"file_{key}" if key in RESERVED else key
    return (key if _KEY.fullmatch(key) else None), unit


def _unquoted(text: str) -> str:
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return value if isinstance(value, str) else text


def _plain_value(text: str) -> MetadataValue:
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    # int() and float() also accept 1_000, which is not how a number is written in a file.
    if "_" in text:
        return text
    try:
        integer = int(text)
        return integer if -(2**63) <= integer < 2**63 else float(integer)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return text


# How names of facts end, and how their numbers are shown: factor and unit. Longer endings come first.
FACT_UNITS = (
    ("_n_per_m", 1.0, "N/m"),
    ("_ohm", 1.0, "ohm"),
    ("_m", 1e3, "mm"),
    ("_n", 1.0, "N"),
    ("_v", 1.0, "V"),
    ("_s", 1.0, "s"),
    ("_k", 1.0, "K"),
)


def fact_in_words(name: str, value: MetadataValue) -> tuple[str, str]:
    """Return a fact, in SI, as its name in words and its value with the unit that the name ends in; lengths in mm."""
    if isinstance(value, (str, bool)) or value is None:
        return name.replace("_", " "), str(value)
    for ending, factor, unit in FACT_UNITS:
        if name.endswith(ending):
            return name.removesuffix(ending).replace("_", " "), f"{factor * value:.4g} {unit}"
    return name.replace("_", " "), f"{value:.4g}"
