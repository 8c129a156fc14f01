"""Files as laboratories make them: each layout writes a loop as an instrument, a program or a person does.

A layout takes a loop (``loops.py``) and returns the files, what must come out of them, and how the import must end:
"read" as they are, by the "line" that the refusal names, or "refused" because nothing can be known. The formats of
instruments are those of their makers; the numbers are our own. An extra adds layouts of its files by a module
``tests/extras/NAME/labs/layouts.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from tests.labs.loops import Array, Loop

# What a person knows and no file of a scope states.
OF_A_SHUNT = ("--shunt", "0.47 ohm")
BEGAN = datetime(2026, 2, 17, 12, 21, 0, tzinfo=UTC)
V, AMP, R, STROKE = "wire_voltage_v", "wire_current_a", "wire_resistance_ohm", "displacement_m"
SHUNT, FORCE, TIME = "shunt_voltage_v", "force_n", "time_s"


@dataclass(frozen=True)
class Written:
    """Files by name, what must come out of them (columns in SI), what the person gives, and how the import ends."""

    files: Mapping[str, str | bytes]
    expected: Mapping[str, Array]
    ends: str = "read"
    given: tuple[str, ...] = ()


Layout = Callable[[Loop], Written]


def lines(rows: Iterable[Sequence[object]], separator: str = ",", end: str = "\n") -> str:
    return "".join(separator.join(map(str, row)) + end for row in rows)


def period_of(loop: Loop) -> float:
    return float(loop[TIME][1] - loop[TIME][0])


def numbers(*columns: Array, form: str = "%.6g") -> list[list[str]]:
    return [[form % cell for cell in row] for row in np.column_stack(columns).tolist()]


def chosen(loop: Loop, *names: str) -> dict[str, Array]:
    return {name: loop[name] for name in names}


# Oscilloscopes: names of channels say nothing, so that one line has to say what they measured.


def keysight_scope(loop: Loop) -> Written:
    rows = numbers(loop[TIME] - 30.0, loop[V], loop[SHUNT], form="%+.9E")
    text = lines([("x-axis", 1, 2), ("second", "Volt", "Volt"), *rows])
    return Written({"scope_0.csv": text}, {**chosen(loop, V, SHUNT), TIME: loop[TIME] - 30.0}, "line", given=OF_A_SHUNT)


def keysight_scope_by_number(loop: Loop) -> Written:
    columns = ("-c", f"{V}=#2:V", "-c", f"{SHUNT}=#3:V")
    return Written(keysight_scope(loop).files, chosen(loop, V, SHUNT), given=(*columns, *OF_A_SHUNT))


def rigol_scope(loop: Loop) -> Written:
    rows = [[number, *row, ""] for number, row in enumerate(numbers(loop[V], loop[SHUNT], form="%.5e"))]
    head = [
        ("X", "CH1", "CH2", "Start", "Increment", ""),
        ("Sequence", "VOLT", "VOLT", "-3.000000e+01", f"{period_of(loop):.6e}"),
    ]
    text = lines([*head, *rows])
    return Written(
        {"NewFile1.csv": text}, {**chosen(loop, V, SHUNT), TIME: loop[TIME] - 30.0}, "line", given=OF_A_SHUNT
    )


def rigol_scope_of_today(loop: Loop) -> Written:
    rows = [[*row, "", ""] for row in numbers(loop[V], loop[SHUNT], form="%.5e")]
    head = ("CH1(V)", "CH2(V)", "t0 =-3.000000e+01", f" tInc = {period_of(loop):.6e}", "")
    text = lines([head, *rows])
    return Written(
        {"RigolDS0.csv": text}, {**chosen(loop, V, SHUNT), TIME: loop[TIME] - 30.0}, "line", given=OF_A_SHUNT
    )


def _tektronix(loop: Loop, channel: str, name: str) -> str:
    beside = [
        ("Record Length", f"{loop[TIME].size:.6e}"), ("Sample Interval", "2.000000e-01"),
        ("Trigger Point", "1.500000000000e+02"), ("", ""), ("", ""), ("", ""), ("Source", channel),
        ("Vertical Units", "V"), ("Vertical Scale", "1.0e+00"), ("Vertical Offset", "0.0"), ("Horizontal Units", "s"),
        ("Horizontal Scale", "5.0"), ("Pt Fmt", "Y"), ("Yzero", "0.0"), ("Probe Atten", "1.0e+00"),
        ("Model Number", "TDS2024"), ("Serial Number", "C000000"), ("Firmware Version", "FV:v4.12"),
    ]  # fmt: skip
    rows = [(f"{t:.12f}", f"{v:.5f}") for t, v in zip(loop[TIME] - 30.0, loop[name], strict=True)]
    return lines(
        (*(beside[number] if number < len(beside) else ("", "")), "", *row, "") for number, row in enumerate(rows)
    )


def tektronix_scope(loop: Loop) -> Written:
    text = _tektronix(loop, "CH1", V)
    return Written({"F0000CH1.CSV": text}, {TIME: loop[TIME] - 30.0, V: loop[V]}, "line")


def tektronix_scope_two_channels(loop: Loop) -> Written:
    files = {"F0000CH1.CSV": _tektronix(loop, "CH1", V), "F0000CH2.CSV": _tektronix(loop, "CH2", SHUNT)}
    given = ("-c", f"{V}=CH1:V", "-c", f"{SHUNT}=CH2:V", "--join", TIME)
    return Written(files, {TIME: loop[TIME] - 30.0, **chosen(loop, V, SHUNT)}, given=given)


def tektronix_scope_of_today(loop: Loop) -> Written:
    head = [
        ("Model", "MSO24"), ("Firmware Version", "1.44.3"), ("", ""), ("Waveform Type", "ANALOG", "", ""),
        ("Point Format", "Y", "", ""), ("Horizontal Units", "s", "", ""), ("Horizontal Scale", "6", "", ""),
        ("Sample Interval", "0.2", "", ""), ("Record Length", loop[TIME].size, "", ""),
        ("Vertical Units", "V", "V", ""), ("Vertical Offset", "0", "0", ""), ("Vertical Scale", "1", "0.05", ""),
        ("", "", ""), ("", "", ""), ("Label", "", "", ""), ("TIME", "CH1", "CH2"),
    ]  # fmt: skip
    text = lines([*head, *numbers(loop[TIME] - 30.0, loop[V], loop[SHUNT])])
    return Written({"Tek000.csv": text}, {TIME: loop[TIME] - 30.0, **chosen(loop, V, SHUNT)}, "line", given=OF_A_SHUNT)


def siglent_scope(loop: Loop) -> Written:
    head = [
        ("Record Length", f"Analog:{loop[TIME].size}"), ("Sample Interval", "Analog:2.000000e-01"),
        ("Vertical Units", "CH1:V", "CH2:V", "CH3:", "CH4:"),
        ("Vertical Scale", "CH1:1.00", "CH2:0.05", "CH3:", "CH4:"),
        ("Vertical Offset", "CH1:0.0", "CH2:0.0", "CH3:", "CH4:"), ("Horizontal Units", "s"),
        ("Horizontal Scale", "5.0"), ("Model Number", "SDS1104X-E"), ("Serial Number", "SDSXXXX"),
        ("Software Version", "8.2.6.1.37R9"), ("Source", "CH1", "CH2"), ("Second", "Volt", "Volt"),
    ]  # fmt: skip
    text = lines([*head, *numbers(loop[TIME] - 30.0, loop[V], loop[SHUNT])])
    return Written(
        {"SDS00001.csv": text}, {TIME: loop[TIME] - 30.0, **chosen(loop, V, SHUNT)}, "line", given=OF_A_SHUNT
    )


# Meters, source meters and loggers.


def keithley_buffer(loop: Loop) -> Written:
    names = "Index,Reading,Unit,Range Digits,Disp Digits,Math,Start Group,Terminal,Origin,Value,Unit,Digits,Output,Time"
    rows = [
        (
            number + 1,
            v,
            "Volt DC",
            "20.00",
            "6.50",
            "F",
            "F",
            "Front",
            "Main",
            i,
            "Amp DC",
            "6.50",
            "T",
            t,
        )
        for number, (v, i, t) in enumerate(numbers(loop[V], loop[AMP], loop[TIME]))
    ]
    text = "General Information\nBuffer Name,defbuffer1\nCapacity,100000\n\n" + names + "\n" + lines(rows)
    return Written({"defbuffer1.csv": text}, chosen(loop, TIME, V, AMP), "line")


def keithley_kickstart(loop: Loop) -> Written:
    head = "Model,2450\nSerial Number,04300000\nStart Time,2/17/2026 12:21:00\n\n"
    names = ("Reading Number", "Relative Time (s)", "Voltage (V)", "Current (A)")
    rows = [(number + 1, *row) for number, row in enumerate(numbers(loop[TIME], loop[V], loop[AMP]))]
    return Written({"2450-1.csv": head + lines([names, *rows])}, chosen(loop, TIME, V, AMP))


def german_source_meter(loop: Loop) -> Written:
    head = f"Gerät: Keithley 2450\nDatum: 17.02.2026\nAbtastrate: {1.0 / period_of(loop):g} Hz\n\n"
    rows = [[cell.replace(".", ",") for cell in row] for row in numbers(loop[V], 1e3 * loop[AMP])]
    text = head + lines([("Spannung [V]", "Strom [mA]"), *rows], ";", "\r\n")
    return Written({"messung.csv": text}, {TIME: loop[TIME], **chosen(loop, V, AMP)})


def keysight_source_meter(loop: Loop) -> Written:
    head = [("SetupTitle", "sma hold"), ("PrimitiveTest", "I/V-t Sampling"), ("Dimension1", loop[TIME].size)]
    names = ("DataName", " Time", " V1", " I1")
    units = ("DataUnit", " s", " V", " A")
    rows = [("DataValue", *(" " + cell for cell in row)) for row in numbers(loop[TIME], loop[V], loop[AMP])]
    return Written({"sampling.csv": lines([*head, names, units, *rows])}, chosen(loop, TIME, V, AMP), "line")


def keysight_quick_iv(loop: Loop) -> Written:
    head = "Instrument,B2902A\nInterval,2.0E-01 s\n"
    rows = [(number + 1, *row) for number, row in enumerate(numbers(loop[V], loop[AMP], loop[TIME]))]
    return Written(
        {"quick.csv": head + lines([("Point", "Voltage (V)", "Current (A)", "Time (s)"), *rows])},
        chosen(loop, TIME, V, AMP),
    )


def keysight_logger(loop: Loop) -> Written:
    stamps = [(BEGAN + timedelta(seconds=float(t))).strftime("%m/%d/%Y %H:%M:%S.%f")[:-3] for t in loop[TIME]]
    names = ("Scan", "Time", "101 <R wire> (OHM)", "102 <LVDT> (MM)")
    rows = [
        (number + 1, stamp, *row)
        for number, (stamp, row) in enumerate(zip(stamps, numbers(loop[R], 1e3 * loop[STROKE]), strict=True))
    ]
    return Written({"daq970.csv": lines([names, *rows])}, {TIME: loop[TIME], **chosen(loop, R, STROKE)}, "line")


def units_in_columns(loop: Loop) -> Written:
    names = ("Start Time", "Primary", "", "Maximum", "", "Minimum", "", "#Samples", "Type")
    rows = [
        ((BEGAN + timedelta(seconds=number)).strftime("%Y-%m-%d %H:%M:%S"), f"{r:.4f}", "OHM",
         f"{r + 0.01:.4f}", "OHM", f"{r - 0.01:.4f}", "OHM", 10, "INTERVAL")
        for number, r in enumerate(loop[R])
    ]  # fmt: skip
    expected = {TIME: np.arange(loop[TIME].size, dtype=np.float64), R: loop[R]}
    return Written({"rec7.txt": lines([names, *rows], "\t")}, expected, "line")


def lcr_meter(loop: Loop) -> Written:
    names = ("Time (s)", "Rs (Ohm)", "Ls (uH)", "Current (mA)", "LVDT (mm)")
    rows = numbers(loop[TIME], loop[R], 0.7 + 0.0 * loop[R], 1e3 * loop[AMP], 1e3 * loop[STROKE])
    return Written({"lcr.csv": lines([names, *rows])}, chosen(loop, TIME, R, AMP, STROKE))


def overlong_unit_names(loop: Loop) -> Written:
    names = ("Time [Seconds]", "Resistance [Ohms]", "Stroke [Millimeters]")
    return Written(
        {"meter.csv": lines([names, *numbers(loop[TIME], loop[R], 1e3 * loop[STROKE])])}, chosen(loop, TIME, R, STROKE)
    )


# Sketches, people, scripts.


def sketch_blocks(loop: Loop) -> Written:
    text = "".join(
        f"Bus Voltage:   {v:.4f} V\nShunt Voltage: {1e3 * s:.3f} mV\nCurrent:       {1e3 * i:.3f} mA\n\n"
        for v, s, i in zip(loop[V], loop[SHUNT], loop[AMP], strict=True)
    )
    return Written({"serial.txt": text}, {}, "refused")


def sketch_blocks_with_time(loop: Loop) -> Written:
    text = "".join(
        f"Time: {1e3 * t:.0f} ms\nWire voltage: {v:.4f} V\nCurrent: {1e3 * i:.3f} mA\n"
        f"Position: {1e3 * x:.4f} mm\n----\n"
        for t, v, i, x in zip(loop[TIME], loop[V], loop[AMP], loop[STROKE], strict=True)
    )
    return Written({"putty.log.txt": text}, chosen(loop, TIME, V, AMP, STROKE))


def sketch_pairs(loop: Loop) -> Written:
    text = "".join(
        f"millis:{1e3 * t:.0f},V_wire:{v:.4f} V,I_mA:{1e3 * i:.3f}\n"
        for t, v, i in zip(loop[TIME], loop[V], loop[AMP], strict=True)
    )
    return Written({"plotter.txt": text}, chosen(loop, TIME, V, AMP))


def units_inside_cells(loop: Loop) -> Written:
    rows = [
        (f"{t:.1f} s", f"{v:.4f} V", f"{1e3 * i:.3f} mA", f"{1e3 * x:.4f} mm")
        for t, v, i, x in zip(loop[TIME], loop[V], loop[AMP], loop[STROKE], strict=True)
    ]
    return Written(
        {"typed.csv": lines([("Time", "Voltage", "Current", "Stroke"), *rows])}, chosen(loop, TIME, V, AMP, STROKE)
    )


def minutes_and_seconds(loop: Loop) -> Written:
    stamps = [f"{int(t) // 60:02d}:{t % 60:04.1f}" for t in loop[TIME]]
    rows = [(stamp, *row) for stamp, row in zip(stamps, numbers(loop[R], 1e3 * loop[STROKE]), strict=True)]
    return Written({"watch.csv": lines([("Time", "R (Ohm)", "Stroke (mm)"), *rows])}, chosen(loop, TIME, R, STROKE))


def whole_minutes_and_seconds(loop: Loop) -> Written:
    seconds = np.arange(loop[TIME].size)
    rows = [
        (f"{t // 60:02d}:{t % 60:02d}", *row)
        for t, row in zip(seconds, numbers(loop[R], 1e3 * loop[STROKE]), strict=True)
    ]
    expected = {TIME: seconds.astype(np.float64), **chosen(loop, R, STROKE)}
    return Written({"stopwatch.csv": lines([("Time (mm:ss)", "R (Ohm)", "Stroke (mm)"), *rows])}, expected)


def unnamed_minutes_and_seconds(loop: Loop) -> Written:
    table = whole_minutes_and_seconds(loop)
    text = str(table.files["stopwatch.csv"]).replace("Time (mm:ss)", "Time")
    return Written({"stopwatch.csv": text}, table.expected, "line")


def unix_time(loop: Loop) -> Written:
    rows = [
        (f"{BEGAN.timestamp() + t:.3f}", *row) for t, row in zip(loop[TIME], numbers(loop[V], loop[AMP]), strict=True)
    ]
    return Written({"pi.csv": lines([("timestamp", "V_wire (V)", "I (A)"), *rows])}, chosen(loop, TIME, V, AMP))


def stamps_of_batches(loop: Loop) -> Written:
    stamps = loop[TIME][np.arange(loop[TIME].size) // 20 * 20]
    rows = numbers(stamps, loop[V], 1e3 * loop[SHUNT], 1e3 * loop[STROKE])
    text = lines([("Time (s)", "V_wire (V)", "V_shunt (mV)", "Laser (mm)"), *rows])
    return Written({"batch.csv": text}, chosen(loop, TIME, V, SHUNT, STROKE), "line", given=OF_A_SHUNT)


def polled_too_fast(loop: Loop) -> Written:
    noisy = loop[R] * (1.0 + 1e-3 * np.sin(1e3 * np.arange(loop[R].size) ** 1.5))
    table = np.column_stack([loop[TIME], noisy, 1e3 * loop[STROKE] + 1e-3 * np.cos(np.arange(noisy.size) ** 2)])
    source = np.repeat(np.arange(noisy.size), np.where(np.arange(noisy.size) % 3 == 1, 2, 1))
    repeated = table[source].copy()
    again = np.flatnonzero(np.diff(source, prepend=-1) == 0)
    late = np.where(np.arange(again.size) % 7 == 0, 0.0, 0.09)
    repeated[again, 0] += late
    text = lines([("t (s)", "R (Ohm)", "Laser (mm)"), *numbers(*repeated.T, form="%.7g")])
    return Written({"polled.csv": text}, {TIME: loop[TIME], R: noisy, STROKE: table[:, 2] / 1e3})


def doubled_rows(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[V], loop[AMP])
    doubled = [row for number, row in enumerate(rows) for _ in range(1 + (number % 10 == 3))]
    return Written({"doubled.csv": lines([("Time (s)", "V_wire (V)", "I (A)"), *doubled])}, chosen(loop, TIME, V, AMP))


def empty_first_column(loop: Loop) -> Written:
    rows = [("", *row) for row in numbers(loop[TIME], loop[V], 1e3 * loop[AMP])]
    return Written({"pasted.csv": lines([("", "Time (s)", "V_wire (V)", "I (mA)"), *rows])}, chosen(loop, TIME, V, AMP))


def numbered_rows(loop: Loop) -> Written:
    rows = [(number, *row) for number, row in enumerate(numbers(loop[TIME], loop[V], loop[AMP]))]
    return Written({"frame.csv": lines([("", "time_s", "wire_voltage_v", "wire_current_a"), *rows])},
                   chosen(loop, TIME, V, AMP))  # fmt: skip


def blank_row_below_headers(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[R], loop[FORCE])
    return Written({"machine.csv": lines([("Time (s)", "R (Ohm)", "Load (N)"), ("", "", ""), *rows])},
                   chosen(loop, TIME, R, FORCE))  # fmt: skip


def unit_row(loop: Loop) -> Written:
    head = [("Time", "Voltage", "Current", "Stroke"), ("sec", "volts", "mA", "mm")]
    rows = numbers(loop[TIME], loop[V], 1e3 * loop[AMP], 1e3 * loop[STROKE])
    return Written({"units.tsv": lines([*head, *rows], "\t")}, chosen(loop, TIME, V, AMP, STROKE))


def short_names(loop: Loop) -> Written:
    names = ("t_rel_s", "sma_v", "sma_i", "laser_mm")
    rows = numbers(loop[TIME], loop[V], loop[AMP], 1e3 * loop[STROKE])
    return Written({"console_joined.csv": lines([names, *rows])}, chosen(loop, TIME, V, AMP, STROKE), "line")


def two_clocks_of_a_host(loop: Loop) -> Written:
    names = ("host_timestamp_s", "monotonic_s", "rs_raw_ohm", "laser_mm")
    rows = [
        (f"{BEGAN.timestamp() + t:.4f}", f"{5123.4 + t:.4f}", *row)
        for t, row in zip(loop[TIME], numbers(loop[R], 1e3 * loop[STROKE]), strict=True)
    ]
    return Written({"processed.csv": lines([names, *rows])}, {TIME: loop[TIME], R: loop[R], STROKE: loop[STROKE]})


def factor_of_a_laser(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[R], 2e3 * loop[STROKE])
    text = lines([("Time (s)", "R (Ohm)", "Laser (V)"), *rows])
    given = ("-c", f"{STROKE}=Laser (V):2 V/mm")
    return Written({"laser.csv": text}, chosen(loop, TIME, R, STROKE), given=given)


def factor_of_a_bare_laser(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[R], 4e3 * loop[STROKE])
    text = lines([("Time (s)", "R (Ohm)", "laser_raw"), *rows])
    given = ("-c", f"{STROKE}=laser_raw:0.25 mm/V")
    return Written({"laser.csv": text}, chosen(loop, TIME, R, STROKE), given=given)


def strain_of_a_coil(loop: Loop) -> Written:
    strain = 0.334 * loop[STROKE] / loop[STROKE].max()
    rows = numbers(loop[TIME], loop[R], strain)
    return Written({"coil.csv": lines([("Time (s)", "R (Ohm)", "strain"), *rows])},
                   {**chosen(loop, TIME, R), "reference_strain": strain})  # fmt: skip


def voltage_of_a_sensor(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[FORCE], 1.0 + 0.1 * loop[FORCE])
    text = lines([("time_s", "force_N", "voltage_V"), *rows])
    return Written({"sensor.csv": text}, {}, "refused")


def a_column_mapped_twice(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[V], loop[V])
    text = lines([("Time (s)", "A (V)", "B (V)"), *rows])
    return Written({"twice.csv": text}, {}, "refused", ("-c", f"{V}=A (V)", "-c", f"{V}=B (V)"))


# Tables without a clock, of which only the order counts, and tables of something else than samples.


def branches_side_by_side(loop: Loop) -> Written:
    peak = int(np.argmax(loop[AMP]))
    # Side by side both branches have as many rows: those that the shorter one has, of a sparse loop.
    count = min(40, peak + 1, loop[AMP].size - peak)
    rising = np.linspace(0, peak, count).round().astype(int)
    falling = np.linspace(peak, loop[AMP].size - 1, count).round().astype(int)
    cells = numbers(*(scale * loop[name][rows] for rows in (rising, falling)
                      for name, scale in ((AMP, 1.0), (R, 1.0), (STROKE, 1e3))))  # fmt: skip
    names = ["Current heating [A]", "Resistance heating [Ohm]", "Stroke heating [mm]",
             "Current cooling [A]", "Resistance cooling [Ohm]", "Stroke cooling [mm]"]  # fmt: skip
    order = np.concatenate([rising, falling])
    return Written({"staircase.csv": lines([names, *cells])}, {name: loop[name][order] for name in (AMP, R, STROKE)})


def cooling_from_the_cold(loop: Loop) -> Written:
    """The branches side by side, both in rows of rising current: cooling has to be turned around."""
    peak = int(np.argmax(loop[AMP]))
    # Side by side both branches have as many rows: those that the shorter one has, of a sparse loop.
    count = min(40, peak + 1, loop[AMP].size - peak)
    rising = np.linspace(0, peak, count).round().astype(int)
    falling = np.linspace(peak, loop[AMP].size - 1, count).round().astype(int)
    cells = numbers(*(scale * loop[name][rows] for rows in (rising, falling[::-1])
                      for name, scale in ((AMP, 1e3), (R, 1.0), (STROKE, 1e3))))  # fmt: skip
    names = ["I_heat (mA)", "R_heat (ohm)", "pos_heat (mm)", "I_cool (mA)", "R_cool (ohm)", "pos_cool (mm)"]
    order = np.concatenate([rising, falling])
    return Written({"sweep.csv": lines([names, *cells])}, {name: loop[name][order] for name in (AMP, R, STROKE)})


def heating_only(loop: Loop) -> Written:
    rows = np.unique(np.linspace(0, int(np.argmax(loop[AMP])), 30).round().astype(int))
    columns = {name: loop[name][rows] for name in (AMP, R, STROKE)}
    text = lines(
        [
            ("Current (mA)", "R (Ohm)", "Stroke (mm)"),
            *numbers(1e3 * columns[AMP], columns[R], 1e3 * columns[STROKE]),
        ]
    )
    return Written({"up.csv": text}, columns)


def pulses(loop: Loop) -> Written:
    rows = np.arange(0, int(np.argmax(loop[AMP])), 3)
    length_s = 0.1 + 0.1 * (np.arange(rows.size) % 4)
    current_a, ohm, stroke_m = loop[AMP][rows], loop[R][rows], loop[STROKE][rows]
    cold = loop[R][0] + 0.0 * ohm
    cells = numbers(1e3 * current_a, 1e3 * length_s, cold, ohm, 1e3 * stroke_m)
    names = ("current_mA", "pulse_ms", "R_cold_ohm", "R_end_ohm", "peak_stroke_mm")
    expected = {AMP: current_a, "pulse_duration_s": length_s, R: ohm, STROKE: stroke_m, "cold_resistance_ohm": cold}
    return Written({"heat_time_map.csv": lines([names, *cells])}, expected)


def long_table(loop: Loop) -> Written:
    series = (("wire_voltage_v", V), ("wire_current_a", AMP), ("displacement_m", STROKE))
    times = zip(loop[TIME], *(loop[column] for _, column in series), strict=True)
    rows = [
        (name, f"{t:.1f}", f"{value:.6g}")
        for t, *values in times
        for (name, _), value in zip(series, values, strict=True)
    ]
    return Written({"long.csv": lines([("source", "time_s", "value"), *rows])}, chosen(loop, TIME, V, AMP, STROKE))


def long_table_of_two_rates(loop: Loop) -> Written:
    rows = [("meter", f"{1e6 * t:.0f}", f"{r:.6g}", "ohm") for t, r in zip(loop[TIME], loop[R], strict=True)]
    fine_s = np.linspace(0.0, loop[TIME][-1], 3 * loop[TIME].size - 2)
    fine_mm = 1e3 * np.interp(fine_s, loop[TIME], loop[STROKE])
    rows += [("laser", f"{1e6 * t:.0f}", f"{x:.6g}", "mm") for t, x in zip(fine_s, fine_mm, strict=True)]
    rows.sort(key=lambda row: int(row[1]))
    return Written({"events.csv": lines([("src", "hw_us", "value", "unit"), *rows])}, chosen(loop, R, STROKE), "line")


def two_tests_below_each_other(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[R], loop[FORCE])
    text = lines([("Time (s)", "R (Ohm)", "Load (N)"), *rows, *rows[::2]])
    return Written({"tests.csv": text}, chosen(loop, TIME, R, FORCE), "line")


def two_tests_each_with_headers(loop: Loop) -> Written:
    rows = numbers(loop[TIME], loop[R], loop[FORCE])
    head = ("Time (s)", "R (Ohm)", "Load (N)")
    return Written(
        {"runs.csv": lines([head, *rows]) + "\n" + lines([head, *rows])}, chosen(loop, TIME, R, FORCE), "line"
    )


# Two instruments.


def two_files_of_one_host(loop: Loop) -> Written:
    began_s = BEGAN.timestamp()
    fine_s = np.linspace(-1.0, loop[TIME][-1] + 1.0, 1500)
    fine_mm = 1e3 * np.interp(fine_s, loop[TIME], loop[STROKE])

    def file(header: str, times_s: Array, values: Array) -> str:
        rows = ((f"{began_s + t:.4f}", f"{value:.6g}") for t, value in zip(times_s, values, strict=True))
        return lines([("host_timestamp_s", header), *rows])

    meter, laser = file("R (Ohm)", loop[TIME], loop[R]), file("laser_mm", fine_s, fine_mm)
    # A faster instrument is averaged over the sample period of the slower one.
    around = [np.abs(fine_s - time_s) <= 0.5 * period_of(loop) for time_s in loop[TIME]]
    means_m = np.array([1e-3 * fine_mm[rows].mean() for rows in around])
    return Written({"meter.csv": meter, "laser.csv": laser}, {**chosen(loop, TIME, R), STROKE: means_m})


def two_clocks_of_two_rates(loop: Loop) -> Written:
    """The second clock is 1.3 % fast and was started seconds before; both recorded the current, with a few steps."""
    time_s = np.arange(0.0, 200.0, 0.1)
    steps_a = np.interp(time_s, 200.0 / 60.0 * loop[TIME], loop[AMP]) * (1.0 + 0.3 * (np.searchsorted(
        [21.0, 44.0, 58.0, 90.0, 97.0, 131.0, 160.0, 171.0], time_s) % 2))  # fmt: skip
    ohm = np.interp(time_s, 200.0 / 60.0 * loop[TIME], loop[R])
    other_s = np.arange(2.0, 197.0, 0.13)
    force_n = np.interp(other_s, 200.0 / 60.0 * loop[TIME], loop[FORCE])
    steps_other_a = np.interp(other_s, time_s, steps_a)
    one = lines([("Time (s)", "I (A)", "R (Ohm)"), *numbers(time_s, steps_a, ohm)])
    other = lines([("Time (s)", "I (A)", "Load (N)"), *numbers(1.013 * other_s + 4.2, steps_other_a, force_n)])
    return Written({"source.csv": one, "cell.csv": other}, {}, "refused", given=("--join", AMP))


def two_sines(loop: Loop) -> Written:
    """Two cycles of a sine, as we recommend them: only the person knows the delay."""
    time_s = np.concatenate([loop[TIME], loop[TIME][1:] + loop[TIME][-1]])
    twice = {name: np.concatenate([loop[name], loop[name][1:]]) for name in (R, FORCE, AMP)}
    one = lines([("Time (s)", "I (A)", "R (Ohm)"), *numbers(time_s, twice[AMP], twice[R])])
    other = lines([("Time (s)", "I (A)", "Load (N)"), *numbers(time_s + 7.0, twice[AMP], twice[FORCE])])
    return Written({"source.csv": one, "cell.csv": other}, {TIME: time_s, R: twice[R], FORCE: twice[FORCE]},
                   given=("--delay", "7 s"))  # fmt: skip


def two_sines_of_unknown_delay(loop: Loop) -> Written:
    return Written(two_sines(loop).files, {}, "refused", ("--join", AMP))


LAYOUTS: tuple[Layout, ...] = (
    keysight_scope, keysight_scope_by_number, rigol_scope, rigol_scope_of_today, tektronix_scope,
    tektronix_scope_two_channels, tektronix_scope_of_today, siglent_scope, keithley_buffer, keithley_kickstart,
    german_source_meter, keysight_source_meter, keysight_quick_iv, keysight_logger, units_in_columns, lcr_meter,
    overlong_unit_names, sketch_blocks, sketch_blocks_with_time, sketch_pairs, units_inside_cells, minutes_and_seconds,
    whole_minutes_and_seconds, unnamed_minutes_and_seconds, unix_time, stamps_of_batches, polled_too_fast, doubled_rows,
    empty_first_column, numbered_rows, blank_row_below_headers, unit_row, short_names, two_clocks_of_a_host,
    factor_of_a_laser, factor_of_a_bare_laser, strain_of_a_coil, voltage_of_a_sensor, a_column_mapped_twice,
    branches_side_by_side, cooling_from_the_cold, heating_only, pulses, long_table, long_table_of_two_rates,
    two_tests_below_each_other, two_tests_each_with_headers, two_files_of_one_host, two_clocks_of_two_rates, two_sines,
    two_sines_of_unknown_delay,
)  # fmt: skip
