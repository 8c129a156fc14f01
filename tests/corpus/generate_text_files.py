"""Write the text files of the corpus: one small recording as many programs and people write it, and damaged files.

    python tests/corpus/generate_text_files.py

Every file holds the same ten rows (time, voltage, current, displacement, temperature) in another shape, so that what is
read can be compared with numbers known beforehand: text_files.toml says for each file what must come out. Files whose
numbers are not these say so there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROWS = range(10)
TIME_S = [0.1 * row for row in ROWS]
WIRE_V = [1.25 + 0.05 * row for row in ROWS]
CURRENT_A = [0.18 + 0.001 * row for row in ROWS]
MOVED_MM = [0.15 * row for row in ROWS]
HEAT_C = [25.0 + 2.5 * row for row in ROWS]
COLUMNS = (TIME_S, WIRE_V, CURRENT_A, MOVED_MM, HEAT_C)
PLAIN_HEADERS = ("Time [s]", "V_SMA [V]", "Current [A]", "LVDT [mm]", "T [degC]")
START = datetime(2026, 3, 1, 23, 59, 59, 500000)


def number(value: float) -> str:
    return f"{value:.4f}"


def comma(value: float) -> str:
    return f"{value:.4f}".replace(".", ",")


def table(
    headers: Sequence[str] = PLAIN_HEADERS,
    columns: Sequence[Sequence[float | str]] = COLUMNS,
    separator: str = ",",
    spell: Callable[[float], str] = number,
    above: str = "",
    end: str = "\n",
    after: str = "",
) -> str:
    """Return a table as text; ``above`` comes before the headers and ``after`` at the end of every line."""
    rows = [
        separator.join(cell if isinstance(cell, str) else spell(cell) for cell in row)
        for row in zip(*columns, strict=True)
    ]
    head = [separator.join(headers)] if headers else []
    return above + "".join(line + after + end for line in (*head, *rows))


def scaled(factors: Sequence[float]) -> list[list[float]]:
    return [[factor * value for value in column] for factor, column in zip(factors, COLUMNS, strict=True)]


def moments(pattern: str, milliseconds: bool = True) -> list[str]:
    """Return the times of the rows as text, from just before midnight on."""
    found = [START + timedelta(seconds=time_s) for time_s in TIME_S]
    return [each.strftime(pattern) + (f"{each.microsecond // 1000:03d}" if milliseconds else "") for each in found]


def timed(header: str, times: Sequence[str], **how: object) -> str:
    return table((header, *PLAIN_HEADERS[1:]), (times, *COLUMNS[1:]), **how)  # type: ignore[arg-type]


def days_of_excel() -> list[str]:
    return [f"{46082.25 + time_s / 86400.0:.12f}" for time_s in TIME_S]


def two_branches(headers: str) -> str:
    """Return heating and cooling next to each other, the second with fewer rows."""
    heating = [(40.0 + 5.0 * row, 4.0 - 0.4 * row) for row in ROWS]
    cooling = [(85.0 - 6.0 * row, 0.4 + 0.45 * row) for row in range(8)]
    lines = [headers]
    for row in ROWS:
        right = cooling[row] if row < len(cooling) else None
        cells = [*map(number, heating[row]), *(map(number, right) if right else ("", ""))]
        lines.append(",".join([*cells[:2], "172", *cells[2:], "172" if right else ""]))
    return "\n".join(lines) + "\n"


GERMAN = ("Zeit [s]", "Spannung [V]", "Strom [A]", "Weg [mm]", "Temperatur [°C]")
KEITHLEY = (
    "Title,,Basic DC Readings,,,,\nInstrument,Model,2450,Serial Number,01234567,,\nSample Interval,0.1 s,,,,,\n"
    "Limit,1.05 A\n,,,,,,\n"
)
LABVIEW_TITLE = "Test of spool 3, 172 MPa\nOperator;Meier\nDatum;01.03.2026\n\n"

READ: dict[str, str | bytes] = {
    "plain.csv": table(),
    "windows_line_ends.csv": table(end="\r\n"),
    "old_macintosh_line_ends.csv": table(end="\r"),
    "no_last_line_end.csv": table().rstrip("\n"),
    "utf8_mark.csv": b"\xef\xbb\xbf" + table().encode(),
    "utf16_little.csv": table(separator="\t").encode("utf-16"),
    "utf16_without_mark.txt": table(separator="\t").encode("utf-16-le"),
    "latin1_degrees.csv": table((*PLAIN_HEADERS[:4], "T [°C]")).encode("latin-1"),
    "semicolons_decimal_commas.csv": table(GERMAN, separator=";", spell=comma),
    "semicolons_decimal_points.csv": table(GERMAN, separator=";"),
    "tabs_decimal_commas_trailing.txt": table(GERMAN, separator="\t", spell=comma, after="\t"),
    "quoted_decimal_commas.csv": table(spell=lambda value: f'"{comma(value)}"'),
    "all_quoted.csv": table([f'"{header}"' for header in PLAIN_HEADERS], spell=lambda value: f'"{number(value)}"'),
    "bars.txt": table(separator="|"),
    "spaces.txt": table(separator="   "),
    "aligned_spaces.txt": table(separator=" ", spell=lambda value: f"{value:>12.4e}"),
    "excel_sep_line.csv": table(separator=";", above="sep=;\r\n", end="\r\n"),
    "trailing_commas.csv": table(after=","),
    "empty_lines_at_end.csv": table() + ",,,,\n,,,,\n\n",
    "title_lines.csv": table(GERMAN, separator=";", spell=comma, above=LABVIEW_TITLE),
    "keithley_like.csv": table(above=KEITHLEY),
    "excel_title_with_commas.csv": table(above="Loop 7,,,,\n,,,,\n"),
    "comment_lines.csv": table(above="# wire = 100 um Flexinol\n# shunt_resistance = 1.0 ohm\n"),
    "percent_comments.txt": table(separator="\t", above="% exported by a script\n% version 2\n"),
    "numpy_savetxt.txt": "# " + table(separator=" ").replace("] ", "]  "),
    "rule_below_headers.txt": table(separator="\t").replace("\n", "\n------\t------\t------\t------\t------\n", 1),
    "units_in_second_row.csv": table(("Time", "V_SMA", "Current", "LVDT", "T"), above="").replace(
        "\n", "\ns,V,A,mm,°C\n", 1
    ),
    "units_in_brackets_below.csv": table(GERMAN).replace("\n", "\n[s],[V],[A],[mm],[°C]\n", 1).replace(" [", "[", 0),
    "origin_long_names.txt": table(
        ("Time", "Wire voltage", "Current", "Displacement", "Temperature"), separator="\t"
    ).replace("\n", "\ns\tV\tA\tmm\tdegC\n", 1),
    "units_after_underscore.csv": table(
        ("time_ms", "V_SMA_mV", "current_mA", "lvdt_um", "T_degC"), scaled((1e3, 1e3, 1e3, 1e3, 1.0))
    ),
    "units_in_words.csv": table(
        ("Time in milliseconds", "Wire voltage in volts", "Current in amps", "Position in microns", '"Temp, deg C"'),
        scaled((1e3, 1.0, 1.0, 1e3, 1.0)),
    ),
    "units_after_slash.csv": table(("t / s", "U / mV", "I / mA", "x / mm", "T / °C"), scaled((1, 1e3, 1e3, 1, 1))),
    "units_after_comma.csv": table(
        ("Zeit, s", "Spannung, V", "Strom, A", "Weg, mm", "Temperatur, °C"), separator=";", spell=comma
    ),
    "header_is_the_unit.csv": table(("ms", *PLAIN_HEADERS[1:]), scaled((1e3, 1, 1, 1, 1))),
    "thousands_commas.csv": table(
        ("Time [ms]", "V_SMA [mV]", "Current [mA]", "LVDT [um]", "T [degC]"),
        scaled((1e3, 1e3, 1e3, 1e3, 1.0)),
        spell=lambda value: f'"{value:,.2f}"',
    ),
    "thousands_points.csv": table(
        ("Zeit [ms]", "Spannung [mV]", "Strom [mA]", "Weg [um]", "Temperatur [°C]"),
        scaled((1e3, 1e3, 1e3, 1e3, 1.0)),
        separator=";",
        spell=lambda value: f"{value:,.2f}".translate(str.maketrans(",.", ".,")),
    ),
    "thousands_apostrophes.csv": table(
        ("Zeit [ms]", "Spannung [mV]", "Strom [mA]", "Weg [um]", "Temperatur [°C]"),
        scaled((1e3, 1e3, 1e3, 1e3, 1.0)),
        separator=";",
        spell=lambda value: f"{value:,.2f}".replace(",", "'"),
    ),
    "fortran_exponents.txt": table(separator="  ", spell=lambda value: f"{value:.6E}".replace("E", "D")),
    "iso_times.csv": timed("Timestamp", moments("%Y-%m-%dT%H:%M:%S.")),
    "iso_times_zone.csv": timed("Timestamp", [f"{each}+01:00" for each in moments("%Y-%m-%d %H:%M:%S.")]),
    "german_dates.csv": timed("Datum Uhrzeit", moments("%d.%m.%Y %H:%M:%S,"), separator=";", spell=comma),
    "american_dates.csv": timed("Date/Time", moments("%m/%d/%Y %H:%M:%S.")),
    "date_and_time_apart.csv": table(
        ("Date", "Time", *PLAIN_HEADERS[1:]),
        (moments("%Y/%m/%d", False), moments("%H:%M:%S."), *COLUMNS[1:]),
    ),
    "times_of_day_over_midnight.csv": timed("Time", moments("%H:%M:%S.")),
    "elapsed_minutes_and_seconds.csv": timed("Elapsed", [f"00:{time_s:04.1f}" for time_s in TIME_S]),
    "excel_dates_as_numbers.csv": timed("Date", days_of_excel()),
    "unix_seconds.csv": timed("timestamp", [f"{1772409599.5 + time_s:.3f}" for time_s in TIME_S]),
    "unix_milliseconds.csv": timed("timestamp", [f"{1772409599500 + 1000 * time_s:.0f}" for time_s in TIME_S]),
    "month_in_letters.csv": timed("Date Time", moments("%d-%b-%Y %H:%M:%S.")),
    "no_clock_rate_in_title.csv": table(PLAIN_HEADERS[1:], COLUMNS[1:], above="Sample rate,10 Hz\n"),
    "no_clock.csv": table(PLAIN_HEADERS[1:], COLUMNS[1:]),
    "row_numbers_for_a_clock.csv": table(("No.", *PLAIN_HEADERS[1:]), ([f"{row + 1}" for row in ROWS], *COLUMNS[1:])),
    "comment_column.csv": table(
        (*PLAIN_HEADERS, "Comment", ""), (*COLUMNS, ["", "begin", *[""] * 7, "end"], [""] * 10)
    ),
    "empty_column_in_between.csv": table(
        (*PLAIN_HEADERS[:2], "Force [N]", *PLAIN_HEADERS[2:]), (*COLUMNS[:2], [""] * 10, *COLUMNS[2:])
    ),
    "states_as_words.csv": table((*PLAIN_HEADERS, "Heater"), (*COLUMNS, ["OFF", *["ON"] * 9])),
    "two_channels_with_one_name.csv": table(
        (*PLAIN_HEADERS, "V_SMA [V]"), (*COLUMNS, [number(value) for value in CURRENT_A])
    ),
    "missing_values.csv": table().replace("0.2000,1.3500", "0.2000,NaN").replace("0.1860", "#N/A"),
    "remark_between_rows.csv": table().replace("0.5000,", "# heater off\n0.5000,"),
    "line_break_in_header.csv": table(('"Time\n[s]"', '"V_SMA\n[V]"', *PLAIN_HEADERS[2:])),
    "own_names.csv": table(
        ("time_s", "wire_voltage_v", "wire_current_a", "displacement_m", "wire_temperature_k"),
        (*COLUMNS[:3], [f"{1e-3 * value:.6f}" for value in MOVED_MM], [number(273.15 + value) for value in HEAT_C]),
    ),
    "no_headers.txt": table((), separator="\t"),
    "unknown_names.csv": table(("a", "b", "c", "d", "e")),
    "time_without_unit.csv": table(("Time", *PLAIN_HEADERS[1:])),
    "two_branches_groups.csv": two_branches(
        "Heating,,,Cooling,,\nTemperature [°C],Strain [%],Stress [MPa],Temperature [°C],Strain [%],Stress [MPa]"
    ),
    "two_branches_names.csv": two_branches(
        "Heating T [°C],Heating strain [%],Heating stress [MPa],Cooling T [°C],Cooling strain [%],Cooling stress [MPa]"
    ),
}

DAMAGED: dict[str, str | bytes] = {
    "empty.csv": b"",
    "only_line_ends.csv": b"\n\r\n\n",
    "only_headers.csv": table(columns=[[] for _ in COLUMNS]),
    "one_row.csv": "\n".join(table().splitlines()[:2]) + "\n",
    "only_text.csv": "Dear colleague,\nplease find the numbers in the other file.\nYours\n",
    "binary.csv": bytes(range(256)) * 20,
    "random_bytes.csv": bytes((167 * index * index + 13 * index) % 251 for index in range(4000)),
    "workbook_renamed.csv": b"PK\x03\x04\x14\x00\x06\x00" + bytes(range(64)),
    "old_workbook_renamed.csv": b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(512),
    "gzip_renamed.csv": b"\x1f\x8b\x08\x00" + bytes(64),
    "hdf5_renamed.csv": b"\x89HDF\r\n\x1a\n" + bytes(64),
    "parquet_renamed.csv": b"PAR1" + bytes(64),
    "tdms_renamed.txt": b"TDSm\x0e\x00\x00\x00" + bytes(64),
    "matlab_renamed.txt": b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(64),
    "pdf_renamed.csv": b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj\n",
    "web_page.csv": "<!DOCTYPE html><html><body><table><tr><td>1</td></tr></table></body></html>\n",
    "nul_after_power_loss.csv": table().encode() + bytes(3000),
    "nul_in_a_row.csv": (
        table() + "1.1000,1.75\0,1,1,1\n" + table((), [[value + 2 for value in column] for column in COLUMNS])
    ).encode(),
    "endless_quote.csv": table().replace("1.3500", '"1.3500'),
    "deep_quotes.csv": table() + "1.1," + '"' * 5001 + ",1,1,1\n",
    "five_thousand_columns.csv": (
        ",".join(f"c{index}" for index in range(5000)) + "\n" + (",".join(["1"] * 5000) + "\n") * 3
    ),
    "cut_in_the_middle_of_a_row.csv": table()[:-20],
    "row_too_short.csv": table().replace("0.5000,1.5000,0.1850,0.7500,37.5000", "0.5000,1.5000"),
    "row_too_long.csv": table().replace("37.5000", "37.5000,99,98"),
    "word_in_a_row.csv": table().replace("1.5000,0.1850", "ERR,0.1850"),
    "formula_in_a_row.csv": table().replace("1.5000,0.1850", "=cmd|' /C calc'!A0,0.1850"),
    "formula_in_a_header.csv": table(("=HYPERLINK(\"http://x\")", *PLAIN_HEADERS[1:])),
    "python_in_a_cell.csv": table().replace("1.5000,0.1850", "__import__('os').getcwd(),0.1850"),
    "unit_with_code.csv": table(("Time [__import__('os').system('true')]", *PLAIN_HEADERS[1:])),
    "unit_of_powers.csv": table(("Time [s**9999999]", *PLAIN_HEADERS[1:])),
    "infinite.csv": table().replace("1.5000,0.1850", "inf,0.1850"),
    "too_large_to_be_finite.csv": table().replace("1.5000,0.1850", "1e999,0.1850"),
    "underscore_in_number.csv": table().replace("1.5000,0.1850", "1_500,0.1850"),
    "two_points_in_number.csv": table().replace("1.5000,0.1850", "1.5.0,0.1850"),
    "clock_stands_still.csv": table().replace("0.5000,1.5000", "0.4000,1.5000"),
    "clock_runs_back.csv": table().replace("0.5000,1.5000", "0.0500,1.5000"),
    "logger_began_again.csv": table() + table(()),
    "impossible_time.csv": timed("Time", moments("%Y-%m-%dT%H:%M:%S.")).replace("03-02T00:00:00.1", "02-30T00:00:00.1"),
    "word_among_times.csv": timed("Time", moments("%H:%M:%S.")).replace("00:00:00.100", "sometime"),
    "decimal_commas_between_commas.csv": table(spell=comma),
    "percent_without_a_sign.csv": table((*PLAIN_HEADERS[:3], "strain", "T [degC]"), scaled((1, 1, 1, 100, 1))),
    "unit_of_another_quantity.csv": table(("Time [s]", "V_SMA [mm]", *PLAIN_HEADERS[2:])),
    "unknown_unit.csv": table(("Time [s]", "V_SMA [Volz]", *PLAIN_HEADERS[2:])),
    "colder_than_possible.csv": table(PLAIN_HEADERS).replace(",37.5000", ",-300.0"),
}  # fmt: skip


def main() -> None:
    """Write all files."""
    for folder, files in (("read", READ), ("damaged", DAMAGED)):
        (HERE / folder).mkdir(exist_ok=True)
        for name, content in files.items():
            data = content if isinstance(content, bytes) else content.encode("utf-8")
            (HERE / folder / name).write_bytes(data)
    print(f"{len(READ)} files to read, {len(DAMAGED)} damaged or hostile ones")


if __name__ == "__main__":
    main()
