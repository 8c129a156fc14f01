"""Layouts of files drawn from values of many axes, each by a seed, with what must come out of them.

``AXES`` lists all values; the first of each axis is the plain one. What people met in public is among them, as kinds
and in our own words: no maker's file was copied. Not drawn is what is no text (MATLAB's, HDF5), two files, and what
only a fit can judge (pulses, a late drive). A layout has one value of each axis, and one value of all, by turns, is
certainly in it. The wires are those of ``loops.py``.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from tests.labs.layouts import AMP, FORCE, SHUNT, STROKE, TIME, R, V
from tests.labs.loops import LOOPS, PERIOD_S, SHUNT_OHM, Array, loop

Cells = list[tuple[str, ...]]


@dataclass(frozen=True)
class Clock:
    """Columns of a clock: names, the unit if they count one, how times are written and read back, the day if stated."""

    names: tuple[str, ...]
    unit: str | None
    text: Callable[[Array], Cells]
    seconds: Callable[[Cells], Array]
    day: str = ""


def counting(name: str, unit: str | None, per_s: float, decimals: int = 0, start: int = 0, bits: int = 63) -> Clock:
    """Return a clock that counts in a unit, from a number on, and wraps beyond its bits."""

    def text(time_s: Array) -> Cells:
        if decimals:
            return [(f"{start + each * per_s:.{decimals}f}",) for each in time_s.tolist()]
        return [(str((start + round(each * per_s)) % 2**bits),) for each in time_s.tolist()]

    def seconds(cells: Cells) -> Array:
        first = int(float(cells[0][0])) if decimals else int(cells[0][0])
        counts = [float(cell) - first if decimals else float(int(cell) - first) for (cell,) in cells]
        return np.unwrap(counts, period=2.0**bits) / per_s

    return Clock((name,), unit, text, seconds)


def stamped(names: Sequence[str], formats: Sequence[str], began: str = "", again_s: float = 1e9) -> Clock:
    """Return a clock of dates or times of day in one or more columns; its stamps come again after a time, as a day."""
    start = datetime.fromisoformat(began or "2026-03-01T12:21:00.200")

    def text(time_s: Array) -> Cells:
        times = [start + timedelta(milliseconds=round(1e3 * each)) for each in time_s.tolist()]
        times = [each - timedelta(hours=1) * (again_s == 3600.0 and each.hour > 2) for each in times]
        return [tuple(t.strftime(f.replace("%f", f"{t.microsecond // 1000:03d}")) for f in formats) for t in times]

    def seconds(cells: Cells) -> Array:
        times = [datetime.strptime("|".join(row), "|".join(formats)) for row in cells]
        return np.unwrap([(each - times[0]).total_seconds() for each in times], period=again_s)

    return Clock(tuple(names), None, text, seconds, start.date().isoformat() if "%Y" in "".join(formats) else "")


def batches(clock: Clock, rows: int) -> Clock:
    """Return a clock that stands still for some rows."""

    def seconds(cells: Cells) -> Array:
        return clock.seconds([cells[0], cells[rows]])[1] / rows * np.arange(len(cells))

    return Clock(
        clock.names, clock.unit, lambda time_s: clock.text(time_s[np.arange(time_s.size) // rows * rows]), seconds
    )


def in_two(first: str, second: str) -> Clock:
    """Return a clock of whole seconds and the nanoseconds beyond them."""
    start = 1_772_367_660

    def text(time_s: Array) -> Cells:
        counts = [round(1e9 * each) + 18_500_096 for each in time_s.tolist()]
        return [(str(start + each // 10**9), str(each % 10**9)) for each in counts]

    def seconds(cells: Cells) -> Array:
        counts = [(int(whole) - start) * 10**9 + int(rest) for whole, rest in cells]
        return np.array([each - counts[0] for each in counts]) / 1e9

    return Clock((first, second), None, text, seconds)


NO_CLOCK = Clock((), None, lambda time_s: [()] * time_s.size, lambda cells: PERIOD_S * np.arange(len(cells)))
EPOCH_S = 1_772_367_660
CLOCKS = {
    "seconds": counting("Time", "s", 1.0, 2),
    "milliseconds": counting("millis", "ms", 1e3),
    "microseconds": counting("micros", "us", 1e6),
    "nanoseconds": counting("timestamp", "ns", 1e9),
    "minutes": counting("Time", "min", 1.0 / 60.0, 6),
    "a counter and a stated interval": counting("Sample", None, 1.0 / PERIOD_S, 0, 219),
    "a counter and a given interval": counting("sample", None, 1.0 / PERIOD_S, 0, 219),
    "a stated interval alone": NO_CLOCK,
    "epoch in seconds": counting("unix", None, 1.0, 3, EPOCH_S),
    "epoch in milliseconds": counting("ts", None, 1e3, 0, EPOCH_S * 10**3),
    "epoch in nanoseconds": counting("stamp", None, 1e9, 0, EPOCH_S * 10**9),
    "seconds and nanoseconds": in_two("header.stamp.secs", "header.stamp.nsecs"),
    "ISO": stamped(["Timestamp"], ["%Y-%m-%dT%H:%M:%S.%f"]),
    "ISO with a zone and no name": stamped([""], ["%Y-%m-%dT%H:%M:%S.%f+01:00"]),
    "created_at": stamped(["created_at"], ["%Y-%m-%d %H:%M:%S.%f UTC"]),
    "date-time, day first": stamped(["Datum"], ["%d.%m.%Y %H:%M:%S.%f"]),
    "date-time, month first": stamped(["Time"], ["%m/%d/%Y %I:%M:%S.%f %p"], "2026-03-01T23:24:14.200"),
    "a format as its name": stamped(["dd/MM/yyyy HH:mm:ss.fff"], ["%d/%m/%Y %H:%M:%S.%f"]),
    "date and time": stamped(["Date", "Time"], ["%Y-%m-%d", "%H:%M:%S.%f"]),
    "date, time, fraction": stamped(["Date", "Time", "Fractional Seconds"], ["%m/%d/%Y", "%H:%M:%S", "0.%f"]),
    "date-time and milliseconds": stamped(["Date&Time", "ms"], ["%Y-%m-%d %H:%M:%S", "%f"]),
    "time of day": stamped(["Time"], ["%H:%M:%S.%f"]),
    "minutes and seconds": stamped(["Time"], ["%M:%S.%f"], "2026-01-01T00:00:00"),
    "over midnight": stamped(["Time"], ["%H:%M:%S.%f"], "2026-03-01T23:59:31.200", 86_400.0),
    "noon and midnight by AM and PM": stamped(["Time"], ["%I:%M:%S.%f %p"], "2026-03-01T23:59:31.200", 86_400.0),
    "end of summer time": stamped(["Time"], ["%Y-%m-%d %H:%M:%S.%f"], "2026-10-25T02:59:31.200", 3600.0),
    "Timedelta": stamped(["t"], ["0 days %H:%M:%S.%f"], "2026-01-01T00:00:00"),
    "a stamp before an arrow": stamped([""], ["%H:%M:%S.%f -> "]),
    "a stamp in brackets": stamped([""], ["[%Y-%m-%d %H:%M:%S.%f] "]),
    "wraps at 16 bits": counting("millis", "ms", 1e3, 0, 2**16 - 24_000, 16),
    "wraps at 32 bits": counting("micros", "us", 1e6, 0, 2**32 - 24_000_000, 32),
    "one stamp for 20 rows": batches(counting("Time", "s", 1.0, 2), 20),
    "whole seconds for 5 rows": batches(stamped(["Time"], ["%H:%M:%S"]), 5),
    "seconds headed ns": counting("timestamp", "ns", 1.0, 2),
}
# What stands where a reading is none, as it is written.
MARKS = {
    "no mark": "", "a blank": "", "---": "---", "OVER": "OVER", "OL": "OL", "OVLD": "OVLD", "+++++++": "+++++++",
    "#N/A": "#N/A", "NaN": "NaN", "null": "null", "inf": "inf", "∞": "∞", "1.#INF": "1.#INF", "-9999": "-9999",
    "9.9E37": "9.9E+37", "9.91E37": "+9.91E+37", "-1E+999": "-1E+999", "1e9": "1000000000", "8388607": "8388607",
    "8388.607": "8388.607", "65535": "65535", "8190": "8190", "999.999": "999.999", "-1": "-1",
}  # fmt: skip
QUANTITIES = {
    "voltage, current, stroke": (V, AMP, STROKE), "voltage, shunt, stroke": (V, SHUNT, STROKE),
    "resistance, stroke": (R, STROKE), "voltage, current, force": (V, AMP, FORCE),
    "voltage, current, stroke, force": (V, AMP, STROKE, FORCE),
}  # fmt: skip
UNITS = {
    "V, mA, mm": {V: "V", AMP: "mA", SHUNT: "mV", R: "Ohm", STROKE: "mm", FORCE: "N"},
    "V, A, mm": {V: "V", AMP: "A", SHUNT: "V", R: "Ohm", STROKE: "mm", FORCE: "N"},
    "mV, mA, µm": {V: "mV", AMP: "mA", SHUNT: "mV", R: "Ohm", STROKE: "µm", FORCE: "mN"},
    "V, A, m": {V: "V", AMP: "A", SHUNT: "V", R: "Ohm", STROKE: "m", FORCE: "N"},
}
NAMES: dict[str, Mapping[str, str]] = {
    "short": {V: "V_wire", AMP: "I_wire", SHUNT: "V_shunt", R: "R_wire", STROKE: "pos", FORCE: "F"},
    "words": {V: "Wire voltage", AMP: "Current", SHUNT: "Shunt voltage", R: "Resistance", STROKE: "Position",
              FORCE: "Force"},
    "German": {V: "Spannung", AMP: "Strom", SHUNT: "Shuntspannung", R: "Widerstand", STROKE: "Weg", FORCE: "Kraft"},
    "ours": {V: V[:-2], AMP: AMP[:-2], SHUNT: SHUNT[:-2], R: R[:-4], STROKE: STROKE[:-2], FORCE: FORCE[:-2]},
    "channels": {}, "fields": {}, "numbers": {},
}  # fmt: skip
# The names of channels, of which the first is the wire's voltage and the second the shunt's, if both are in volts.
NUMBERED = {"channels": "CH{}", "fields": "field{}", "numbers": "{}"}
KEYED = {
    "key=value": "{}={}", "key: value": "{}: {}", "key, value": "{}<sep>{}", "INI": "{}={}", "# comments": "# {}: {}",
    "; comments": "; {} = {}", "an end marker": "{}<sep>{}", "a data marker": "{}<sep>{}",
    "a blank line below": "{}:<sep>{}", "lines of channels": "{}<sep>{}",
}  # fmt: skip
BELOW = {"INI": "[Data]", "an end marker": "***End_of_Header***", "a data marker": "Data", "a blank line below": ""}
AXES: dict[str, tuple[str, ...]] = {
    "form": ("table", "name: value lines", "name:value pairs", "JSON lines", "long by channel", "signals in rows"),
    "suffix": (".csv", ".txt", ".dat", ".log"),
    "separator": ("comma", "semicolon", "tab", "blanks", "bar", "comma and blank"),
    "decimal": ("point", "decimal comma"),
    "digits": ("five digits", "exponent", "sign and blanks", "two decimals"),
    "quotes": ("no quotes", "quoted headers", "all quoted"),
    "encoding": ("utf-8", "utf-8-sig", "utf-16", "cp1252"),
    "line ends": ("LF", "CRLF", "CR", "blank lines between"),
    "header": ("one row", "no names", *KEYED, "a terminal's line, half a row, READY", "sep= and titles",
               "a blank row below", "titles"),
    "names": tuple(NAMES),
    "quantities": tuple(QUANTITIES),
    "units": ("in parentheses", "in brackets", "behind a line", "in a row", "in a row, in words",
              "in a row with other cells", "in each cell", "changing by cell", "in a column", "changing in a column",
              "in the preamble", "nowhere"),
    "scale": tuple(UNITS),
    "clock": tuple(CLOCKS),
    "mark": tuple(MARKS),
    "readings": ("sound", "spikes", "current wraps its sign", "current negative", "current clipped"),
    "defect": ("whole", "cut in its last line", "a restart", "two blocks", "a table after", "words between rows",
               "doubled rows", "gaps", "a separator at the end", "a cell more than headers"),
    "beside": ("nothing beside", "a row number", "a constant", "letters", "an empty column", "room temperature"),
    "given": ("what is missing", "a unit against the file's"),
}  # fmt: skip
# How often an axis is plain without being asked.
PLAIN = {
    "form": 0.9, "suffix": 0.7, "separator": 0.4, "decimal": 0.7, "digits": 0.7, "quotes": 0.8, "encoding": 0.6,
    "line ends": 0.6, "header": 0.4, "names": 0.3, "quantities": 0.4, "units": 0.3, "scale": 0.5, "clock": 0.3,
    "mark": 0.75, "readings": 0.9, "defect": 0.8, "beside": 0.7, "given": 0.97,
}  # fmt: skip
AXIS_OF = {value: axis for axis, values in AXES.items() for value in values}
VALUES = tuple(AXIS_OF)
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "blanks": "  ", "bar": "|", "comma and blank": ", "}
FACTORS = {"V": 1.0, "mV": 1e-3, "A": 1.0, "mA": 1e-3, "Ohm": 1.0, "mm": 1e-3, "µm": 1e-6, "m": 1.0, "N": 1.0,
           "mN": 1e-3}  # fmt: skip
SMALLER = {"V": "mV", "A": "mA", "mm": "µm"}
IN_WORDS = {"V": "Volt", "mV": "Millivolt", "A": "Ampere", "mA": "Milliampere", "Ohm": "Ohms", "mm": "Millimeter",
            "µm": "Micrometer", "m": "Meter", "N": "Newton", "mN": "Millinewton", "s": "Seconds", "ms": "Milliseconds",
            "us": "Microseconds", "ns": "Nanoseconds", "min": "Minutes"}  # fmt: skip


MEASURED = (V, AMP, SHUNT, R, STROKE, FORCE)


def other(axis: str, *allowed: str) -> set[str]:
    """Return the values of an axis but some."""
    return set(AXES[axis]) - set(allowed)


GLUED = {"a stamp before an arrow", "a stamp in brackets"}
STATED = {"a counter and a stated interval", "a stated interval alone"}
STILL = {"one stamp for 20 rows", "whole seconds for 5 rows"}
ONE_COLUMN = {name for name, clock in CLOCKS.items() if clock.names not in ((), ("",)) and len(clock.names) == 1}
WITH_BLANKS = {n for n, clock in CLOCKS.items() if " " in "".join(clock.names + clock.text(np.zeros(1))[0])}
AS_ROW = {"in a row", "in a row, in words", "in a row with other cells"}
AS_COLUMN, IN_CELLS = {"in a column", "changing in a column"}, {"in each cell", "changing by cell"}
IN_NAMES, ENDS = (
    {"in parentheses", "in brackets", "behind a line"},
    {"a separator at the end", "a cell more than headers"},
)
NO_ROW = {"no names", "lines of channels"}
# What no file can have at once, and what together nobody could know.
CONFLICTS: list[tuple[set[str], set[str]]] = [
    ({"decimal comma"}, {"comma", "comma and blank", "JSON lines", "date, time, fraction"}),
    ({"blanks"}, {*WITH_BLANKS, *IN_CELLS, "ISO with a zone and no name", "words", "sign and blanks", "a blank",
                  "an empty column", "lines of channels", "a separator at the end", "a blank row below",
                  "sep= and titles"}),
    ({"cp1252"}, {"∞"}),
    ({"two decimals"}, other("scale", "V, A, mm")),
    (NO_ROW, {"a restart", "quoted headers", "a cell more than headers"}),
    ({"no names"}, {*IN_NAMES, *AS_ROW, *AS_COLUMN, *GLUED, *STATED, "in the preamble", "seconds headed ns",
                  "two blocks"}),
    ({"lines of channels"}, {*other("clock", "a stated interval alone"), *other("units", "in the preamble"),
                             *other("beside", "nothing beside"), "numbers", "a separator at the end"}),
    (STATED | {"in the preamble"}, other("header", *KEYED)),
    ({"ours"}, {*other("units", "behind a line"), *other("scale", "V, A, m")}),
    ({"words", "numbers"}, {"behind a line"}),
    ({"in a row with other cells"}, other("beside", "a row number", "letters")),
    ({"changing by cell", "changing in a column"}, {*other("scale", "V, A, mm"), "exponent", "two decimals",
                                                    "resistance, stroke"}),
    ({"seconds headed ns"}, other("units", "in parentheses", "in brackets", "in a row", "in a row, in words")),
    (GLUED, {*other("header", "one row"), *other("quotes", "no quotes"), *AS_ROW, "a row number",
             *other("defect", "whole", "cut in its last line", "words between rows", "gaps"),
             *other("form", "table", "name:value pairs")}),
    (other("form", "table"), {*other("header", "one row"), *other("quotes", "no quotes"), "sign and blanks", "numbers",
                              *other("beside", "nothing beside"), *AS_ROW, *AS_COLUMN, *ENDS, "a restart",
                              "two blocks", "a table after", *(set(CLOCKS) - ONE_COLUMN - GLUED)}),
    ({"JSON lines"}, {"comma and blank", "1.#INF", "-1E+999"}),
    ({"name:value pairs"}, {"words", "a blank"}),
    ({"name: value lines", "name:value pairs"}, {"a format as its name"}),
    ({"signals in rows"}, {"cut in its last line", "words between rows", "doubled rows", "blanks"}),
    ({"long by channel"}, {"doubled rows"}),
    (STILL | {"a stated interval alone"}, {"gaps", "doubled rows", "a restart"}),
    ({"a restart"}, other("clock", "seconds", "milliseconds", "microseconds", "minutes")),
    (other("readings", "sound", "spikes"), {"resistance, stroke", "voltage, shunt, stroke", "two decimals"}),
    (other("readings", "sound"), other("mark", "no mark")),
    ({"-1"}, other("scale", "V, mA, mm", "V, A, mm")),
    ({"a unit against the file's"}, {*other("units", "in parentheses", "in brackets", "in a row"), *GLUED, *NO_ROW,
                                     *other("form", "table"), *other("header", *KEYED, "one row"), "numbers",
                                     "resistance, stroke"}),
]  # fmt: skip
APART = {pair for one, two in CONFLICTS for a in one for b in two for pair in ((a, b), (b, a))}


def chosen_values(random: Generator, certain: str) -> dict[str, str]:
    """Return a value of each axis, one of them certain, that a file can have at once."""
    while True:
        choice = {AXIS_OF[certain]: certain}
        for axis in random.permutation([axis for axis in AXES if axis not in choice]).tolist():
            fitting = [value for value in AXES[axis] if not any((value, one) in APART for one in choice.values())]
            if not fitting:
                break
            plain = fitting[0] == AXES[axis][0] and random.random() < PLAIN[axis]
            choice[axis] = fitting[0] if plain else fitting[int(random.integers(len(fitting)))]
        else:
            return choice


@dataclass(frozen=True)
class Truth:
    """What one test holds: columns in SI, which rows are measurements, what decimals leave open, the day if stated."""

    columns: Mapping[str, Array]
    kept: NDArray[np.bool_]
    tolerance: Mapping[str, float]
    day: str


@dataclass(frozen=True)
class Drawn:
    """One file, what is given with it, the truth, of several tests any one, and all that a plain reader has to be told.

    ``rows`` are the lines that hold rows: number among those that are not blank, test, row; ``clock`` and ``columns``
    say where columns are, and in which unit.
    """

    choice: Mapping[str, str]
    name: str
    content: bytes
    given: tuple[str, ...]
    truths: tuple[Truth, ...]
    rows: list[tuple[int, int, int]]
    clock: list[int]
    columns: dict[str, tuple[int, str]]


@dataclass(frozen=True)
class Column:
    """One column of a table as text."""

    name: str
    unit: str | None
    cells: Sequence[str]


@lru_cache
def wire(name: str) -> Mapping[str, Array]:
    """Return a loop, read once."""
    return loop(name)


def drawn(seed: int, number: int, value: str = "") -> Drawn:
    """Return one layout of a seed; a value is certainly in it, by turns each, unless one is named."""
    random = np.random.default_rng([seed, number])
    choice = chosen_values(random, value or VALUES[number % len(VALUES)])
    found = wire(str(random.choice(LOOPS)))
    rows = np.arange(found[TIME].size)
    if choice["defect"] == "gaps":
        starts = random.choice(np.arange(40, rows.size - 40, 20), 3, replace=False)
        rows = np.setdiff1d(rows, np.concatenate([start + np.arange(5) for start in starts]))
    names = QUANTITIES[choice["quantities"]]
    columns = {name: found[name][rows] for name in (TIME, *names)}
    kept = np.ones(rows.size, dtype=np.bool_)
    written = readings_of(choice["readings"], columns, kept, random)
    marked = (str(random.choice(names)), random.choice(np.arange(10, rows.size - 10), 6, replace=False))
    if choice["mark"] != "no mark":
        kept[marked[1]] = False
    else:
        marked = ("", marked[1])
    table, tolerance = table_of(choice, written, names, marked)
    return file_of(choice, table, Truth(columns, kept, tolerance, CLOCKS[choice["clock"]].day), random)


def readings_of(
    readings: str, columns: Mapping[str, Array], kept: NDArray[np.bool_], random: Generator
) -> dict[str, Array]:
    """Return what an instrument makes of columns; the rows that are no measurements are taken from those kept."""
    written = {name: values.copy() for name, values in columns.items()}
    rows = random.choice(np.arange(10, kept.size - 10), 18, replace=False)
    if readings == "spikes":
        name = str(random.choice([name for name in columns if name != TIME]))
        written[name][rows] = columns[name].max() * random.uniform(2.0, 20.0, rows.size) * random.choice([-1, 1], 18)
        kept[rows] = False
    if readings == "current negative":
        written[AMP] = -columns[AMP]
    if readings.startswith("current ") and readings != "current negative":
        end_a = 0.8 * columns[AMP].max()
        beyond = columns[AMP] > end_a
        written[AMP][beyond] = columns[AMP][beyond] - 2.0 * end_a if "sign" in readings else end_a
        kept[beyond] = False
    return written


def table_of(
    choice: Mapping[str, str], written: Mapping[str, Array], names: Sequence[str], marked: tuple[str, NDArray[np.intp]]
) -> tuple[dict[str, Column], dict[str, float]]:
    """Return the columns as text, the clock's as "clock 0" and so on, and the tolerance that their decimals leave."""
    clock, comma = CLOCKS[choice["clock"]], choice["decimal"] == "decimal comma"
    beside = f" {clock.unit}" if clock.unit and choice["units"] in IN_CELLS else ""
    # Text of a day, as of German dates, has points that are no decimal marks.
    stamps = list(zip(*clock.text(written[TIME]), strict=True))
    table = {
        f"clock {k}": Column(
            name, clock.unit, [as_decimal(cell, comma and bool(clock.unit)) + beside for cell in cells]
        )
        for k, (name, cells) in enumerate(zip(clock.names, stamps, strict=True))
    }
    tolerance = {TIME: 1e-3 if clock.unit in ("s", "min") else 1e-5}
    called = {n: NUMBERED.get(choice["names"], "").format(k + 1) for k, n in enumerate(names)} | dict(
        NAMES[choice["names"]]
    )
    for name in names:
        unit = UNITS[choice["scale"]][name]
        values = written[name] / FACTORS[unit]
        decimals = max(0, 4 - int(np.floor(np.log10(np.median(np.abs(values))))))
        decimals = 2 if choice["digits"] == "two decimals" else decimals
        exponent = choice["digits"] == "exponent"
        tolerance[name] = 0.51e-6 * np.abs(written[name]).max() if exponent else 0.51 * 10.0**-decimals * FACTORS[unit]
        cells, units = [], []
        for value in values.tolist():
            small = choice["units"].startswith("changing") and abs(value) < 1.0 and unit in SMALLER
            units.append(SMALLER[unit] if small else unit)
            text = number_text(value * (1e3 if small else 1.0), max(0, decimals - 3 * small), choice["digits"])
            cells.append(as_decimal(text, comma))
        if choice["units"] in IN_CELLS:
            cells = [f"{cell} {unit}" for cell, unit in zip(cells, units, strict=True)]
        if name == marked[0]:
            for row in marked[1].tolist():
                cells[row] = as_decimal(MARKS[choice["mark"]], comma)
        table[name] = Column(called[name], unit, cells)
        if choice["units"] in AS_COLUMN:
            table[f"unit of {name}"] = Column("Unit", None, units)
    return table, tolerance


