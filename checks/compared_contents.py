"""Compare columns of samples, facts and texts, to the bit or within a tolerance: no file is read here.

The docstring of ``same_samples.py`` says what is not compared, and why.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

NOT_COMPARED = re.compile(
    r"wall_s|drift_us|scheduling|(compute|jitter|latency)(_\w+)?_us|software_version|created_by|engine|fingerprint|checksum"
)
MASKS = (
    (re.compile(r"musclewire v?\d+(\.\d+)+[\w.+-]*"), "musclewire VERSION"),
    (re.compile(r'\bversion="?\d[\w.+-]*"?'), "version=VERSION"),
    (re.compile(r"\b[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\b"), "GUID"),
    (re.compile(r"\b\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d)?(\.\d+)?(Z|[+-]\d\d:?\d\d)?"), "DATE"),
    (re.compile(r"(?<![\w.*/:<)])(/[\w.+-]+){2,}"), "PATH"),
)
# Comments of C name the module whose arithmetic they have; a module may move.
C_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
INDEX = re.compile(r"\[\d+\]")


class Contents(NamedTuple):
    """What is compared of a file: columns of samples, facts as parsed JSON has them, and texts by name."""

    columns: Mapping[str, Array] = {}
    facts: Any = None
    texts: Mapping[str, str] = {}


def content_differences(before: Contents, after: Contents, tolerance: float | None = None) -> list[str]:
    """Return what differs between the contents of two files, one line each."""
    lines = column_differences(before.columns, after.columns, tolerance)
    lines += fact_differences(before.facts, after.facts, tolerance)
    lines += [f"{name} only in one of the two" for name in sorted(before.texts.keys() ^ after.texts.keys())]
    for name in sorted(before.texts.keys() & after.texts.keys()):
        found = text_difference(before.texts[name], after.texts[name], tolerance)
        lines += [f"{name} {found}".strip()] if found else []
    return lines


def column_differences(
    before: Mapping[str, Array], after: Mapping[str, Array], tolerance: float | None = None
) -> list[str]:
    """Return what differs in columns of samples, one line each; a tolerance is a fraction of a column's range."""
    names = [name for name in sorted(before.keys() | after.keys()) if not NOT_COMPARED.fullmatch(name)]
    lines = []
    for name in names:
        if name not in before or name not in after:
            lines.append(f"column {name} only in one of the two")
            continue
        one, other = before[name], after[name]
        if one.shape != other.shape:
            lines.append(f"{name} has {one.shape} and {other.shape} samples")
        elif one.dtype != other.dtype:
            lines.append(f"{name} has samples of {one.dtype} and {other.dtype}")
        else:
            excess = relative_differences(one, other)
            differ = other_bits(one, other) if tolerance is None else excess > tolerance
            if differ.any():
                largest = f"by up to {excess[differ].max():.2g} of its range"
                lines.append(f"{name} differs in {int(differ.sum())} of {differ.size} samples, {largest}")
    return lines


def other_bits(one: Array, other: Array) -> Array:
    """Return which samples of two arrays of the same shape and type are not equal to the bit."""
    first, second = (np.ascontiguousarray(item).reshape(-1) for item in (one, other))
    differ: Array = (first.view(np.uint8) != second.view(np.uint8)).reshape(-1, first.itemsize).any(axis=1)
    return differ


def relative_differences(one: Array, other: Array) -> Array:
    """Return how far samples are apart as fractions of the first array's range; infinite where only one is a number."""
    first, second = (np.asarray(item, dtype=np.float64).reshape(-1) for item in (one, other))
    numbers = first[np.isfinite(first)]
    scale = float(np.ptp(numbers) or np.abs(numbers).max()) if numbers.size else 0.0
    same = (first == second) | (np.isnan(first) & np.isnan(second))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        apart = np.abs(first - second) / scale
    return np.where(same, 0.0, np.where(np.isnan(apart), np.inf, apart))


