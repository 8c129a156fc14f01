"""Write the corpus's LVM files by the specification of National Instruments, as "Write To Measurement File" does."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    PERIOD_S,
    ROWS,
    SHUNT_VOLTAGE_V,
    TIME_S,
    WIRE_VOLTAGE_V,
)

END = "***End_of_Header***"
NAMES = ("Wire voltage", "Shunt voltage", "LVDT")
UNITS = ("V", "V", "mm")
CHANNELS = (WIRE_VOLTAGE_V, SHUNT_VOLTAGE_V, DISPLACEMENT_MM)


def file_header(separator: str = "\t", decimal: str = ".", x_columns: str = "No", **more: str) -> list[str]:
    """Return the lines before the first packet."""
    word = {"\t": "Tab", ",": "Comma", ";": "Semicolon"}[separator]
    entries = {
        "Writer_Version": "2", "Reader_Version": "2", "Separator": word, "Decimal_Separator": decimal,
        "Multi_Headings": "Yes", "X_Columns": x_columns, "Time_Pref": "Relative", "Operator": "lab",
        "Date": "2024/03/08", "Time": f"10:30:28{decimal}5130068", **more,
    }  # fmt: skip
    lines = [f"LabVIEW Measurement{separator}"]
    return [*lines, *(f"{key}{separator}{value}" for key, value in entries.items()), END, separator]


def packet_header(
    samples: int,
    separator: str = "\t",
    decimal: str = ".",
    time: str = "10:30:28.5130068",
    names: Sequence[str] = NAMES,
) -> list[str]:
    """Return the header of a packet, a cell for each channel."""

    def line(key: str, *cells: object) -> str:
        return separator.join([key, *(str(cell).replace(".", decimal) for cell in cells), ""])

    names, count = NAMES, len(NAMES)
    return [
        separator.join(["Channels", str(count), *[""] * count]),
        line("Samples", *[samples] * count),
        line("Date", *["2024/03/08"] * count),
        line("Time", *[time] * count),
        line("Y_Unit_Label", *UNITS[:count]),
        line("X_Dimension", *["Time"] * count),
        line("X0", *["0.0000000000000000E+0"] * count),
        line("Delta_X", *[PERIOD_S] * count),
        END + separator * (count + 1),
        separator.join(["X_Value", *names, "Comment"]),
    ]


def rows(start: int, stop: int, with_x: bool, separator: str = "\t", decimal: str = ".") -> list[str]:
    """Return rows of numbers; without X values the first cell is blank."""
    lines = []
    for row in range(start, stop):
        x = f"{TIME_S[row] - TIME_S[start]:.6f}" if with_x else ""
        cells = [x, *(f"{channel[row]:.6f}" for channel in CHANNELS)]
        lines.append(separator.join(cells).replace(".", decimal))
    return lines


def save(path: Path, *parts: Sequence[str], encoding: str = "utf-8") -> None:
    """Write lines with LabVIEW's line ends."""
    path.write_bytes(("\r\n".join(line for part in parts for line in part) + "\r\n").encode(encoding))


def good(folder: Path) -> None:
    """Write files that are read."""
    save(folder / "lvm_no_x_column.lvm", file_header(), packet_header(ROWS), rows(0, ROWS, False))
    one = (file_header(x_columns="One"), packet_header(ROWS), rows(0, ROWS, True))
    save(folder / "lvm_one_x_column.lvm", *one)
    save(folder / "lvm_called_txt.txt", *one)
    save(folder / "lvm_utf16.lvm", *one, encoding="utf-16")
    save(
        folder / "lvm_decimal_comma.lvm",
        file_header(decimal=",", x_columns="One"),
        packet_header(ROWS, decimal=","),
        [f"{line}\tmarke" if number == 3 else line for number, line in enumerate(rows(0, ROWS, True, decimal=","))],
    )
    save(
        folder / "lvm_commas.lvm",
        file_header(",", x_columns="One", Description="SMA wire, 0.1 mm", Project="finger"),
        packet_header(ROWS, ","),
        rows(0, ROWS, True, ","),
    )
    packets = []
    for number, start in enumerate(range(0, ROWS, 20)):
        # Each packet begins 20 samples, which is one second, after the one before.
        packets += [*packet_header(20, time=f"10:30:{28 + number}.5130068"), *rows(start, start + 20, False), ""]
    save(folder / "lvm_three_packets.lvm", file_header(), packets)
    special = ["***Start_Special***", "some program\twrites what it likes", "***End_Special***"]
    save(folder / "lvm_special_block.lvm", file_header(), special, packet_header(ROWS), rows(0, ROWS, False))
    pairs = ["\t".join(f"{t:.6f}\t{channel[row]:.6f}" for channel in CHANNELS) for row, t in enumerate(TIME_S)]
    header = packet_header(ROWS)
    header[-1] = "X_Value\t" + "\tX_Value\t".join(NAMES) + "\tComment"
    save(folder / "lvm_multi_x_column.lvm", file_header(x_columns="Multi"), header, pairs)
    later = [line.replace(f"\t{TIME_S[row]:.6f}\t", f"\t{TIME_S[row] + 0.01:.6f}\t") for row, line in enumerate(pairs)]
    save(folder / "lvm_two_clocks.lvm", file_header(x_columns="Multi"), header, later)


def damaged(folder: Path, good_folder: Path) -> None:
    """Write files that are refused."""
    whole = (good_folder / "lvm_one_x_column.lvm").read_bytes()
    (folder / "lvm_header_cut.lvm").write_bytes(whole[:150])
    (folder / "lvm_packet_header_cut.lvm").write_bytes(whole[:400])
    (folder / "lvm_binary.lvm").write_bytes(whole[:700] + b"\0\1\2" * 50 + whole[700:])
    (folder / "lvm_word_in_a_cell.lvm").write_bytes(whole.replace(b"0.050000\t", b"0.050000\tERROR", 1))
    (folder / "lvm_not_one.lvm").write_bytes(b"time\tvoltage\r\n0\t1\r\n1\t2\r\n")
    (folder / "lvm_no_clock.lvm").write_bytes(
        (good_folder / "lvm_no_x_column.lvm").read_bytes().replace(b"Delta_X", b"Delta_Q")
    )
    (folder / "lvm_unknown_separator.lvm").write_bytes(whole.replace(b"Separator\tTab", b"Separator\tBar"))
    (folder / "lvm_many_channels.lvm").write_bytes(whole.replace(b"X_Value", b"X_Value" + b"\tq" * 10_001))