def as_decimal(text: str, comma: bool) -> str:
    return text.replace(".", ",") if comma else text


def number_text(value: float, decimals: int, digits: str) -> str:
    """Return a number as an instrument writes it."""
    if digits == "exponent":
        return f"{value:.6E}"
    if digits == "sign and blanks":
        return f"{'-' if value < 0.0 else '+'}{abs(value):9.{decimals}f}"
    return f"{value:.{decimals}f}"


def with_others(choice: Mapping[str, str], table: dict[str, Column]) -> dict[str, Column]:
    """Return a table with what stands beside the measurements."""
    count = len(next(iter(table.values())).cells)
    others = {
        "a row number": Column("Index", None, [str(1 + row) for row in range(count)]),
        "a constant": Column("Range", None, ["20"] * count),
        "letters": Column("Mode", None, ["DC"] * count),
        "an empty column": Column("", None, [""] * count),
        "room temperature": Column("T_room", "degC", [f"{23 + row % 3}" for row in range(count)]),
    }
    beside = choice["beside"]
    if beside == "nothing beside":
        return table
    return {beside: others[beside], **table} if beside == "a row number" else {**table, beside: others[beside]}


def label(choice: Mapping[str, str], column: Column) -> str:
    """Return the header of a column, with its unit if units are there."""
    place, unit = choice["units"], column.unit
    if unit is None or place in {*IN_CELLS, *AS_ROW, "in the preamble", "nowhere"}:
        return column.name
    if place == "behind a line":
        return f"{column.name}_{'ohm' if unit == 'Ohm' else unit}"
    blank = "" if choice["separator"] == "blanks" else " "
    return f"{column.name}{blank}[{unit}]" if place == "in brackets" else f"{column.name}{blank}({unit})"