def fact_differences(before: Any, after: Any, tolerance: float | None = None) -> list[str]:
    """Return what differs between two parsed JSON documents, one line each; the items of a list share one."""
    one, other = dict(facts_in(before)), dict(facts_in(after))
    found: dict[str, list[str]] = {}
    for place in [*one, *(place for place in other if place not in one)]:
        if place not in one or place not in other:
            found.setdefault(f"{INDEX.sub('[]', place)} only in one of the two", []).append("")
        elif fact_differs(one[place], other[place], tolerance):
            shown = f"{one[place]!r} and {other[place]!r}"
            found.setdefault(f"{INDEX.sub('[]', place)} differs", []).append(shown)
    return [line_of(what, examples) for what, examples in found.items()]


def line_of(what: str, examples: list[str]) -> str:
    """Return one line on places that differ alike: how many, and the first of them."""
    times = f" in {len(examples)} places, first" if len(examples) > 1 else ""
    return f"{what}{times}: {examples[0]}" if examples[0] else what + times.removesuffix(", first")


def facts_in(document: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield each value of a parsed JSON document that is compared, with its place."""
    if isinstance(document, Mapping):
        for key, value in document.items():
            if not NOT_COMPARED.fullmatch(str(key)):
                yield from facts_in(value, f"{place}.{key}" if place else str(key))
    elif isinstance(document, list | tuple):
        for index, value in enumerate(document):
            yield from facts_in(value, f"{place}[{index}]")
    else:
        yield place, document


def fact_differs(one: Any, other: Any, tolerance: float | None) -> bool:
    """Return whether two values differ: numbers by the tolerance, words as they are, sentences by their numbers."""
    if is_number(one) and is_number(other):
        return number_differs(one, other, tolerance)
    if isinstance(one, str) and isinstance(other, str):
        first, second = masked(one), masked(other)
        words = " " not in first and " " not in second
        return line_differs(first, second, tolerance) if words else numbers_differ(first, second, tolerance)
    return bool(one != other) or type(one) is not type(other)


def is_number(value: Any) -> bool:
    """Return whether a value is a number; true and false are words."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def number_differs(one: float, other: float, tolerance: float | None) -> bool:
    """Return whether two numbers differ by a single bit, or by more than a tolerance relative to the larger."""
    if one == other:
        return tolerance is None and math.copysign(1.0, one) != math.copysign(1.0, other)
    if math.isnan(one) and math.isnan(other):
        return False
    near = tolerance is not None and abs(one - other) <= tolerance * max(abs(one), abs(other))
    return not near or math.isinf(one) or math.isinf(other)


def masked(text: str) -> str:
    """Return a text without the versions, dates, GUIDs, paths and comments of C that do not count; no line is lost."""
    text = C_COMMENT.sub(lambda comment: "\n" * comment[0].count("\n"), text)
    for pattern, name in MASKS:
        text = pattern.sub(name, text)
    return text


def numbers_differ(one: str, other: str, tolerance: float | None) -> bool:
    """Return whether the numbers in two texts differ."""
    first, second = (list(map(float, NUMBER.findall(text))) for text in (one, other))
    pairs = zip(first, second, strict=False)
    return len(first) != len(second) or any(number_differs(*pair, tolerance) for pair in pairs)


def line_differs(one: str, other: str, tolerance: float | None) -> bool:
    """Return whether two lines differ in their words, or in their numbers by more than the tolerance."""
    if one == other:
        return False
    return tolerance is None or NUMBER.sub("#", one) != NUMBER.sub("#", other) or numbers_differ(one, other, tolerance)


def text_difference(before: str, after: str, tolerance: float | None = None) -> str:
    """Return what differs between two texts, empty if nothing does."""
    one, other = masked(before).splitlines(keepends=True), masked(after).splitlines(keepends=True)
    if len(one) != len(other):
        return f"has {len(one)} and {len(other)} lines"
    differ = [index for index, pair in enumerate(zip(one, other, strict=True)) if line_differs(*pair, tolerance)]
    if not differ:
        return ""
    first = differ[0]
    return f"differs in {len(differ)} of {len(one)} lines, first line {first + 1}: {one[first]!r} and {other[first]!r}"