def preamble(choice: Mapping[str, str], table: Mapping[str, Column], random: Generator) -> list[tuple[str, str]]:
    """Return what a file states above its rows: the interval and the units, if they are there."""
    separator = SEPARATORS[choice["separator"]]
    stated = [("Instrument", "Logger 7"), ("Operator", "Jürgen"), ("Date", CLOCKS[choice["clock"]].day or "2026-03-01")]
    if choice["clock"] in STATED:
        texts = (("Sample interval", f"{PERIOD_S:g} s"), ("Sampling interval", "200 ms"), ("Sample rate", "5 Hz"))
        key, text = texts[int(random.integers(3))]
        stated.append((key, as_decimal(text, choice["decimal"] == "decimal comma")))
    measured = [column for column in table.values() if column.unit]
    if choice["header"] == "lines of channels":
        stated.append(("TraceName", separator.join(column.name for column in measured)))
        stated.append(("VUnit", separator.join(str(column.unit) for column in measured)))
    elif choice["units"] == "in the preamble":
        stated += [(f"Unit of {column.name}", str(column.unit)) for column in measured]
    return stated


def lines_above(choice: Mapping[str, str], table: Mapping[str, Column], random: Generator) -> list[str]:
    """Return the lines above the names of the columns."""
    header, separator = choice["header"], SEPARATORS[choice["separator"]]
    if header in KEYED:
        stated = preamble(choice, table, random)
        form = KEYED[header].replace("<sep>", separator)
        above = ["[Header]"] * (header == "INI") + [form.format(*pair) for pair in stated]
        return [*above, BELOW[header]] if header in BELOW else above
    return {
        "a terminal's line, half a row, READY": [
            "=~=~=~= log of 2026.03.01 12:21:00 =~=~=~=",
            f"12{separator}0",
            "READY",
        ],
        "sep= and titles": [f"sep={separator}", "Export 1|Logger 7", "", separator + separator.join(["SN: 1"] * 3)],
        "titles": ["Wire 3, second cycle", "Operator: Jürgen"],
    }.get(header, [])


def joined(choice: Mapping[str, str], cells: Iterable[str], named: bool = False) -> str:
    """Return one line of a table; a stamp that is glued to it is its first cell."""
    cells = list(cells)
    if choice["quotes"] == "all quoted" or (named and choice["quotes"] == "quoted headers"):
        cells = [f'"{cell}"' for cell in cells]
    glued = cells.pop(0) if choice["clock"] in GLUED else ""
    return glued + SEPARATORS[choice["separator"]].join(cells)


def names_above(choice: Mapping[str, str], table: Mapping[str, Column]) -> list[str]:
    """Return the row of names and, if it is there, that of units."""
    columns = list(table.values())
    if choice["header"] in NO_ROW or choice["form"] not in ("table", "long by channel"):
        return []
    if choice["form"] == "long by channel":
        return [joined(choice, ("channel", label(choice, columns[0]), "value"), named=True)]
    first = [columns[0].cells[0]] if choice["clock"] in GLUED else [label(choice, columns[0])]
    head = [joined(choice, first + [label(choice, column) for column in columns[1:]], named=True)]
    place, blank = choice["units"], "-" if choice["separator"] == "blanks" else ""
    if place in ("in a row", "in a row, in words"):
        units = [blank if column.unit is None else column.unit for column in columns]
        words = [IN_WORDS.get(unit, unit) for unit in units]
        head.append(joined(choice, words if "words" in place else units, named=True))
    if place == "in a row with other cells":
        head.append(joined(choice, [column.unit or f"A12345{k}" for k, column in enumerate(columns)], named=True))
    if choice["header"] == "a blank row below":
        head.append(joined(choice, [""] * len(columns)))
    return head


def row_lines(choice: Mapping[str, str], headers: Sequence[str], cells: list[str]) -> list[str]:
    """Return the lines of one row."""
    form = choice["form"]
    if form == "name: value lines":
        return [f"{header}: {cell}" for header, cell in zip(headers, cells, strict=True)]
    if form == "name:value pairs":
        first = choice["clock"] in GLUED
        return [joined(choice, cells[:first] + [f"{h}:{c}" for h, c in list(zip(headers, cells, strict=True))[first:]])]
    if form == "JSON lines":
        known = [float(cell) if re.fullmatch(r"[+-]?\d+(\.\d+)?(E[+-]\d+)?", cell) else cell or None for cell in cells]
        return [json.dumps(dict(zip(headers, known, strict=True)), ensure_ascii=False)]
    if form == "long by channel":
        return [joined(choice, (h, cells[0], cell)) for h, cell in zip(headers[1:], cells[1:], strict=True)]
    ends = {"a separator at the end": [""], "a cell more than headers": ["0"]}.get(choice["defect"], [])
    first_cell = [""] if choice["header"] == "lines of channels" else []
    return [joined(choice, [*first_cell, *cells, *ends])]


def file_of(choice: Mapping[str, str], table: dict[str, Column], truth: Truth, random: Generator) -> Drawn:
    """Return a table as a file in a form, with its header and its defect."""
    table = with_others(choice, table)
    count, defect, headers = truth.kept.size, choice["defect"], [label(choice, column) for column in table.values()]
    lines: list[tuple[str, tuple[int, int] | None]] = []

    def add(run: int, until: int, again: bool = False) -> None:
        if not again:
            lines.extend((line, None) for line in lines_above(choice, table, random))
        lines.extend((line, None) for line in names_above(choice, table))
        for row in range(until):
            written = row_lines(choice, headers, [column.cells[row] for column in table.values()])
            lines.extend((line, (run, row)) for line in written * (1 + (defect == "doubled rows" and row % 17 == 5)))
            if defect == "words between rows" and row % 90 == 40:
                lines.append(("READY", None))

    truths = (truth,)
    if choice["form"] == "signals in rows":
        lines += [(joined(choice, (label(choice, c), *c.cells)), (0, k)) for k, c in enumerate(table.values())]
    elif defect == "a restart":
        until = 2 * count // 5
        add(0, until)
        add(1, count, again=True)
        part = {name: values[:until] for name, values in truth.columns.items()}
        truths = (Truth(part, truth.kept[:until], truth.tolerance, truth.day), truth)
    elif defect == "two blocks":
        add(0, count)
        lines.append(("", None))
        add(1, count)
        truths = (truth, truth)
    else:
        add(0, count)
    if defect == "a table after":
        lines += [("", None), *((joined(choice, cells), None) for cells in (("", "Min", "Max"), ("CH1", "0", "3")))]
    if defect == "cut in its last line":
        line, place = lines[-1]
        lines[-1] = (line[: -max(2, int(random.uniform(0.1, 0.6) * len(line)))], place)
        truth.kept[-1] = False
    rows = [(k, *at) for k, (_, at) in enumerate(one for one in lines if one[0].strip()) if at is not None]
    places = {name: k + (choice["header"] == "lines of channels") for k, name in enumerate(table)}
    end = {"LF": "\n", "CRLF": "\r\n", "CR": "\r", "blank lines between": "\n\n"}[choice["line ends"]]
    text = end.join(line for line, _ in lines) + ("" if defect == "cut in its last line" else end)
    suffix = ".jsonl" if choice["form"] == "JSON lines" and choice["suffix"] == ".csv" else choice["suffix"]
    return Drawn(
        *(choice, f"log{suffix}", text.encode(choice["encoding"]), given_with(choice, table), truths, rows),
        clock=[place for name, place in places.items() if name.startswith("clock ")],
        columns={name: (place, str(table[name].unit)) for name, place in places.items() if name in truth.columns},
    )


def given_with(choice: Mapping[str, str], table: Mapping[str, Column]) -> tuple[str, ...]:
    """Return what a person says of a file because it does not: the shunt, the interval, what unknown names mean."""
    given: list[str] = ["--shunt", f"{SHUNT_OHM:g} ohm"] if SHUNT in table else []
    if choice["clock"] == "a counter and a given interval":
        given += ["--sample-period", f"{PERIOD_S:g} s"]
    unnamed = choice["header"] == "no names"
    if choice["units"] == "nowhere" and (unnamed or choice["names"] in NUMBERED):
        for number, (name, column) in enumerate(table.items()):
            if name in MEASURED or (unnamed and name == "clock 0" and len(CLOCKS[choice["clock"]].names) == 1):
                unit = "" if column.unit is None else f":{column.unit}"
                given += [
                    "-c",
                    f"{TIME if name == 'clock 0' else name}={f'#{number + 1}' if unnamed else column.name}{unit}",
                ]
    if choice["given"] == "a unit against the file's":
        given += ["-c", f"{V}={label(choice, table[V])}:{'V' if table[V].unit == 'mV' else 'mV'}"]
    return tuple(given)


NUMBER = re.compile(r"([+-]?)\s*(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*(\D*)")


def read_as_told(one: Drawn) -> list[tuple[dict[str, Array], NDArray[np.intp]]]:
    """Return the columns of each test in SI and the numbers of their rows, by a reader that guesses nothing."""
    choice = one.choice
    lines = [line for line in re.split(r"\r\n|\r|\n", one.content.decode(choice["encoding"])) if line.strip()]
    runs: dict[int, dict[int, list[list[str]]]] = {}
    for line, run, row in one.rows:
        runs.setdefault(run, {}).setdefault(row, []).append(cells_as_told(lines[line], choice))
    found = []
    for parts in runs.values():
        rows = {row: cells_of_row(lists, choice["form"]) for row, lists in parts.items()}
        if choice["form"] == "signals in rows":
            rows = dict(enumerate(map(list, zip(*rows.values(), strict=True))))
        if choice["defect"] == "cut in its last line" and max(parts) == one.rows[-1][2]:
            rows.popitem()
        stamps = [tuple(stamp_as_told(cells[k], choice) for k in one.clock) for cells in rows.values()]
        columns = {TIME: CLOCKS[choice["clock"]].seconds(stamps)}
        for name, (index, unit) in one.columns.items():
            columns[name] = np.array([value_as_told(cells, index, unit, choice) for cells in rows.values()])
        if choice["readings"] == "current negative":
            columns[AMP] = -columns[AMP]
        found.append((columns, np.array(list(rows))))
    return found


def cells_as_told(line: str, choice: Mapping[str, str]) -> list[str]:
    """Return the cells of a line."""
    if choice["form"] == "JSON lines":
        return [str(each) for each in json.loads(line).values()] if line.endswith("}") else []
    if choice["form"] == "name: value lines":
        return [line.partition(":")[2].strip()]
    mark = {"a stamp before an arrow": "-> ", "a stamp in brackets": "] "}.get(choice["clock"], "")
    glued, _, rest = line.partition(mark) if mark else ("", "", line)
    separator = SEPARATORS[choice["separator"]]
    cells = (
        rest.replace('"', "").split()
        if separator == "  "
        else next(csv.reader([rest], delimiter=separator[0], skipinitialspace=True))
    )
    if choice["form"] == "name:value pairs":
        cells = [cell.partition(":")[2] for cell in cells]
    return ([glued + mark] if mark else []) + (cells[1:] if choice["form"] == "signals in rows" else cells)


def cells_of_row(lists: list[list[str]], form: str) -> list[str]:
    """Return the cells of a row that is in one line or in several."""
    if form == "name: value lines":
        return [cell for cells in lists for cell in cells]
    return [lists[0][1], *(cells[-1] for cells in lists)] if form == "long by channel" else lists[0]


def stamp_as_told(cell: str, choice: Mapping[str, str]) -> str:
    """Return a cell of a clock without what its unit and its decimal mark add."""
    unit = CLOCKS[choice["clock"]].unit
    if unit is not None:
        cell = cell.removesuffix(f" {unit}").replace(",", "." if choice["decimal"] == "decimal comma" else ",")
    return re.sub(r"\.0$", "", cell) if choice["form"] == "JSON lines" else cell


def value_as_told(cells: list[str], index: int, unit: str, choice: Mapping[str, str]) -> float:
    """Return a reading in SI; NaN for what is no number."""
    text = cells[index].replace(",", ".") if choice["decimal"] == "decimal comma" else cells[index]
    match = NUMBER.fullmatch(text.strip())
    if match is None:
        return np.nan
    beside = cells[index + 1] if "in a column" in choice["units"] else match[3].strip()
    return float(match[1] + match[2]) * FACTORS.get(beside or unit, np.nan)
